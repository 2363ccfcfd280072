//! Balance of balls, rings and shaft: the minimum of their potential over the balls of all bearings and a border of common freedoms. Forces of
//! rolling balls take part without a potential.

use super::ball::{Axis, BallSlopes, FREEDOMS, OF_BALL, Placed, Pose, RingBearing};
use crate::numerics::bordered::Bordered;
use crate::numerics::minimum::{Potential, Search, Slopes};

/// Most common freedoms: five of a shaft, and one of each sliding outer ring of eight bearings.
pub(super) const BORDER: usize = FREEDOMS + 8;

/// Values of the common freedoms.
pub(super) type Border = [f64; BORDER];

/// No balance of loads and balls.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum NoBalance {
    #[error(
        "{residual:.3e} N stay unbalanced of {applied:.3e} N applied by loads, contacts and orbiting balls. Lower loads or speeds may have one"
    )]
    Unbalanced { residual: f64, applied: f64 },
    #[error("{load:.1e} N press a ball into its raceways by {depth:.2} of its radius")]
    TooDeep { load: f64, depth: f64 },
}

/// Largest penetration over the ball's radius [-]: a little deeper, balls would pass through the raceways.
pub(crate) const MAX_RELATIVE_DEPTH: f64 = 0.5;
/// First step of a search under the applied load [m]: of the size of clearances, because a longer step would penetrate the contacts far too deep
/// and be rejected.
pub(crate) const FIRST_STEP: f64 = 1e-5;

/// The search of a balance under forces of a size [N], of balls on circles up to a pitch radius [m].
pub(crate) fn search(force: f64, pitch_radius: f64, first_damping: f64) -> Search {
    Search { converged: 1e-11 * force + 1e-12, longest_step: 0.01 * pitch_radius, first_damping }
}

/// Refuses a residual beyond the rounding of forces of a size [N].
pub(crate) fn check_residual(residual: f64, applied: f64) -> Result<(), NoBalance> {
    let is_rounding = residual <= 1e-6 * applied + 1e-9;
    if is_rounding { Ok(()) } else { Err(NoBalance::Unbalanced { residual, applied }) }
}

/// A bearing whose pose follows the common freedoms: `base` and the sum of `by` times the freedoms.
#[derive(Debug, Clone)]
pub(super) struct Link<'a> {
    pub(super) bearing: &'a RingBearing,
    pub(super) base: Pose,
    pub(super) by: [Border; FREEDOMS],
}

/// Bearings at a speed of the shaft [rad/s], under loads on the common freedoms [N] and springs along them [N/m]. All freedoms are lengths.
#[derive(Debug, Clone)]
pub(super) struct Balance<'a> {
    pub(super) links: Vec<Link<'a>>,
    pub(super) speed: f64,
    pub(super) width: usize,
    pub(super) load: Border,
    pub(super) springs: Border,
}

/// Places of the balls of a bearing, of all its places in a ball spacing.
pub(super) type Places = Vec<[f64; OF_BALL]>;

/// A balance that was found.
pub(super) struct Found {
    pub(super) border: Border,
    pub(super) balls: Vec<Places>,
    /// Load below which a ball is loose [N].
    pub(super) least_load: f64,
}

impl Link<'_> {
    pub(super) fn pose(&self, border: &[f64]) -> Pose {
        std::array::from_fn(|k| {
            self.base[k] + border.iter().zip(&self.by[k]).map(|(value, by)| value * by).sum::<f64>()
        })
    }
}

/// All balls of a bearing at their places and a pose of its inner ring, with the potential of their contacts.
pub(super) fn balls_of<'a>(
    bearing: &'a RingBearing,
    pose: &'a Pose,
    balls: impl Iterator<Item = [f64; OF_BALL]> + 'a,
) -> impl Iterator<Item = (Placed, BallSlopes)> + 'a {
    let axis = Axis::new(pose);
    balls.enumerate().map(move |(index, place)| {
        let ball = bearing.placed(bearing.azimuth(index), &axis, pose, place);
        let slopes = bearing.contacts(&ball);
        (ball, slopes)
    })
}

