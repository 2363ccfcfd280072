//! Requested order analysis of a run whose speed varies: order spectra, order tracks and waterfalls.

use raceway_core::orders::rotations::Combination;
use raceway_core::orders::settings::{MOST_BINS, OrderSettings, Reference, highest_order};
use raceway_core::orders::waterfall::{TimeWindows, sharpest_window};
use raceway_core::simulation::recording::sampling::{BAND, RATE};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::recorded_turns::{RecordedBearing, RecordedTurns};
use crate::contract::json::defaults::Defaults;
use crate::contract::json::numbers::{out_of_range, short, significant};
use crate::contract::json::problem::FieldError;

/// Order spectra, order tracks and waterfalls of a run. They need the series of the channels, which are kept as if they were requested, with
/// the speeds of cage and ball 1.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct OrdersInput {
    /// Channels that are analysed. Default: the acceleration of the spindle in y; of a machine that of its first sensor, or of its first bearing in
    /// y.
    #[schema(nullable = false, min_items = 1, max_items = 8, example = json!(["spindle.y.acceleration"]))]
    pub channels: Option<Vec<String>>,
    /// Tracked orders as text: numbers such as `"2"`, or `FTF`, `BPFO`, `BPFI` and `BSF`, also with a factor (`2·BPFO` or `2*BPFO`), and of one bearing of several as
    /// `BPFO@A`. Names follow the simulated speeds of cage and ball. Default: those of 1, 2, FTF, BPFO, 2·BPFO, BPFI and 2·BSF up to `max_order`;
    /// with several bearings 1, 2, and BPFO and BPFI of each.
    #[schema(nullable = false, max_items = 32, example = json!(["1", "BPFO", "2·BPFO"]))]
    pub tracks: Option<Vec<String>>,
    /// Highest order. Default: four times that of BPFI, or the order of 20 kHz at the highest speed if that is lower.
    #[schema(nullable = false, example = 40)]
    pub max_order: Option<f64>,
    /// Turns of the reference in a block; the order resolution is its reciprocal. Default: the square root of the recorded turns, rounded
    /// down, at most 32; a short run has as many blocks as turns in a block.
    #[schema(nullable = false, example = 32)]
    pub turns_per_block: Option<f64>,
    /// Share of a block that the next one repeats. Default 0.5.
    #[schema(nullable = false, example = 0.5)]
    pub overlap: Option<f64>,
    /// Body whose turns an order counts. Default `shaft`.
    #[schema(nullable = false)]
    pub reference: Option<ReferenceName>,
}

/// `shaft`: orders of the spindle or shaft. `cage`, with one bearing: orders of the simulated cage; the ball passage over the outer raceway is then exactly order Z,
/// whatever the slip.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum ReferenceName {
    Shaft,
    Cage,
}

impl ReferenceName {
    pub fn name(self) -> &'static str {
        match self {
            Self::Shaft => "shaft",
            Self::Cage => "cage",
        }
    }
}

impl From<ReferenceName> for Reference {
    fn from(name: ReferenceName) -> Self {
        match name {
            ReferenceName::Shaft => Self::Shaft,
            ReferenceName::Cage => Self::Cage,
        }
    }
}

/// A checked order analysis.
#[derive(Debug, Clone, PartialEq)]
pub struct OrderRequest {
    pub settings: OrderSettings,
    pub reference: ReferenceName,
    /// Tracked orders with their names.
    pub tracks: Vec<(String, Combination)>,
}

const REVERSES: &str = "the shaft reverses within the recorded time: orders need one direction";
const OUTER_RING_TURNS: &str = "the outer ring turns (/scene/operation/outer_speed_rpm): orders of the shaft name cage and balls only where it stands";
const OF: &str = "/outputs/orders";
/// Default of the highest order over that of BPFI [-].
const USUAL_MULTIPLE: f64 = 4.0;
/// The analysed channel of one bearing by default.
pub const DEFAULT_CHANNEL: &str = "spindle.y.acceleration";
const DEFAULT_TRACKS: [&str; 7] = ["1", "2", "FTF", "BPFO", "2·BPFO", "BPFI", "2·BSF"];
/// The same of each bearing of several.
const DEFAULT_TRACKS_OF_EACH: [&str; 2] = ["BPFO", "BPFI"];
const MOST_CHANNELS: usize = 8;
const MOST_TRACKS: usize = 32;

