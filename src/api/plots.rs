//! Pictures of a succeeded job.

use axum::extract::State;
use axum::http::HeaderMap;
use axum::http::header::CONTENT_TYPE;
use axum::response::{IntoResponse, Response};
use utoipa::ToSchema;
use uuid::Uuid;

use super::auth::Owner;
use super::describe::{Anywhere, BadQuery, NoPlot, NoResult, NotAccepted, Unchanged};
use super::error::ApiError;
use super::request::{JobId, Nothing, PlotFile, Query, negotiated};
use super::results::{read, series_of, shaped, spectrum_of};
use super::studies::table_of;
use super::{App, describe};
use crate::contract::answer::views::TraceView;
use crate::contract::{
    JobKind, Metrics, OptimumAnswer, SeriesAnswer, SpectrumKind, TableAnswer, ViewsAnswer, WorkPrecisionAnswer,
};
use crate::jobs::Signal;
use crate::plots::draw;

/// Plots by name; which of them a job has depends on its kind.
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
    #[schema(rename = "work-precision.svg")]
    WorkPrecision,
    #[schema(rename = "optimum.svg")]
    Optimum,
    #[schema(rename = "trend.svg")]
    Trend,
    #[schema(rename = "map.svg")]
    Map,
}

const SVG: &str = "image/svg+xml";
pub(super) const OF_SIMULATION: &[&str] =
    &["spectrum.svg", "velocity.svg", "acceleration.svg", "orbit.svg", "loads.svg"];
pub(super) const OF_ACCURACY: &[&str] = &["work-precision.svg"];
pub(super) const OF_OPTIMUM: &[&str] = &["optimum.svg"];
pub(super) const OF_STUDY: &[&str] = &["trend.svg", "map.svg"];
/// Of studies over one axis, over two, and over more.
const BY_AXES: [&[&str]; 3] = [&["trend.svg"], &["map.svg"], &[]];

/// Get a plot
///
/// `spectrum.svg`: the amplitude spectra that are kept, with labelled lines. `velocity.svg`,
/// `acceleration.svg`: the spindle's, thinned so that peaks survive. `orbit.svg`: the paths of the centres of spindle and cage. `loads.svg`: of ball 1 along its way,
/// where contacts were asked for. They show what can be told apart: at a steady speed the last 12 ball passages, four turns, and the first three turns of the ball; else the run. Of a run longer than a second they show its first part, a second at most. `work-precision.svg`: of an accuracy
/// job, error against run time, a curve a method. `optimum.svg`: of an optimum job, its runs and the best of them. `trend.svg`, `map.svg`: of a study over one axis or two, with what has been
/// computed so far.
#[utoipa::path(
    get, path = "/v1/jobs/{id}/plots/{file}", tag = describe::RESULTS, operation_id = "getPlot",
    params(
        ("id" = Uuid, Path, description = "The job"),
        ("file" = inline(PlotName), Path, description = "The plot", example = "spectrum.svg")
    ),
    responses((status = 200, description = "The plot", body = String, content_type = "image/svg+xml", example = json!("<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 760 654\">…</svg>")), Unchanged, BadQuery, NoPlot, NoResult, NotAccepted, Anywhere)
)]
pub async fn plot(
    State(app): State<App>,
    Owner(owner): Owner,
    headers: HeaderMap,
    JobId(id): JobId,
    PlotFile(file): PlotFile,
    _: Query<Nothing>,
) -> Result<Response, ApiError> {
    negotiated(&headers, &[SVG])?;
    match file.as_str() {
        "spectrum.svg" => spectra(&app, &owner, id).await,
        "velocity.svg" => series(&app, &owner, id, "velocity").await,
        "acceleration.svg" => series(&app, &owner, id, "acceleration").await,
        "orbit.svg" => {
            view(&app, &owner, id, |views| Some(draw::orbits(&views.orbits)).filter(|_| !views.orbits.is_empty())).await
        }
        "loads.svg" => view(&app, &owner, id, |views| views.loads.as_ref().map(draw::loads)).await,
        "work-precision.svg" => work_precision(&app, &owner, id).await,
        "optimum.svg" => optimum(&app, &owner, id).await,
        "trend.svg" => of_study(&app, &owner, id, draw::trend).await,
        "map.svg" => of_study(&app, &owner, id, draw::map).await,
        _ => {
            // Whether the job is there comes first.
            let record = app.jobs.get(&owner, id).await?;
            let is = |kind: JobKind| record.kind == kind.name();
            let known = if is(JobKind::Accuracy) {
                OF_ACCURACY
            } else if is(JobKind::Optimum) {
                OF_OPTIMUM
            } else if is(JobKind::Study) {
                OF_STUDY
            } else {
                OF_SIMULATION
            };
            Err(ApiError::UnknownPlot { known })
        }
    }
}

