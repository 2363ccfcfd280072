//! Plots of a job.

use axum::body::to_bytes;
use axum::extract::State;
use axum::http::HeaderMap;
use axum::http::header::CONTENT_TYPE;
use axum::response::{IntoResponse, Response};
use serde::Deserialize;
use utoipa::{IntoParams, ToSchema};
use uuid::Uuid;

use super::app::App;
use super::concurrency::{RequestPermit, hold_until_sent};
use super::credentials::Owner;
use super::error::ApiError;
use super::openapi::{self, Anywhere, BadQuery, NoPlot, NoResult, NotAccepted, Unchanged};
use super::orders::{OrdersQuery, WaterfallQuery, orders_of, waterfall_of};
use super::request::{JobId, PlotFile, Query, negotiated};
use super::stored_answer::{SVG, formatted, read, series_of, spectrum_of};
use super::studies::{table_of, uncertainty_of, uncertainty_points};
use crate::contract::answer::views::TraceView;
use crate::contract::job::simulation::varying_speed_rpm;
use crate::contract::{
    AccuracyJobAnswer, JobKind, Metrics, OptimumAnswer, RotorAnswer, SeriesAnswer, SpectrumKind, TableAnswer,
    ViewsAnswer,
};
use crate::jobs::{JobError, Signal};
use crate::plots::{Theme, draw, draw_rotor, draw_uncertainty, seen};

/// Names of plots. The kind of a job decides which of them it has.
#[derive(ToSchema)]
#[allow(dead_code, reason = "only describes the path; the handler reads it")]
enum PlotName {
    #[schema(rename = "spectrum.svg")]
    Spectrum,
    #[schema(rename = "velocity.svg")]
    Velocity,
    #[schema(rename = "acceleration.svg")]
    Acceleration,
    #[schema(rename = "orbit.svg")]
    Orbit,
    #[schema(rename = "loads.svg")]
    Loads,
    #[schema(rename = "envelope.svg")]
    Envelope,
    #[schema(rename = "impact.svg")]
    Impact,
    #[schema(rename = "orders.svg")]
    Orders,
    #[schema(rename = "waterfall.svg")]
    Waterfall,
    #[schema(rename = "campbell.svg")]
    Campbell,
    #[schema(rename = "shapes.svg")]
    Shapes,
    #[schema(rename = "work-precision.svg")]
    WorkPrecision,
    #[schema(rename = "optimum.svg")]
    Optimum,
    #[schema(rename = "uncertainty.svg")]
    Uncertainty,
    #[schema(rename = "trend.svg")]
    Trend,
    #[schema(rename = "map.svg")]
    Map,
}

pub const OF_SIMULATION: &[&str] = &[
    "spectrum.svg",
    "envelope.svg",
    "velocity.svg",
    "acceleration.svg",
    "orbit.svg",
    "loads.svg",
    "impact.svg",
    "orders.svg",
    "waterfall.svg",
];
pub const OF_MACHINE: &[&str] = &["spectrum.svg", "envelope.svg", "orders.svg", "waterfall.svg"];
pub const OF_ROTOR: &[&str] = &["campbell.svg", "shapes.svg"];
pub const OF_ACCURACY: &[&str] = &["work-precision.svg"];
pub const OF_OPTIMUM: &[&str] = &["optimum.svg"];
pub const OF_UNCERTAINTY: &[&str] = &["uncertainty.svg"];
pub const OF_STUDY: &[&str] = &["trend.svg", "map.svg"];
/// Plots of one channel or of several.
const OF_CHANNELS: [&str; 6] =
    ["spectrum.svg", "envelope.svg", "velocity.svg", "acceleration.svg", "orders.svg", "waterfall.svg"];
/// Plots of studies over one axis, over two, and over more.
const OF_STUDY_BY_AXES: [&[&str]; 3] = [&["trend.svg"], &["map.svg"], &[]];

