//! Surfaces of the balls: diameters that differ from nominal, waves and defects.

use super::wave::{Kind, MOST_WAVES, RandomWaviness, Wave, WaveNames, drawn_number};
use crate::physics::bearing::Bearing;
use crate::physics::limits::Faults;

/// A round recess of a ball.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BallDefect {
    /// [m]
    pub diameter: f64,
    /// [m]
    pub depth: f64,
    /// Angle of its middle from the ball's equator, towards the ball's axis 1 [rad].
    pub latitude: f64,
    /// Angle of its middle along the equator, from axis 2 towards axis 3 [rad].
    pub longitude: f64,
}

impl BallDefect {
    /// Returns true where the outlines of two defects on a ball of some diameter [m] overlap.
    fn overlaps(&self, other: &Self, ball_diameter: f64) -> bool {
        let sines = self.latitude.sin() * other.latitude.sin();
        let cosines = self.latitude.cos() * other.latitude.cos() * (self.longitude - other.longitude).cos();
        let apart = 0.5 * ball_diameter * (sines + cosines).clamp(-1.0, 1.0).acos();
        apart < 0.5 * (self.diameter + other.diameter)
    }
}

/// Surface of one ball. Its frame at t = 0: axis 2 from the ball's centre to its outer contact, axis 3 along the orbit from +Y towards +Z,
/// axis 1 = 2 × 3.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct BallSurface {
    /// Diameter less the nominal one [m].
    pub diameter_deviation: f64,
    /// Waves round the equator.
    pub waviness: Vec<Wave>,
    /// Adds to `waviness`. Waves of one order have one phase, so that the amplitudes of several items add.
    pub random_waviness: Vec<RandomWaviness>,
    pub defects: Vec<BallDefect>,
}

/// Surface of a ball as given.
#[derive(Debug, Clone, PartialEq)]
pub struct GivenBall {
    /// Number of the ball, from 1.
    pub ball: u32,
    pub surface: BallSurface,
}

/// Surface that all balls have in common. It adds to that of each ball.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct EveryBall {
    pub random_waviness: Option<RandomWaviness>,
    /// Largest less smallest diameter of drawn diameters [m].
    pub diameter_spread: f64,
}

/// Largest number of defects of one ball.
pub const MOST_BALL_DEFECTS: usize = 4;
/// Largest deviation of a ball's diameter over the nominal diameter [-].
const LARGEST_DEVIATION: f64 = 0.01;

/// Names of the number of a ball and of its deviation.
const NUMBER: &str = "surfaces.balls.ball";
const DEVIATION: &str = "surfaces.balls.diameter_deviation";
const NAMES: WaveNames = WaveNames {
    waviness: "surfaces.balls.waviness",
    wave: ["surfaces.balls.waviness.order", "surfaces.balls.waviness.amplitude", "surfaces.balls.waviness.phase"],
};
const RANDOM_OF_A_BALL: [&str; 5] = [
    "surfaces.balls.random_waviness.amplitude",
    "surfaces.balls.random_waviness.at_order",
    "surfaces.balls.random_waviness.exponent",
    "surfaces.balls.random_waviness.from_order",
    "surfaces.balls.random_waviness.to_order",
];
const RANDOM_OF_EVERY_BALL: [&str; 5] = [
    "surfaces.every_ball.random_waviness.amplitude",
    "surfaces.every_ball.random_waviness.at_order",
    "surfaces.every_ball.random_waviness.exponent",
    "surfaces.every_ball.random_waviness.from_order",
    "surfaces.every_ball.random_waviness.to_order",
];

impl BallSurface {
    /// Returns true for a smooth ball of the nominal diameter.
    pub fn is_ideal(&self) -> bool {
        self.diameter_deviation == 0.0 && self.is_sphere()
    }

    /// Returns true for a ball of any diameter without waves and defects.
    pub fn is_sphere(&self) -> bool {
        self.waviness.iter().all(|wave| wave.amplitude == 0.0)
            && self.random_waviness.iter().all(|random| random.amplitude == 0.0)
            && !self.has_defects()
    }

    /// Returns true where a defect has a depth.
    pub(crate) fn has_defects(&self) -> bool {
        self.defects.iter().any(|defect| defect.depth > 0.0)
    }

