//! Requested results of a run.

use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::orders::{DEFAULT_CHANNEL, OrdersInput};
use super::recorded_turns::turning_channels;
use crate::contract::json::defaults::Defaults;
use crate::contract::json::numbers;
use crate::contract::json::problem::FieldError;
use crate::contract::json::shapes::optional_object;
use raceway_core::numerics::spectrum::{EnvelopeAnalysis, EnvelopeKind};
use raceway_core::physics::spindle::{AxialHold, SpindleTilt};
use raceway_core::simulation::input::channel::{Axis, BallContact, Channel};
use raceway_core::simulation::input::scene::{Scene, Term, TermChoice};
use raceway_core::simulation::input::settings::{BAND_EDGES, ENVELOPE, Outputs, longest_window};
use raceway_core::simulation::recording::sampling::BAND;

/// Requested results. Results that are not requested are neither computed nor stored.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct OutputsInput {
    /// Parts of the metrics. Default: `vibration`, `contacts` and `cage`.
    #[schema(nullable = false, max_items = 5)]
    pub metrics: Option<Vec<MetricsPart>>,
    /// Channels whose amplitude and envelope spectra are kept. Default: accelerations of the spindle in y and z.
    #[schema(nullable = false, max_items = 64, example = json!(["spindle.y.acceleration"]))]
    pub spectra: Option<Vec<String>>,
    /// Channels whose complete time series are kept. Default: none.
    #[schema(nullable = false, max_items = 64, example = json!(["cage.y.displacement"]))]
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
    #[serde(default, deserialize_with = "optional_object")]
    #[schema(nullable = false)]
    pub orders: Option<OrdersInput>,
}

/// `magnitude`: the envelope itself, in the channel's unit. `squared`: its square, in the square of the unit; the differences of a few tones
/// have no harmonics in it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum EnvelopeName {
    Magnitude,
    Squared,
}

impl From<EnvelopeName> for EnvelopeKind {
    fn from(name: EnvelopeName) -> Self {
        match name {
            EnvelopeName::Magnitude => Self::Magnitude,
            EnvelopeName::Squared => Self::Squared,
        }
    }
}

/// `vibration`: channels and spectral lines. `contacts`: loads, pressure and slip of the raceway contacts. `cage`:
/// kinematics, orbit of the cage and pocket loads. `life`: rating life, also from the recorded ball loads; not on `spindle_only` and `periodic`.
/// `friction`: torque of friction by place; on `full` and `planar` only.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum MetricsPart {
    Vibration,
    Contacts,
    Cage,
    Life,
    Friction,
}

impl MetricsPart {
    pub fn name(self) -> &'static str {
        match self {
            Self::Vibration => "vibration",
            Self::Contacts => "contacts",
            Self::Cage => "cage",
            Self::Life => "life",
            Self::Friction => "friction",
        }
    }
}

/// Channels whose spectra are kept by default.
pub const USUAL_SPECTRA: [&str; 2] = ["spindle.y.acceleration", "spindle.z.acceleration"];
pub const MAX_CHANNELS: usize = 64;
/// Limits of the band whose envelope is analysed [Hz].
pub const ENVELOPE_LIMITS: [f64; 2] = [10.0, 25_600.0];
/// Numbers of edges of bands, and their limits [Hz].
pub const MIN_BAND_EDGES: usize = 2;
pub const MAX_BAND_EDGES: usize = 17;
const BAND_EDGE_LIMITS: [f64; 2] = [1.0, BAND];
/// The default.
const USUAL: [MetricsPart; 3] = [MetricsPart::Vibration, MetricsPart::Contacts, MetricsPart::Cage];

impl OutputsInput {
    /// The outputs of a run. Channels are checked against the scene; without a scene only their number is checked.
    pub fn resolve(&mut self, defaults: &mut Defaults, scene: Option<&Scene>) -> Outputs {
        let outputs = self.resolve_metrics(defaults);
        let usual = USUAL_SPECTRA.map(str::to_owned).to_vec();
        let spectra = defaults.fill("/outputs/spectra", &mut self.spectra, usual);
        let series = defaults.fill("/outputs/series", &mut self.series, Vec::new());
        let of_orders =
            self.orders.as_mut().map(|orders| orders.resolve_channels(DEFAULT_CHANNEL, defaults)).unwrap_or_default();
        let is_uneven = scene.is_some_and(|scene| !scene.surfaces.are_ideal());
        let envelope_harmonics = outputs.vibration && is_uneven;
        let has_spectra = envelope_harmonics || !spectra.is_empty();
        Outputs {
            spectra: channels(defaults, "/outputs/spectra", &spectra, scene),
            series: with_orders(channels(defaults, "/outputs/series", &series, scene), &of_orders, defaults, scene),
            envelope: envelope(defaults, &mut self.envelope_band_hz, &mut self.envelope),
            envelope_harmonics,
            band_edges: band_edges(defaults, &self.bands_hz),
            longest_window: scene.filter(|_| has_spectra).map_or(outputs.longest_window, longest_window),
            ..outputs
        }
    }

    /// The outputs of a run that keeps metrics only.
    pub fn resolve_metrics(&mut self, defaults: &mut Defaults) -> Outputs {
        let metrics = defaults.fill("/outputs/metrics", &mut self.metrics, USUAL.to_vec());
        for (index, part) in metrics.iter().enumerate() {
            if metrics[..index].contains(part) {
                defaults.refuse(format!("/outputs/metrics/{index}"), "given more than once");
            }
        }
        Outputs {
            vibration: metrics.contains(&MetricsPart::Vibration),
            contacts: metrics.contains(&MetricsPart::Contacts),
            cage: metrics.contains(&MetricsPart::Cage),
            life: metrics.contains(&MetricsPart::Life),
            friction: metrics.contains(&MetricsPart::Friction),
            ..Outputs::vibration()
        }
    }
}