/// Get a plot
///
/// Simulation:
/// - `spectrum.svg`: the kept amplitude spectra, with labelled lines.
/// - `envelope.svg`: the spectra of the envelopes of the accelerations, with labelled lines.
/// - `velocity.svg`, `acceleration.svg`: velocity and acceleration of the spindle over time, thinned so that peaks survive.
/// - `orbit.svg`: the paths of the centres of spindle and cage.
/// - `loads.svg`: loads of ball 1 over its orbit, if contacts were requested.
/// - `impact.svg`: the acceleration of the spindle around its largest peak, if a raceway has a defect. Times at which the centre of a ball
///   is over a defect are shaded.
///
/// - `orders.svg`: the mean order spectrum and tracks of orders over the shaft speed, if orders or series were requested; of a machine job, too.
/// - `waterfall.svg`: spectra over the shaft speed with labelled orders, likewise. `…/orders` and `…/waterfall` take settings.
///
/// At a steady speed these plots show the last 12 ball passages, four turns, or the first three turns of the ball; otherwise the whole
/// run. Of a run longer than 1 s they show at most its first second.
///
/// Other kinds:
/// - `spectrum.svg`, `envelope.svg` (machine job): the spectra of the sensors' accelerations, or without sensors, of the bearings' inner
///   rings along y, with labelled lines.
/// - `campbell.svg` (rotor job): natural frequencies over speed with the critical speeds.
/// - `shapes.svg` (rotor job): shapes of the natural motions at the operating speed, on the outline of the shaft.
/// - `work-precision.svg` (accuracy job): error against run time, one curve for each method.
/// - `optimum.svg` (optimum job): the runs and the best point.
/// - `uncertainty.svg` (uncertainty job): histograms with percentiles, and the share of the variance that each input explains.
/// - `trend.svg`, `map.svg` (study over one axis or two): the points that have been computed.
#[utoipa::path(
    get, path = "/v1/jobs/{id}/plots/{file}", tag = openapi::RESULTS, operation_id = "getPlot",
    params(
        ("id" = Uuid, Path, description = "The job"),
        ("file" = inline(PlotName), Path, description = "The plot", example = "spectrum.svg"), PlotQuery
    ),
    responses((status = 200, description = "The plot", body = String, content_type = "image/svg+xml", example = json!("<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 760 654\">…</svg>")), Unchanged, BadQuery, NoPlot, NoResult, NotAccepted, Anywhere)
)]
pub async fn plot(
    State(app): State<App>,
    Owner(owner): Owner,
    permit: RequestPermit,
    headers: HeaderMap,
    JobId(id): JobId,
    PlotFile(file): PlotFile,
    Query(query): Query<PlotQuery>,
) -> Result<Response, ApiError> {
    negotiated(&headers, &[SVG])?;
    query.check()?;
    // A study has up to a hundred megabytes, and a series a million values.
    let held = match file.as_str() {
        "trend.svg" | "map.svg" | "uncertainty.svg" | "velocity.svg" | "acceleration.svg" | "orders.svg"
        | "waterfall.svg" => Some(permit.concurrency().series()?),
        _ => None,
    };
    let response = drawn(&app, &owner, id, &permit, &file, query.channel.clone()).await?;
    let response = query.applied(response).await?;
    Ok(match held {
        Some(held) => hold_until_sent(held, response),
        None => response,
    })
}

/// How a plot is seen, and of which channel it is.
#[derive(Debug, Default, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub struct PlotQuery {
    /// The channel of `spectrum.svg`, `envelope.svg`, `velocity.svg`, `acceleration.svg`, `orders.svg` or `waterfall.svg`. Default: all that the
    /// plot shows; of the last two the first channel.
    #[param(example = "spindle.y.acceleration", pattern = r"^[^\u0000]*$")]
    channel: Option<String>,
    /// Width of the picture [px]; the height follows. Default: the plot's own.
    #[param(minimum = 100, maximum = 4000, example = 1200)]
    size: Option<u32>,
    /// Ground of the picture. Default `auto`.
    #[param(inline)]
    theme: Option<ThemeName>,
}

