//! A service without jobs, for the fuzz target `request`. Extractors and the formatting of stored signals are those of the service. In
//! place of stored jobs there is one that has every result.

use axum::Router;
use axum::body::{Body, Bytes};
use axum::http::header::{LINK, LOCATION, RANGE};
use axum::http::{HeaderMap, HeaderName, HeaderValue, Request, StatusCode};
use axum::middleware;
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use http_body_util::BodyExt;
use hyper::service::Service as _;
use hyper_util::service::TowerToHyperService;
use uuid::Uuid;

use super::error::ApiError;
use super::jobs::ShowQuery;
use super::list_query::ListQuery;
use super::orders::{OrdersQuery, PNG, WaterfallQuery};
use super::request::{
    JobId, JsonBody, NoQuery, PlotFile, Query, SeriesBody, SeriesFormat, SeriesHash, header, negotiated,
};
use super::results::{BandsQuery, SeriesQuery, SpectrumQuery, bands_response};
use super::rotor::{PYTHON, RossQuery};
use super::routes::document;
use super::stored_answer::{CSV, JSON, NPY, SVG};
use super::submission_headers::{idempotency_key, preferred_wait};
use super::uploaded_series::{self, SeriesQuery as SeriesUpload};
use super::{conditional, error_layers, plots, portal, preview, scenes};
use crate::contract::answer::signals::SpectrumScaling;
use crate::contract::{
    MeasurementRequest, SeriesAnswer, SpectrumAnswer, SpectrumKind, Uploads, parse_batch, parse_job,
    parse_machine_request, parse_rotor_request, parse_scene_request,
};

/// The service.
pub struct Service {
    router: TowerToHyperService<Router>,
    runtime: tokio::runtime::Runtime,
}

/// An answer.
#[derive(Debug)]
pub struct Answer {
    pub status: u16,
    pub headers: HeaderMap,
    pub body: Bytes,
}

impl Default for Service {
    fn default() -> Self {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_time().build().expect("a runtime");
        Self { router: TowerToHyperService::new(router()), runtime }
    }
}

impl Service {
    /// The answer to a request; `None` if it is not a valid HTTP request.
    pub fn answer(&self, method: &str, target: &str, headers: &[(&[u8], &[u8])], body: &[u8]) -> Option<Answer> {
        let mut request = Request::builder().method(method).uri(target);
        for (name, value) in headers {
            let (name, value) = (HeaderName::from_bytes(name).ok()?, HeaderValue::from_bytes(value).ok()?);
            request = request.header(name, value);
        }
        let request = request.body(Body::from(body.to_vec())).ok()?;
        self.runtime.block_on(async {
            let (parts, body) = self.router.call(request).await.unwrap_or_else(|never| match never {}).into_parts();
            let body = body.collect().await.expect("an answer has a body").to_bytes();
            Some(Answer { status: parts.status.as_u16(), headers: parts.headers, body })
        })
    }

    /// Paths of the OpenAPI document.
    pub fn paths() -> Vec<String> {
        document().paths.paths.keys().cloned().collect()
    }
}

fn router() -> Router {
    let mut router = Router::new()
        .route("/v1/jobs", get(list).post(submit))
        .route("/v1/jobs/batch", post(batch))
        .route("/v1/jobs/{id}", get(show).delete(with_job))
        .route("/v1/jobs/{id}/events", get(events))
        .route("/v1/jobs/{id}/spectrum", get(spectrum))
        .route("/v1/jobs/{id}/bands", get(bands))
        .route("/v1/jobs/{id}/series", get(series))
        .route("/v1/jobs/{id}/orders", get(orders))
        .route("/v1/jobs/{id}/waterfall", get(waterfall))
        .route("/v1/jobs/{id}/plots/{file}", get(plot))
        .route("/v1/jobs/{id}/table", get(table))
        .route("/v1/jobs/{id}/rotor.py", get(rotor_script))
        .route("/v1/jobs/{id}/comparison", post(comparison))
        .route("/v1/rotor", post(rotor))
        .route("/v1/machine/resolve", post(machine))
        .route("/v1/preview", post(preview))
        .route("/v1/series", get(without_job).post(upload_series))
        .route("/v1/series/{hash}", get(uploaded).delete(uploaded))
        .route("/v1/scenes/resolve", post(resolve))
        .route("/v1/catalogue", get(scenes::catalogue))
        .route("/portal/{*file}", get(portal::file));
    for result in ["metrics", "channels", "accuracy", "optimum", "uncertainty", "rotor", "machine"] {
        router = router.route(&format!("/v1/jobs/{{id}}/{result}"), get(with_job));
    }
    for action in ["cancel", "resume"] {
        router = router.route(&format!("/v1/jobs/{{id}}/{action}"), post(with_job));
    }
    for path in ["/v1/presets", "/health/live", "/health/ready", "/metrics", "/openapi.json"] {
        router = router.route(path, get(without_job));
    }
    router.layer(middleware::from_fn(error_layers::as_problems))
}