async fn spectra(app: &App, owner: &str, id: Uuid) -> Result<Response, ApiError> {
    let metrics = app.jobs.metrics(owner, id).await?;
    let mut spectra = Vec::new();
    for channel in app.jobs.channels(owner, id, Signal::Amplitude).await? {
        spectra.push(spectrum_of(app, owner, id, SpectrumKind::Amplitude, &channel).await?);
    }
    if spectra.is_empty() {
        return Err(ApiError::UnknownChannel { channel: "spindle.y.acceleration".into(), kept: Vec::new() });
    }
    shaped(move || {
        let metrics: Metrics = read(metrics.as_bytes())?;
        Ok(drawn(draw::spectra(&metrics, &spectra)))
    })
    .await
}

/// A picture of what is kept for pictures; a rung may lack what it shows.
async fn view(
    app: &App,
    owner: &str,
    id: Uuid,
    draw: impl FnOnce(ViewsAnswer) -> Option<String> + Send + 'static,
) -> Result<Response, ApiError> {
    let stored = app.jobs.views(owner, id).await?;
    shaped(move || {
        let views = stored.map(|stored| read::<ViewsAnswer>(&stored)).transpose()?;
        let known = match &views {
            None => &[][..],
            Some(views) if views.loads.is_none() => &OF_SIMULATION[..4],
            Some(_) => OF_SIMULATION,
        };
        views.and_then(draw).map(drawn).ok_or(ApiError::UnknownPlot { known })
    })
    .await
}

async fn series(app: &App, owner: &str, id: Uuid, quantity: &'static str) -> Result<Response, ApiError> {
    let kept = app.jobs.channels(owner, id, Signal::Series).await?;
    let wanted = kept.iter().filter(|channel| draw::is_of_spindle(channel, quantity));
    let mut stored = Vec::new();
    for channel in wanted {
        stored.push(series_of(app, owner, id, channel).await?);
    }
    if stored.is_empty() {
        return view(app, owner, id, move |views| {
            let of_quantity = views.traces.into_iter().filter(|trace| draw::is_of_spindle(&trace.channel, quantity));
            let traces: Vec<SeriesAnswer> = of_quantity.map(TraceView::series).collect();
            (!traces.is_empty()).then(|| draw::series(&traces))
        })
        .await;
    }
    shaped(move || {
        let series = stored.iter().map(|stored| read(stored)).collect::<Result<Vec<SeriesAnswer>, _>>()?;
        Ok(drawn(draw::series(&series)))
    })
    .await
}

async fn work_precision(app: &App, owner: &str, id: Uuid) -> Result<Response, ApiError> {
    let stored = app.jobs.report(owner, id, JobKind::Accuracy).await?;
    shaped(move || Ok(drawn(draw::work_precision(&read::<WorkPrecisionAnswer>(&stored)?)))).await
}

async fn optimum(app: &App, owner: &str, id: Uuid) -> Result<Response, ApiError> {
    let stored = app.jobs.report(owner, id, JobKind::Optimum).await?;
    shaped(move || Ok(drawn(draw::optimum(&read::<OptimumAnswer>(&stored)?)))).await
}

/// A picture of a study, which may have another number of axes.
async fn of_study(
    app: &App,
    owner: &str,
    id: Uuid,
    draw: fn(&TableAnswer) -> Option<String>,
) -> Result<Response, ApiError> {
    let (request, points) = app.jobs.points(owner, id).await?;
    shaped(move || {
        let table = table_of(&request, points)?;
        let known = BY_AXES[table.axes.len().clamp(1, 3) - 1];
        draw(&table).map(drawn).ok_or(ApiError::UnknownPlot { known })
    })
    .await
}

fn drawn(svg: String) -> Response {
    ([(CONTENT_TYPE, SVG)], svg).into_response()
}
