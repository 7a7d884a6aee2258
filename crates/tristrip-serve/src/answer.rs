//! The processing that is common to all routes: checks of the host name and the method, CORS,
//! common response headers, and the log.
//!
//! ```text
//! request ─▶ host? ─▶ method? ─▶ HEAD becomes GET ─▶ CORS ─▶ routes ─▶ headers ─▶ body: paced, counted, logged; none for HEAD
//! ```

use std::convert::Infallible;
use std::net::IpAddr;
use std::sync::Arc;

use axum::Router;
use axum::body::Body;
use axum::http::header::{
    ACCEPT_RANGES, ALLOW, CONTENT_LENGTH, CONTENT_RANGE, CONTENT_TYPE, ETAG, IF_NONE_MATCH, IF_RANGE, RANGE,
    TRANSFER_ENCODING,
};
use axum::http::{HeaderMap, HeaderName, HeaderValue, Method, Request, StatusCode, Version};
use axum::response::Response;
use hyper::body::Incoming;
use percent_encoding::{CONTROLS, utf8_percent_encode};
use tokio::time::Instant;
use tower::ServiceExt;
use tower_http::cors::{AllowOrigin, Any, CorsLayer};

use crate::activity::Activity;
use crate::clients::Clients;
use crate::error::Error;
use crate::hosts::Hosts;
use crate::metrics::ServerMetrics;
use crate::options::{Limits, ServerOptions};
use crate::replies::text;
use crate::response_body::{Pace, Record, ResponseBody};
use crate::site::route_name;

/// The content security policy of the viewer page: it may load files of this server and data that
/// it creates itself.
const PAGE_POLICY: &str = "default-src 'self'; img-src 'self' blob: data:; worker-src 'self' blob:; style-src 'self' 'unsafe-inline'; connect-src 'self' blob:; frame-ancestors 'none'; base-uri 'none'; form-action 'none'";
/// The content security policy of files: a browser does not run models as pages.
const FILE_POLICY: &str = "default-src 'none'; sandbox";

/// Answers the requests of all connections.
#[derive(Debug, Clone)]
pub(crate) struct Answerer {
    routes: Router,
    hosts: Arc<Hosts>,
    has_cors: bool,
    bandwidth: Option<u64>,
    limits: Arc<Limits>,
    /// The unfinished responses of each client.
    responses: Arc<Clients>,
    metrics: Arc<ServerMetrics>,
}

impl Answerer {
    pub(crate) fn new(
        routes: Router,
        options: &ServerOptions,
        metrics: Arc<ServerMetrics>,
    ) -> Result<Self, Error> {
        let has_cors = !options.cors.is_empty();
        let routes = if has_cors { routes.layer(cors(&options.cors)?) } else { routes };
        let hosts = Arc::new(Hosts::new(options.address, &options.hosts)?);
        Ok(Self {
            routes,
            hosts,
            has_cors,
            bandwidth: options.bandwidth,
            limits: Arc::new(options.limits.clone()),
            responses: Arc::default(),
            metrics,
        })
    }

    /// Answers a request.
    pub(crate) async fn answer(
        self,
        request: Request<Incoming>,
        client: IpAddr,
        activity: Arc<Activity>,
    ) -> Result<Response<ResponseBody>, Infallible> {
        let _running = Running::new(Arc::clone(&activity), request.version() == Version::HTTP_2);
        let (method, path) = (request.method().clone(), request.uri().path().to_owned());
        let (route, started) = (route_name(&path), Instant::now());
        let place = self.responses.enter(client, &self.limits);
        let mut response = match place {
            Ok(_) => self.route(request).await,
            Err(_) => text(StatusCode::SERVICE_UNAVAILABLE, "too many requests at once; try again later"),
        };
        set_headers(route, response.headers_mut());
        // Names can contain characters that control a terminal or reverse its text direction.
        let path = utf8_percent_encode(&path, CONTROLS).to_string();
        let record =
            Record { method: method.clone(), path, route, status: response.status(), client, started };
        let pace = self.bandwidth.map(Pace::new);
        Ok(response.map(|body| {
            // A response to HEAD has the headers of a response to GET.
            let body = if method == Method::HEAD { Body::empty() } else { body };
            ResponseBody::new(body, pace, record, self.metrics, activity, place.ok())
        }))
    }

