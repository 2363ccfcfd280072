//! Radial internal clearance: groups of deep-groove bearings, and what fits and temperatures take away from it.
//!
//! Clearances and lengths have the units of catalogues, µm and mm; pressures are in Pa.

use std::sync::LazyLock;

use super::bearing::PerRaceway;
use super::material::Material;

const FILE: &str = include_str!("../../data/clearance.csv");

/// Groups of ISO 5753-1, and those of NSK for bores below 10 mm.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ClearanceGroup {
    C2,
    Cn,
    C3,
    C4,
    C5,
    Mc1,
    Mc2,
    Mc3,
    Mc4,
    Mc5,
    Mc6,
}

impl ClearanceGroup {
    pub const ALL: [Self; 11] = [
        Self::C2,
        Self::Cn,
        Self::C3,
        Self::C4,
        Self::C5,
        Self::Mc1,
        Self::Mc2,
        Self::Mc3,
        Self::Mc4,
        Self::Mc5,
        Self::Mc6,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Self::C2 => "C2",
            Self::Cn => "CN",
            Self::C3 => "C3",
            Self::C4 => "C4",
            Self::C5 => "C5",
            Self::Mc1 => "MC1",
            Self::Mc2 => "MC2",
            Self::Mc3 => "MC3",
            Self::Mc4 => "MC4",
            Self::Mc5 => "MC5",
            Self::Mc6 => "MC6",
        }
    }
}

/// Bores with a group [mm]: above the first up to the second.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoreRange {
    pub over: f64,
    pub up_to: f64,
}

/// Bore from which groups MC1 to MC6 end [mm].
pub const MC_BORES_END: f64 = 10.0;

/// Clearances of groups MC1 to MC6, least and greatest [µm] (NSK, miniature and extra small bearings).
const MC: [[f64; 2]; 6] = [[0.0, 5.0], [3.0, 8.0], [5.0, 10.0], [8.0, 13.0], [13.0, 20.0], [20.0, 28.0]];

/// A line of the file.
struct Line {
    bores: BoreRange,
    /// Least and greatest clearance of C2, CN, C3, C4, C5 [µm].
    groups: [[f64; 2]; 5],
}

fn lines() -> &'static [Line] {
    static LINES: LazyLock<Vec<Line>> = LazyLock::new(|| FILE.lines().filter_map(line).collect());
    &LINES
}

/// The line's bores and clearances; `None` for the heading. A test holds that every other line is read.
fn line(text: &str) -> Option<Line> {
    let mut cells = text.split(',').map(str::parse::<f64>);
    let mut number = || cells.next()?.ok();
    let bores = BoreRange { over: number()?, up_to: number()? };
    let mut groups = [[0.0; 2]; 5];
    for limit in groups.as_flattened_mut() {
        *limit = number()?;
    }
    Some(Line { bores, groups })
}

/// Bores for which a group exists [mm].
pub fn bores_of(group: ClearanceGroup) -> BoreRange {
    let over = lines().first().map_or(f64::NAN, |line| line.bores.over);
    match group {
        ClearanceGroup::C2 | ClearanceGroup::Cn | ClearanceGroup::C3 | ClearanceGroup::C4 | ClearanceGroup::C5 => {
            BoreRange { over, up_to: lines().last().map_or(f64::NAN, |line| line.bores.up_to) }
        }
        _ => BoreRange { over: 0.0, up_to: MC_BORES_END },
    }
}

/// Least and greatest radial clearance of an unmounted bearing [µm]; `None` for bores without this group.
pub fn limits_um(group: ClearanceGroup, bore_mm: f64) -> Option<[f64; 2]> {
    let of_line = |place: usize| {
        let line = lines().iter().find(|line| bore_mm > line.bores.over && bore_mm <= line.bores.up_to)?;
        line.groups.get(place).copied()
    };
    let of_miniature = |place: usize| MC.get(place).copied().filter(|_| bore_mm > 0.0 && bore_mm < MC_BORES_END);
    match group {
        ClearanceGroup::C2 => of_line(0),
        ClearanceGroup::Cn => of_line(1),
        ClearanceGroup::C3 => of_line(2),
        ClearanceGroup::C4 => of_line(3),
        ClearanceGroup::C5 => of_line(4),
        ClearanceGroup::Mc1 => of_miniature(0),
        ClearanceGroup::Mc2 => of_miniature(1),
        ClearanceGroup::Mc3 => of_miniature(2),
        ClearanceGroup::Mc4 => of_miniature(3),
        ClearanceGroup::Mc5 => of_miniature(4),
        ClearanceGroup::Mc6 => of_miniature(5),
    }
}

/// Middle of group CN [µm]; for bores outside the table that of its nearest line.
pub fn default_clearance_um(bore_mm: f64) -> f64 {
    let line = lines().iter().find(|line| bore_mm <= line.bores.up_to).or(lines().last());
    line.map_or(f64::NAN, |line| middle(line.groups[1]))
}

