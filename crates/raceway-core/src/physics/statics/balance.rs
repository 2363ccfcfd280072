//! Balance of balls, rings and shaft: the minimum of their potential over the balls of all bearings and a border of common freedoms.

use super::ball::{Axis, BallSlopes, FREEDOMS, OF_BALL, Pose, RingBearing};
use crate::numerics::bordered::Bordered;
use crate::numerics::minimum::{Potential, Search, Slopes};

/// Most common freedoms: five of a shaft, and one of each sliding outer ring of eight bearings.
pub(super) const BORDER: usize = FREEDOMS + 8;

/// Values of the common freedoms.
pub(super) type Border = [f64; BORDER];

/// No balance of loads and balls.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum NoBalance {
    #[error("{residual:.3e} N stay unbalanced of {applied:.3e} N applied")]
    Unbalanced { residual: f64, applied: f64 },
    #[error("{load:.1e} N press a ball into its raceways by {depth:.2} of its radius")]
    TooDeep { load: f64, depth: f64 },
}

/// Largest penetration over the ball's radius [-]: a little deeper, balls would pass through the raceways.
pub(crate) const MAX_RELATIVE_DEPTH: f64 = 0.5;
/// First step of a search under the applied load [m]: of the size of clearances, because a longer step would penetrate the contacts far too deep
/// and be rejected.
pub(crate) const FIRST_STEP: f64 = 1e-5;

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

/// Potentials of all balls of a bearing at a pose of its inner ring.
pub(super) fn slopes_of_balls<'a>(
    bearing: &'a RingBearing,
    pose: &'a Pose,
    speed: f64,
    balls: impl Iterator<Item = [f64; OF_BALL]> + 'a,
) -> impl Iterator<Item = BallSlopes> + 'a {
    let (axis, centrifugal) = (Axis::new(pose), bearing.centrifugal(speed));
    balls.enumerate().map(move |(index, place)| bearing.ball(bearing.azimuth(index), &axis, pose, place, centrifugal))
}

