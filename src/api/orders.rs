//! Orders of a run whose speed varies: order spectra, order tracks and waterfalls. They are computed from the kept series on request, chunk
//! by chunk, so that no signal is held as a whole.

use std::sync::Arc;

use axum::extract::State;
use axum::http::HeaderMap;
use axum::response::Response;
use raceway_core::orders::analysis::Value;
use raceway_core::orders::rotations::SimulatedSpeeds;
use serde::Deserialize;
use utoipa::IntoParams;
use uuid::Uuid;

use super::app::App;
use super::computation::computed;
use super::concurrency::{RequestPermit, hold_until_sent};
use super::credentials::Owner;
use super::error::ApiError;
use super::openapi::{self, Anywhere, BadQuery, NoChannel, NoResult, NotAccepted, Unchanged};
use super::request::{JobId, Query, negotiated};
use super::stored_answer::{CSV, JSON, NPY, SVG, formatted, json_text, respond, series_of};
use crate::contract::answer::orders::{
    AnalysedSignal, OrdersAnswer, RunningOrders, RunningWaterfall, WaterfallAnswer, WaterfallAxis,
};
use crate::contract::job::orders::{OrdersInput, ReferenceName, time_windows};
use crate::contract::job::recorded_turns::RecordedTurns;
use crate::contract::{FieldError, Job, Uploads, parse_job_with};
use crate::jobs::{JobError, Signal, StoredSeries};
use crate::plots::draw;

/// Media type of a picture.
pub(super) const PNG: &str = "image/png";

/// Get orders
///
/// Order analysis of a kept series: the mean order spectrum, and tracks of orders over the shaft speed. The shaft angle is exact. Settings that
/// the query leaves out are those of `outputs.orders`. JSON; the tracks as CSV, NPY or SVG by `Accept`. The NPY file is a table in single
/// precision: speed [r/min], time [s] and the amplitude of each track.
#[utoipa::path(
    get, path = "/v1/jobs/{id}/orders", tag = openapi::RESULTS, operation_id = "getOrders",
    params(("id" = Uuid, Path, description = "The job, with `outputs.orders` or `outputs.series`"), OrdersQuery),
    responses(
        (status = 200, description = "The orders", content((OrdersAnswer = "application/json"), (String = "text/csv", example = json!("speed_rpm,time_s,1 [m/s²],BPFO [m/s²]\n1229.4,0.42,0.084,1\n")), (String = "application/x-npy", example = json!("(bytes) NUMPY {'descr': '<f4', 'fortran_order': False, …")), (String = "image/svg+xml", example = json!("<svg xmlns=\"http://www.w3.org/2000/svg\">…</svg>")))),
        Unchanged, BadQuery, NoChannel, NoResult, NotAccepted, Anywhere
    )
)]
pub async fn orders(
    State(app): State<App>,
    Owner(owner): Owner,
    permit: RequestPermit,
    headers: HeaderMap,
    JobId(id): JobId,
    Query(query): Query<OrdersQuery>,
) -> Result<Response, ApiError> {
    let format = negotiated(&headers, &[JSON, CSV, NPY, SVG])?;
    let held = permit.concurrency().series()?;
    let answer = orders_of(&app, &owner, id, &permit, query).await?;
    Ok(hold_until_sent(held, formatted(move || orders_response(format, &answer)).await?))
}

/// Get a waterfall
///
/// Spectra of a kept series over the shaft speed, by frequency (`axis=hz`, windows of equal time) or by order (`axis=order`, blocks of equal
/// angle), with at most 4 000 000 bins. JSON; CSV and NPY are one table with the axis in the first row and the speed in the first column. SVG has
/// axes and labelled orders, PNG only the colours.
#[utoipa::path(
    get, path = "/v1/jobs/{id}/waterfall", tag = openapi::RESULTS, operation_id = "getWaterfall",
    params(("id" = Uuid, Path, description = "The job, with `outputs.orders` or `outputs.series`"), WaterfallQuery),
    responses(
        (status = 200, description = "The waterfall", content((WaterfallAnswer = "application/json"), (String = "text/csv", example = json!("speed_rpm,0,16,32\n1229.4,0,0.084,1\n")), (String = "application/x-npy", example = json!("(bytes) NUMPY {'descr': '<f4', 'fortran_order': False, …")), (String = "image/svg+xml", example = json!("<svg xmlns=\"http://www.w3.org/2000/svg\">…</svg>")), (String = "image/png", example = json!("(bytes) PNG")))),
        Unchanged, BadQuery, NoChannel, NoResult, NotAccepted, Anywhere
    )
)]
pub async fn waterfall(
    State(app): State<App>,
    Owner(owner): Owner,
    permit: RequestPermit,
    headers: HeaderMap,
    JobId(id): JobId,
    Query(query): Query<WaterfallQuery>,
) -> Result<Response, ApiError> {
    let format = negotiated(&headers, &[JSON, CSV, NPY, SVG, PNG])?;
    let picture = query.picture()?;
    let held = permit.concurrency().series()?;
    let answer = waterfall_of(&app, &owner, id, &permit, query).await?;
    Ok(hold_until_sent(held, formatted(move || waterfall_response(format, &answer, picture)).await?))
}