/// Middle of two limits.
pub fn middle([least, greatest]: [f64; 2]) -> f64 {
    0.5 * (least + greatest)
}

/// A ring pressed on a shaft. Lengths in one unit, the interference in another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InnerFit {
    /// Diametral interference; a loose fit, below 0, has no effect.
    pub interference: f64,
    /// Bore of the shaft; 0: solid.
    pub shaft_bore: f64,
    /// Seat: bore of the ring.
    pub seat: f64,
    /// Groove bottom of the ring.
    pub groove: f64,
    pub shaft: Material,
    pub ring: Material,
}

/// A ring pressed into a housing. Lengths in one unit, the interference in another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OuterFit {
    /// Diametral interference; a loose fit, below 0, has no effect.
    pub interference: f64,
    /// Outer diameter of the housing; infinite: solid.
    pub housing_outside: f64,
    /// Seat: outer diameter of the ring.
    pub seat: f64,
    /// Groove bottom of the ring.
    pub groove: f64,
    pub housing: Material,
    pub ring: Material,
}

impl InnerFit {
    /// Contact pressure over interference and seat diameter [Pa]: Lamé's thick-walled cylinders in plane stress.
    fn pressure_factor(&self) -> f64 {
        1.0 / (inside_compliance(self.shaft, self.shaft_bore, self.seat)
            + outside_compliance(self.ring, self.seat, self.groove))
    }

    /// Contact pressure [Pa] of an interference in the unit of the lengths.
    pub fn pressure(&self) -> f64 {
        self.interference.max(0.0) / self.seat * self.pressure_factor()
    }

    /// Growth of the groove's diameter, in the unit of the interference. For a solid shaft of the ring's material it is the interference
    /// times seat over groove.
    pub fn groove_growth(&self) -> f64 {
        let share = 2.0 * self.seat * self.groove / (self.groove.powi(2) - self.seat.powi(2));
        self.interference.max(0.0) * self.pressure_factor() * share / self.ring.elastic_modulus
    }
}

impl OuterFit {
    /// Shrinkage of the groove's diameter, in the unit of the interference. For a solid housing of the ring's material it is the
    /// interference times groove over seat.
    pub fn groove_shrinkage(&self) -> f64 {
        let housing = if self.housing_outside.is_finite() {
            outside_compliance(self.housing, self.seat, self.housing_outside)
        } else {
            (1.0 + self.housing.poisson_ratio) / self.housing.elastic_modulus
        };
        let factor = 1.0 / (inside_compliance(self.ring, self.groove, self.seat) + housing);
        let share = 2.0 * self.seat * self.groove / (self.seat.powi(2) - self.groove.powi(2));
        self.interference.max(0.0) * factor * share / self.ring.elastic_modulus
    }
}

/// Shrinkage of a cylinder's outer diameter over diameter and outer pressure [1/Pa].
fn inside_compliance(of: Material, bore: f64, outside: f64) -> f64 {
    let (bore, outside) = (bore.powi(2), outside.powi(2));
    ((outside + bore) / (outside - bore) - of.poisson_ratio) / of.elastic_modulus
}

/// Growth of a cylinder's bore over diameter and inner pressure [1/Pa].
fn outside_compliance(of: Material, bore: f64, outside: f64) -> f64 {
    let (bore, outside) = (bore.powi(2), outside.powi(2));
    ((outside + bore) / (outside - bore) + of.poisson_ratio) / of.elastic_modulus
}

/// Temperatures above the one at which the clearance was measured [K], and coefficients of expansion [1/K].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Expansion {
    pub rings: PerRaceway<f64>,
    pub balls: f64,
    pub ring_expansion: f64,
    pub ball_expansion: f64,
}

impl Expansion {
    /// Clearance that the expansion takes away, in the unit of the diameters of grooves and balls.
    pub fn clearance_loss(&self, grooves: PerRaceway<f64>, ball: f64) -> f64 {
        self.ring_expansion * (self.rings.inner * grooves.inner - self.rings.outer * grooves.outer)
            + 2.0 * self.ball_expansion * self.balls * ball
    }
}

