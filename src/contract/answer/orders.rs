//! Order spectra, order tracks and waterfalls as JSON, tables and arrays.

use raceway_core::orders::analysis::{OrderAnalysis, Orders, Value};
use raceway_core::orders::blocks::Middle;
use raceway_core::orders::rotations::{Combination, RotationCourse, SimulatedSpeeds};
use raceway_core::orders::settings::OrderSettings;
use raceway_core::orders::waterfall::{OrderRows, Row, TimeRows, TimeWindows, smear_bins};
use raceway_core::simulation::recording::sampling::RATE;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::csv::{npy_table, quoted};
use super::signals::{SeriesAnswer, SpectrumAnswer};
use crate::contract::job::checked::Job;
use crate::contract::job::orders::{OrderRequest, OrdersInput, ReferenceName, time_windows};
use crate::contract::job::recorded_turns::RecordedTurns;
use crate::contract::json::numbers::rounded;

/// Speed of 1 Hz in r/min.
const RPM: f64 = 60.0;
/// Significant digits of orders, speeds and times.
const AXIS_DIGITS: i32 = 9;

/// Channel of an analysis, and where its first value lies.
#[derive(Debug, Clone, PartialEq)]
pub struct AnalysedSignal {
    pub channel: String,
    pub unit: String,
    /// Time of the first value [s].
    pub start_s: f64,
    /// Time between values [s].
    pub step_s: f64,
    /// True if the simulated speeds of cage and ball of every bearing are known.
    pub is_simulated: bool,
}

impl AnalysedSignal {
    /// Turns at each value; `None` where the shaft reverses.
    fn course(&self, run: &RecordedTurns) -> Option<RotationCourse> {
        Some(RotationCourse::new(run.angle.clone()?, run.ratios(), self.start_s, self.step_s))
    }

    fn follows(&self) -> NamesFollow {
        if self.is_simulated { NamesFollow::Simulated } else { NamesFollow::IdealRolling }
    }
}

/// Speeds that the names of orders follow. `simulated`: those of the simulated cage and ball 1 of each bearing. `ideal_rolling`: those of balls that roll, because
/// the run kept no others.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum NamesFollow {
    Simulated,
    IdealRolling,
}

/// An order analysis: the mean order spectrum of all blocks, and tracks of orders over speed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct OrdersAnswer {
    /// The analysed channel.
    #[schema(example = "spindle.y.acceleration")]
    pub channel: String,
    /// Unit of the amplitudes.
    #[schema(example = "m/s²")]
    pub unit: String,
    /// Body whose turns an order counts.
    pub reference: ReferenceName,
    /// Window function of a block.
    #[schema(example = "hann")]
    pub window: String,
    /// Turns of the reference in the recorded time.
    pub turns: f64,
    /// Turns of the reference in a block.
    pub turns_per_block: usize,
    /// Share of a block that the next one repeats.
    pub overlap: f64,
    /// Samples in a turn after resampling: the next power of two from 2.56 times the highest order on.
    pub samples_per_turn: usize,
    /// Distance of two bins in orders.
    pub resolution: f64,
    /// Speeds that names such as BPFO follow.
    pub names_follow: NamesFollow,
    /// Number of blocks whose power is averaged in `amplitude`.
    pub averages: usize,
    /// Orders in ascending order.
    pub order: Vec<f64>,
    /// Amplitude at each order: a sine of amplitude 1 in a fixed ratio to the reference reads 1.
    pub amplitude: Vec<f64>,
    /// Shaft speed at the middle in angle of each block [r/min].
    pub speed_rpm: Vec<f64>,
    /// Time at the middle in angle of each block, since the start of the run [s].
    pub time_s: Vec<f64>,
    /// Amplitudes over `speed_rpm`.
    pub tracks: Vec<TrackAnswer>,
}

/// Amplitude of one order over speed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct TrackAnswer {
    /// The order: a number or a name.
    #[schema(example = "BPFO")]
    pub name: String,
    /// Mean order over the recorded time.
    pub order: f64,
    /// Amplitude in each block.
    pub amplitude: Vec<f64>,
    /// Tracks whose order is closer than 2/`turns_per_block`: the amplitudes of both beat.
    pub beats_with: Vec<String>,
}

