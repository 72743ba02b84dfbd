//! Answers of the server.

use super::door::Reason;
use super::writer::Unwritten;
use crate::store::Refusal;
use axum::body::Body;
use axum::http::header::CONTENT_TYPE;
use axum::http::{HeaderValue, StatusCode};
use axum::response::Response;
use serde_json::{Value, json};

/// The answer of the store.
pub(super) fn stored(answer: Result<Value, Unwritten>) -> Response {
    match answer {
        Ok(value) => response(StatusCode::OK, "application/json", Body::from(value.to_string())),
        Err(Unwritten::Refused(refusal)) => refused(&refusal),
        Err(Unwritten::Failed) => {
            sentence(StatusCode::INTERNAL_SERVER_ERROR, "store", "the server cannot store anything just now")
        }
    }
}

pub(super) fn refused(refusal: &Refusal) -> Response {
    let (status, reason) = match refusal {
        Refusal::Form(_) => (StatusCode::BAD_REQUEST, "form"),
        Refusal::Unknown => (StatusCode::FORBIDDEN, "unknown"),
        Refusal::Damaged => (StatusCode::UNPROCESSABLE_ENTITY, "damaged"),
        Refusal::OtherChunk => (StatusCode::CONFLICT, "other-chunk"),
        Refusal::Finished => (StatusCode::CONFLICT, "finished"),
        Refusal::TooMuch => (StatusCode::PAYLOAD_TOO_LARGE, "too-much"),
        Refusal::Full => (StatusCode::GONE, "full"),
        Refusal::Changed => (StatusCode::CONFLICT, "changed"),
        Refusal::BegunBefore => (StatusCode::CONFLICT, "begun-before"),
        Refusal::NotWhole => (StatusCode::CONFLICT, "not-whole"),
    };
    sentence(status, reason, &refusal.to_string())
}

pub(super) fn sentence(status: StatusCode, reason: &'static str, sentence: &str) -> Response {
    let body = json!({ "reason": reason, "error": sentence }).to_string();
    let mut response = response(status, "application/json", Body::from(body));
    response.extensions_mut().insert(Reason(reason));
    response
}

pub(super) fn response(status: StatusCode, mime: &'static str, body: Body) -> Response {
    let mut response = Response::new(body);
    *response.status_mut() = status;
    response.headers_mut().insert(CONTENT_TYPE, HeaderValue::from_static(mime));
    response
}
