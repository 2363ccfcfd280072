//! Reference rating life from the loads of the balls, ISO/TS 16281.

use crate::numerics::exponential::power;
use crate::physics::bearing::{Bearing, PerRaceway};

/// Basic dynamic load rating of a contact Q_c [N], from that of the bearing C [N].
///
/// Q_c = C/(k Z cos^0.7 α) [1 + (1.044 χ)^(±10/3)]^0.3, χ = ((1 − γ)/(1 + γ))^1.72 [f_i (2f_e − 1)/(f_e (2f_i − 1))]^0.41; k 0.407 and + on the
/// inner raceway, 0.389 and − on the outer one. α is 0 for deep-groove bearings.
pub fn contact_ratings(bearing: &Bearing, dynamic_rating: f64) -> PerRaceway<f64> {
    let (p, gamma) = (&bearing.parameters, bearing.gamma());
    let (inner, outer) = (p.groove_curvature.inner, p.groove_curvature.outer);
    let conformity = inner * (2.0 * outer - 1.0) / (outer * (2.0 * inner - 1.0));
    let rings = 1.044 * ((1.0 - gamma) / (1.0 + gamma)).powf(1.72) * conformity.powf(0.41);
    let of_bearing = dynamic_rating / (p.ball_count as f64 * bearing.kinematic_contact_angle().cos().powf(0.7));
    let one = |k: f64, exponent: f64| of_bearing / k * (1.0 + rings.powf(exponent)).powf(0.3);
    PerRaceway { inner: one(0.407, 10.0 / 3.0), outer: one(0.389, -10.0 / 3.0) }
}

/// Exponent of the mean load of the balls on a ring [-]: 3 on a ring that turns against the load, each place of which meets all loads; 10/3 on one
/// that stands, whose most loaded place counts more.
pub fn mean_exponent(turns: bool) -> f64 {
    if turns { 3.0 } else { 10.0 / 3.0 }
}

/// Power means of the loads on both raceways, over balls and time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoadMeans {
    exponents: PerRaceway<f64>,
    sums: PerRaceway<f64>,
    count: f64,
}

impl LoadMeans {
    /// `turns`: whether a ring turns against the load.
    pub fn new(turns: PerRaceway<bool>) -> Self {
        Self { exponents: turns.map(|turns| mean_exponent(*turns)), sums: PerRaceway::default(), count: 0.0 }
    }

    /// Empty means for largest speeds of both rings; a load that stands is supposed.
    pub(crate) fn of_rings(inner: f64, outer: f64) -> Self {
        Self::new(PerRaceway { inner: inner != 0.0, outer: outer != 0.0 })
    }

    /// Adds the loads of a ball [N].
    #[inline]
    pub fn add(&mut self, load: PerRaceway<f64>) {
        self.sums.inner += power(load.inner, self.exponents.inner);
        self.sums.outer += power(load.outer, self.exponents.outer);
        self.count += 1.0;
    }

    /// The means [N]; 0 without a ball.
    pub fn means(&self) -> PerRaceway<f64> {
        let one = |sum: f64, exponent: f64| power(sum / self.count.max(1.0), 1.0 / exponent);
        PerRaceway {
            inner: one(self.sums.inner, self.exponents.inner),
            outer: one(self.sums.outer, self.exponents.outer),
        }
    }
}

/// L₁₀r = [(Q_ci/Q_mi)^(−10/3) + (Q_ce/Q_me)^(−10/3)]^(−0.9) [10⁶ turns] of mean loads Q_m [N]; infinite without load.
pub fn reference_life(contact_ratings: PerRaceway<f64>, means: PerRaceway<f64>) -> f64 {
    let one = |mean: f64, rating: f64| (mean / rating).powf(10.0 / 3.0);
    (one(means.inner, contact_ratings.inner) + one(means.outer, contact_ratings.outer)).powf(-0.9)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::examples::deep_groove;

    const INNER_TURNS: PerRaceway<bool> = PerRaceway { inner: true, outer: false };

    /// 1 and 2 kN half of the time each.
    #[test]
    fn means_of_two_loads() {
        let mut means = LoadMeans::new(INNER_TURNS);
        for load in [1e3, 2e3] {
            means.add(PerRaceway { inner: load, outer: load });
        }
        let PerRaceway { inner, outer } = means.means();
        assert!((inner - 1651.0).abs() < 0.5 && (outer - 1671.0).abs() < 0.5, "{inner} {outer}");
        assert_eq!(LoadMeans::new(INNER_TURNS).means(), PerRaceway { inner: 0.0, outer: 0.0 });
    }

    /// Under a radial load without clearance the life is that of ISO 281 for P = F_r (its C supposes such a distribution) to 2 %.
    #[test]
    fn life_of_a_radial_load_is_the_basic_one() {
        let bearing = deep_groove(40, 6.0, 100.0, [0.52, 0.53], 0.0, 206e9);
        let (rating, load) = (40e3, 2e3);
        let mut means = LoadMeans::new(INNER_TURNS);
        let largest = 4.37 * load / 40.0;
        for ball in 0..40 {
            let cosine = (std::f64::consts::TAU * f64::from(ball) / 40.0).cos().max(0.0);
            let one = largest * cosine.powf(1.5);
            means.add(PerRaceway { inner: one, outer: one });
        }
        let life = reference_life(contact_ratings(&bearing, rating), means.means());
        assert!((life / (rating / load).powi(3) - 1.0).abs() < 0.02, "{life}");
    }

    #[test]
    fn no_load_lives_for_ever() {
        let rating = PerRaceway { inner: 1.0, outer: 1.0 };
        assert_eq!(reference_life(rating, PerRaceway::default()), f64::INFINITY);
    }
}
