//! Loads on the spindle or on the shaft that may vary.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::surfaces::are_within_limits;
use crate::contract::json::defaults::Defaults;
use crate::contract::json::problem::listed;
use crate::contract::json::shapes::{optional_list, optional_object};
use crate::contract::json::units::{DEG, HZ, N, N_M, NUMBER, S, Unit};
use raceway_core::physics::limits::MOST_POINTS;
use raceway_core::physics::loads::{Harmonic, Load, LoadCourse, LoadDirection, LoadRate, MOST_LOADS, Shock};

/// A load on the spindle, at its centre of mass, or on a place of the shaft: exactly one of `constant_n`, `points`, `harmonic`, `rotating`, `shock` and `series`. Moments have
/// `n_m` in place of `n`. Times count from the start, settling included.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(example = json!({"direction": "y", "harmonic": {"amplitude_n": 50, "order": 2, "phase_deg": 0}}))]
pub struct LoadInput {
    /// The body that the load acts on: `shaft` where the scene has one, else `spindle`, which is the default.
    #[schema(nullable = false)]
    pub on: Option<LoadedBody>,
    /// Place along the shaft [mm]. Default: the mass centre of shaft and discs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, example = 150.0)]
    pub at_mm: Option<f64>,
    /// Required, except for a rotating load. `x` requires a spindle or shaft that is free in axial direction, moments a shaft, or a spindle that
    /// tilts freely.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub direction: Option<LoadDirectionInput>,
    /// Constant force [N].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub constant_n: Option<f64>,
    /// Constant moment [N·m].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub constant_n_m: Option<f64>,
    /// Straight lines between up to 1000 points, constant outside them.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "optional_list")]
    #[schema(nullable = false)]
    pub points: Option<Vec<LoadPointInput>>,
    /// A load that oscillates.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "optional_object")]
    #[schema(nullable = false)]
    pub harmonic: Option<HarmonicLoadInput>,
    /// A force that turns from +Y to +Z.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "optional_object")]
    #[schema(nullable = false)]
    pub rotating: Option<RotatingLoadInput>,
    /// Half of a sine.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "optional_object")]
    #[schema(nullable = false)]
    pub shock: Option<ShockInput>,
    /// An uploaded series.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "optional_object")]
    #[schema(nullable = false)]
    pub series: Option<LoadSeriesInput>,
}

/// A body that loads act on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum LoadedBody {
    Spindle,
    Shaft,
}

/// Axis of a force, or axis that a moment turns about. Y points along gravity, X along the bearing's axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum LoadDirectionInput {
    X,
    Y,
    Z,
    AboutY,
    AboutZ,
}

/// Load at a time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct LoadPointInput {
    /// Time since the start [s]; increases from point to point.
    #[schema(example = 0.0)]
    pub at_s: f64,
    /// Force [N].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, example = 100.0)]
    pub n: Option<f64>,
    /// Moment [N·m].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub n_m: Option<f64>,
}

/// amplitude · cos(2π · `frequency_hz` · t + phase), or amplitude · cos(`order` · angle of the spindle + phase).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct HarmonicLoadInput {
    /// Amplitude of a force [N].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, example = 50.0)]
    pub amplitude_n: Option<f64>,
    /// Amplitude of a moment [N·m].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub amplitude_n_m: Option<f64>,
    /// Frequency [Hz]. Either this or `order`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub frequency_hz: Option<f64>,
    /// Periods in a turn of the spindle [-]; at most 100 kHz at the largest speed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, example = 2.0)]
    pub order: Option<f64>,
    /// Phase [°]. Default 0.
    #[schema(nullable = false)]
    pub phase_deg: Option<f64>,
}