    async fn route(&self, request: Request<Incoming>) -> Response {
        if !self.hosts.allow(request.uri(), request.headers()) {
            return text(StatusCode::FORBIDDEN, "unknown host name; allow it with --host");
        }
        let method = request.method().clone();
        let is_known =
            [Method::GET, Method::HEAD].contains(&method) || self.has_cors && method == Method::OPTIONS;
        if !is_known {
            let mut response =
                text(StatusCode::METHOD_NOT_ALLOWED, &format!("found method {method}, expected GET or HEAD"));
            response.headers_mut().insert(ALLOW, HeaderValue::from_static("GET, HEAD"));
            return response;
        }
        // Two different lengths can hide one request inside another behind a proxy (request
        // smuggling). GET has no body that would need chunks.
        if request.headers().contains_key(TRANSFER_ENCODING) {
            return text(StatusCode::BAD_REQUEST, "found a request with Transfer-Encoding, expected no body");
        }
        // Request bodies are not read.
        let (mut parts, _) = request.into_parts();
        if method == Method::HEAD {
            parts.method = Method::GET;
            // Ranges are defined for GET only.
            parts.headers.remove(RANGE);
        }
        match self.routes.clone().oneshot(Request::from_parts(parts, Body::empty())).await {
            Ok(response) => response,
            Err(never) => match never {},
        }
    }
}

/// A request without a response. Dropping it ends the request, even if the client leaves early.
struct Running(Arc<Activity>);

impl Running {
    fn new(activity: Arc<Activity>, is_http2: bool) -> Self {
        activity.request_begins(is_http2);
        Self(activity)
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        self.0.request_ends();
    }
}

fn cors(origins: &[String]) -> Result<CorsLayer, Error> {
    let layer = CorsLayer::new()
        .allow_methods([Method::GET, Method::HEAD])
        .allow_headers([RANGE, IF_RANGE, IF_NONE_MATCH])
        .expose_headers([ETAG, CONTENT_RANGE, ACCEPT_RANGES, CONTENT_LENGTH]);
    if origins.iter().any(|origin| origin == "*") {
        return Ok(layer.allow_origin(Any));
    }
    let mut allowed = Vec::with_capacity(origins.len());
    for origin in origins {
        let uri = origin.parse::<axum::http::Uri>().ok();
        let is_origin = uri.is_some_and(|uri| {
            uri.scheme().is_some() && uri.authority().is_some() && uri.path() == "/" && uri.query().is_none()
        });
        let value = HeaderValue::from_str(origin).ok().filter(|_| is_origin && !origin.ends_with('/'));
        let expected = "an origin such as https://example.org, or *";
        allowed.push(value.ok_or_else(|| Error::Parameter {
            name: "cors",
            found: origin.clone(),
            expected,
        })?);
    }
    Ok(layer.allow_origin(AllowOrigin::list(allowed)))
}

fn set_headers(route: &str, headers: &mut HeaderMap) {
    headers.insert(HeaderName::from_static("x-content-type-options"), HeaderValue::from_static("nosniff"));
    headers.insert(HeaderName::from_static("referrer-policy"), HeaderValue::from_static("no-referrer"));
    if headers.contains_key(CONTENT_TYPE) {
        let policy = if route == "viewer" { PAGE_POLICY } else { FILE_POLICY };
        headers.insert(HeaderName::from_static("content-security-policy"), HeaderValue::from_static(policy));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn origins_are_checked() {
        let of = |origin: &str| cors(&[origin.to_owned()]);
        for origin in ["*", "https://example.org", "http://localhost:3000"] {
            assert!(of(origin).is_ok(), "{origin}");
        }
        for origin in ["", "example.org", "https://example.org/", "https://example.org/a", "https://", "a b"]
        {
            assert!(of(origin).is_err(), "{origin}");
        }
    }
}
