//! Robustness of the article's statements against the parameters that it does not give: parameter sets sampled over their ranges.

use rand_xoshiro::SplitMix64;
use rand_xoshiro::rand_core::{RngCore, SeedableRng};
use serde_json::{Value, json};

use super::claims::{Claim, Finding, SHOWN, Verdict, compared, judged};
use super::figures::{DEEP_GROOVE, INTEGRATED};
use crate::contract::{self, TableAnswer};
use raceway_core::study::{Goal, best};

/// A parameter that the article does not give, and its sampled range.
pub struct Parameter {
    pub name: &'static str,
    pub unit: &'static str,
    from: f64,
    to: f64,
    /// True if the logarithm of the parameter is sampled uniformly.
    logarithmic: bool,
    set: fn(&mut Value, f64),
}

impl Parameter {
    pub fn range(&self) -> (f64, f64) {
        (self.from, self.to)
    }

    pub fn is_logarithmic(&self) -> bool {
        self.logarithmic
    }
}

/// The parameters; the report gives the reasons of their ranges.
pub const PARAMETERS: [Parameter; 7] = [
    Parameter {
        name: "spindle mass",
        unit: "kg",
        from: 0.02,
        to: 0.2,
        logarithmic: true,
        set: |scene, mass| scene["spindle"]["mass_kg"] = mass.into(),
    },
    Parameter {
        name: "radial clearance",
        unit: "µm",
        from: 2.0,
        to: 13.0,
        logarithmic: false,
        set: |scene, clearance| scene["bearing"]["radial_clearance_um"] = clearance.into(),
    },
    Parameter {
        name: "restitution of the raceways at 0.1 m/s",
        unit: "",
        from: 0.5,
        to: 0.95,
        logarithmic: false,
        set: |scene, restitution| scene["damping"]["raceway"]["restitution"] = restitution.into(),
    },
    Parameter {
        name: "largest traction",
        unit: "",
        from: 0.03,
        to: 0.09,
        logarithmic: false,
        set: |scene, maximum| {
            let traction = &mut scene["lubricant"]["traction"];
            let limit = traction["limit"].as_f64().unwrap_or(0.0) / traction["maximum"].as_f64().unwrap_or(1.0);
            traction["maximum"] = maximum.into();
            traction["limit"] = (limit * maximum).into();
        },
    },
    Parameter {
        name: "viscosity of the base oil",
        unit: "Pa·s",
        from: 0.01,
        to: 0.2,
        logarithmic: true,
        set: |scene, viscosity| scene["lubricant"]["viscosity_pa_s"] = viscosity.into(),
    },
    Parameter {
        name: "unbalance, balance grade",
        unit: "mm/s",
        from: 0.0,
        to: 6.3,
        logarithmic: false,
        set: |scene, grade| scene["spindle"]["balance_grade"] = grade.into(),
    },
    Parameter {
        name: "cage mass over the preset's",
        unit: "",
        from: 0.6,
        to: 1.5,
        logarithmic: false,
        set: |scene, factor| {
            for field in ["mass_g", "axial_inertia_kg_m2", "transverse_inertia_kg_m2"] {
                let value = scene["bearing"]["cage"][field].as_f64().unwrap_or(0.0);
                scene["bearing"]["cage"][field] = (factor * value).into();
            }
        },
    },
];

/// A parameter set: values of all parameters.
pub type Set = [f64; PARAMETERS.len()];