#[derive(Debug, Default, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub struct OrdersQuery {
    /// The channel; by default the first of `outputs.orders`, else the first kept series (`…/channels`).
    #[param(example = "spindle.y.acceleration", pattern = r"^[^\u0000]*$")]
    channel: Option<String>,
    /// Tracked orders, separated by commas: numbers, or `FTF`, `BPFO`, `BPFI` and `BSF`, also with a factor (`2*BPFO`); of one bearing of several
    /// as `BPFO@A`.
    #[param(example = "1,BPFO,2*BPFO", pattern = r"^[^\u0000]*$")]
    tracks: Option<String>,
    /// Highest order.
    #[param(example = 40.0)]
    max_order: Option<f64>,
    /// Turns of the reference in a block.
    #[param(example = 16.0)]
    turns_per_block: Option<f64>,
    /// Share of a block that the next one repeats, from 0 to 0.9.
    #[param(example = 0.5)]
    overlap: Option<f64>,
    /// Body whose turns an order counts.
    #[param(inline = false)]
    reference: Option<ReferenceName>,
}

impl OrdersQuery {
    /// Of a channel, or of the first one; everything else as in the request of the job.
    pub(super) fn of_channel(channel: Option<String>) -> Self {
        Self { channel, ..Self::default() }
    }
}

impl WaterfallQuery {
    /// Likewise.
    pub(super) fn of_channel(channel: Option<String>) -> Self {
        Self { channel, ..Self::default() }
    }
}

#[derive(Debug, Default, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub struct WaterfallQuery {
    /// The channel; by default the first of `outputs.orders`, else the first kept series (`…/channels`).
    #[param(example = "spindle.y.acceleration", pattern = r"^[^\u0000]*$")]
    channel: Option<String>,
    /// Unit of the columns. Default `hz`.
    #[param(inline = false)]
    axis: Option<WaterfallAxis>,
    /// Time of a row [s], for `axis=hz`. Default: the time in which BPFI moves by one bin at the fastest change of speed, at most a sixteenth of the
    /// recorded time.
    #[param(example = 0.2)]
    window_s: Option<f64>,
    /// Highest frequency [Hz], for `axis=hz`. Default: that of `max_order` at the highest speed, at most 20 kHz.
    #[param(example = 2000.0)]
    max_frequency_hz: Option<f64>,
    /// Labelled orders, separated by commas.
    #[param(example = "1,BPFO,2*BPFO", pattern = r"^[^\u0000]*$")]
    tracks: Option<String>,
    /// Highest order.
    #[param(example = 40.0)]
    max_order: Option<f64>,
    /// Turns of the reference in a row, for `axis=order`.
    #[param(example = 16.0)]
    turns_per_block: Option<f64>,
    /// Share of a row that the next one repeats, from 0 to 0.9.
    #[param(example = 0.5)]
    overlap: Option<f64>,
    /// Body whose turns an order counts.
    #[param(inline = false)]
    reference: Option<ReferenceName>,
    /// Width of a PNG [pixels]. Default 1024.
    #[param(value_type = Option<u32>, minimum = 16, maximum = 4096, example = 1024)]
    width: Option<u32>,
    /// Height of a PNG [pixels]. Default 512.
    #[param(value_type = Option<u32>, minimum = 16, maximum = 4096, example = 512)]
    height: Option<u32>,
    /// Range of the colours below the largest amplitude, for SVG and PNG [dB]. Default 60.
    #[param(minimum = 1, maximum = 200, example = 60.0)]
    range_db: Option<f64>,
}