/// A waterfall: spectra over speed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct WaterfallAnswer {
    /// The analysed channel.
    #[schema(example = "spindle.y.acceleration")]
    pub channel: String,
    /// Unit of `amplitude`.
    #[schema(example = "m/s²")]
    pub unit: String,
    /// Unit of `axis`: `Hz` or `order`.
    pub axis_unit: WaterfallAxis,
    /// Body whose turns an order counts.
    pub reference: ReferenceName,
    /// Window function of a row.
    #[schema(example = "hann")]
    pub window: String,
    /// Time of a row [s], for `axis=hz`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub window_s: Option<f64>,
    /// Bins by which the order `smear_order` moves within a row at the fastest change of speed, for `axis=hz`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub smear_bins: Option<f64>,
    /// Order of BPFI where the balls roll ideally, for `axis=hz`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub smear_order: Option<f64>,
    /// Turns of the reference in a row, for `axis=order`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub turns_per_block: Option<usize>,
    /// Distance of two bins, in the unit of the axis.
    pub resolution: f64,
    /// Orders that are labelled in plots: periods in a turn of the shaft for `axis=hz`, of the reference for `axis=order`.
    pub order_lines: Vec<OrderLineAnswer>,
    /// Shaft speed in the middle of each row [r/min].
    pub speed_rpm: Vec<f64>,
    /// Time in the middle of each row, since the start of the run [s].
    pub time_s: Vec<f64>,
    /// Frequencies or orders of the bins.
    pub axis: Vec<f64>,
    /// Amplitudes, row after row: one row for each speed, one value for each entry of `axis`.
    pub amplitude: Vec<f32>,
}

/// Unit of the columns of a waterfall. `hz`: frequencies, of windows of equal time. `order`: orders, of blocks of equal angle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub enum WaterfallAxis {
    #[serde(rename = "hz")]
    Hz,
    #[serde(rename = "order")]
    Order,
}

/// A labelled order.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct OrderLineAnswer {
    /// A number or a name.
    #[schema(example = "BPFO")]
    pub name: String,
    /// Mean order over the recorded time.
    pub order: f64,
}

/// An order analysis that takes its signal value by value.
pub struct RunningOrders {
    signal: AnalysedSignal,
    request: OrderRequest,
    analysis: OrderAnalysis,
}

impl RunningOrders {
    /// `None` where the shaft reverses.
    pub fn new(signal: AnalysedSignal, request: OrderRequest, run: &RecordedTurns) -> Option<Self> {
        let orders = request.tracks.iter().map(|track| track.1).collect();
        let analysis = OrderAnalysis::new(request.settings, signal.course(run)?, orders);
        Some(Self { signal, request, analysis })
    }

    pub fn push(&mut self, value: Value<'_>) {
        self.analysis.push(value);
    }

    pub fn finish(self) -> OrdersAnswer {
        let Self { signal, request, analysis } = self;
        let follows = signal.follows();
        let Orders { turns, spectrum, orders, beating, points } = analysis.finish();
        let settings = request.settings;
        let name = |number: usize| request.tracks[number].0.clone();
        let beats_with = |number: usize| {
            let other = |&(one, other): &(usize, usize)| match number {
                _ if number == one => Some(name(other)),
                _ if number == other => Some(name(one)),
                _ => None,
            };
            beating.iter().filter_map(other).collect()
        };
        let track = |(number, order): (usize, &f64)| TrackAnswer {
            name: name(number),
            order: rounded(*order, AXIS_DIGITS),
            amplitude: points.iter().map(|point| shown(point.amplitudes[number])).collect(),
            beats_with: beats_with(number),
        };
        let (speed_rpm, time_s) = middles(points.iter().map(|point| point.middle));
        let resolution = 1.0 / settings.turns_per_block as f64;
        let amplitude = spectrum.as_ref().map_or(Vec::new(), |spectrum| spectrum.amplitude.clone());
        OrdersAnswer {
            channel: signal.channel,
            unit: signal.unit,
            reference: request.reference,
            window: "hann".to_owned(),
            turns: rounded(turns, AXIS_DIGITS),
            turns_per_block: settings.turns_per_block,
            overlap: settings.overlap,
            samples_per_turn: settings.samples_per_turn(),
            resolution,
            names_follow: follows,
            averages: spectrum.as_ref().map_or(0, |spectrum| spectrum.averages),
            order: bins(amplitude.len(), resolution),
            amplitude: amplitude.into_iter().map(shown).collect(),
            speed_rpm,
            time_s,
            tracks: orders.iter().enumerate().map(track).collect(),
        }
    }
}