impl RingBearing {
    /// Potential of the contacts, with its slopes by the places of the balls and by the pose of the inner ring. The gradient holds the forces of
    /// rolling, too; the second derivatives do not. `places`: of each ball at each place.
    pub(crate) fn slopes(&self, pose: &Pose, speed: f64, places: &[f64]) -> Slopes<Bordered<FREEDOMS>> {
        let (mut value, share) = (0.0, self.share());
        let [mut gradient, mut without_potential] = [(); 2].map(|()| vec![0.0; places.len() + FREEDOMS]);
        let (of_balls, of_ring) = gradient.split_at_mut(places.len());
        let (rolling_of_balls, rolling_of_ring) = without_potential.split_at_mut(places.len());
        let rolling_of_balls = rolling_of_balls.as_chunks_mut::<OF_BALL>().0;
        let mut hessian = Bordered::zeros(self.entries(), FREEDOMS);
        let (balls, speeds) = (balls_of(self, pose, places.as_chunks().0.iter().copied()), self.speeds(speed));
        let of_each = balls.zip(&mut hessian.blocks).zip(of_balls.as_chunks_mut::<OF_BALL>().0).zip(rolling_of_balls);
        for ((((placed, ball), block), slope), of_rolling) in of_each {
            value += share * ball.energy;
            let rolling = self.rolling_forces(&placed, speeds).map(|force| -share * force);
            *of_rolling = std::array::from_fn(|k| rolling[k]);
            *slope = std::array::from_fn(|k| share * ball.gradient[k] + rolling[k]);
            block.diagonal = [share * ball.hessian[0][0], share * ball.hessian[1][1]];
            block.between = share * ball.hessian[1][0];
            for k in 0..FREEDOMS {
                for (column, entries) in block.border.iter_mut().enumerate() {
                    entries[k] = share * ball.hessian[OF_BALL + k][column];
                }
                rolling_of_ring[k] += rolling[OF_BALL + k];
                of_ring[k] += share * ball.gradient[OF_BALL + k] + rolling[OF_BALL + k];
                for (other, entry) in hessian.border[k][..=k].iter_mut().enumerate() {
                    *entry += share * ball.hessian[OF_BALL + k][OF_BALL + other];
                }
            }
        }
        Slopes { value, gradient, without_potential, hessian }
    }

    /// Places of all balls on the lines between both grooves' centres.
    pub(crate) fn all_between_grooves(&self, pose: &Pose) -> Vec<f64> {
        (0..self.entries()).flat_map(|index| self.between_grooves(self.azimuth(index), pose)).collect()
    }

    /// Size of the forces on the balls at these places [N]: of orbits and contacts.
    pub(crate) fn force(&self, pose: &Pose, speed: f64, places: &[f64]) -> f64 {
        self.rolling.ideal_centrifugal(self.speeds(speed), self.pitch_radius) + self.largest_load(pose, places)
    }

    fn largest_load(&self, pose: &Pose, places: &[f64]) -> f64 {
        let balls = balls_of(self, pose, places.as_chunks().0.iter().copied());
        balls.map(|(_, ball)| ball.touch.inner.load.max(ball.touch.outer.load)).fold(0.0, f64::max)
    }

    /// Refuses balls that nearly pass through the raceways.
    pub(crate) fn check_depth(&self, pose: &Pose, places: &[f64]) -> Result<(), NoBalance> {
        let load = self.largest_load(pose, places);
        let depth = self.relative_depth(load);
        if depth > MAX_RELATIVE_DEPTH { Err(NoBalance::TooDeep { load, depth }) } else { Ok(()) }
    }
}