impl Balance<'_> {
    /// Balance from a guess of the common freedoms, and of the places of the balls where they are known.
    pub(super) fn find(&self, border: &Border, balls: Option<&[Places]>) -> Result<Found, NoBalance> {
        let mut place: Vec<f64> = Vec::new();
        for (index, link) in self.links.iter().enumerate() {
            let pose = link.pose(&border[..self.width]);
            match balls {
                Some(balls) => place.extend(balls[index].iter().flatten()),
                None => place.extend(
                    (0..link.bearing.entries())
                        .flat_map(|index| link.bearing.between_grooves(link.bearing.azimuth(index), &pose)),
                ),
            }
        }
        place.extend(&border[..self.width]);
        let force = self.force(&place);
        let radius = self.links.iter().map(|link| link.bearing.pitch_radius).fold(0.0, f64::max);
        let search = Search {
            converged: 1e-11 * force + 1e-12,
            longest_step: 0.01 * radius,
            first_damping: if balls.is_some() { 0.0 } else { force / FIRST_STEP },
        };
        let residual = search.minimise(self, &mut place).residual();
        if residual.is_nan() || residual > 1e-6 * force + 1e-9 {
            return Err(NoBalance::Unbalanced { residual, applied: force });
        }
        let (border, balls) = self.parts(&place);
        self.check_depth(&border, &balls)?;
        let places = self.links.iter().map(|link| link.bearing.places).max().unwrap_or_default();
        Ok(Found { border, balls, least_load: places as f64 * residual.max(search.converged) })
    }

    /// Force that measures residuals at a place [N]: of loads, orbits and contacts.
    fn force(&self, place: &[f64]) -> f64 {
        let of_loads = self.load.iter().map(|load| load.abs()).fold(0.0, f64::max);
        let (border, balls) = self.parts(place);
        let of_links = self.links.iter().zip(&balls).map(|(link, balls)| {
            let centrifugal = link.bearing.centrifugal(self.speed) * link.bearing.pitch_radius;
            centrifugal + self.largest_load(link, &border, balls)
        });
        of_loads + of_links.fold(0.0, f64::max)
    }

    fn largest_load(&self, link: &Link<'_>, border: &Border, balls: &Places) -> f64 {
        let pose = link.pose(&border[..self.width]);
        let slopes = slopes_of_balls(link.bearing, &pose, self.speed, balls.iter().copied());
        slopes.map(|ball| ball.inner.load.max(ball.outer.load)).fold(0.0, f64::max)
    }

    fn check_depth(&self, border: &Border, balls: &[Places]) -> Result<(), NoBalance> {
        for (link, balls) in self.links.iter().zip(balls) {
            let load = self.largest_load(link, border, balls);
            let depth = link.bearing.relative_depth(load);
            if depth > MAX_RELATIVE_DEPTH {
                return Err(NoBalance::TooDeep { load, depth });
            }
        }
        Ok(())
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

impl Potential<BORDER> for Balance<'_> {
    fn slopes(&self, place: &[f64]) -> Slopes<BORDER> {
        let width = self.width;
        let (of_balls, border) = place.split_at(place.len() - width);
        let mut hessian = Bordered::zeros(of_balls.len() / OF_BALL, width);
        let mut gradient = vec![0.0; place.len()];
        let (gradient_of_balls, gradient_of_border) = gradient.split_at_mut(of_balls.len());
        let mut value = 0.0;
        for k in 0..width {
            value += (0.5 * self.springs[k] * border[k] - self.load[k]) * border[k];
            gradient_of_border[k] = self.springs[k] * border[k] - self.load[k];
            hessian.border[k][k] = self.springs[k];
        }
        let mut index = 0;
        for link in &self.links {
            let (pose, share) = (link.pose(border), link.bearing.share());
            let balls = of_balls[OF_BALL * index..].chunks_exact(OF_BALL).map(|ball| [ball[0], ball[1]]);
            let balls = balls.take(link.bearing.entries());
            let mut of_ring = [0.0; FREEDOMS];
            let mut ring = [[0.0; FREEDOMS]; FREEDOMS];
            for ball in slopes_of_balls(link.bearing, &pose, self.speed, balls) {
                value += share * ball.energy;
                let block = &mut hessian.blocks[index];
                for k in 0..OF_BALL {
                    gradient_of_balls[OF_BALL * index + k] = share * ball.gradient[k];
                    block.diagonal[k] = share * ball.hessian[k][k];
                }
                block.between = share * ball.hessian[1][0];
                for (column, entries) in block.border.iter_mut().enumerate() {
                    for (k, by) in link.by.iter().enumerate() {
                        let coupling = share * ball.hessian[OF_BALL + k][column];
                        entries[..width].iter_mut().zip(by).for_each(|(entry, by)| *entry += coupling * by);
                    }
                }
                for (k, row) in ring.iter_mut().enumerate() {
                    of_ring[k] += share * ball.gradient[OF_BALL + k];
                    for (other, entry) in row[..=k].iter_mut().enumerate() {
                        *entry += share * ball.hessian[OF_BALL + k][OF_BALL + other];
                    }
                }
                index += 1;
            }
            for (force, by) in of_ring.iter().zip(&link.by) {
                gradient_of_border.iter_mut().zip(by).for_each(|(slope, by)| *slope += force * by);
            }
            for (row, entries) in hessian.border[..width].iter_mut().enumerate() {
                for (column, sum) in entries[..=row].iter_mut().enumerate() {
                    for k in 0..FREEDOMS {
                        for other in 0..FREEDOMS {
                            let entry = ring[k.max(other)][k.min(other)];
                            *sum += entry * link.by[k][row] * link.by[other][column];
                        }
                    }
                }
            }
        }
        Slopes { value, gradient, hessian }
    }
}
