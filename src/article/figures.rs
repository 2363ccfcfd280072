//! The figures: the jobs of each, and the article's statement.

use serde_json::{Value, json};

use super::claims::Claim;

/// One figure, or several figures from one run.
#[derive(Debug, Clone)]
pub struct Figure {
    /// First number, and name of the figures.
    pub number: u32,
    pub title: &'static str,
    /// The article's statement, paraphrased.
    pub says: &'static str,
    /// Remark on the verdict.
    pub remark: &'static str,
    pub subject: Subject,
}

/// Subject of a figure.
#[derive(Debug, Clone)]
pub enum Subject {
    /// Series over time of one run.
    Series { job: Value, quantity: &'static str },
    /// The lines of a spectrum.
    Spectrum(Lines),
    /// A study over one axis.
    Trend { study: Value, claim: Claim },
    /// Optima of several metrics over one range: name of the metric and job.
    Optimum { jobs: Vec<(&'static str, Value)>, within: (f64, f64) },
    /// Two bearings against speed.
    Comparison(Compared),
    /// Force of a ball in its pocket, compared with finite elements: the bearing, and the case of the finite elements.
    Pocket { scene: Value, case: &'static str },
}

/// A spectrum and its lines according to the article [Hz].
#[derive(Debug, Clone)]
pub struct Lines {
    pub job: Value,
    pub unbalanced: Value,
    pub said: [(f64, &'static str); 4],
}

/// The integrated and the deep-groove bearing.
#[derive(Debug, Clone)]
pub struct Compared {
    pub integrated: Value,
    pub deep_groove: Value,
}

pub fn operation() -> Value {
    json!({ "speed_rpm": 50_000, "radial_load_y_n": 200, "radial_load_z_n": 0, "axial_load_n": 0 })
}

/// The full model with all terms: trends of some hundredths of a decibel must be resolved.
fn job(bearing: &str, extra: Value) -> Value {
    let mut job = json!({
        "kind": "simulation", "settle_s": 0.05, "duration_s": 0.2,
        "scene": { "bearing": bearing, "operation": operation() },
        "solver": { "rung": "full", "model_tolerance_db": 0 },
        "outputs": { "metrics": ["vibration"] },
    });
    if let (Value::Object(job), Value::Object(extra)) = (&mut job, extra) {
        job.extend(extra);
    }
    job
}

fn study(bearing: &str, axis: Value) -> Value {
    job(bearing, json!({ "kind": "study", "axes": [axis] }))
}

/// Job for the inner groove curvature of the lowest level in one direction.
fn optimum(direction: &str) -> Value {
    let axis = json!({ "path": "/bearing/inner_groove_curvature", "from": 0.51, "to": 0.55 });
    let mut sought = study(INTEGRATED, axis);
    sought["kind"] = "optimum".into();
    sought["metric"] = format!("/channels/spindle.{direction}.acceleration/level_db").into();
    sought
}

pub const INTEGRATED: &str = "article-integrated";
pub const DEEP_GROOVE: &str = "article-deep-groove";

/// All figures that simulations reproduce, in the article's order.
pub fn figures() -> Vec<Figure> {
    let spaced =
        |path: &str, from: f64, to: f64, count: u32| json!({ "path": path, "from": from, "to": to, "count": count });
    let speeds = || spaced("/operation/speed_rpm", 10_000.0, 60_000.0, 26);
    let series = |quantity: &'static str| Subject::Series {
        job: job(
            INTEGRATED,
            json!({
                "duration_s": 0.02,
                "outputs": { "metrics": ["vibration"], "series": [format!("spindle.y.{quantity}"), format!("spindle.z.{quantity}")] }
            }),
        ),
        quantity,
    };
    vec![
        Figure {
            number: 5,
            title: "Figures 5 and 6: velocity of the spindle over time",
            says: "Velocity of the spindle's centre in Y and Z at 50 000 r/min under 200 N. No number is given.",
            remark: "For visual comparison. The article does not give spindle mass, bearing clearance and contact damping; the values of the preset are used.",
            subject: series("velocity"),
        },
        Figure {
            number: 7,
            title: "Figures 7 and 8: acceleration of the spindle over time",
            says: "Acceleration in Y and Z, whose rms value gives the level by equation (15). No number is given.",
            remark: "The reference of the level, 9.81·10⁻³ m/s², is the article's; the minus sign of the exponent is missing in print.",
            subject: series("acceleration"),
        },
        Figure {
            number: 9,
            title: "Figure 9: spectrum of the acceleration",
            says: "Lines at 833 Hz (f_r), 1666 Hz (2 f_r), 2333 Hz (f_r + ½ f_i) and 3800 Hz (f_i).",
            remark: "The article's numbers contradict each other. Its equation (16) gives 7080 Hz for f_i, or 3540 Hz with the factor ½ that is missing there. f_r + ½ · 3800 is 2733 Hz. 2333 Hz is 1.7 % from the ball pass frequency of the outer raceway, 2293 Hz. With ideal circles and without unbalance, as in its equations (13) and (14), no excitation rotates with the spindle, and no line at f_r can appear. The run with balance grade G 6.3 has this line.",
            subject: Subject::Spectrum(Lines {
                job: job(INTEGRATED, json!({ "duration_s": 0.5 })),
                unbalanced: {
                    let mut unbalanced = job(INTEGRATED, json!({ "duration_s": 0.5 }));
                    unbalanced["scene"]["spindle"] = json!({ "balance_grade": 6.3 });
                    unbalanced
                },
                said: [(833.0, "f_r"), (1666.0, "2 f_r"), (2333.0, "f_r + ½ f_i"), (3800.0, "f_i")],
            }),
        },
        Figure {
            number: 10,
            title: "Figure 10: curvature of the inner groove",
            says: "Velocity and level fall, then rise with the curvature; best at 0.52 to 0.53.",
            remark: "The stiffness of a Hertz contact falls monotonically with the curvature. An optimum would need another cause in the model.",
            subject: Subject::Trend {
                study: study(INTEGRATED, spaced("/bearing/inner_groove_curvature", 0.51, 0.55, 17)),
                claim: Claim::LeastWithin(0.52, 0.53),
            },
        },
        Figure {
            number: 10,
            title: "Figure 10, optimum: inner groove curvature of the lowest level",
            says: "Best at 0.52 to 0.53.",
            remark: "Found by an optimum job between 0.51 and 0.55 for each direction. Other points whose level may be as low within the errors are listed.",
            subject: Subject::Optimum {
                jobs: vec![("acceleration level, Y", optimum("y")), ("acceleration level, Z", optimum("z"))],
                within: (0.52, 0.53),
            },
        },
        Figure {
            number: 11,
            title: "Figure 11: curvature of the outer groove",
            says: "Velocity and level fall, then rise with the curvature; best at 0.52 to 0.53.",
            remark: "As for the inner groove.",
            subject: Subject::Trend {
                study: study(INTEGRATED, spaced("/bearing/outer_groove_curvature", 0.51, 0.55, 17)),
                claim: Claim::LeastWithin(0.52, 0.53),
            },
        },
        Figure {
            number: 12,
            title: "Figure 12: clearance of the cage's pockets",
            says: "Velocity and level fall, then rise with the clearance; best at 0.045 to 0.055 mm.",
            remark: "The article does not state whether its clearance is diametral or radial; diametral is assumed.",
            subject: Subject::Trend {
                study: study(INTEGRATED, spaced("/bearing/cage/pocket_clearance_mm", 0.02, 0.1, 17)),
                claim: Claim::LeastWithin(0.045, 0.055),
            },
        },
        Figure {
            number: 13,
            title: "Figure 13: axial preload",
            says: "A preload reduces vibration; it falls, then rises, and is best at 0.5 to 0.8 % of the dynamic load rating.",
            remark: "In the article's equations the spindle is fixed along X and carries no axial force. Here the spindle is free along X and carries the load.",
            subject: Subject::Trend {
                study: study(
                    INTEGRATED,
                    json!({ "quantity": "axial_load_over_rating", "from": 0.0, "to": 0.02, "count": 21 }),
                ),
                claim: Claim::LeastWithin(0.005, 0.008),
            },
        },
        Figure {
            number: 14,
            title: "Figure 14: radial load",
            says: "Velocity and level rise with the load. (Also: an appropriate load can reduce vibration.)",
            remark: "The two sentences contradict each other where the rise is monotonic.",
            subject: Subject::Trend {
                study: study(INTEGRATED, spaced("/operation/radial_load_y_n", 50.0, 400.0, 15)),
                claim: Claim::Rises,
            },
        },
        Figure {
            number: 15,
            title: "Figure 15: speed",
            says: "Velocity and level rise with the speed. (The abstract: there is an optimal range of speeds.)",
            remark: "The two sentences contradict each other where the rise is monotonic.",
            subject: Subject::Trend { study: study(INTEGRATED, speeds()), claim: Claim::Rises },
        },
        Figure {
            number: 16,
            title: "Figure 16 and Table 4: integrated against deep-groove bearing",
            says: "Both curves over speed are almost the same; the level of the integrated bearing is slightly lower.",
            remark: "Groove curvature, clearance and pockets of the deep-groove bearing are not given; those of the integrated one are used. The spindle mass follows from the bore.",
            subject: Subject::Comparison(Compared {
                integrated: study(INTEGRATED, speeds()),
                deep_groove: study(DEEP_GROOVE, speeds()),
            }),
        },
        Figure {
            number: 17,
            title: "Figures 17 and 18: pocket force against finite elements",
            says: "The largest force between ball and cage by finite elements (204 251 of them, Ansys) and by the dynamics agree to 13 %, which validates the model.",
            remark: "Here the contact law is compared with our own finite elements (CalculiX, `verification/pocket`), to which it is fitted, over all loads of the simulations. The article compares two programs at one load, and does not name the load.",
            subject: Subject::Pocket {
                scene: json!({ "bearing": INTEGRATED, "operation": operation() }),
                case: "clearance-51",
            },
        },
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::parse_job;

    #[test]
    fn every_figure_is_a_job_that_can_be_run() {
        let all = figures();
        assert!(all.windows(2).all(|pair| pair[0].number <= pair[1].number));
        for figure in all {
            let jobs = match figure.subject {
                Subject::Series { job, .. } => vec![job],
                Subject::Spectrum(lines) => vec![lines.job, lines.unbalanced],
                Subject::Trend { study, .. } => vec![study],
                Subject::Optimum { jobs, .. } => jobs.into_iter().map(|job| job.1).collect(),
                Subject::Comparison(both) => vec![both.integrated, both.deep_groove],
                Subject::Pocket { .. } => Vec::new(),
            };
            for job in jobs {
                let parsed = parse_job(job.to_string().as_bytes()).unwrap_or_else(|refusal| panic!("{job}: {refusal}"));
                let last = parsed.into_study().map(|study| study.point(study.points - 1).map(|_| ()));
                assert!(last.is_none_or(|last| last.is_ok()), "{job}");
            }
        }
    }
}