/// A Latin hypercube: each range is divided into as many equal parts as there are sets, and each part contains one value.
pub fn sampled(sets: usize, seed: u64) -> Vec<Set> {
    let mut random = SplitMix64::seed_from_u64(seed);
    let mut sampled = vec![[0.0; PARAMETERS.len()]; sets];
    for (number, parameter) in PARAMETERS.iter().enumerate() {
        let mut parts: Vec<usize> = (0..sets).collect();
        for last in (1..sets).rev() {
            parts.swap(last, (random.next_u64() % (last as u64 + 1)) as usize);
        }
        for (set, part) in sampled.iter_mut().zip(parts) {
            // 53 random bits: uniform doubles between 0 and 1.
            let within = (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
            let share = (part as f64 + within) / sets as f64;
            let value = if parameter.logarithmic {
                parameter.from * (parameter.to / parameter.from).powf(share)
            } else {
                parameter.from + share * (parameter.to - parameter.from)
            };
            // Four digits, so that the reported values are those that ran.
            set[number] = format!("{value:.3e}").parse().unwrap_or(value);
        }
    }
    sampled
}

/// A statement that is tested with every set.
pub struct Question {
    pub figure: u32,
    pub title: &'static str,
    asked: Asked,
}

enum Asked {
    /// A trend along one axis.
    Trend(fn() -> Value, Claim),
    /// A comparison of both bearings over speed.
    Comparison,
}

fn spaced(path: &str, from: f64, to: f64, count: u32) -> Value {
    json!({ "path": path, "from": from, "to": to, "count": count })
}

fn speeds() -> Value {
    spaced("/operation/speed_rpm", 10_000.0, 60_000.0, 9)
}

const BEST_CURVATURE: Claim = Claim::LeastWithin(0.52, 0.53);

/// The statements that simulations can test.
pub const QUESTIONS: [Question; 7] = [
    Question {
        figure: 10,
        title: "curvature of the inner groove: falls, then rises, best at 0.52 to 0.53",
        asked: Asked::Trend(|| spaced("/bearing/inner_groove_curvature", 0.51, 0.55, 13), BEST_CURVATURE),
    },
    Question {
        figure: 11,
        title: "curvature of the outer groove: falls, then rises, best at 0.52 to 0.53",
        asked: Asked::Trend(|| spaced("/bearing/outer_groove_curvature", 0.51, 0.55, 9), BEST_CURVATURE),
    },
    Question {
        figure: 12,
        title: "pocket clearance: falls, then rises, best at 0.045 to 0.055 mm",
        asked: Asked::Trend(
            || spaced("/bearing/cage/pocket_clearance_mm", 0.02, 0.1, 9),
            Claim::LeastWithin(0.045, 0.055),
        ),
    },
    Question {
        figure: 13,
        title: "axial preload: falls, then rises, best at 0.5 to 0.8 % of the rating",
        asked: Asked::Trend(
            // These runs cost ten times the others: more points only near the stated optimum.
            || json!({ "quantity": "axial_load_over_rating", "values": [0.0, 0.0025, 0.005, 0.0065, 0.008, 0.0125, 0.02] }),
            Claim::LeastWithin(0.005, 0.008),
        ),
    },
    Question {
        figure: 14,
        title: "radial load: rises with it",
        asked: Asked::Trend(|| spaced("/operation/radial_load_y_n", 50.0, 400.0, 8), Claim::Rises),
    },
    Question { figure: 15, title: "speed: rises with it", asked: Asked::Trend(speeds, Claim::Rises) },
    Question { figure: 16, title: "integrated slightly lower than deep-groove", asked: Asked::Comparison },
];

/// Times of a run [s]: shorter than for the figures, but long compared with a ball passage.
const SETTLE: f64 = 0.02;
const DURATION: f64 = 0.05;

/// The studies that test the statements for a set; the last one is for the deep-groove bearing.
pub fn studies(set: &Set) -> Vec<Value> {
    let study = |bearing: &str, axis: Value| {
        let mut scene = complete(bearing);
        for (parameter, value) in PARAMETERS.iter().zip(set) {
            (parameter.set)(&mut scene, *value);
        }
        json!({
            "kind": "study", "scene": scene, "axes": [axis], "settle_s": SETTLE, "duration_s": DURATION,
            "outputs": { "metrics": ["vibration"] },
        })
    };
    let mut studies: Vec<Value> = Vec::new();
    for question in &QUESTIONS {
        match question.asked {
            Asked::Trend(axis, _) => studies.push(study(INTEGRATED, axis())),
            Asked::Comparison => studies.push(study(DEEP_GROOVE, speeds())),
        }
    }
    studies
}

/// A preset in the article's operation with all defaults, so that parameters outside the set keep their values; without the spindle's fields.
fn complete(bearing: &str) -> Value {
    let scene = json!({ "scene": { "bearing": bearing, "operation": super::figures::operation() } });
    let job = contract::parse_scene_request(scene.to_string().as_bytes());
    let mut scene = job.map(|job| job.scene_json()).unwrap_or_default();
    // The spindle is free in axial direction only with an axial load.
    scene["spindle"] = json!({});
    scene
}

/// Findings of the tables of a set: for each question, one finding for each metric.
pub fn answers(tables: &[TableAnswer]) -> Vec<Vec<Finding>> {
    let by_speed = QUESTIONS.iter().position(|question| question.figure == 15).unwrap_or(0);
    let of = |(question, table): (&Question, &TableAnswer)| match question.asked {
        Asked::Trend(_, claim) => judged(table, claim),
        Asked::Comparison => compared(&tables[by_speed], table),
    };
    QUESTIONS.iter().zip(tables).map(of).collect()
}

/// A set and its findings.
pub struct Judged {
    pub set: Set,
    /// Verdicts by question and metric.
    pub findings: Vec<Vec<Finding>>,
    /// Inner groove curvature of the lowest level, in Y and Z.
    pub best_curvature: [Option<f64>; 2],
    /// Number of failed simulations.
    pub failed: u64,
}

impl Judged {
    pub fn of(set: Set, tables: &[TableAnswer]) -> Self {
        let least = |metric: usize| {
            let table = tables.first()?;
            let found = best(&table.column(SHOWN[metric].1), Goal::Least)?;
            table.axes.first()?.values.get(found.point)?.as_f64()
        };
        Self {
            set,
            findings: answers(tables),
            best_curvature: [least(2), least(3)],
            failed: tables.iter().map(|table| table.ended - table.succeeded).sum(),
        }
    }

    /// Confirmed share of a statement, 0–1: mean over the metrics, where a partly confirmed one counts half.
    pub fn score(&self, question: usize) -> f64 {
        let findings = &self.findings[question];
        let points = findings.iter().map(|finding| match finding.verdict {
            Verdict::Shown => 1.0,
            Verdict::InPart => 0.5,
            Verdict::NotShown => 0.0,
        });
        points.sum::<f64>() / findings.len().max(1) as f64
    }
}

/// Dependence of a score on a parameter: mean scores for the lower, middle and upper third of the parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Influence {
    pub thirds: [f64; 3],
    /// Largest difference between two thirds, divided by its standard deviation by chance [-].
    pub strength: f64,
}