/// Diameters of the groove bottoms of a bearing with a clearance, in one unit.
pub fn groove_bottoms(pitch_diameter: f64, ball_diameter: f64, clearance: f64) -> PerRaceway<f64> {
    let half = ball_diameter + 0.5 * clearance;
    PerRaceway { inner: pitch_diameter - half, outer: pitch_diameter + half }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEEL: Material = Material { elastic_modulus: 208e9, poisson_ratio: 0.3, density: 7810.0 };

    fn on_shaft(interference: f64, shaft_bore: f64) -> InnerFit {
        InnerFit { interference, shaft_bore, seat: 25.0, groove: 31.2, shaft: STEEL, ring: STEEL }
    }

    fn assert_close(value: f64, expected: f64, tolerance: f64) {
        assert!((value / expected - 1.0).abs() < tolerance, "{value} instead of {expected}");
    }

    #[test]
    fn every_line_has_groups() {
        assert_eq!(lines().len(), FILE.lines().count() - 1);
        assert!(lines().windows(2).all(|pair| pair[0].bores.up_to == pair[1].bores.over));
        for line in lines() {
            assert!(line.groups.iter().all(|[least, greatest]| least < greatest), "{}", line.bores.over);
            assert!(line.groups.windows(2).all(|pair| middle(pair[0]) < middle(pair[1])), "{}", line.bores.over);
        }
    }

    #[test]
    fn groups_over_24_to_30_mm_are_those_of_the_standard() {
        let groups =
            [ClearanceGroup::C2, ClearanceGroup::Cn, ClearanceGroup::C3, ClearanceGroup::C4, ClearanceGroup::C5];
        let expected = [[1.0, 11.0], [5.0, 20.0], [13.0, 28.0], [23.0, 41.0], [30.0, 53.0]];
        assert_eq!(groups.map(|group| limits_um(group, 25.0)), expected.map(Some));
        assert_eq!(groups.map(|group| limits_um(group, 30.0)), expected.map(Some));
        assert_ne!(limits_um(ClearanceGroup::C3, 30.1), Some(expected[2]));
    }

    #[test]
    fn miniature_groups_end_below_10_mm() {
        assert_eq!(limits_um(ClearanceGroup::Mc3, 8.0), Some([5.0, 10.0]));
        assert_eq!(limits_um(ClearanceGroup::Mc6, 2.0), Some([20.0, 28.0]));
        assert_eq!(limits_um(ClearanceGroup::Mc3, 10.0), None);
        assert_eq!(limits_um(ClearanceGroup::Cn, 2.5), None);
        assert_eq!(limits_um(ClearanceGroup::Cn, 800.1), None);
        assert!(ClearanceGroup::ALL.iter().all(|group| limits_um(*group, f64::NAN).is_none()));
    }

    /// The defaults before groups could be chosen.
    #[test]
    fn default_is_the_middle_of_group_n() {
        let bores = [1.0, 8.0, 10.0, 20.0, 25.0, 120.0, 300.0, 900.0];
        assert_eq!(bores.map(default_clearance_um), [7.5, 7.5, 7.5, 12.5, 12.5, 28.0, 77.5, 205.0]);
    }

    /// Solid shaft of 25 mm in a ring of 31.2 mm, interference 10 µm: 14.891 MPa, the outside grows by 8.013 µm; with a bore of 10 mm in
    /// the shaft by 7.501 µm.
    #[test]
    fn fit_on_a_shaft_is_lame_s() {
        let solid = on_shaft(0.01, 0.0);
        assert_close(solid.pressure(), 14.891e6, 5e-5);
        assert_close(on_shaft(10.0, 0.0).groove_growth(), 8.013, 5e-5);
        assert_close(on_shaft(10.0, 10.0).groove_growth(), 7.501, 1e-4);
        assert_eq!(on_shaft(-5.0, 0.0).groove_growth(), 0.0);
    }

    /// 6205: a solid shaft takes 0.804 of the interference; an inner groove that is 10 K hotter takes 3.58 µm.
    #[test]
    fn clearance_of_a_6205_follows_fit_and_temperature() {
        let grooves = groove_bottoms(39.0398, 7.94004, 0.0125);
        let fit = InnerFit { groove: grooves.inner, ..on_shaft(1.0, 0.0) };
        assert_close(fit.groove_growth(), 0.804, 5e-4);
        assert_close(fit.groove_growth(), 25.0 / grooves.inner, 1e-12);
        let hot = Expansion {
            rings: PerRaceway { inner: 10.0, outer: 0.0 },
            balls: 0.0,
            ring_expansion: 11.5e-6,
            ball_expansion: 11.5e-6,
        };
        assert_close(hot.clearance_loss(grooves, 7.94004) * 1e3, 3.58, 2e-3);
        // Alike everywhere, the clearance itself expands.
        let alike = Expansion { rings: PerRaceway { inner: 10.0, outer: 10.0 }, balls: 10.0, ..hot };
        assert_close(alike.clearance_loss(grooves, 7.94004), -0.0125 * 11.5e-5, 1e-6);
    }

    /// A solid housing of the ring's material takes groove over seat; a thin one gives way.
    #[test]
    fn fit_in_a_housing_is_lame_s() {
        let solid = OuterFit {
            interference: 10.0,
            housing_outside: f64::INFINITY,
            seat: 52.0,
            groove: 47.0,
            housing: STEEL,
            ring: STEEL,
        };
        assert_close(solid.groove_shrinkage(), 10.0 * 47.0 / 52.0, 1e-12);
        let thin = OuterFit { housing_outside: 60.0, ..solid };
        assert!(thin.groove_shrinkage() < 0.8 * solid.groove_shrinkage());
        let thick = OuterFit { housing_outside: 52e3, ..solid };
        assert_close(thick.groove_shrinkage(), solid.groove_shrinkage(), 1e-5);
    }
}
