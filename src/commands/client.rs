//! A client of the HTTP API.

use axum::body::Bytes;
use axum::http::header::{ACCEPT, CONTENT_TYPE};
use axum::http::{Method, Request, StatusCode};
use http_body_util::{BodyExt, Full};
use hyper_util::client::legacy::Client as HyperClient;
use hyper_util::client::legacy::connect::HttpConnector;
use hyper_util::rt::TokioExecutor;
use serde_json::Value;

/// A client of one service.
pub struct Client {
    url: String,
    http: HyperClient<HttpConnector, Full<Bytes>>,
}

/// Reason why a request failed.
#[derive(Debug, thiserror::Error)]
pub enum ClientError {
    #[error("{0}")]
    NoAnswer(String),
    #[error("{status}: {body}")]
    Refused { status: StatusCode, body: String },
}

impl Client {
    pub fn new(url: String) -> Self {
        Self { url, http: HyperClient::builder(TokioExecutor::new()).build_http() }
    }

    /// The JSON at a path.
    pub async fn get_json(&self, path: &str) -> Result<Value, ClientError> {
        json(&self.send(Method::GET, path, "application/json", None).await?)
    }

    /// The text at a path.
    pub async fn get_text(&self, path: &str) -> Result<String, ClientError> {
        let body = self.send(Method::GET, path, "*/*", None).await?;
        String::from_utf8(body.to_vec()).map_err(|error| ClientError::NoAnswer(error.to_string()))
    }

    /// The answer to a posted body.
    pub async fn post_json(&self, path: &str, body: &Value) -> Result<Value, ClientError> {
        json(&self.send(Method::POST, path, "application/json", Some(body)).await?)
    }

    async fn send(&self, method: Method, path: &str, accept: &str, body: Option<&Value>) -> Result<Bytes, ClientError> {
        let no_answer = |error: &dyn std::error::Error| ClientError::NoAnswer(with_sources(error));
        let bytes = body.map_or_else(Bytes::new, |body| Bytes::from(body.to_string()));
        let request = Request::builder()
            .method(method)
            .uri(format!("{}{path}", self.url))
            .header(ACCEPT, accept)
            .header(CONTENT_TYPE, "application/json")
            .body(Full::new(bytes))
            .map_err(|error| no_answer(&error))?;
        let answer = self.http.request(request).await.map_err(|error| no_answer(&error))?;
        let status = answer.status();
        let body = answer.into_body().collect().await.map_err(|error| no_answer(&error))?.to_bytes();
        if status.is_success() {
            return Ok(body);
        }
        Err(ClientError::Refused { status, body: String::from_utf8_lossy(&body).into_owned() })
    }
}

fn json(body: &[u8]) -> Result<Value, ClientError> {
    serde_json::from_slice(body).map_err(|error| ClientError::NoAnswer(error.to_string()))
}

fn with_sources(error: &dyn std::error::Error) -> String {
    match error.source() {
        Some(source) => format!("{error}: {}", with_sources(source)),
        None => error.to_string(),
    }
}