/// Influence of each parameter on a score of the sets.
pub fn influences(sets: &[Set], scores: &[f64]) -> Vec<Influence> {
    let n = scores.len() as f64;
    let mean = scores.iter().sum::<f64>() / n.max(1.0);
    let variance = scores.iter().map(|score| (score - mean).powi(2)).sum::<f64>() / (n - 1.0).max(1.0);
    let by_chance = (variance * 6.0 / n.max(1.0)).sqrt();
    let one = |number: usize| {
        let mut order: Vec<usize> = (0..sets.len()).collect();
        order.sort_by(|a, b| sets[*a][number].total_cmp(&sets[*b][number]));
        let third = |k: usize| {
            let part = &order[k * order.len() / 3..(k + 1) * order.len() / 3];
            part.iter().map(|set| scores[*set]).sum::<f64>() / part.len().max(1) as f64
        };
        let thirds = [third(0), third(1), third(2)];
        let span = thirds.iter().copied().fold(f64::NEG_INFINITY, f64::max)
            - thirds.iter().copied().fold(f64::INFINITY, f64::min);
        Influence { thirds, strength: if by_chance > 0.0 { span / by_chance } else { 0.0 } }
    };
    (0..PARAMETERS.len()).map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_latin_hypercube_has_one_value_in_each_part_and_is_the_same_again() {
        let sets = sampled(50, 1);
        assert_eq!(sets, sampled(50, 1));
        assert_ne!(sets, sampled(50, 2));
        for (number, parameter) in PARAMETERS.iter().enumerate() {
            let part = |set: &Set| {
                let share = if parameter.logarithmic {
                    (set[number] / parameter.from).ln() / (parameter.to / parameter.from).ln()
                } else {
                    (set[number] - parameter.from) / (parameter.to - parameter.from)
                };
                (50.0 * share).floor() as usize
            };
            let mut parts: Vec<usize> = sets.iter().map(part).collect();
            parts.sort_unstable();
            // Rounding to four digits may move a value into the next part.
            let off = parts.iter().enumerate().filter(|(k, part)| k != *part).count();
            assert!(off <= 2, "{}: {parts:?}", parameter.name);
        }
    }

    #[test]
    fn every_study_of_a_set_can_be_run_and_has_the_values_of_the_set() {
        let set = sampled(3, 7)[1];
        let all = studies(&set);
        assert_eq!(all.len(), QUESTIONS.len());
        for request in all {
            let job = contract::parse_job(request.to_string().as_bytes())
                .unwrap_or_else(|refusal| panic!("{request}: {refusal}"));
            let study = job.into_study().unwrap();
            let last = study.point(study.points - 1).unwrap();
            let scene = last.scene();
            assert!((scene.spindle.mass / set[0] - 1.0).abs() < 1e-12);
            assert!((scene.bearing.radial_clearance / (1e-6 * set[1]) - 1.0).abs() < 1e-9);
            let axial = scene.operation.load[0] > 0.0;
            assert_eq!(axial, scene.spindle.axial == raceway_core::physics::spindle::AxialHold::Free);
        }
    }

    #[test]
    fn the_parameter_that_decides_is_found() {
        let sets = sampled(200, 3);
        let scores: Vec<f64> = sets.iter().map(|set| f64::from(u8::from(set[0] > 0.06))).collect();
        let found = influences(&sets, &scores);
        assert!(found[0].strength > 10.0 && found[0].thirds[0] == 0.0 && found[0].thirds[2] == 1.0, "{found:?}");
        assert!(found[1..].iter().all(|other| other.strength < 3.5), "{found:?}");
        assert_eq!(influences(&sets, &vec![0.5; 200])[0].strength, 0.0);
    }
}