/// The reason why a run has no orders.
fn without_angle(run: &RecordedTurns) -> &'static str {
    if run.outer_ring_turns { OUTER_RING_TURNS } else { REVERSES }
}

impl OrdersInput {
    /// These settings, and others where one is missing.
    pub fn or(self, others: Self) -> Self {
        Self {
            channels: self.channels.or(others.channels),
            tracks: self.tracks.or(others.tracks),
            max_order: self.max_order.or(others.max_order),
            turns_per_block: self.turns_per_block.or(others.turns_per_block),
            overlap: self.overlap.or(others.overlap),
            reference: self.reference.or(others.reference),
        }
    }

    /// Names of the analysed channels; `usual`: that of the default.
    pub fn resolve_channels(&mut self, usual: &str, defaults: &mut Defaults) -> Vec<String> {
        let channels = defaults.fill(format!("{OF}/channels"), &mut self.channels, vec![usual.to_owned()]);
        if !(1..=MOST_CHANNELS).contains(&channels.len()) {
            let detail = format!("{} channels: must be 1 to {MOST_CHANNELS}", channels.len());
            defaults.refuse(format!("{OF}/channels"), detail);
            return Vec::new();
        }
        channels
    }

    /// The analysis, or `None` after its errors were noted.
    pub fn resolve(&mut self, run: &RecordedTurns, defaults: &mut Defaults) -> Option<OrderRequest> {
        let Some(angle) = &run.angle else {
            defaults.refuse(OF, without_angle(run));
            return None;
        };
        let faults = defaults.errors.len();
        let reference = defaults.fill(format!("{OF}/reference"), &mut self.reference, ReferenceName::Shaft);
        if let Some(detail) = run.without_cage().filter(|_| reference == ReferenceName::Cage) {
            defaults.refuse(format!("{OF}/reference"), detail);
        }
        let ratio = run.of_reference(reference.into());
        let (turns, fastest) = (angle.total() * ratio, angle.speeds().1 * ratio);
        if turns < 1.0 {
            let body = reference.name();
            let detail = format!("the recorded time has {} turns of the {body}: at least 1 is needed", short(turns));
            defaults.refuse(OF, detail);
            return None;
        }
        let of_bearing = (USUAL_MULTIPLE * run.ball_pass_inner() / ratio).ceil();
        let usual = significant((BAND / fastest).min(of_bearing), 3);
        let max_order = defaults.fill(format!("{OF}/max_order"), &mut self.max_order, usual);
        // The product of order and speed is rounded.
        let highest = significant(highest_order(RATE, fastest), 6);
        if !(0.1..=highest).contains(&max_order) {
            let detail = out_of_range(max_order, 0.1, highest, false, "");
            defaults.refuse(
                format!("{OF}/max_order"),
                format!("{detail}: 40 kHz at {} Hz, the highest speed of the {}", short(fastest), reference.name()),
            );
        }
        let usual = turns.sqrt().min(32.0).floor();
        let block = defaults.fill(format!("{OF}/turns_per_block"), &mut self.turns_per_block, usual);
        if !(1.0..=turns).contains(&block) || block.fract() != 0.0 {
            let detail = out_of_range(block, 1.0, turns.floor(), false, "");
            let detail =
                format!("{detail}, a whole number: the recorded time has {} turns", short(significant(turns, 6)));
            defaults.refuse(format!("{OF}/turns_per_block"), detail);
        }
        let overlap = defaults.fill(format!("{OF}/overlap"), &mut self.overlap, 0.5);
        defaults.check(&format!("{OF}/overlap"), overlap);
        if defaults.errors.len() > faults {
            return None;
        }
        let settings =
            OrderSettings { reference: reference.into(), max_order, turns_per_block: block as usize, overlap };
        let rows = settings.blocks(turns).max(1);
        if let Some(detail) = too_many_bins(rows, settings.bins().max(settings.samples_per_turn())) {
            defaults.refuse(OF, format!("{detail}: lower max_order, or raise turns_per_block at less overlap"));
        }
        let tracks = self.resolve_tracks(run, &settings, defaults);
        (defaults.errors.len() == faults).then_some(OrderRequest { settings, reference, tracks })
    }

