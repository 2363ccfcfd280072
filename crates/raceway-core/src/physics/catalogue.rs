//! Ball bearings by designation, from `data/bearings.csv`.
//!
//! The file gives boundary dimensions, balls, pitch circle and contact angle. The module `defaults` supplies what the file does not give.

use std::sync::LazyLock;

use super::bearing::BearingKind;
use super::defaults::{BearingDefaults, DefaultFit, Dimensions};

const FILE: &str = include_str!("../../data/bearings.csv");

/// How well the balls of a bearing are supported by its sources.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Confidence {
    /// Printed by a maker, or ratings of one maker confirmed by a second source.
    High,
    /// A unique fit to the ratings of one maker.
    Medium,
    /// Another number of balls fits almost as well, or the pitch circle was inferred.
    Low,
}

/// Frequencies of rolling at the free contact angle, over the speed of the shaft [-].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrequencyFactors {
    pub cage: f64,
    pub ball_pass_outer: f64,
    pub ball_pass_inner: f64,
    /// Turns of a ball; a ball defect strikes at twice this.
    pub ball_spin: f64,
}

/// A bearing of the catalogue.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CatalogueBearing {
    pub designation: &'static str,
    pub kind: BearingKind,
    pub dimensions: Dimensions,
    /// Free contact angle [°]; 0 for deep-groove bearings.
    pub contact_angle_deg: f64,
    /// Basic dynamic load rating as printed [kN], and the maker that prints it.
    pub listed_rating_kn: f64,
    pub rating_source: &'static str,
    /// Basic dynamic load rating by ISO 281 from the geometry [kN].
    pub rating_kn: f64,
    pub factors: FrequencyFactors,
    /// Sources of number and size of the balls.
    pub source: &'static str,
    pub confidence: Confidence,
    /// Makers with other balls, and ball sizes that fit almost as well; may be empty.
    pub note: &'static str,
}

/// All bearings, in the order of the file.
pub fn bearings() -> &'static [CatalogueBearing] {
    static BEARINGS: LazyLock<Vec<CatalogueBearing>> = LazyLock::new(|| FILE.lines().filter_map(row).collect());
    &BEARINGS
}

/// The bearing with this designation, without suffixes of seals, clearance and tolerance.
pub fn find(designation: &str) -> Option<&'static CatalogueBearing> {
    bearings().iter().find(|bearing| bearing.designation == designation)
}

impl CatalogueBearing {
    /// Series: the designation without the code of the bore and of the contact angle, such as 62 of 6205 and of 62/28, 718 of 71805C.
    pub fn series(&self) -> &'static str {
        if let Some((series, _)) = self.designation.split_once('/') {
            return series;
        }
        let digits = self.designation.find(|c: char| !c.is_ascii_digit()).unwrap_or(self.designation.len());
        // Miniature bearings have one digit for the bore: 608.
        let of_bore = if digits <= 3 { 1 } else { 2 };
        self.designation.get(..digits.saturating_sub(of_bore)).unwrap_or(self.designation)
    }

    /// Defaults of the quantities that the file does not give.
    pub fn defaults(&self) -> BearingDefaults {
        let defaults = BearingDefaults::new(self.kind, &self.dimensions);
        match self.kind {
            BearingKind::AngularContact => {
                BearingDefaults { fit: DefaultFit::ContactAngleDeg(self.contact_angle_deg), ..defaults }
            }
            BearingKind::DeepGroove | BearingKind::Integrated => defaults,
        }
    }
}

/// The bearing of a line; `None` for the heading. A test holds that every other line is read.
fn row(line: &'static str) -> Option<CatalogueBearing> {
    let cells: Vec<&'static str> = line.split(',').collect();
    let &[
        designation,
        kind,
        bore,
        outside,
        width,
        ball_count,
        ball_diameter,
        pitch_diameter,
        contact_angle,
        listed_rating,
        rating_source,
        rating,
        _,
        cage,
        outer,
        inner,
        spin,
        source,
        confidence,
        note,
    ] = cells.as_slice()
    else {
        return None;
    };
    let number = |text: &str| text.parse::<f64>().ok().filter(|value| value.is_finite());
    Some(CatalogueBearing {
        designation,
        kind: match kind {
            "deep_groove" => BearingKind::DeepGroove,
            "angular_contact" => BearingKind::AngularContact,
            _ => return None,
        },
        dimensions: Dimensions {
            outer_diameter_mm: number(outside)?,
            inner_diameter_mm: number(bore)?,
            width_mm: number(width)?,
            ball_count: ball_count.parse().ok()?,
            ball_diameter_mm: number(ball_diameter)?,
            pitch_diameter_mm: number(pitch_diameter)?,
        },
        contact_angle_deg: number(contact_angle)?,
        listed_rating_kn: number(listed_rating)?,
        rating_source,
        rating_kn: number(rating)?,
        factors: FrequencyFactors {
            cage: number(cage)?,
            ball_pass_outer: number(outer)?,
            ball_pass_inner: number(inner)?,
            ball_spin: number(spin)?,
        },
        source,
        confidence: match confidence {
            "high" => Confidence::High,
            "medium" => Confidence::Medium,
            "low" => Confidence::Low,
            _ => return None,
        },
        note,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::bearing::Bearing;
    use crate::physics::kinematics::ideal_frequencies;
    use crate::physics::rating::dynamic_load_rating;
    use std::collections::HashSet;
    use std::f64::consts::TAU;

    fn built(bearing: &CatalogueBearing) -> Bearing {
        Bearing::new(bearing.defaults().parameters(&bearing.dimensions))
            .unwrap_or_else(|errors| panic!("{}: {errors:?}", bearing.designation))
    }

    #[test]
    fn every_line_is_a_bearing() {
        assert_eq!(bearings().len(), FILE.lines().count() - 1);
        assert_eq!(bearings().len(), 394);
        let names: HashSet<_> = bearings().iter().map(|bearing| bearing.designation).collect();
        assert_eq!(names.len(), 394);
        let count = |confidence| bearings().iter().filter(|bearing| bearing.confidence == confidence).count();
        assert_eq!([Confidence::High, Confidence::Medium, Confidence::Low].map(count), [219, 166, 9]);
    }

    #[test]
    fn ratings_agree_with_iso_281() {
        for bearing in bearings() {
            let rating = dynamic_load_rating(&built(bearing)) / 1e3;
            assert!((rating / bearing.rating_kn - 1.0).abs() < 1e-3, "{}: {rating} kN", bearing.designation);
        }
    }

    /// The file has five digits.
    #[test]
    fn frequencies_agree_with_rolling() {
        for bearing in bearings() {
            let ours = ideal_frequencies(&built(bearing), TAU);
            let theirs = bearing.factors;
            let pairs = [
                (ours.cage, theirs.cage),
                (ours.ball_pass_outer, theirs.ball_pass_outer),
                (ours.ball_pass_inner, theirs.ball_pass_inner),
                (ours.ball_spin, theirs.ball_spin),
            ];
            for (ours, theirs) in pairs {
                assert!((ours / theirs - 1.0).abs() < 5e-5, "{}: {ours}, {theirs}", bearing.designation);
            }
        }
    }

    #[test]
    fn series_is_the_designation_without_bore_and_angle() {
        let series = |name| find(name).map(CatalogueBearing::series);
        let names = ["608", "6205", "62/28", "16005", "7008C", "71805AC"];
        assert_eq!(names.map(series), ["60", "62", "62", "160", "70", "718"].map(Some));
    }
}