/// A force of constant magnitude: in Y as the harmonic load, in Z with sin in place of cos. Order 1 turns with the spindle, as an unbalance.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct RotatingLoadInput {
    /// Magnitude [N].
    #[schema(example = 50.0)]
    pub amplitude_n: f64,
    /// Frequency [Hz]. Either this or `order`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub frequency_hz: Option<f64>,
    /// Turns of the force in a turn of the spindle [-]; at most 100 kHz at the largest speed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, example = 1.0)]
    pub order: Option<f64>,
    /// Angle from +Y towards +Z at the start [°]. Default 0.
    #[schema(nullable = false)]
    pub phase_deg: Option<f64>,
}

/// peak · sin(π (t − `at_s`)/`duration_s`) during its time, else 0.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ShockInput {
    /// Largest force [N].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, example = 500.0)]
    pub peak_n: Option<f64>,
    /// Largest moment [N·m].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub peak_n_m: Option<f64>,
    /// Begin [s].
    #[schema(example = 0.05)]
    pub at_s: f64,
    /// Duration [s].
    #[schema(example = 0.001)]
    pub duration_s: f64,
}

/// Values of an uploaded series from time 0 on, in N or N·m by the direction; cubic between values, constant after the last one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct LoadSeriesInput {
    /// Content hash that `POST /v1/series` answers.
    #[schema(pattern = "^[0-9a-f]{64}$", example = "6f0c4b3e5f7a1d2c8b9e0f1a2b3c4d5e6f708192a3b4c5d6e7f8091a2b3c4d5e")]
    pub hash: String,
}

pub(super) const POINTER: &str = "/scene/operation/loads";

/// Loads on the spindle in `physics`. A load with an error is left out.
pub fn resolve(loads: &mut Option<Vec<LoadInput>>, defaults: &mut Defaults) -> Vec<Load> {
    let count = loads.as_ref().map_or(0, Vec::len);
    if count > MOST_LOADS {
        defaults.refuse(POINTER, format!("{count} loads: at most {MOST_LOADS}"));
    }
    let all = loads.iter_mut().flatten().enumerate().take(MOST_LOADS);
    let resolve = |(index, load): (usize, &mut LoadInput)| {
        let at = format!("{POINTER}/{index}");
        if load.on == Some(LoadedBody::Shaft) {
            defaults.refuse(format!("{at}/on"), "the scene has no `shaft`: leave it out, or give `spindle`");
        }
        if load.at_mm.is_some() {
            defaults.refuse(
                format!("{at}/at_mm"),
                "only a `shaft` has places: the load acts at the centre of mass of the spindle",
            );
        }
        defaults.fill(format!("{at}/on"), &mut load.on, LoadedBody::Spindle);
        load.resolve(&at, defaults)
    };
    all.filter_map(resolve).collect()
}

impl LoadDirectionInput {
    fn in_physics(self) -> LoadDirection {
        match self {
            Self::X => LoadDirection::X,
            Self::Y => LoadDirection::Y,
            Self::Z => LoadDirection::Z,
            Self::AboutY => LoadDirection::AboutY,
            Self::AboutZ => LoadDirection::AboutZ,
        }
    }
}

/// Where the values of a load stand, and whether they are moments.
struct Place<'a> {
    pointer: &'a str,
    is_moment: bool,
}

impl Place<'_> {
    /// The given one of a force and a moment with names such as `peak_n` and `peak_n_m`; `None` after an error.
    fn pick(&self, names: [&str; 2], given: [Option<f64>; 2], defaults: &mut Defaults) -> Option<f64> {
        let (own, other) = if self.is_moment { (1, 0) } else { (0, 1) };
        if given[other].is_some() {
            let kind = if self.is_moment { "moment" } else { "force" };
            let detail = format!("the direction is that of a {kind}: give {}", names[own]);
            defaults.refuse(format!("{}/{}", self.pointer, names[other]), detail);
            return None;
        }
        if given[own].is_none() {
            defaults.refuse(format!("{}/{}", self.pointer, names[own]), "required, but missing");
        }
        given[own]
    }

    fn unit(&self) -> Unit {
        if self.is_moment { N_M } else { N }
    }

    /// The name in `physics` and the field of a force or a moment.
    fn name<'n>(&self, force: (&'n str, &'n str), moment: (&'n str, &'n str)) -> (&'n str, &'n str) {
        if self.is_moment { moment } else { force }
    }
}

