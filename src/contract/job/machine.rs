//! A machine job: a shaft on ball bearings in time.

use raceway_core::machine::channel::MachineChannel;
use raceway_core::machine::input::{Machine, MachineBearing};
use raceway_core::machine::level::{LevelChoice, ReducedLevel, inapplicability, missing_signal};
use raceway_core::machine::settings::{MachineSettings, RANGE};
use raceway_core::numerics::spectrum::EnvelopeAnalysis;
use raceway_core::physics::kinematics::RingSpeeds;
use raceway_core::simulation::input::settings::ENVELOPE;
use raceway_core::simulation::recording::sampling::RATE;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use utoipa::ToSchema;

use super::kind::JobKind;
use super::orders::OrdersInput;
use super::outputs::{EnvelopeName, MAX_CHANNELS, band_edges, envelope};
use super::recorded_turns::{RecordedBearing, RecordedTurns};
use super::shaft_draft::{ShaftDraft, ShaftRequest};
use super::submission::{ServiceFields, Submission};
use crate::contract::json::defaults::Defaults;
use crate::contract::json::given_fields::given_fields;
use crate::contract::json::numbers::{short, significant};
use crate::contract::json::problem::{Refusal, listed};
use crate::contract::json::shapes::{object, optional_object, whole_number};
use crate::contract::json::units::{DEG, US};
use crate::contract::json::uploads::Uploads;
use crate::contract::scene::rotor_scene::{ResolvedRotor, RotorSceneInput};
use crate::contract::scene::scene_input::ResolvedScene;

/// Recorded time by default [s].
const DURATION_S: f64 = 0.2;
/// Angle between the first balls of one bearing and the next [°]: the golden angle, so that no ball passages coincide.
const NEXT_AZIMUTH_DEG: f64 = 137.5;
/// Longest default recorded time of a speed profile [s].
const MAX_RUN_UP_S: f64 = 10.0;
/// Most values of all channels: they take 256 MB.
const MAX_VALUES: f64 = 3.2e7;

/// A machine job: a flexible shaft on ball bearings in time. Balls and cages of all bearings move with all their forces, the shaft by
/// its modes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = MachineJob)]
pub struct MachineInput {
    /// Kind of the computation: `machine`.
    pub kind: String,
    /// The shaft on its bearings. A `rotor` job takes the same scene.
    #[serde(deserialize_with = "object")]
    pub scene: RotorSceneInput,
    /// Recorded time, after settling [s]. Default 0.2, or up to the last point of a speed profile, at most 10 and as long as it can be kept. At most 60, and 312.5 over the number
    /// of recorded signals.
    #[schema(nullable = false, example = 0.2)]
    pub duration_s: Option<f64>,
    /// Time simulated before recording begins [s]; times of a speed profile and of loads count from its start. Default: until the slowest motion
    /// of shaft and bearings has decayed to a fiftieth, and at least three turns of the cages, at most 5; up to the first point of a speed profile.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, example = 0.1)]
    pub settle_s: Option<f64>,
    /// Step [µs]. Default: the longest whose levels a run in half steps confirms.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, example = 5.0)]
    pub step_us: Option<f64>,
    /// Highest frequency of the kept modes of the shaft over 20 kHz, the band of the levels [-]. Default 1.5.
    #[schema(nullable = false, example = 1.5)]
    pub mode_range: Option<f64>,
    /// Model level of the bearings.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "optional_object")]
    #[schema(nullable = false)]
    pub solver: Option<MachineSolverInput>,
    /// Kept time series, and order analysis. Metrics and spectra of every channel are always kept.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "optional_object")]
    #[schema(nullable = false)]
    pub outputs: Option<MachineOutputsInput>,
    /// Labels to find the job by: at most 16, each at most 200 characters.
    #[schema(nullable = false, max_items = 16, example = json!(["line 3"]))]
    pub labels: Option<Vec<String>>,
    /// Priority from 1 (first) to 4 (last). Default 2.
    #[serde(default, deserialize_with = "whole_number::<_, 1, 4>")]
    #[schema(nullable = false, example = 2)]
    pub priority: Option<u32>,
    /// True if the result of an identical finished job may be returned. Default true.
    #[schema(nullable = false)]
    pub reuse: Option<bool>,
    /// Time that the job and its result are kept after its end [s]. Default: set by the service.
    #[schema(nullable = false)]
    pub keep_for_s: Option<f64>,
}