    fn resolve_tracks(
        &mut self,
        run: &RecordedTurns,
        settings: &OrderSettings,
        defaults: &mut Defaults,
    ) -> Vec<(String, Combination)> {
        let ratios = run.ratios();
        let order = |track: &Combination| track.ratio(&ratios) / run.of_reference(settings.reference);
        let is_within = |track: &Combination| order(track) > 0.0 && order(track) <= settings.max_order;
        let known = |name: &str| track(name, &run.bearings, settings.reference);
        let usual = usual_tracks(&run.bearings).into_iter().filter_map(|name| known(&name));
        let usual = usual.filter(|(_, track)| is_within(track)).map(|(name, _)| name).collect();
        let names = defaults.fill(format!("{OF}/tracks"), &mut self.tracks, usual);
        if names.len() > MOST_TRACKS {
            defaults.refuse(format!("{OF}/tracks"), format!("{} orders: at most {MOST_TRACKS}", names.len()));
            return Vec::new();
        }
        let mut tracks: Vec<(String, Combination)> = Vec::new();
        for (index, name) in names.iter().enumerate() {
            let shown: String = name.chars().take(40).collect();
            let detail = match known(name) {
                None => format!("`{shown}` is no order: {}", known_orders(&run.bearings)),
                Some((_, track)) if !is_within(&track) => {
                    out_of_range(order(&track), 0.0, settings.max_order, true, "") + ", the highest order"
                }
                Some((canonical, _)) if tracks.iter().any(|(other, _)| *other == canonical) => {
                    format!("`{shown}` is given more than once")
                }
                Some(track) => {
                    tracks.push(track);
                    continue;
                }
            };
            defaults.refuse(format!("{OF}/tracks/{index}"), detail);
        }
        tracks
    }
}

/// Longest default window of a waterfall by frequency, as a share of the recorded time: at least 31 rows.
const LONGEST_WINDOW: f64 = 1.0 / 16.0;
/// Fewest values in a window.
const FEWEST_VALUES: f64 = 16.0;

/// Windows of a waterfall by frequency, of which rows and bins are limited. `window_s`, by default the sharpest for BPFI. `max_frequency_hz`,
/// by default that of the highest order at the highest speed, at most 20 kHz. Errors name a field.
pub fn time_windows(
    run: &RecordedTurns,
    settings: &OrderSettings,
    window_s: Option<f64>,
    max_frequency_hz: Option<f64>,
) -> Result<TimeWindows, FieldError> {
    let refuse = |field: &str, detail: String| Err(FieldError::new(field, detail));
    let Some(angle) = &run.angle else { return refuse("", without_angle(run).to_owned()) };
    let duration = angle.duration() + RATE.recip();
    let sharpest = sharpest_window(run.ball_pass_inner(), angle.steepest()).min(LONGEST_WINDOW * duration);
    let shortest = FEWEST_VALUES / RATE;
    let window = window_s.unwrap_or(sharpest.max(shortest));
    if !(shortest..=duration).contains(&window) {
        return refuse("window_s", out_of_range(window, shortest, duration, false, "s"));
    }
    let usual = settings.max_order * run.of_reference(settings.reference) * angle.speeds().1;
    let max_frequency = max_frequency_hz.unwrap_or(usual.min(BAND));
    if !(max_frequency > 0.0 && max_frequency <= 0.5 * RATE) {
        return refuse("max_frequency_hz", out_of_range(max_frequency, 0.0, 0.5 * RATE, true, "Hz"));
    }
    let length = (window * RATE).round() as usize;
    let windows = TimeWindows { length, overlap: settings.overlap, step: RATE.recip(), max_frequency };
    let rows = windows.rows((duration * RATE).round() as usize);
    match too_many_bins(rows, windows.bins()) {
        Some(detail) => refuse("", format!("{detail}: lower max_frequency_hz or overlap")),
        None => Ok(windows),
    }
}