/// Size [pixels] and range of colours [dB] of a picture.
#[derive(Debug, Clone, Copy)]
pub struct PictureSize {
    size: (usize, usize),
    range_db: f64,
}

impl WaterfallQuery {
    /// Size and colours of a picture.
    pub fn picture(&self) -> Result<PictureSize, ApiError> {
        let pixels = |name: &str, value: Option<u32>, usual: u32| match value.unwrap_or(usual) {
            pixels @ 16..=4096 => Ok(pixels as usize),
            other => {
                Err(ApiError::BadRequest(format!("query: {name}: {other} pixels: must be from 16 to 4096 pixels")))
            }
        };
        let range_db = self.range_db.unwrap_or(draw::WATERFALL_RANGE_DB);
        if !(1.0..=200.0).contains(&range_db) {
            return Err(ApiError::BadRequest(format!("query: range_db: {range_db} dB: must be from 1 to 200 dB")));
        }
        Ok(PictureSize { size: (pixels("width", self.width, 1024)?, pixels("height", self.height, 512)?), range_db })
    }

    /// The settings of an order analysis.
    fn settings(&self) -> OrdersInput {
        OrdersInput {
            channels: None,
            tracks: self.tracks.as_deref().map(names),
            max_order: self.max_order,
            turns_per_block: self.turns_per_block,
            overlap: self.overlap,
            reference: self.reference,
        }
    }
}

/// Names separated by commas.
fn names(text: &str) -> Vec<String> {
    text.split(',').map(|name| name.trim().to_owned()).collect()
}

/// The order analysis of a job.
pub(super) async fn orders_of(
    app: &App,
    owner: &str,
    id: Uuid,
    permit: &RequestPermit,
    query: OrdersQuery,
) -> Result<OrdersAnswer, ApiError> {
    let kept = Kept::of(app, owner, id, permit, query.channel).await?;
    let settings = OrdersInput {
        channels: None,
        tracks: query.tracks.as_deref().map(names),
        max_order: query.max_order,
        turns_per_block: query.turns_per_block,
        overlap: query.overlap,
        reference: query.reference,
    };
    let signal = kept.signal.clone();
    let running = kept.started(permit, move |job, run| {
        let request = job.orders(settings, run).map_err(wrong_query)?;
        RunningOrders::new(signal, request, run).ok_or(ApiError::Internal)
    });
    let running = running.await?;
    let running = kept.fed(permit, running, RunningOrders::push).await?;
    computed(permit, |_| running.finish()).await
}

/// The waterfall of a job.
pub(super) async fn waterfall_of(
    app: &App,
    owner: &str,
    id: Uuid,
    permit: &RequestPermit,
    query: WaterfallQuery,
) -> Result<WaterfallAnswer, ApiError> {
    let settings = query.settings();
    let kept = Kept::of(app, owner, id, permit, query.channel).await?;
    let signal = kept.signal.clone();
    let running = kept.started(permit, move |job, run| {
        let request = job.orders(settings, run).map_err(wrong_query)?;
        let windows = match query.axis {
            Some(WaterfallAxis::Order) => None,
            _ => {
                let windows = time_windows(run, &request.settings, query.window_s, query.max_frequency_hz);
                Some(windows.map_err(|error| wrong_query(vec![error]))?)
            }
        };
        RunningWaterfall::new(signal, request, windows, run).ok_or(ApiError::Internal)
    });
    let running = running.await?;
    let running = kept.fed(permit, running, RunningWaterfall::push).await?;
    computed(permit, |_| running.finish()).await
}

/// Errors of the settings of an analysis, as those of a query.
fn wrong_query(errors: Vec<FieldError>) -> ApiError {
    let one = |error: &FieldError| {
        let name = error.pointer.trim_start_matches("/outputs/orders").trim_start_matches('/');
        if name.is_empty() { error.detail.clone() } else { format!("{name}: {}", error.detail) }
    };
    ApiError::BadRequest(format!("query: {}", errors.iter().map(one).collect::<Vec<_>>().join("; ")))
}

/// The kept series of a channel, with those of cage and ball of each bearing.
struct Kept {
    job: Arc<Job>,
    run: Arc<RecordedTurns>,
    signal: AnalysedSignal,
    series: StoredSeries,
    turning: Vec<[Option<StoredSeries>; 2]>,
}