impl ShaftRequest for MachineInput {
    fn scene(&mut self) -> &mut RotorSceneInput {
        &mut self.scene
    }

    fn service(&mut self) -> ServiceFields<'_> {
        let Self { labels, priority, reuse, keep_for_s, .. } = self;
        ServiceFields { labels, priority, reuse: *reuse, keep_for_s: *keep_for_s }
    }
}

/// Model level of the bearings of a machine.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct MachineSolverInput {
    /// Model level of all bearings: `full`, the default, or a leaner one, for radial loads at a constant speed. The first part of its record (0.1 s, or a
    /// turn of the shaft or a period of a load that takes longer) is repeated on `full`; the result states the deviation of each level
    /// (`accuracy.model_errors_db`).
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, value_type = Option<MachineRungName>)]
    pub rung: Option<String>,
    /// Largest accepted error of a level by the model [dB], in place of `rung`. Above 0, `spindle_only` and then `radially_condensed` are tried.
    /// The first whose levels deviate by no more from `full` gives the result; otherwise the job runs on `full`. All of them are without the terms
    /// of shaft and housing whose bound is as small (`scene.terms`).
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0, maximum = 20, example = 0.5)]
    pub model_tolerance_db: Option<f64>,
}

/// `full`: six degrees of freedom for each ball and the cage. The others have moments that are linear in the tilt of the ring. `planar`: balls and
/// cage move in their plane. `radially_condensed`: balls in radial equilibrium between their raceways. `spindle_only`: equally spaced balls as
/// springs.
#[derive(ToSchema)]
#[schema(rename_all = "snake_case")]
pub enum MachineRungName {
    Full,
    Planar,
    RadiallyCondensed,
    SpindleOnly,
}

impl MachineSolverInput {
    /// The level of a machine of which signals are asked for. Errors are noted in `defaults`.
    fn resolve(&self, machine: Option<&Machine>, series: &[MachineChannel], defaults: &mut Defaults) -> LevelChoice {
        if let (Some(tolerance_db), Some(_)) = (self.model_tolerance_db, &self.rung) {
            let detail = format!("{tolerance_db} dB: goes without `rung`, which selects one level");
            defaults.refuse("/solver/model_tolerance_db", detail);
        }
        match (self.rung.as_deref(), self.model_tolerance_db) {
            (Some("full"), _) => LevelChoice::Full,
            (Some(name), _) => {
                let Some(level) = ReducedLevel::named(name) else {
                    let shown: String = name.chars().take(100).collect();
                    let known = listed(ReducedLevel::ALL.map(|level| level.level().name()));
                    defaults.refuse("/solver/rung", format!("`{shown}` is unknown; available: `full`, {known}"));
                    return LevelChoice::Full;
                };
                let of_machine = machine.and_then(|machine| inapplicability(machine, level));
                if let Some(reason) = of_machine.or_else(|| missing_signal(series, level)) {
                    defaults.refuse("/solver/rung", format!("`{name}` does not apply: {reason}"));
                }
                LevelChoice::Reduced(level)
            }
            (None, Some(tolerance_db)) => {
                defaults.check("/solver/model_tolerance_db", tolerance_db);
                if tolerance_db > 0.0 { LevelChoice::Within(tolerance_db) } else { LevelChoice::Full }
            }
            (None, None) => LevelChoice::Full,
        }
    }
}