impl Balance<'_> {
    /// Balance from a guess of the common freedoms, and of the places of the balls where they are known.
    pub(super) fn find(&self, border: &Border, balls: Option<&[Places]>) -> Result<Found, NoBalance> {
        let mut place: Vec<f64> = Vec::new();
        for (index, link) in self.links.iter().enumerate() {
            let pose = link.pose(&border[..self.width]);
            match balls {
                Some(balls) => place.extend(balls[index].iter().flatten()),
                None => place.extend(link.bearing.all_between_grooves(&pose)),
            }
        }
        place.extend(&border[..self.width]);
        let force = self.force(&place);
        let radius = self.links.iter().map(|link| link.bearing.pitch_radius).fold(0.0, f64::max);
        let search = search(force, radius, if balls.is_some() { 0.0 } else { force / FIRST_STEP });
        let residual = search.minimise(self, &mut place).residual();
        check_residual(residual, force)?;
        let (border, balls) = self.parts(&place);
        for (link, balls) in self.links.iter().zip(&balls) {
            link.bearing.check_depth(&link.pose(&border[..self.width]), balls.as_flattened())?;
        }
        let places = self.links.iter().map(|link| link.bearing.places).max().unwrap_or_default();
        Ok(Found { border, balls, least_load: places as f64 * residual.max(search.converged) })
    }

    /// Force that measures residuals at a place [N]: of loads, orbits and contacts.
    fn force(&self, place: &[f64]) -> f64 {
        let of_loads = self.load.iter().map(|load| load.abs()).fold(0.0, f64::max);
        let (border, balls) = self.parts(place);
        let of_links = self.links.iter().zip(&balls).map(|(link, balls)| {
            link.bearing.force(&link.pose(&border[..self.width]), self.speed, balls.as_flattened())
        });
        of_loads + of_links.fold(0.0, f64::max)
    }

    /// The common freedoms and the balls of a place.
    fn parts(&self, place: &[f64]) -> (Border, Vec<Places>) {
        let mut rest = place;
        let mut balls = Vec::new();
        for link in &self.links {
            let (of_link, others) = rest.split_at(OF_BALL * link.bearing.entries());
            balls.push(of_link.chunks_exact(OF_BALL).map(|ball| [ball[0], ball[1]]).collect());
            rest = others;
        }
        let mut border = [0.0; BORDER];
        border[..self.width].copy_from_slice(rest);
        (border, balls)
    }
}

impl Potential for Balance<'_> {
    type Curvature = Bordered<BORDER>;

    fn step(&self, slopes: &Slopes<Self::Curvature>, damping: f64) -> Option<Vec<f64>> {
        slopes.bordered_step(damping)
    }

    fn slopes(&self, place: &[f64]) -> Slopes<Self::Curvature> {
        let width = self.width;
        let (of_balls, border) = place.split_at(place.len() - width);
        let mut hessian = Bordered::zeros(of_balls.len() / OF_BALL, width);
        let [mut gradient, mut without_potential] = [(); 2].map(|()| vec![0.0; place.len()]);
        let mut value = 0.0;
        for k in 0..width {
            value += (0.5 * self.springs[k] * border[k] - self.load[k]) * border[k];
            gradient[of_balls.len() + k] = self.springs[k] * border[k] - self.load[k];
            hessian.border[k][k] = self.springs[k];
        }
        let mut first = 0;
        for link in &self.links {
            let end = first + link.bearing.entries();
            let of_link = &of_balls[OF_BALL * first..OF_BALL * end];
            let ring = link.bearing.slopes(&link.pose(border), self.speed, of_link);
            value += ring.value;
            for (sums, of_link_and_ring) in
                [(&mut gradient, &ring.gradient), (&mut without_potential, &ring.without_potential)]
            {
                let (of_link, of_ring) = of_link_and_ring.split_at(of_link.len());
                let (sums_of_balls, sums_of_border) = sums.split_at_mut(of_balls.len());
                sums_of_balls[OF_BALL * first..OF_BALL * end].copy_from_slice(of_link);
                for (force, by) in of_ring.iter().zip(&link.by) {
                    sums_of_border.iter_mut().zip(by).for_each(|(slope, by)| *slope += force * by);
                }
            }
            for (block, own) in hessian.blocks[first..end].iter_mut().zip(&ring.hessian.blocks) {
                (block.diagonal, block.between) = (own.diagonal, own.between);
                for (entries, couplings) in block.border.iter_mut().zip(&own.border) {
                    for (coupling, by) in couplings.iter().zip(&link.by) {
                        entries[..width].iter_mut().zip(by).for_each(|(entry, by)| *entry += coupling * by);
                    }
                }
            }
            for (row, entries) in hessian.border[..width].iter_mut().enumerate() {
                for (column, sum) in entries[..=row].iter_mut().enumerate() {
                    for k in 0..FREEDOMS {
                        for other in 0..FREEDOMS {
                            let entry = ring.hessian.border[k.max(other)][k.min(other)];
                            *sum += entry * link.by[k][row] * link.by[other][column];
                        }
                    }
                }
            }
            first = end;
        }
        Slopes { value, gradient, without_potential, hessian }
    }
}