/// The reason why a waterfall is too large; `None` if it is not.
pub fn too_many_bins(rows: usize, columns: usize) -> Option<String> {
    let bins = rows.saturating_mul(columns);
    (bins > MOST_BINS).then(|| format!("{rows} rows of {columns} bins are {bins} bins: at most {MOST_BINS}"))
}

/// Names of the orders that are tracked by default.
fn usual_tracks(bearings: &[RecordedBearing]) -> Vec<String> {
    let named = |order: &str| {
        let of_bearing = |bearing: &RecordedBearing| bearing.name.as_ref().map(|name| format!("{order}@{name}"));
        bearings.iter().filter_map(of_bearing).collect::<Vec<_>>()
    };
    match bearings {
        [RecordedBearing { name: None, .. }] => DEFAULT_TRACKS.map(str::to_owned).to_vec(),
        [_] => DEFAULT_TRACKS[..2]
            .iter()
            .map(|order| (*order).to_owned())
            .chain(DEFAULT_TRACKS[2..].iter().flat_map(|order| named(order)))
            .collect(),
        _ => DEFAULT_TRACKS[..2]
            .iter()
            .map(|order| (*order).to_owned())
            .chain(DEFAULT_TRACKS_OF_EACH.iter().flat_map(|order| named(order)))
            .collect(),
    }
}

fn known_orders(bearings: &[RecordedBearing]) -> String {
    let names: Vec<&str> = bearings.iter().filter_map(|bearing| bearing.name.as_deref()).collect();
    let orders = "give a number, or FTF, BPFO, BPFI or BSF, with a factor such as 2·BPFO";
    if names.is_empty() {
        orders.to_owned()
    } else {
        format!("{orders}, and with its bearing, such as BPFO@{}", names[0])
    }
}

/// Name and turns of a tracked order. `BPFO@A` is that of bearing A, which is left out where there is only one.
fn track(name: &str, bearings: &[RecordedBearing], reference: Reference) -> Option<(String, Combination)> {
    let name = name.trim();
    let (factor, named) = match name.split_once(['·', '*']) {
        Some((factor, named)) => (factor.parse::<f64>().ok().filter(|factor| factor.is_finite())?, named),
        None => (1.0, name),
    };
    if let Some(order) = named.parse::<f64>().ok().filter(|order| order.is_finite() && named == name) {
        let combination = match reference {
            Reference::Shaft => Combination { shaft: order, ..Combination::default() },
            Reference::Cage => Combination { cage: order, ..Combination::default() },
        };
        return Some((short(order), combination));
    }
    let (order, bearing) = match named.split_once('@') {
        Some((order, of)) => (order, bearings.iter().position(|bearing| bearing.name.as_deref() == Some(of))?),
        None if bearings.len() == 1 => (named, 0),
        None => return None,
    };
    let RecordedBearing { name, balls, .. } = &bearings[bearing];
    let of = |shaft: f64, cage: f64, ball: f64| Combination {
        shaft: factor * shaft,
        cage: factor * cage,
        ball: factor * ball,
        bearing,
    };
    let combination = match order {
        "FTF" => of(0.0, 1.0, 0.0),
        "BPFO" => of(0.0, *balls, 0.0),
        "BPFI" => of(*balls, -balls, 0.0),
        "BSF" => of(0.0, 0.0, 1.0),
        _ => return None,
    };
    let factor = if factor == 1.0 { String::new() } else { format!("{}·", short(factor)) };
    let of_bearing = name.as_ref().map(|name| format!("@{name}")).unwrap_or_default();
    Some((format!("{factor}{order}{of_bearing}"), combination))
}

#[cfg(test)]
mod tests {
    use raceway_core::orders::rotations::Ratios;

    use super::*;
    use crate::contract::scene_from_json;