/// `auto`: as the viewer's system is set. `light`, `dark`: always so, as for paper or slides.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum ThemeName {
    Auto,
    Light,
    Dark,
}

/// Widths of a picture [px].
const SIZES: std::ops::RangeInclusive<u32> = 100..=4000;

impl PlotQuery {
    pub(super) fn check(&self) -> Result<(), ApiError> {
        match self.size.filter(|size| !SIZES.contains(size)) {
            Some(size) => Err(ApiError::BadRequest(format!("query: `size` must be from 100 to 4000 px, not {size}"))),
            None => Ok(()),
        }
    }

    /// The plot as it is to be seen.
    async fn applied(&self, response: Response) -> Result<Response, ApiError> {
        let theme = match self.theme {
            None | Some(ThemeName::Auto) => Theme::Auto,
            Some(ThemeName::Light) => Theme::Light,
            Some(ThemeName::Dark) => Theme::Dark,
        };
        if theme == Theme::Auto && self.size.is_none() {
            return Ok(response);
        }
        let size = self.size;
        let drawn = to_bytes(response.into_body(), usize::MAX).await.map_err(|_| ApiError::Internal)?;
        formatted(move || Ok(svg_response(seen(&String::from_utf8_lossy(&drawn), theme, size)))).await
    }
}

async fn drawn(
    app: &App,
    owner: &str,
    id: Uuid,
    permit: &RequestPermit,
    file: &str,
    channel: Option<String>,
) -> Result<Response, ApiError> {
    if let Some(channel) = channel.clone().filter(|_| !OF_CHANNELS.contains(&file)) {
        // A missing job is reported first.
        app.jobs.get(owner, id).await?;
        return Err(ApiError::UnknownChannel { channel, kept: Vec::new() });
    }
    let named = channel.as_deref();
    match file {
        "spectrum.svg" => spectra(app, owner, id, SpectrumKind::Amplitude, named).await,
        "envelope.svg" => spectra(app, owner, id, SpectrumKind::Envelope, named).await,
        "impact.svg" => view(app, owner, id, |views| views.impact.as_ref().map(draw::impact)).await,
        "velocity.svg" => series(app, owner, id, "velocity", named).await,
        "acceleration.svg" => series(app, owner, id, "acceleration", named).await,
        "orbit.svg" => {
            view(app, owner, id, |views| Some(draw::orbits(&views.orbits)).filter(|_| !views.orbits.is_empty())).await
        }
        "loads.svg" => view(app, owner, id, |views| views.loads.as_ref().map(draw::loads)).await,
        "orders.svg" => {
            check_series(app, owner, id).await?;
            let answer = orders_of(app, owner, id, permit, OrdersQuery::of_channel(channel)).await?;
            formatted(move || Ok(svg_response(draw::orders(&answer)))).await
        }
        "waterfall.svg" => {
            check_series(app, owner, id).await?;
            let answer = waterfall_of(app, owner, id, permit, WaterfallQuery::of_channel(channel)).await?;
            formatted(move || Ok(svg_response(draw::waterfall(&answer, draw::WATERFALL_RANGE_DB)))).await
        }
        "campbell.svg" => rotor(app, owner, id, draw_rotor::campbell).await,
        "shapes.svg" => rotor(app, owner, id, draw_rotor::shapes).await,
        "work-precision.svg" => work_precision(app, owner, id).await,
        "optimum.svg" => optimum(app, owner, id).await,
        "uncertainty.svg" => {
            let (request, points) = uncertainty_points(app, owner, id).await?;
            formatted(move || Ok(svg_response(draw_uncertainty::histograms(&uncertainty_of(&request, points)?)))).await
        }
        "trend.svg" => of_study(app, owner, id, draw::trend).await,
        "map.svg" => of_study(app, owner, id, draw::map).await,
        _ => {
            // A missing job is reported first.
            let record = app.jobs.get(owner, id).await?;
            let is = |kind: JobKind| record.kind == kind.name();
            let known = if is(JobKind::Accuracy) {
                OF_ACCURACY
            } else if is(JobKind::Optimum) {
                OF_OPTIMUM
            } else if is(JobKind::Study) {
                OF_STUDY
            } else if is(JobKind::Uncertainty) {
                OF_UNCERTAINTY
            } else if is(JobKind::Machine) {
                OF_MACHINE
            } else if is(JobKind::Rotor) {
                OF_ROTOR
            } else {
                OF_SIMULATION
            };
            Err(ApiError::UnknownPlot { known })
        }
    }
}