impl LoadInput {
    /// `None` after an error.
    pub(super) fn resolve(&mut self, at: &str, defaults: &mut Defaults) -> Option<Load> {
        let kinds = [
            ("constant_n", self.constant_n.is_some() || self.constant_n_m.is_some()),
            ("points", self.points.is_some()),
            ("harmonic", self.harmonic.is_some()),
            ("rotating", self.rotating.is_some()),
            ("shock", self.shock.is_some()),
            ("series", self.series.is_some()),
        ];
        let given: Vec<&str> = kinds.iter().filter(|kind| kind.1).map(|kind| kind.0).collect();
        if given.len() != 1 {
            let all = listed(kinds.map(|kind| kind.0));
            // A part that could not be read is missing here.
            if !(given.is_empty() && kinds.iter().any(|kind| defaults.is_unread(&format!("{at}/{}", kind.0)))) {
                defaults.refuse(at, format!("takes exactly one of {all}; {} given", given.len()));
            }
            return None;
        }
        if let Some(rotating) = &mut self.rotating {
            if self.direction.is_some() {
                defaults.refuse(format!("{at}/direction"), "a rotating load acts in y and z: leave the direction out");
                return None;
            }
            return rotating.resolve(&format!("{at}/rotating"), defaults).map(Load::Rotating);
        }
        let Some(direction) = self.direction.map(LoadDirectionInput::in_physics) else {
            if !defaults.is_unread(&format!("{at}/direction")) {
                defaults.refuse(format!("{at}/direction"), "required, but missing: x, y, z, about_y or about_z");
            }
            return None;
        };
        let is_moment = direction.is_moment();
        let place = |pointer| Place { pointer, is_moment };
        let course = if let Some(points) = &self.points {
            points_of(points, &format!("{at}/points"), is_moment, defaults)?
        } else if let Some(harmonic) = &mut self.harmonic {
            let at = format!("{at}/harmonic");
            LoadCourse::Harmonic(harmonic.resolve(&place(&at), defaults)?)
        } else if let Some(shock) = &self.shock {
            let at = format!("{at}/shock");
            LoadCourse::Shock(shock.resolve(&place(&at), defaults)?)
        } else if let Some(series) = &self.series {
            let Some(samples) = defaults.uploads.get(&series.hash) else {
                defaults.refuse(
                    format!("{at}/series/hash"),
                    "no uploaded series has this hash: send it to /v1/series first",
                );
                return None;
            };
            let place = place(at);
            let (parameter, field) = place.name(("series", "series/hash"), ("series_moment", "series/hash"));
            let fields = [(parameter, field, samples.largest(), place.unit())];
            are_within_limits(defaults, (at, "operation.loads"), &fields).then_some(LoadCourse::Samples(samples))?
        } else {
            let (constants, place) = ([self.constant_n, self.constant_n_m], place(at));
            let value = place.pick(["constant_n", "constant_n_m"], constants, defaults)?;
            let (parameter, field) = place.name(("constant", "constant_n"), ("constant_moment", "constant_n_m"));
            let fields = [(parameter, field, value, place.unit())];
            are_within_limits(defaults, (at, "operation.loads"), &fields).then_some(LoadCourse::Constant(value))?
        };
        Some(Load::Along(direction, course))
    }
}