/// A waterfall that takes its signal value by value.
pub struct RunningWaterfall {
    signal: AnalysedSignal,
    request: OrderRequest,
    course: RotationCourse,
    rows: Rows,
    middles: Vec<Middle>,
    amplitude: Vec<f32>,
    /// Bins of a row, and their distance.
    columns: usize,
    resolution: f64,
    /// Order whose line smears, and the fastest change of speed [Hz/s].
    smear: (f64, f64),
}

enum Rows {
    Hz(TimeRows, TimeWindows),
    Order(Box<OrderRows>, OrderSettings),
}

impl RunningWaterfall {
    /// By frequency where there are windows, else by order; `None` where the shaft reverses.
    pub fn new(
        signal: AnalysedSignal,
        request: OrderRequest,
        windows: Option<TimeWindows>,
        run: &RecordedTurns,
    ) -> Option<Self> {
        let settings = request.settings;
        let rows = match windows {
            Some(windows) => Rows::Hz(TimeRows::new(windows), windows),
            None => Rows::Order(Box::new(OrderRows::new(settings)), settings),
        };
        let (columns, resolution) = match windows {
            Some(windows) => (windows.bins(), windows.window().recip()),
            None => (settings.bins(), 1.0 / settings.turns_per_block as f64),
        };
        Some(Self {
            course: signal.course(run)?,
            smear: (run.ball_pass_inner(), run.angle.as_ref()?.steepest()),
            signal,
            request,
            rows,
            middles: Vec::new(),
            amplitude: Vec::new(),
            columns,
            resolution,
        })
    }

    pub fn push(&mut self, value: Value<'_>) {
        let step = self.course.step();
        let at = self.course.next(value.bearings);
        let (middles, amplitude) = (&mut self.middles, &mut self.amplitude);
        match &mut self.rows {
            Rows::Hz(rows, _) => rows.push(at, value.signal).into_iter().for_each(|row| keep(row, middles, amplitude)),
            Rows::Order(rows, _) => {
                rows.push(at, step, value.signal, |row| keep(row, middles, amplitude));
            }
        }
    }

    pub fn finish(mut self) -> WaterfallAnswer {
        let last = self.course.last();
        let of = |track: &Combination| match self.rows {
            Rows::Hz(..) => track.turns(last) / last.shaft.turns,
            Rows::Order(..) => track.turns(last) / last.of(self.request.settings.reference).turns,
        };
        let line = |(name, track): &(String, Combination)| OrderLineAnswer {
            name: name.clone(),
            order: rounded(of(track), AXIS_DIGITS),
        };
        let order_lines = self.request.tracks.iter().map(line).collect();
        let (mut window_s, mut turns_per_block) = (None, None);
        match self.rows {
            Rows::Hz(_, windows) => window_s = Some(windows.window()),
            Rows::Order(rows, settings) => {
                turns_per_block = Some(settings.turns_per_block);
                rows.finish(|row| keep(row, &mut self.middles, &mut self.amplitude));
            }
        }
        let (speed_rpm, time_s) = middles(self.middles.into_iter());
        let (smear_order, slope) = self.smear;
        WaterfallAnswer {
            channel: self.signal.channel,
            unit: self.signal.unit,
            axis_unit: if window_s.is_some() { WaterfallAxis::Hz } else { WaterfallAxis::Order },
            reference: self.request.reference,
            window: "hann".to_owned(),
            window_s: window_s.map(|window| rounded(window, AXIS_DIGITS)),
            smear_bins: window_s.map(|window| rounded(smear_bins(smear_order, slope, window), 4)),
            smear_order: window_s.map(|_| rounded(smear_order, AXIS_DIGITS)),
            turns_per_block,
            resolution: rounded(self.resolution, AXIS_DIGITS),
            order_lines,
            speed_rpm,
            time_s,
            axis: bins(self.columns, self.resolution),
            amplitude: self.amplitude,
        }
    }
}