async fn spectra(
    app: &App,
    owner: &str,
    id: Uuid,
    kind: SpectrumKind,
    named: Option<&str>,
) -> Result<Response, ApiError> {
    let metrics = match app.jobs.metrics(owner, id, JobKind::Simulation).await {
        Err(JobError::OtherKind { kind: other }) if other == JobKind::Machine.name() => {
            return machine_spectra(app, owner, id, kind, named).await;
        }
        metrics => metrics?,
    };
    let is_shown = |channel: &String| kind == SpectrumKind::Amplitude || draw::is_of_spindle(channel, "acceleration");
    let channels = match named {
        Some(channel) => vec![channel.to_owned()],
        None => app.jobs.channels(owner, id, Signal::Amplitude).await?.into_iter().filter(is_shown).collect(),
    };
    let mut spectra = Vec::new();
    for channel in channels {
        spectra.push(spectrum_of(app, owner, id, kind, &channel).await?);
    }
    if spectra.is_empty() {
        return Err(ApiError::UnknownChannel { channel: "spindle.y.acceleration".into(), kept: Vec::new() });
    }
    let speed = varying_speed(app, owner, id).await?;
    formatted(move || {
        let metrics: Metrics = read(metrics.as_bytes())?;
        let draw = if kind == SpectrumKind::Envelope { draw::envelopes } else { draw::spectra };
        Ok(svg_response(draw(&metrics, &spectra, speed)))
    })
    .await
}

/// Whether the speed of a job varies, and whether the job has a waterfall.
async fn varying_speed(app: &App, owner: &str, id: Uuid) -> Result<draw::VaryingSpeed, ApiError> {
    let request = app.jobs.get(owner, id).await?.request;
    let has_waterfall = !app.jobs.channels(owner, id, Signal::Series).await?.is_empty();
    let range_rpm =
        tokio::task::spawn_blocking(move || read(request.as_bytes()).map(|request| varying_speed_rpm(&request)));
    Ok(draw::VaryingSpeed { range_rpm: range_rpm.await.map_err(|_| ApiError::Internal)??, has_waterfall })
}

/// Spectra of a machine job: of its sensors, or without any, of its bearings along Y.
async fn machine_spectra(
    app: &App,
    owner: &str,
    id: Uuid,
    kind: SpectrumKind,
    named: Option<&str>,
) -> Result<Response, ApiError> {
    let metrics = app.jobs.metrics(owner, id, JobKind::Machine).await?;
    let kept = app.jobs.channels(owner, id, kind.into()).await?;
    let has_sensors = kept.iter().any(|channel| draw::is_of_machine(channel, true));
    let channels: Vec<&str> = match named {
        Some(channel) => vec![channel],
        None => kept.iter().map(String::as_str).filter(|channel| draw::is_of_machine(channel, has_sensors)).collect(),
    };
    let mut spectra = Vec::new();
    for channel in channels {
        spectra.push(spectrum_of(app, owner, id, kind, channel).await?);
    }
    let speed = varying_speed(app, owner, id).await?;
    formatted(move || Ok(svg_response(draw::machine_spectra(&read(metrics.as_bytes())?, kind, &spectra, speed)))).await
}