    /// All waves, those given first. `first_zero`: the order that ends drawn waves by default; `index`: number of the ball's surface.
    pub(crate) fn waves(&self, first_zero: f64, index: u64, seed: u64) -> impl Iterator<Item = Wave> + '_ {
        let drawn = self.random_waviness.iter().flat_map(move |random| random.waves(first_zero, index, seed));
        self.waviness.iter().copied().chain(drawn).filter(|wave| wave.amplitude != 0.0)
    }

    /// `item`: number of the surface in its list.
    fn check(&self, item: usize, faults: &mut Faults) {
        faults.check(DEVIATION, self.diameter_deviation);
        NAMES.check_waves(&self.waviness, MOST_WAVES, &[item], faults);
        for random in &self.random_waviness {
            random.check(&RANDOM_OF_A_BALL, &[item], faults);
        }
        if self.defects.len() > MOST_BALL_DEFECTS {
            let reason = format!("{} defects: at most {MOST_BALL_DEFECTS}", self.defects.len());
            faults.inconsistent_item("surfaces.balls.defects", &[item], reason);
        }
        for BallDefect { diameter, depth, latitude, longitude } in &self.defects {
            faults.check("surfaces.balls.defects.diameter", *diameter);
            faults.check("surfaces.balls.defects.depth", *depth);
            faults.check("surfaces.balls.defects.latitude", *latitude);
            faults.check("surfaces.balls.defects.longitude", *longitude);
        }
    }
}

/// Checks the surfaces of single balls and of every ball, each by itself.
pub(super) fn check(balls: &[GivenBall], every: &EveryBall, faults: &mut Faults) {
    for (index, GivenBall { ball, surface }) in balls.iter().enumerate() {
        faults.check(NUMBER, f64::from(*ball));
        if let Some(first) = balls.iter().take(index).position(|other| other.ball == *ball) {
            let reason = format!("items {first} and {index} are both of ball {ball}: give them as one");
            faults.inconsistent_item(NUMBER, &[index], reason);
        }
        surface.check(index, faults);
    }
    faults.check("surfaces.every_ball.diameter_spread", every.diameter_spread);
    if let Some(random) = &every.random_waviness {
        random.check(&RANDOM_OF_EVERY_BALL, &[], faults);
    }
}

/// Refuses balls that the bearing does not have, and diameters that do not fit it.
pub(super) fn check_fit(balls: &[GivenBall], every: &EveryBall, bearing: &Bearing, faults: &mut Faults) {
    let p = &bearing.parameters;
    let most = LARGEST_DEVIATION * p.ball_diameter;
    let limit = format!("at most {:.4} µm, a hundredth of the ball diameter", 1e6 * most);
    for (index, GivenBall { ball, surface }) in balls.iter().enumerate() {
        if *ball as usize > p.ball_count {
            let reason = format!("{ball}: the bearing has {} balls", p.ball_count);
            faults.inconsistent_item(NUMBER, &[index], reason);
        }
        let deviation = surface.diameter_deviation;
        if deviation.abs() > most {
            let reason = format!("{} µm: {limit}, more or less", 1e6 * deviation);
            faults.inconsistent_item(DEVIATION, &[index], reason);
        }
        let is_other = |of: usize| {
            surface.defects[..of].iter().position(|other| surface.defects[of].overlaps(other, p.ball_diameter))
        };
        if let Some((other, of)) = (0..surface.defects.len()).find_map(|of| Some((is_other(of)?, of))) {
            let reason =
                format!("the outlines of defects {other} and {of} of ball {ball} overlap: give them as one defect");
            faults.inconsistent_item("surfaces.balls.defects", &[index, of], reason);
        }
    }
    if every.diameter_spread > most {
        let reason = format!("{} µm: {limit}", 1e6 * every.diameter_spread);
        faults.inconsistent("surfaces.every_ball.diameter_spread", reason);
    }
}

/// Refuses balls that their pockets clamp. `surfaces`: of each ball, with drawn diameters; `clearance`: of a nominal ball [m].
pub(super) fn check_pockets(balls: &[GivenBall], surfaces: &[BallSurface], clearance: f64, faults: &mut Faults) {
    for (index, BallSurface { diameter_deviation, .. }) in surfaces.iter().enumerate() {
        if *diameter_deviation >= clearance {
            let (ball, by, clearance) = (index + 1, 1e6 * diameter_deviation, 1e6 * clearance);
            let reason = format!("ball {ball} is {by:.4} µm larger than nominal, its pocket leaves {clearance:.4} µm");
            let is_larger = |given: &GivenBall| given.ball as usize == ball && given.surface.diameter_deviation > 0.0;
            match balls.iter().position(is_larger) {
                Some(item) => faults.inconsistent_item(DEVIATION, &[item], reason),
                None => faults.inconsistent("surfaces.every_ball.diameter_spread", reason),
            }
        }
    }
}

