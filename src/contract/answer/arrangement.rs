//! How neighbouring bearings of a shaft face each other.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::contract::scene::rotor_bearings::{FacesName, RotorBearingInput};
use crate::contract::scene::rotor_scene::RotorSceneInput;

/// Two neighbouring bearings along the shaft.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct ArrangementAnswer {
    /// Their names, the one at the lower place first.
    pub between: [String; 2],
    /// How they face each other.
    pub arrangement: ArrangementName,
}

/// `DB`: back to back, lines of contact apart at the shaft. `DF`: face to face. `DT`: tandem, both carry thrust in one direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub enum ArrangementName {
    #[serde(rename = "DB")]
    BackToBack,
    #[serde(rename = "DF")]
    FaceToFace,
    #[serde(rename = "DT")]
    Tandem,
}

/// The arrangement of each pair of neighbours.
pub fn arrangements(scene: &RotorSceneInput) -> Vec<ArrangementAnswer> {
    let mut bearings: Vec<&RotorBearingInput> = scene.bearings.iter().flatten().collect();
    bearings.sort_by(|one, other| one.at_mm.total_cmp(&other.at_mm));
    bearings.windows(2).map(|pair| of_pair(pair[0], pair[1])).collect()
}

fn of_pair(lower: &RotorBearingInput, higher: &RotorBearingInput) -> ArrangementAnswer {
    let [first, second] = [lower, higher].map(|bearing| bearing.faces.unwrap_or(FacesName::PlusX));
    let arrangement = match (first, second) {
        (FacesName::PlusX, FacesName::MinusX) => ArrangementName::BackToBack,
        (FacesName::MinusX, FacesName::PlusX) => ArrangementName::FaceToFace,
        _ => ArrangementName::Tandem,
    };
    ArrangementAnswer { between: [lower.name.clone(), higher.name.clone()], arrangement }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn neighbours_are_named_by_the_thrusts_that_they_carry() {
        let scene: RotorSceneInput = serde_json::from_value(json!({
            "spindle": {},
            "bearings": [
                { "name": "C", "bearing": "7008C", "at_mm": 80, "faces": "+x" },
                { "name": "A", "bearing": "7008C", "at_mm": 0 },
                { "name": "B", "bearing": "7008C", "at_mm": 20, "faces": "-x" },
                { "name": "D", "bearing": "7008C", "at_mm": 100, "faces": "+x" },
            ],
            "operation": { "speed_rpm": 1000 },
        }))
        .unwrap();
        let found = arrangements(&scene);
        let named: Vec<_> = found.iter().map(|pair| (pair.between.concat(), pair.arrangement)).collect();
        let expected = [
            ("AB".to_owned(), ArrangementName::BackToBack),
            ("BC".to_owned(), ArrangementName::FaceToFace),
            ("CD".to_owned(), ArrangementName::Tandem),
        ];
        assert_eq!(named, expected);
    }
}