impl Kept {
    async fn of(
        app: &App,
        owner: &str,
        id: Uuid,
        permit: &RequestPermit,
        channel: Option<String>,
    ) -> Result<Self, ApiError> {
        let request = app.jobs.get(owner, id).await?.request;
        let kept = app.jobs.channels(owner, id, Signal::Series).await?;
        let job = computed(permit, move |_| stored_job(&request)).await??;
        let first = || job.first_channel().map(str::to_owned).or_else(|| kept.first().cloned());
        let channel = channel.or_else(first).unwrap_or_default();
        let series = series_of(app, owner, id, &channel).await?;
        let run = job.recorded_turns(series.time(0)).ok_or(ApiError::Internal)?;
        let other = async |name: &String| match kept.contains(name) {
            true => series_of(app, owner, id, name).await.map(Some),
            false => Ok(None),
        };
        let mut turning = Vec::new();
        for bearing in &run.bearings {
            let [cage, ball] = bearing.turning_channels();
            turning.push([other(&cage).await?, other(&ball).await?]);
        }
        let signal = AnalysedSignal {
            channel: series.channel().to_owned(),
            unit: series.unit().to_owned(),
            start_s: series.time(0),
            step_s: series.time(1) - series.time(0),
            is_simulated: turning.iter().flatten().all(Option::is_some),
        };
        Ok(Self { job: Arc::new(job), run: Arc::new(run), signal, series, turning })
    }

    /// An analysis by the request of the job.
    async fn started<A: Send + 'static>(
        &self,
        permit: &RequestPermit,
        start: impl FnOnce(&Job, &RecordedTurns) -> Result<A, ApiError> + Send + 'static,
    ) -> Result<A, ApiError> {
        let (job, run) = (Arc::clone(&self.job), Arc::clone(&self.run));
        computed(permit, move |_| start(&job, &run)).await?
    }

    /// The analysis after every value of the series. A chunk is read and passed at a time.
    async fn fed<A: Send + 'static>(
        &self,
        permit: &RequestPermit,
        mut analysis: A,
        push: fn(&mut A, Value<'_>),
    ) -> Result<A, ApiError> {
        let (mut at, length) = (0, self.series.length());
        while at < length {
            let signal = self.series.values(at..length).await?;
            let places = at..at + signal.len();
            let other = async |series: &Option<StoredSeries>| match series {
                Some(series) => series.values(places.clone()).await.map(Some),
                None => Ok(None),
            };
            let mut turning = Vec::with_capacity(self.turning.len());
            for [cage, ball] in &self.turning {
                turning.push([other(cage).await?, other(ball).await?]);
            }
            at = places.end;
            let passed = computed(permit, move |_| {
                let mut bearings = vec![SimulatedSpeeds::default(); turning.len()];
                for (k, signal) in signal.into_iter().enumerate() {
                    for (now, of) in bearings.iter_mut().zip(&turning) {
                        [now.cage, now.ball] = of.each_ref().map(|values| values.as_ref()?.get(k).copied());
                    }
                    push(&mut analysis, Value { signal, bearings: &bearings });
                }
                analysis
            });
            analysis = passed.await?;
        }
        Ok(analysis)
    }
}

/// The job of a stored request. Series that it names may be gone: the analysis does not need them.
fn stored_job(request: &str) -> Result<Job, ApiError> {
    parse_job_with(request.as_bytes(), &Uploads::stand_in())
        .map_err(|error| JobError::Corrupt(error.to_string()).into())
}

/// An order analysis in a format.
pub fn orders_response(format: &'static str, answer: &OrdersAnswer) -> Result<Response, ApiError> {
    Ok(match format {
        CSV => respond(CSV, answer.csv()),
        NPY => respond(NPY, answer.npy()),
        SVG => respond(SVG, draw::orders(answer)),
        _ => respond(JSON, json_text(answer)?),
    })
}

/// A waterfall in a format.
pub fn waterfall_response(
    format: &'static str,
    answer: &WaterfallAnswer,
    picture: PictureSize,
) -> Result<Response, ApiError> {
    Ok(match format {
        CSV => respond(CSV, answer.csv()),
        NPY => respond(NPY, answer.npy()),
        SVG => respond(SVG, draw::waterfall(answer, picture.range_db)),
        PNG => respond(PNG, draw::waterfall_png(answer, picture.size, picture.range_db)),
        _ => respond(JSON, json_text(answer)?),
    })
}