/// Requested results of a machine job beside its metrics and spectra.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct MachineOutputsInput {
    /// Channels whose complete time series are kept. Default: none. The load of ball 3 of bearing A is `A.ball.3.inner.load` or `.outer.load`; it is
    /// recorded, with its metrics, only where it is named here.
    #[schema(nullable = false, max_items = 64, example = json!(["A.y.acceleration"]))]
    pub series: Option<Vec<String>>,
    /// Lower and upper end of the frequency band whose envelope is analysed [Hz]; it must hold the resonances that impacts excite. Default:
    /// 2000 to 20 000.
    #[schema(nullable = false, example = json!([2000, 20000]))]
    pub envelope_band_hz: Option<[f64; 2]>,
    /// Kind of envelope whose spectrum is taken. Default: `magnitude`.
    #[schema(nullable = false)]
    pub envelope: Option<EnvelopeName>,
    /// Rising edges of the bands in which accelerations are summed [Hz], 2 to 17 of them, from 1 to 20 000. Default: 50, 300, 1800, 10 000.
    #[schema(nullable = false, min_items = 2, max_items = 17, example = json!([50, 300, 1800, 10000]))]
    pub bands_hz: Option<Vec<f64>>,
    /// Order spectra, order tracks and waterfalls, for a run whose speed varies. Default: none.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "optional_object")]
    #[schema(nullable = false)]
    pub orders: Option<OrdersInput>,
}

/// A checked machine job.
#[derive(Debug, Clone)]
pub struct MachineJob {
    pub submission: Submission,
    /// The request with all defaults.
    pub input: MachineInput,
    pub machine: Machine,
    pub settings: MachineSettings,
    pub level: LevelChoice,
    /// The scene of each bearing.
    pub scenes: Vec<ResolvedScene>,
    /// Pointers to the fields that got their default.
    pub defaults: Vec<String>,
}

/// Everything follows from the input.
impl PartialEq for MachineJob {
    fn eq(&self, other: &Self) -> bool {
        self.submission == other.submission && self.input == other.input
    }
}

impl MachineJob {
    /// The job of a request of this kind.
    pub fn of(request: Value, uploads: &Uploads) -> Result<Self, Refusal> {
        let mut draft = ShaftDraft::<MachineInput>::of(request, uploads)?;
        let (input, defaults) = (&mut draft.input, &mut draft.defaults);
        let machine = machine(&mut input.scene, &draft.resolved, defaults);
        let settings = settings(input, machine.as_ref(), defaults);
        // Without a settling time all speeds are constant.
        let end = settings.settle.map_or(f64::INFINITY, |settle| settle + settings.duration);
        let machine = machine.map(|machine| machine.until(end));
        let solver = input.solver.clone().unwrap_or_default();
        let level = solver.resolve(machine.as_ref(), &settings.series, defaults);
        let defaults = std::mem::take(&mut defaults.filled);
        let (submission, input, resolved) = draft.finish()?;
        // Without errors there is one.
        let machine = machine.ok_or(Refusal::Invalid { errors: Vec::new() })?;
        Ok(Self { submission, input, machine, settings, level, scenes: resolved.scenes, defaults })
    }

    /// The job with all defaults, without the fields that concern only the service.
    pub fn complete(&self) -> Value {
        let mut job = json!({
            "kind": JobKind::Machine.name(),
            "scene": given_fields(&self.input.scene),
            "duration_s": self.input.duration_s,
            "mode_range": self.input.mode_range,
        });
        if let Some(outputs) = &self.input.outputs {
            job["outputs"] = given_fields(outputs);
        }
        if let Some(solver) = &self.input.solver {
            job["solver"] = given_fields(solver);
        }
        for (field, value) in [("settle_s", self.input.settle_s), ("step_us", self.input.step_us)] {
            if let Some(value) = value {
                job[field] = value.into();
            }
        }
        job
    }
}

