//! The page at `/` and its files, embedded in the binary. They are the same for every client and need no token; the API from which the
//! page takes its data does.

use std::sync::LazyLock;

use axum::http::header::{CACHE_CONTROL, CONTENT_SECURITY_POLICY, CONTENT_TYPE, ETAG, IF_NONE_MATCH, REFERRER_POLICY};
use axum::http::{HeaderMap, HeaderValue, StatusCode, Uri};
use axum::response::{IntoResponse, Response};
use sha2::{Digest, Sha256};

use super::error::ApiError;

/// Content-Security-Policy of the pages: they may load their own files, images that they created (`blob:`) and images in their style
/// sheets (`data:`). Inline code, other origins and framing are forbidden.
const POLICY: HeaderValue = HeaderValue::from_static(
    "default-src 'self'; img-src 'self' blob: data:; object-src 'none'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
);
const NO_REFERRER: HeaderValue = HeaderValue::from_static("no-referrer");

const HTML: &str = "text/html; charset=utf-8";
const CSS: &str = "text/css; charset=utf-8";
const SCRIPT: &str = "text/javascript; charset=utf-8";
const DATA: &str = "application/json";
const TEXT: &str = "text/plain; charset=utf-8";

struct File {
    name: &'static str,
    media_type: &'static str,
    content: &'static str,
}

macro_rules! files {
    ($($name:literal: $media_type:expr),+ $(,)?) => {
        [$(File { name: $name, media_type: $media_type, content: include_str!(concat!("portal/", $name)) }),+]
    };
}

static FILES: [File; 54] = files! {
    "index.html": HTML,
    "style.css": CSS,
    "icon.svg": "image/svg+xml",
    "example.json": DATA,
    "api.js": SCRIPT,
    "chart.js": SCRIPT,
    "compare.js": SCRIPT,
    "derived.js": SCRIPT,
    "designation.js": SCRIPT,
    "dom.js": SCRIPT,
    "download.js": SCRIPT,
    "example.js": SCRIPT,
    "fields.js": SCRIPT,
    "form.js": SCRIPT,
    "format.js": SCRIPT,
    "housing-drawing.js": SCRIPT,
    "jobs.js": SCRIPT,
    "kinds.js": SCRIPT,
    "machine.js": SCRIPT,
    "main.js": SCRIPT,
    "map.js": SCRIPT,
    "measured.js": SCRIPT,
    "measured-files.js": SCRIPT,
    "measured-partners.js": SCRIPT,
    "measured-spectrum.js": SCRIPT,
    "messages.js": SCRIPT,
    "metrics.js": SCRIPT,
    "pictures.js": SCRIPT,
    "plots.js": SCRIPT,
    "ramp.js": SCRIPT,
    "report.js": SCRIPT,
    "request.js": SCRIPT,
    "result.js": SCRIPT,
    "rotor.js": SCRIPT,
    "run-up.js": SCRIPT,
    "scene.js": SCRIPT,
    "shaft-drawing.js": SCRIPT,
    "shaft-form.js": SCRIPT,
    "shaft-lists.js": SCRIPT,
    "shaft-request.js": SCRIPT,
    "shaft.js": SCRIPT,
    "slider.js": SCRIPT,
    "spectra.js": SCRIPT,
    "study-metrics.js": SCRIPT,
    "study-table.js": SCRIPT,
    "study.js": SCRIPT,
    "surfaces.js": SCRIPT,
    "uncertainty.js": SCRIPT,
    "uncertainty-form.js": SCRIPT,
    "varied-axis.js": SCRIPT,
    "views.js": SCRIPT,
    "vendor/uPlot.esm.js": SCRIPT,
    "vendor/uPlot.min.css": CSS,
    "vendor/LICENSE": TEXT,
};

/// ETag of each file, quoted as it is sent. The files change only with the binary, but one address serves many versions over time. So a
/// browser asks each time, and mostly gets 304.
static TAGS: LazyLock<Vec<String>> = LazyLock::new(|| {
    FILES.iter().map(|file| hex(&Sha256::digest(file.content)[..16])).map(|digest| format!("\"{digest}\"")).collect()
});

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// `GET /`
pub async fn page(headers: HeaderMap) -> Result<Response, ApiError> {
    answer("index.html", &headers)
}

/// `GET /portal/{file}`
pub async fn file(uri: Uri, headers: HeaderMap) -> Result<Response, ApiError> {
    answer(uri.path().trim_start_matches("/portal/"), &headers)
}

fn answer(name: &str, headers: &HeaderMap) -> Result<Response, ApiError> {
    let place = FILES.iter().position(|file| file.name == name).ok_or(ApiError::UnknownPath)?;
    let (file, tag) = (&FILES[place], TAGS[place].as_str());
    let fields = [(CONTENT_TYPE, file.media_type), (CACHE_CONTROL, "no-cache"), (ETAG, tag)];
    if is_known(headers, tag) {
        return Ok((StatusCode::NOT_MODIFIED, fields).into_response());
    }
    Ok((fields, file.content).into_response())
}

/// Layer that adds the policies of the browser to a page and its files.
pub async fn policies(mut response: Response) -> Response {
    let headers = response.headers_mut();
    headers.insert(CONTENT_SECURITY_POLICY, POLICY);
    headers.insert(REFERRER_POLICY, NO_REFERRER);
    response
}

/// Returns whether the client has this content. The comparison is weak (RFC 9110, 13.1.2).
fn is_known(headers: &HeaderMap, tag: &str) -> bool {
    let lists = headers.get_all(IF_NONE_MATCH).iter().filter_map(|list| list.to_str().ok());
    lists.flat_map(|list| list.split(',')).map(str::trim).any(|one| one == "*" || one.trim_start_matches("W/") == tag)
}