/// Orders and waterfall of the first analysed channel of a finished run; `None` where they were not requested.
pub fn of_series(job: &Job, series: &[SeriesAnswer]) -> Option<(OrdersAnswer, WaterfallAnswer)> {
    let of = |name: &str| series.iter().find(|series| series.channel == name);
    let analysed = of(job.first_channel()?)?;
    let run = job.recorded_turns(*analysed.time_s.first()?)?;
    let turning: Vec<[Option<&SeriesAnswer>; 2]> =
        run.bearings.iter().map(|bearing| bearing.turning_channels().map(|name| of(&name))).collect();
    let signal = AnalysedSignal {
        channel: analysed.channel.clone(),
        unit: analysed.unit.clone(),
        start_s: analysed.time_s[0],
        step_s: RATE.recip(),
        is_simulated: turning.iter().flatten().all(Option::is_some),
    };
    let request = job.orders(OrdersInput::default(), &run).ok()?;
    let windows = time_windows(&run, &request.settings, None, None).ok()?;
    let mut orders = RunningOrders::new(signal.clone(), request.clone(), &run)?;
    let mut waterfall = RunningWaterfall::new(signal, request, Some(windows), &run)?;
    let mut bearings = vec![SimulatedSpeeds::default(); turning.len()];
    for (k, signal) in analysed.value.iter().enumerate() {
        for (now, of) in bearings.iter_mut().zip(&turning) {
            [now.cage, now.ball] = of.map(|series| series.and_then(|series| series.value.get(k).copied()));
        }
        let value = Value { signal: *signal, bearings: &bearings };
        orders.push(value);
        waterfall.push(value);
    }
    Some((orders.finish(), waterfall.finish()))
}

/// Keeps a row, with the digits that are shown.
fn keep(row: Row, middles: &mut Vec<Middle>, amplitude: &mut Vec<f32>) {
    middles.push(row.middle);
    amplitude.extend(row.spectrum.amplitude.into_iter().map(|value| shown(value) as f32));
}

fn shown(amplitude: f64) -> f64 {
    rounded(amplitude, SpectrumAnswer::DIGITS)
}

fn bins(count: usize, resolution: f64) -> Vec<f64> {
    (0..count).map(|bin| rounded(bin as f64 * resolution, AXIS_DIGITS)).collect()
}

/// Speeds [r/min] and times [s].
fn middles(middles: impl Iterator<Item = Middle>) -> (Vec<f64>, Vec<f64>) {
    middles.map(|middle| (rounded(RPM * middle.speed, AXIS_DIGITS), rounded(middle.time, AXIS_DIGITS))).unzip()
}

impl OrdersAnswer {
    /// The tracks as CSV: a row for each block.
    pub fn csv(&self) -> String {
        let head = |track: &TrackAnswer| quoted(&format!("{} [{}]", track.name, self.unit));
        let heads = ["speed_rpm", "time_s"].map(str::to_owned).into_iter().chain(self.tracks.iter().map(head));
        let mut text = heads.collect::<Vec<_>>().join(",") + "\n";
        for row in self.rows() {
            text += &row.iter().map(f64::to_string).collect::<Vec<_>>().join(",");
            text.push('\n');
        }
        text
    }

    /// The same rows as a NumPy array file.
    pub fn npy(&self) -> Vec<u8> {
        let columns = 2 + self.tracks.len();
        npy_table(self.speed_rpm.len(), columns, self.rows().flatten().map(|value| value as f32))
    }

    /// Speed, time and the amplitude of each track, block by block.
    fn rows(&self) -> impl Iterator<Item = Vec<f64>> {
        (0..self.speed_rpm.len()).map(|block| {
            let amplitudes = self.tracks.iter().map(|track| track.amplitude[block]);
            [self.speed_rpm[block], self.time_s[block]].into_iter().chain(amplitudes).collect()
        })
    }
}

impl WaterfallAnswer {
    /// Amplitudes of a row.
    pub fn row(&self, number: usize) -> &[f32] {
        let columns = self.axis.len();
        self.amplitude.get(number * columns..(number + 1) * columns).unwrap_or_default()
    }

    /// A table as CSV: the axis in the first line, the speed in the first column.
    pub fn csv(&self) -> String {
        let mut text = "speed_rpm".to_owned();
        self.axis.iter().for_each(|bin| text += &format!(",{bin}"));
        for (number, speed) in self.speed_rpm.iter().enumerate() {
            text += &format!("\n{speed}");
            self.row(number).iter().for_each(|amplitude| text += &format!(",{amplitude}"));
        }
        text + "\n"
    }