/// The analysed envelope of the fields `outputs.envelope_band_hz` and `outputs.envelope`.
pub(super) fn envelope(
    defaults: &mut Defaults,
    band: &mut Option<[f64; 2]>,
    kind: &mut Option<EnvelopeName>,
) -> EnvelopeAnalysis {
    let kind = defaults.fill("/outputs/envelope", kind, EnvelopeName::Magnitude).into();
    EnvelopeAnalysis { band: envelope_band(defaults, band), kind }
}

/// Edges of the bands of accelerations [Hz]. The usual ones are not written into the request, so that results of earlier builds are reused.
pub(super) fn band_edges(defaults: &mut Defaults, field: &Option<Vec<f64>>) -> Vec<f64> {
    let Some(edges) = field else { return BAND_EDGES.to_vec() };
    defaults.errors.extend(band_edge_errors("/outputs/bands_hz", edges));
    edges.clone()
}

/// Errors of the edges of bands [Hz] in the field at a pointer.
pub(super) fn band_edge_errors(pointer: &str, edges: &[f64]) -> Vec<FieldError> {
    let mut errors = Vec::new();
    if !(MIN_BAND_EDGES..=MAX_BAND_EDGES).contains(&edges.len()) {
        let detail = format!("{} edges: must be {MIN_BAND_EDGES} to {MAX_BAND_EDGES}", edges.len());
        errors.push(FieldError::new(pointer, detail));
    }
    let [low, high] = BAND_EDGE_LIMITS;
    for (index, edge) in edges.iter().enumerate() {
        let pointer = format!("{pointer}/{index}");
        if !(low..=high).contains(edge) {
            errors.push(FieldError::new(pointer, numbers::out_of_range(*edge, low, high, false, "Hz")));
        } else if index > 0 && edges[index - 1] >= *edge {
            let detail = format!("{edge} Hz is not above {} Hz: edges rise", edges[index - 1]);
            errors.push(FieldError::new(pointer, detail));
        }
    }
    errors
}

/// The band whose envelope is analysed [Hz].
fn envelope_band(defaults: &mut Defaults, field: &mut Option<[f64; 2]>) -> (f64, f64) {
    const POINTER: &str = "/outputs/envelope_band_hz";
    let band = defaults.fill(POINTER, field, ENVELOPE.band.into());
    let [low, high] = ENVELOPE_LIMITS;
    for (index, edge) in band.into_iter().enumerate() {
        if !(low..=high).contains(&edge) {
            defaults.refuse(format!("{POINTER}/{index}"), numbers::out_of_range(edge, low, high, false, "Hz"));
        }
    }
    if band[0] >= band[1] {
        defaults.refuse(POINTER, format!("{} Hz is not below {} Hz: give the lower end first", band[0], band[1]));
    }
    band.into()
}

fn channels(defaults: &mut Defaults, pointer: &str, names: &[String], scene: Option<&Scene>) -> Vec<Channel> {
    if names.len() > MAX_CHANNELS {
        defaults.refuse(pointer, format!("{} channels: at most {MAX_CHANNELS}", names.len()));
        return Vec::new();
    }
    let Some(scene) = scene else { return Vec::new() };
    let mut seen = BTreeSet::new();
    let mut channels = Vec::new();
    for (index, name) in names.iter().enumerate() {
        match channel(name, scene) {
            Ok(channel) if seen.insert(channel) => channels.push(channel),
            Ok(_) => defaults.refuse(format!("{pointer}/{index}"), format!("`{name}` is given more than once")),
            Err(detail) => defaults.refuse(format!("{pointer}/{index}"), detail),
        }
    }
    channels
}

/// The requested series, and those that an order analysis of channels needs.
fn with_orders(
    mut series: Vec<Channel>,
    analysed: &[String],
    defaults: &mut Defaults,
    scene: Option<&Scene>,
) -> Vec<Channel> {
    let Some(scene) = scene.filter(|_| !analysed.is_empty()) else { return series };
    for channel in
        channels(defaults, "/outputs/orders/channels", analysed, Some(scene)).into_iter().chain(turning_channels(scene))
    {
        if !series.contains(&channel) {
            series.push(channel);
        }
    }
    series
}

/// The channel of that name in this scene, or the reason why there is none.
pub fn channel(name: &str, scene: &Scene) -> Result<Channel, String> {
    let balls = scene.bearing.parameters.ball_count;
    let channel = Channel::parse(name, balls).ok_or_else(|| {
        let name: String = name.chars().take(100).collect();
        format!(
            "unknown channel `{name}`; channels are spindle.{{x|y|z}}.{{displacement|velocity|acceleration}}, spindle.tilt.{{y|z}}, \
             cage.{{x|y|z}}.displacement, cage.speed, ball.N.spin and ball.N.{{inner|outer|pocket}}.load with N = 1…{balls}"
        )
    })?;
    let off = |term| scene.terms.get(term) == TermChoice::Off;
    match channel {
        Channel::Spindle(Axis::X, _) if scene.spindle.axial != AxialHold::Free || off(Term::Axial) => {
            Err(format!("`{name}` exists only where the spindle's axial direction is free (/scene/spindle/axial)"))
        }
        Channel::SpindleTilt(_) if scene.spindle.tilt == SpindleTilt::Held => {
            Err(format!("`{name}` exists only where the spindle tilts freely (/scene/spindle/tilt)"))
        }
        Channel::CageDisplacement(_) | Channel::CageSpeed | Channel::BallLoad(_, BallContact::Pocket)
            if off(Term::Cage) =>
        {
            Err(format!("`{name}` exists only with a cage (/scene/terms/cage is off)"))
        }
        _ => Ok(channel),
    }
}