fn points_of(points: &[LoadPointInput], at: &str, is_moment: bool, defaults: &mut Defaults) -> Option<LoadCourse> {
    let known_errors = defaults.errors.len();
    if !(1..=MOST_POINTS).contains(&points.len()) {
        defaults.refuse(at, format!("{} points: must be 1 to {MOST_POINTS}", points.len()));
        return None;
    }
    let mut all = Vec::new();
    for (index, point) in points.iter().enumerate() {
        let pointer = format!("{at}/{index}");
        let place = Place { pointer: &pointer, is_moment };
        let Some(load) = place.pick(["n", "n_m"], [point.n, point.n_m], defaults) else { continue };
        let (parameter, field) = place.name(("force", "n"), ("moment", "n_m"));
        let fields = [("at", "at_s", point.at_s, S), (parameter, field, load, place.unit())];
        are_within_limits(defaults, (&pointer, "operation.loads.points"), &fields);
        all.push((point.at_s, load));
    }
    (defaults.errors.len() == known_errors).then_some(LoadCourse::Points(all))
}

/// Name of a parameter, field of the request, value and unit.
type Given = (&'static str, &'static str, f64, Unit);

/// The rate and the phase of a harmonic or rotating load with their fields; `None` after an error.
fn rate(
    (frequency, order): (Option<f64>, Option<f64>),
    phase: &mut Option<f64>,
    at: &str,
    defaults: &mut Defaults,
) -> Option<(LoadRate, f64, [Given; 2])> {
    let phase = defaults.fill(format!("{at}/phase_deg"), phase, 0.0);
    let of_phase = ("phase", "phase_deg", phase, DEG);
    let (rate, of_rate) = match (frequency, order) {
        (Some(frequency), None) => (LoadRate::Frequency(frequency), ("frequency", "frequency_hz", frequency, HZ)),
        (None, Some(order)) => (LoadRate::Order(order), ("order", "order", order, NUMBER)),
        _ => {
            defaults.refuse(at, "takes either `frequency_hz` or `order`");
            return None;
        }
    };
    Some((rate, DEG.to_si(phase), [of_phase, of_rate]))
}

impl HarmonicLoadInput {
    fn resolve(&mut self, place: &Place<'_>, defaults: &mut Defaults) -> Option<Harmonic> {
        let at = place.pointer;
        let given = [self.amplitude_n, self.amplitude_n_m];
        let amplitude = place.pick(["amplitude_n", "amplitude_n_m"], given, defaults);
        let (rate, phase, [of_phase, of_rate]) =
            rate((self.frequency_hz, self.order), &mut self.phase_deg, at, defaults)?;
        let amplitude = amplitude?;
        let (parameter, field) = place.name(("amplitude", "amplitude_n"), ("moment_amplitude", "amplitude_n_m"));
        let fields = [(parameter, field, amplitude, place.unit()), of_rate, of_phase];
        let harmonic = Harmonic { amplitude, rate, phase };
        are_within_limits(defaults, (at, "operation.loads.harmonic"), &fields).then_some(harmonic)
    }
}

impl RotatingLoadInput {
    fn resolve(&mut self, at: &str, defaults: &mut Defaults) -> Option<Harmonic> {
        let (rate, phase, [of_phase, of_rate]) =
            rate((self.frequency_hz, self.order), &mut self.phase_deg, at, defaults)?;
        let fields = [("amplitude", "amplitude_n", self.amplitude_n, N), of_rate, of_phase];
        let harmonic = Harmonic { amplitude: self.amplitude_n, rate, phase };
        are_within_limits(defaults, (at, "operation.loads.rotating"), &fields).then_some(harmonic)
    }
}

impl ShockInput {
    fn resolve(&self, place: &Place<'_>, defaults: &mut Defaults) -> Option<Shock> {
        let peak = place.pick(["peak_n", "peak_n_m"], [self.peak_n, self.peak_n_m], defaults)?;
        let (parameter, field) = place.name(("peak", "peak_n"), ("moment_peak", "peak_n_m"));
        let fields = [
            (parameter, field, peak, place.unit()),
            ("at", "at_s", self.at_s, S),
            ("duration", "duration_s", self.duration_s, S),
        ];
        let shock = Shock { peak, at: self.at_s, duration: self.duration_s };
        are_within_limits(defaults, (place.pointer, "operation.loads.shock"), &fields).then_some(shock)
    }
}