async fn list(headers: HeaderMap, Query(query): Query<ListQuery>) -> Result<Response, ApiError> {
    negotiated(&headers, &[JSON])?;
    query.filter()?;
    let next = HeaderValue::try_from(query.page_after(Uuid::nil())).map_err(|_| ApiError::Internal)?;
    Ok([(LINK, next)].into_response())
}

async fn submit(headers: HeaderMap, _: Query<NoQuery>, JsonBody(body): JsonBody) -> Result<Response, ApiError> {
    negotiated(&headers, &[JSON])?;
    let (wait, key) = (preferred_wait(&headers)?, idempotency_key(&headers)?);
    assert!(wait.is_none_or(|seconds| seconds <= 60));
    assert!(key.is_none_or(|key| (1..=255).contains(&key.len()) && key.bytes().all(|byte| byte.is_ascii_graphic())));
    parse_job(&body)?;
    Ok((StatusCode::ACCEPTED, [(LOCATION, "/")]).into_response())
}

async fn batch(headers: HeaderMap, _: Query<NoQuery>, JsonBody(body): JsonBody) -> Result<Response, ApiError> {
    negotiated(&headers, &[JSON])?;
    idempotency_key(&headers)?;
    for error in parse_batch(&body, &Uploads::default(), &|| false)?.into_iter().filter_map(Result::err) {
        let (status, problem) = ApiError::from(error).problem();
        assert!(status.is_client_error() && !problem.detail.is_empty());
    }
    Ok(StatusCode::OK.into_response())
}

async fn resolve(headers: HeaderMap, _: Query<NoQuery>, JsonBody(body): JsonBody) -> Result<Response, ApiError> {
    negotiated(&headers, &[JSON])?;
    parse_scene_request(&body)?;
    Ok(StatusCode::OK.into_response())
}

async fn rotor(headers: HeaderMap, _: Query<NoQuery>, JsonBody(body): JsonBody) -> Result<Response, ApiError> {
    negotiated(&headers, &[JSON])?;
    parse_rotor_request(&body, &Uploads::stand_in())?;
    Ok(StatusCode::OK.into_response())
}

async fn machine(headers: HeaderMap, _: Query<NoQuery>, JsonBody(body): JsonBody) -> Result<Response, ApiError> {
    negotiated(&headers, &[JSON])?;
    parse_machine_request(&body, &Uploads::stand_in())?;
    Ok(StatusCode::OK.into_response())
}

async fn comparison(
    headers: HeaderMap,
    _: JobId,
    _: Query<NoQuery>,
    JsonBody(body): JsonBody,
) -> Result<Response, ApiError> {
    negotiated(&headers, &[JSON])?;
    MeasurementRequest::read(&body)?.with(&Uploads::stand_in())?;
    Ok(StatusCode::OK.into_response())
}

async fn preview(headers: HeaderMap, _: Query<NoQuery>, JsonBody(body): JsonBody) -> Result<Response, ApiError> {
    negotiated(&headers, &[JSON])?;
    preview::checked(parse_job(&body)?)?;
    Ok(StatusCode::OK.into_response())
}

async fn upload_series(
    headers: HeaderMap,
    Query(SeriesUpload { rate_hz }): Query<SeriesUpload>,
    SeriesBody(format, body): SeriesBody,
) -> Result<StatusCode, ApiError> {
    negotiated(&headers, &[JSON])?;
    let samples = match format {
        SeriesFormat::Json => uploaded_series::of_json(rate_hz, &body)?,
        SeriesFormat::Csv => uploaded_series::of_csv(rate_hz, &body)?,
    };
    assert!(samples.values().iter().all(|value| value.is_finite()));
    Ok(StatusCode::CREATED)
}

async fn uploaded(headers: HeaderMap, _: SeriesHash, _: Query<NoQuery>) -> Result<StatusCode, ApiError> {
    negotiated(&headers, &[JSON]).map(|_| StatusCode::OK)
}

async fn rotor_script(headers: HeaderMap, _: JobId, _: Query<RossQuery>) -> Result<StatusCode, ApiError> {
    negotiated(&headers, &[PYTHON]).map(|_| StatusCode::OK)
}