    /// A run-up of a 6205 by 600 turns in 20 s.
    fn run_up() -> RecordedTurns {
        let scene =
            r#"{"bearing": "6205", "operation": {"speed_rpm": [{"at_s": 0, "rpm": 600}, {"at_s": 20, "rpm": 3000}]}}"#;
        RecordedTurns::of(&scene_from_json(scene).unwrap(), 0.0, 20.0)
    }

    #[test]
    fn defaults_follow_the_run() {
        let (mut input, mut defaults) = (OrdersInput::default(), Defaults::default());
        let request = input.resolve(&run_up(), &mut defaults).unwrap();
        let settings =
            OrderSettings { reference: Reference::Shaft, max_order: 22.0, turns_per_block: 24, overlap: 0.5 };
        assert_eq!((request.settings, defaults.errors.len()), (settings, 0));
        let names: Vec<&str> = request.tracks.iter().map(|track| track.0.as_str()).collect();
        assert_eq!(names, DEFAULT_TRACKS);
    }

    #[test]
    fn windows_are_the_sharpest_and_their_bins_are_limited() {
        let (run, settings) = (
            run_up(),
            OrderSettings { reference: Reference::Shaft, max_order: 100.0, turns_per_block: 32, overlap: 0.9 },
        );
        // BPFI is order 5.415, and the speed changes by 2 Hz/s.
        let sharpest = time_windows(&run, &settings, None, None).unwrap();
        assert!(
            (sharpest.window() - 0.3039).abs() < 1e-4 && (sharpest.max_frequency / 5000.0 - 1.0).abs() < 1e-6,
            "{sharpest:?}"
        );
        let error = time_windows(&run, &settings, Some(0.2), Some(51_200.0)).unwrap_err();
        assert!(error.detail.contains("bins: at most 4000000: lower max_frequency_hz"), "{}", error.detail);
        for (window, frequency, field) in [
            (Some(21.0), None, "window_s"),
            (None, Some(0.0), "max_frequency_hz"),
            (None, Some(6e4), "max_frequency_hz"),
        ] {
            assert_eq!(time_windows(&run, &settings, window, frequency).unwrap_err().pointer, field);
        }
    }

    #[test]
    fn orders_have_one_name_each() {
        let rolling = Ratios { cage: 0.4, ball: 2.3, ball_pass_inner: 4.2 };
        let bearing = |name: Option<&str>| RecordedBearing {
            name: name.map(str::to_owned),
            ratios: rolling,
            balls: 7.0,
            has_cage: true,
        };
        let (alone, pair) = ([bearing(None)], ["A", "B"].map(|name| bearing(Some(name))));
        let name = |text| track(text, &alone, Reference::Shaft).map(|(name, _)| name);
        let of_pair = |text| track(text, &pair, Reference::Shaft).map(|(name, track)| (name, track.bearing));
        assert_eq!(of_pair("2*BPFO@B"), Some(("2·BPFO@B".to_owned(), 1)));
        assert_eq!((of_pair("BPFO"), of_pair("BPFO@C")), (None, None));
        assert_eq!(track("BPFI", &pair[..1], Reference::Shaft).unwrap().0, "BPFI@A");
        assert_eq!(usual_tracks(&pair), ["1", "2", "BPFO@A", "BPFO@B", "BPFI@A", "BPFI@B"]);
        assert_eq!(name("2*BPFO").as_deref(), Some("2·BPFO"));
        assert_eq!(name(" 1·FTF").as_deref(), Some("FTF"));
        assert_eq!(name("3.50").as_deref(), Some("3.5"));
        for wrong in ["", "BPF", "2·3", "NaN", "inf", "x·BPFO", "bpfo"] {
            assert_eq!(name(wrong), None, "{wrong}");
        }
        let (_, inner) = track("2·BPFI", &alone, Reference::Cage).unwrap();
        assert!((inner.ratio(&[rolling]) - 8.4).abs() < 1e-12);
        assert_eq!(
            too_many_bins(2000, 2001).as_deref(),
            Some("2000 rows of 2001 bins are 4002000 bins: at most 4000000")
        );
    }
}