/// A plot of the data that are kept for plots. Some models lack the data of some plots.
async fn view(
    app: &App,
    owner: &str,
    id: Uuid,
    draw: impl FnOnce(ViewsAnswer) -> Option<String> + Send + 'static,
) -> Result<Response, ApiError> {
    let stored = app.jobs.views(owner, id).await?;
    formatted(move || {
        let views = stored.map(|stored| read::<ViewsAnswer>(&stored)).transpose()?;
        let known = match &views {
            None => &[][..],
            Some(ViewsAnswer { loads: None, .. }) => &OF_SIMULATION[..5],
            Some(ViewsAnswer { impact: None, .. }) => &OF_SIMULATION[..6],
            Some(_) => OF_SIMULATION,
        };
        views.and_then(draw).map(svg_response).ok_or(ApiError::UnknownPlot { known })
    })
    .await
}

async fn series(
    app: &App,
    owner: &str,
    id: Uuid,
    quantity: &'static str,
    named: Option<&str>,
) -> Result<Response, ApiError> {
    let kept = app.jobs.channels(owner, id, Signal::Series).await?;
    let named = named.map(str::to_owned);
    let is_wanted = move |channel: &str| {
        draw::is_of_spindle(channel, quantity) && named.as_deref().is_none_or(|named| named == channel)
    };
    let mut series = Vec::new();
    for channel in kept.iter().filter(|channel| is_wanted(channel)) {
        series.push(series_of(app, owner, id, channel).await?.beginning(draw::LONGEST_SERIES_S).await?);
    }
    if series.is_empty() {
        return view(app, owner, id, move |views| {
            let of_quantity = views.traces.into_iter().filter(|trace| is_wanted(&trace.channel));
            let traces: Vec<SeriesAnswer> = of_quantity.map(TraceView::series).collect();
            (!traces.is_empty()).then(|| draw::series(&traces))
        })
        .await;
    }
    formatted(move || Ok(svg_response(draw::series(&series)))).await
}

/// Refuses plots of a job without series.
async fn check_series(app: &App, owner: &str, id: Uuid) -> Result<(), ApiError> {
    if !app.jobs.channels(owner, id, Signal::Series).await?.is_empty() {
        return Ok(());
    }
    let is_machine = app.jobs.get(owner, id).await?.kind == JobKind::Machine.name();
    Err(ApiError::UnknownPlot { known: if is_machine { &OF_MACHINE[..2] } else { &OF_SIMULATION[..7] } })
}

async fn rotor(app: &App, owner: &str, id: Uuid, draw: fn(&RotorAnswer) -> String) -> Result<Response, ApiError> {
    let stored = app.jobs.report(owner, id, JobKind::Rotor).await?;
    formatted(move || Ok(svg_response(draw(&read::<RotorAnswer>(&stored)?)))).await
}

async fn work_precision(app: &App, owner: &str, id: Uuid) -> Result<Response, ApiError> {
    let stored = app.jobs.report(owner, id, JobKind::Accuracy).await?;
    formatted(move || {
        Ok(svg_response(match read::<AccuracyJobAnswer>(&stored)? {
            AccuracyJobAnswer::Methods(answer) => draw::work_precision(&answer),
            AccuracyJobAnswer::Modes(answer) => draw::mode_precision(&answer),
        }))
    })
    .await
}

async fn optimum(app: &App, owner: &str, id: Uuid) -> Result<Response, ApiError> {
    let stored = app.jobs.report(owner, id, JobKind::Optimum).await?;
    formatted(move || Ok(svg_response(draw::optimum(&read::<OptimumAnswer>(&stored)?)))).await
}

/// A plot of a study; an error if the plot needs another number of axes.
async fn of_study(
    app: &App,
    owner: &str,
    id: Uuid,
    draw: fn(&TableAnswer) -> Option<String>,
) -> Result<Response, ApiError> {
    let (request, points) = app.jobs.points(owner, id).await?;
    formatted(move || {
        let table = table_of(&request, points)?;
        let known = OF_STUDY_BY_AXES[table.axes.len().clamp(1, 3) - 1];
        draw(&table).map(svg_response).ok_or(ApiError::UnknownPlot { known })
    })
    .await
}

/// The response of a plot.
fn svg_response(svg: String) -> Response {
    ([(CONTENT_TYPE, SVG)], svg).into_response()
}