/// Refuses balls that overlap. `distances`: between the centres of each ball and the next [m]; `diameter`: the nominal one [m].
pub(super) fn check_neighbours(surfaces: &[BallSurface], distances: &[f64], diameter: f64, faults: &mut Faults) {
    for (index, (surface, distance)) in surfaces.iter().zip(distances).enumerate() {
        let next = (index + 1) % surfaces.len();
        let radii = diameter + 0.5 * (surface.diameter_deviation + surfaces[next].diameter_deviation);
        if *distance <= radii {
            let (ball, next, distance, radii) = (index + 1, next + 1, 1e3 * distance, 1e3 * radii);
            let reason = format!(
                "balls {ball} and {next} overlap: their centres are {distance:.4} mm apart, their radii add to {radii:.4} mm"
            );
            faults.inconsistent("surfaces.balls", reason);
        }
    }
}

/// Surface of each ball; empty where all are ideal.
pub(super) fn surfaces(balls: &[GivenBall], every: &EveryBall, count: usize, seed: u64) -> Vec<BallSurface> {
    let spread = drawn_deviations(every.diameter_spread, count, seed);
    let one = |(ball, drawn): (usize, f64)| {
        let given = balls.iter().find(|given| given.ball as usize == ball + 1);
        let mut surface = given.map(|given| given.surface.clone()).unwrap_or_default();
        surface.diameter_deviation += drawn;
        surface.random_waviness.extend(every.random_waviness);
        surface
    };
    let surfaces: Vec<BallSurface> = spread.into_iter().enumerate().map(one).collect();
    if surfaces.iter().all(BallSurface::is_ideal) { Vec::new() } else { surfaces }
}

/// Number of a ball's surface in the hash of drawn numbers; `ball` counts from 0.
pub(crate) fn surface_number(ball: usize) -> u64 {
    ball as u64 + 2
}

/// Deviations of mean 0 whose largest and smallest differ by `spread` [m].
fn drawn_deviations(spread: f64, count: usize, seed: u64) -> Vec<f64> {
    let draw = |ball| drawn_number([seed, surface_number(ball), Kind::Diameter as u64, 0]);
    let drawn: Vec<f64> = (0..count).map(draw).collect();
    let mean = drawn.iter().sum::<f64>() / count as f64;
    let (low, high) = drawn.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &x| (l.min(x), h.max(x)));
    drawn.iter().map(|draw| spread * ((draw - mean) / (high - low))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Mean 0, largest less smallest the spread; a ball's own deviation adds, and the first balls of more balls have the same draws.
    #[test]
    fn drawn_diameters_have_their_spread() {
        let every = EveryBall { diameter_spread: 1e-6, ..EveryBall::default() };
        let of = |balls: &[GivenBall], count| -> Vec<f64> {
            surfaces(balls, &every, count, 1).iter().map(|surface| surface.diameter_deviation).collect()
        };
        for count in [2, 7, 64] {
            let drawn = of(&[], count);
            let (low, high) = drawn.iter().fold((0.0_f64, 0.0_f64), |(l, h), &x| (l.min(x), h.max(x)));
            assert!((high - low - 1e-6).abs() < 1e-18, "{count}");
            assert!(drawn.iter().sum::<f64>().abs() < 1e-19);
        }
        let own = BallSurface { diameter_deviation: 2e-6, ..BallSurface::default() };
        let given = [GivenBall { ball: 3, surface: own }];
        let (drawn, more) = (of(&[], 7), of(&given, 7));
        assert_eq!(more[2], drawn[2] + 2e-6);
        assert_eq!([&more[..2], &more[3..]].concat(), [&drawn[..2], &drawn[3..]].concat());
        assert_ne!(drawn, surfaces(&[], &every, 7, 2).iter().map(|s| s.diameter_deviation).collect::<Vec<_>>());
    }

    #[test]
    fn balls_without_deviation_are_ideal() {
        let still = GivenBall { ball: 1, surface: BallSurface::default() };
        assert!(surfaces(&[still], &EveryBall::default(), 7, 1).is_empty());
    }
}