/// The machine in SI; `None` after errors in its bearings, and where nothing is recorded.
pub(super) fn machine(
    scene: &mut RotorSceneInput,
    resolved: &ResolvedRotor,
    defaults: &mut Defaults,
) -> Option<Machine> {
    let ResolvedRotor { rotor, complete, terms, scenes, sensors, speed, outer_speed, .. } = resolved;
    let inputs = scene.bearings.as_deref_mut().unwrap_or_default();
    if inputs.len() != scenes.len() {
        return None;
    }
    let mut bearings = Vec::with_capacity(inputs.len());
    for (index, (input, ResolvedScene { input: filled, scene, .. })) in inputs.iter_mut().zip(scenes).enumerate() {
        (input.lubricant, input.surfaces) = (filled.lubricant.clone(), filled.surfaces.clone());
        let usual = NEXT_AZIMUTH_DEG * index as f64 % 360.0;
        let pointer = format!("/scene/bearings/{index}/start_azimuth_deg");
        let azimuth = DEG.to_si(defaults.fill(pointer, &mut input.start_azimuth_deg, usual));
        bearings.push(MachineBearing { name: input.name.clone(), scene: scene.clone(), start_azimuth: azimuth });
    }
    let speeds = RingSpeeds { inner: speed.at(0.0).1, outer: outer_speed.at(0.0).1 };
    let complete = complete.clone().map(|complete| Box::new(complete.at_speeds(speeds)));
    let rotor = rotor.clone().at_speeds(speeds);
    let parts = scene.housing.iter().flat_map(|housing| housing.parts()).filter(|_| rotor.housing.moves());
    let bodies = parts.map(|part| part.name.to_owned()).collect();
    let (speed, outer_speed, sensors) = (speed.clone(), outer_speed.clone(), sensors.clone());
    let machine = Machine { rotor, bearings, speed, outer_speed, sensors, bodies, terms: *terms, complete };
    if MachineChannel::all(&machine).is_empty() {
        defaults.refuse("/scene/sensors", "required: without ball bearings nothing else is recorded");
        return None;
    }
    Some(machine)
}

/// Times, accuracy and outputs of the run. Errors are noted in `defaults`.
fn settings(input: &mut MachineInput, machine: Option<&Machine>, defaults: &mut Defaults) -> MachineSettings {
    let series = match (machine, &mut input.outputs) {
        (Some(machine), Some(outputs)) => outputs.series(machine, defaults),
        _ => Vec::new(),
    };
    let of_balls = series.iter().filter(|channel| channel.is_of_ball()).count();
    let channels = machine.map_or(1, |machine| MachineChannel::all(machine).len() + of_balls);
    let duration = checked_times(&mut input.settle_s, &mut input.duration_s, (DURATION_S, channels), machine, defaults);
    let range = defaults.fill("/mode_range", &mut input.mode_range, RANGE);
    defaults.check_of_rotor("/mode_range", range);
    if let Some(step) = input.step_us {
        defaults.check_of_rotor("/step_us", step);
    }
    let mut envelope = ENVELOPE;
    if let (Some(machine), Some(outputs)) = (machine, &mut input.outputs) {
        if let Some(orders) = &mut outputs.orders {
            // At a constant speed the number of turns does not depend on the time before.
            let run = RecordedTurns::of_machine(machine, input.settle_s.unwrap_or_default(), duration);
            orders.resolve(&run, defaults);
        }
        envelope = outputs.envelope(defaults);
    }
    let bands_hz = input.outputs.as_ref().and_then(|outputs| outputs.bands_hz.clone());
    let band_edges = band_edges(defaults, &bands_hz);
    let step = input.step_us.map(|step| US.to_si(step));
    MachineSettings { settle: input.settle_s, duration, step, range, series, envelope, band_edges }
}

