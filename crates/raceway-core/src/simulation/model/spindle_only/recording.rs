//! Recording of a motion of the spindle alone: its signals, and speeds of cage and balls by ideal rolling.

use super::equations::SpindleOnly;
use crate::numerics::ode::Statistics;
use crate::physics::bearing::PerRaceway;
use crate::physics::kinematics::BodySpeeds;
use crate::simulation::model::mechanism::Mechanism;
use crate::simulation::recording::record::{ContactExtremes, Recording};
use crate::simulation::recording::sampling::SPINDLE_IN_PLANE;
use crate::simulation::recording::windows::Recorder;

/// The recording of a run whose spindle signals are in `recorder`; `total_variance`: variance of each signal before any filter.
pub(crate) fn recording(
    model: &SpindleOnly,
    mechanism: &Mechanism,
    start: f64,
    duration: f64,
    recorder: Recorder,
    total_variance: Option<[f64; 6]>,
) -> Recording {
    let series = recorder.series();
    let (signals, spindle_whirl) = recorder.finish();
    let balls = mechanism.layout.balls;
    let none = ContactExtremes { max_load: vec![0.0; balls], angle: None, max_slip: 0.0, least_film: None, off: None };
    let turned = |time: f64| mechanism.rotation.inner.at(time).0;
    let (begin, _) = model.speed(start);
    let mean = if duration > 0.0 { (turned(start + duration) - turned(start)) / duration } else { begin };
    Recording {
        start,
        signals,
        series,
        whirl: None,
        spindle_whirl,
        total_variance: SPINDLE_IN_PLANE.into_iter().zip(total_variance.into_iter().flatten()).collect(),
        contacts: PerRaceway { inner: none.clone(), outer: none },
        max_pocket_load: 0.0,
        direction: if mean < 0.0 { -1.0 } else { 1.0 },
        speeds: BodySpeeds::new(
            mean.into(),
            model.orbit_ratio() * mean,
            ((mechanism.spin_ratio - mechanism.orbit_ratio) * mean).abs(),
        ),
        loaded_orbit_ratio: None,
        load_means: None,
        powers: None,
        tracks: Vec::new(),
        parts: Vec::new(),
        loads: None,
        passages: Vec::new(),
        largest_pocket_offset: None,
    }
}

/// Work statistics of steps of one length [s].
pub(crate) fn statistics(steps: u64, rhs_evaluations: u64, step: f64) -> Statistics {
    let advanced = steps as f64 * step;
    Statistics { steps, rhs_evaluations, least_step: step, advanced, ..Statistics::default() }
}