    /// The same table as a NumPy array file, with 0 in its corner.
    pub fn npy(&self) -> Vec<u8> {
        let first = std::iter::once(0.0).chain(self.axis.iter().map(|bin| *bin as f32));
        let row =
            |number: usize| std::iter::once(self.speed_rpm[number] as f32).chain(self.row(number).iter().copied());
        let rows = (0..self.speed_rpm.len()).flat_map(row);
        npy_table(self.speed_rpm.len() + 1, self.axis.len() + 1, first.chain(rows))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::scene_from_json;

    #[test]
    fn tables_of_a_waterfall_have_the_axis_in_the_first_row() {
        let answer = WaterfallAnswer {
            channel: "spindle.y.acceleration".into(),
            unit: "m/s²".into(),
            axis_unit: WaterfallAxis::Order,
            reference: ReferenceName::Shaft,
            window: "hann".into(),
            window_s: None,
            smear_bins: None,
            smear_order: None,
            turns_per_block: Some(2),
            resolution: 0.5,
            order_lines: Vec::new(),
            speed_rpm: vec![600.0, 900.0],
            time_s: vec![0.1, 0.2],
            axis: vec![0.0, 0.5, 1.0],
            amplitude: vec![0.0, 0.25, 1.5, 0.0, 0.125, 2.0],
        };
        assert_eq!(answer.csv(), "speed_rpm,0,0.5,1\n600,0,0.25,1.5\n900,0,0.125,2\n");
        let array = answer.npy();
        let head = array.len() - 3 * 4 * size_of::<f32>();
        assert!(head.is_multiple_of(64) && array[..head].ends_with(b"\n"));
        assert!(String::from_utf8_lossy(&array[..head]).contains("'<f4', 'fortran_order': False, 'shape': (3, 4)"));
        let value = |place: usize| f32::from_le_bytes(array[head + 4 * place..][..4].try_into().unwrap());
        assert_eq!([value(0), value(3), value(4), value(6), value(11)], [0.0, 1.0, 600.0, 0.25, 2.0]);
    }

    /// A tone of nine periods in a turn of the cage of a 6205 is BPFO, whatever the cage slips.
    #[test]
    fn named_orders_follow_the_simulated_cage() {
        let scene =
            r#"{"bearing": "6205", "operation": {"speed_rpm": [{"at_s": 0, "rpm": 1200}, {"at_s": 1, "rpm": 4800}]}}"#;
        let run = RecordedTurns::of(&scene_from_json(scene).unwrap(), 0.0, 1.0);
        let (mut input, mut defaults) = (OrdersInput::default(), Default::default());
        input.tracks = Some(vec!["BPFO".into(), "1".into()]);
        let request = input.resolve(&run, &mut defaults).unwrap();
        let signal = AnalysedSignal {
            channel: "spindle.y.acceleration".into(),
            unit: "m/s²".into(),
            start_s: 0.0,
            step_s: 1.0 / 102_400.0,
            is_simulated: true,
        };
        let mut running = RunningOrders::new(signal.clone(), request, &run).unwrap();
        let mut cage_turns = 0.0;
        for i in 0..102_400 {
            let time = f64::from(i) / 102_400.0;
            let cage = 0.39 * (20.0 + 60.0 * time) * (1.0 - 0.02 * time);
            let simulated = SimulatedSpeeds { cage: Some(cage), ball: Some(-2.3 * (20.0 + 60.0 * time)) };
            running.push(Value { signal: (9.0 * std::f64::consts::TAU * cage_turns).sin(), bearings: &[simulated] });
            cage_turns += cage / 102_400.0;
        }
        let answer = running.finish();
        assert_eq!((answer.averages, answer.speed_rpm.len(), answer.names_follow), (13, 13, NamesFollow::Simulated));
        assert!((answer.turns - 50.0).abs() < 1e-3);
        assert!(
            answer.tracks[0].amplitude.iter().all(|amplitude| (amplitude - 1.0).abs() < 2e-3),
            "{:?}",
            answer.tracks
        );
        assert!((answer.tracks[0].order - 9.0 * 0.39 * (1.0 - 0.02 * 0.6)).abs() < 0.01, "{}", answer.tracks[0].order);
        assert!(
            answer.tracks[1].amplitude.iter().all(|amplitude| *amplitude < 1e-3)
                && answer.csv().starts_with("speed_rpm,time_s,BPFO [m/s²],1 [m/s²]\n")
        );
    }
}