async fn show(headers: HeaderMap, JobId(id): JobId, _: Query<ShowQuery>) -> Result<Response, ApiError> {
    negotiated(&headers, &[JSON])?;
    Ok(conditional::job(&headers, format!("\"{id}\"").into_bytes()))
}

async fn events(headers: HeaderMap, _: JobId, _: Query<NoQuery>) -> Result<Response, ApiError> {
    negotiated(&headers, &["text/event-stream"])?;
    let seen = header(&headers, &HeaderName::from_static("last-event-id"));
    Ok(if seen == Some("succeeded-1000") { StatusCode::NO_CONTENT } else { StatusCode::OK }.into_response())
}

async fn spectrum(headers: HeaderMap, _: JobId, query: Query<SpectrumQuery>) -> Result<Response, ApiError> {
    let format = negotiated(&headers, &[JSON, CSV])?;
    SpectrumQuery::checked(query)?.formatted(format, stored_spectrum())
}

async fn bands(headers: HeaderMap, _: JobId, query: Query<BandsQuery>) -> Result<Response, ApiError> {
    negotiated(&headers, &[JSON])?;
    bands_response(&stored_spectrum(), &BandsQuery::checked(query)?.1)
}

fn stored_spectrum() -> SpectrumAnswer {
    SpectrumAnswer {
        channel: "spindle.y.acceleration".into(),
        kind: SpectrumKind::Amplitude,
        scaling: SpectrumScaling::Amplitude,
        unit: "m/s²".into(),
        window: "hann".into(),
        window_noise_bandwidth_bins: 1.5,
        averages: 1,
        resolution_hz: 10.0,
        mean_step_s: 1e-5,
        damped_above_hz: 15_915.0,
        frequency_hz: Vec::new(),
        amplitude: (0..40).map(f64::from).collect(),
    }
    .with_frequencies()
}

async fn series(headers: HeaderMap, _: JobId, query: Query<SeriesQuery>) -> Result<Response, ApiError> {
    let format = negotiated(&headers, &[JSON, CSV, NPY])?;
    let stored = SeriesAnswer {
        channel: "cage.y.displacement".into(),
        unit: "µm".into(),
        dt_s: Some(0.01),
        time_s: (0..40).map(|k| 0.01 * f64::from(k)).collect(),
        value: (0..40).map(|k| f64::from(k * 7 % 11) - 5.0).collect(),
    };
    SeriesQuery::checked(query)?.part(stored.into()).answer(format, header(&headers, &RANGE)).await
}

async fn orders(headers: HeaderMap, _: JobId, _: Query<OrdersQuery>) -> Result<StatusCode, ApiError> {
    negotiated(&headers, &[JSON, CSV, NPY, SVG]).map(|_| StatusCode::OK)
}

async fn waterfall(headers: HeaderMap, _: JobId, Query(query): Query<WaterfallQuery>) -> Result<StatusCode, ApiError> {
    negotiated(&headers, &[JSON, CSV, NPY, SVG, PNG])?;
    query.picture().map(|_| StatusCode::OK)
}

async fn plot(
    headers: HeaderMap,
    _: JobId,
    PlotFile(file): PlotFile,
    Query(query): Query<plots::PlotQuery>,
) -> Result<StatusCode, ApiError> {
    negotiated(&headers, &[SVG])?;
    query.check()?;
    let known = [
        plots::OF_SIMULATION,
        plots::OF_ROTOR,
        plots::OF_ACCURACY,
        plots::OF_OPTIMUM,
        plots::OF_STUDY,
        plots::OF_UNCERTAINTY,
    ]
    .concat();
    if known.contains(&file.as_str()) {
        return Ok(StatusCode::OK);
    }
    Err(ApiError::UnknownPlot { known: plots::OF_SIMULATION })
}

async fn table(headers: HeaderMap, _: JobId, _: Query<NoQuery>) -> Result<StatusCode, ApiError> {
    negotiated(&headers, &[JSON, CSV]).map(|_| StatusCode::OK)
}

async fn with_job(headers: HeaderMap, _: JobId, _: Query<NoQuery>) -> Result<StatusCode, ApiError> {
    negotiated(&headers, &[JSON]).map(|_| StatusCode::OK)
}

async fn without_job(headers: HeaderMap, _: Query<NoQuery>) -> Result<StatusCode, ApiError> {
    negotiated(&headers, &[JSON]).map(|_| StatusCode::OK)
}
