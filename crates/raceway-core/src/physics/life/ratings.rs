//! Load ratings that a life refers to: computed, or those of a maker.

use super::factors::static_factor;
use crate::physics::bearing::Bearing;
use crate::physics::rating::dynamic_load_rating;

/// Numbers of a maker in place of computed ones.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct MakersRatings {
    /// C [N].
    pub dynamic: Option<f64>,
    /// C₀ [N].
    pub statical: Option<f64>,
    /// f₀ [-].
    pub static_factor: Option<f64>,
}

/// Load ratings of a bearing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ratings {
    /// C [N].
    pub dynamic: f64,
    /// C₀ [N].
    pub statical: f64,
    /// f₀ [-].
    pub static_factor: f64,
}

impl Ratings {
    /// The ratings of a maker, completed by those of ISO 281 and ISO 76.
    pub fn of(bearing: &Bearing, makers: &MakersRatings) -> Self {
        let factor = makers.static_factor.unwrap_or_else(|| static_factor(bearing.gamma()));
        Self {
            dynamic: makers.dynamic.unwrap_or_else(|| dynamic_load_rating(bearing)),
            statical: makers.statical.unwrap_or_else(|| static_load_rating(bearing, factor)),
            static_factor: factor,
        }
    }
}

/// Basic static radial load rating [N] of one row of balls, C₀ = f₀ Z d² cos α, d in mm (ISO 76).
pub fn static_load_rating(bearing: &Bearing, static_factor: f64) -> f64 {
    let (p, angle) = (&bearing.parameters, bearing.kinematic_contact_angle());
    static_factor * p.ball_count as f64 * (1e3 * p.ball_diameter).powi(2) * angle.cos()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::presets;

    /// 6205: f₀ 13.90 and C₀ 7.89 kN by the formula, 7.85 kN printed.
    #[test]
    fn ratings_of_the_6205() {
        let preset = presets::bearing("6205").unwrap();
        let bearing = Bearing::new(preset.defaults.parameters(&preset.dimensions)).unwrap();
        let computed = Ratings::of(&bearing, &MakersRatings::default());
        assert!((computed.static_factor - 13.90).abs() < 0.01, "{computed:?}");
        assert!((computed.statical / 7890.0 - 1.0).abs() < 1e-3, "{computed:?}");
        let makers = MakersRatings { dynamic: Some(14e3), statical: Some(7850.0), static_factor: Some(13.9) };
        assert_eq!(Ratings::of(&bearing, &makers), Ratings { dynamic: 14e3, statical: 7850.0, static_factor: 13.9 });
    }
}