/// The recorded time of a number of channels [s], by default `usual`, or up to the last point of a speed profile as far as it can
/// be kept. Errors of it and of
/// the time before are noted in `defaults`.
pub(super) fn checked_times(
    settle_s: &mut Option<f64>,
    duration_s: &mut Option<f64>,
    (usual, channels): (f64, usize),
    machine: Option<&Machine>,
    defaults: &mut Defaults,
) -> f64 {
    let longest = MAX_VALUES / (RATE * channels as f64);
    let changing = machine.into_iter().flat_map(|machine| [&machine.speed, &machine.outer_speed]);
    let changing: Vec<_> = changing.filter(|speed| !speed.is_constant()).collect();
    if !changing.is_empty() {
        let first = changing.iter().map(|speed| speed.points()[0].0).fold(f64::INFINITY, f64::min);
        let last = changing.iter().map(|speed| speed.end()).fold(0.0, f64::max);
        let settle = defaults.fill("/settle_s", settle_s, first);
        let most = MAX_RUN_UP_S.min(milliseconds(longest));
        let run_up = significant((last - settle).min(most).max(usual), 6);
        defaults.fill("/duration_s", duration_s, run_up);
    }
    let duration = defaults.fill("/duration_s", duration_s, usual);
    if let Some(settle) = *settle_s {
        defaults.check_of_rotor("/settle_s", settle);
    }
    if defaults.check_of_rotor("/duration_s", duration) && duration > longest {
        let [given, most] = [duration, milliseconds(longest)].map(short);
        defaults.refuse("/duration_s", format!("{given} s: at most {most} s with {channels} channels"));
    }
    duration
}

/// A time [s] in whole milliseconds, not more than it.
fn milliseconds(time: f64) -> f64 {
    (1e3 * time).floor() / 1e3
}

impl MachineOutputsInput {
    /// The analysed envelope. Errors are noted in `defaults`.
    fn envelope(&mut self, defaults: &mut Defaults) -> EnvelopeAnalysis {
        envelope(defaults, &mut self.envelope_band_hz, &mut self.envelope)
    }

    /// The kept series, with those of the order analysis. Errors are noted in `defaults`.
    fn series(&mut self, machine: &Machine, defaults: &mut Defaults) -> Vec<MachineChannel> {
        let names = defaults.fill("/outputs/series", &mut self.series, Vec::new());
        let mut series = channels(&names, "/outputs/series", machine, defaults);
        if let Some(orders) = &mut self.orders {
            let analysed = orders
                .resolve_channels(&MachineChannel::first_acceleration(machine).named(machine).to_string(), defaults);
            let analysed = channels(&analysed, "/outputs/orders/channels", machine, defaults);
            let turning = RecordedBearing::of_machine(machine).flat_map(|bearing| bearing.turning_channels());
            let turning = turning.filter_map(|name| MachineChannel::parse(&name, machine));
            for channel in analysed.into_iter().chain(turning) {
                if !series.contains(&channel) {
                    series.push(channel);
                }
            }
        }
        series
    }
}

/// The channels of these names. Errors are noted in `defaults`.
fn channels(names: &[String], pointer: &str, machine: &Machine, defaults: &mut Defaults) -> Vec<MachineChannel> {
    if names.len() > MAX_CHANNELS {
        defaults.refuse(pointer, format!("{} channels: at most {MAX_CHANNELS}", names.len()));
    }
    let mut channels = Vec::new();
    for (index, name) in names.iter().enumerate().take(MAX_CHANNELS) {
        let shown: String = name.chars().take(100).collect();
        match MachineChannel::parse(name, machine) {
            None => {
                let detail = format!("unknown channel `{shown}`; channels are {}", known_channels(machine));
                defaults.refuse(format!("{pointer}/{index}"), detail);
            }
            Some(channel) if channels.contains(&channel) => {
                defaults.refuse(format!("{pointer}/{index}"), format!("`{shown}` is given more than once"));
            }
            Some(channel) => channels.push(channel),
        }
    }
    channels
}

/// Channels of the first bearing and of the first sensor, as examples of all.
fn known_channels(machine: &Machine) -> String {
    let is_first = |channel: &MachineChannel| channel.source() == 0;
    let names = MachineChannel::all(machine).into_iter().filter(is_first);
    let mut names: Vec<String> = names.map(|channel| channel.named(machine).to_string()).collect();
    names.extend(
        machine.bearings.first().map(|first| format!("{0}.ball.1.inner.load, {0}.ball.1.outer.load", first.name)),
    );
    let names = names.join(", ");
    if machine.bearings.len() > 1 { format!("{names}, and those of the other bearings") } else { names }
}
