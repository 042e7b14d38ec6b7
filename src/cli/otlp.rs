//! Sends the spans of requests to a collector: OTLP over HTTP, protobuf, in batches, in the background.

use std::pin::Pin;
use std::sync::Arc;
use std::time::{Duration, SystemTime};

use bytes::Bytes;
use http::{Request, Response};
use opentelemetry::trace::{SpanContext, SpanId, SpanKind, Status, TraceFlags, TraceId, TraceState};
use opentelemetry::{InstrumentationScope, KeyValue};
use opentelemetry_http::hyper::HyperClient;
use opentelemetry_http::{HttpClient, HttpError};
use opentelemetry_otlp::{Protocol, SpanExporter, WithExportConfig, WithHttpConfig};
use opentelemetry_sdk::Resource;
use opentelemetry_sdk::trace::{BatchSpanProcessor, SpanData, SpanEvents, SpanLinks, SpanProcessor};
use tokio::runtime::Handle;

use super::StartFault;
use crate::http::observation::{Exporter, FinishedSpan};

/// Longest time for one batch, and for the remaining spans when the service stops.
const PATIENCE: Duration = Duration::from_secs(1);

/// Sends spans to the collector at `endpoint`. Call it within the runtime that it will use.
///
/// # Errors
/// The endpoint is not an `http` address.
pub(super) fn exporter(endpoint: &str) -> Result<Arc<dyn Exporter>, StartFault> {
    let unusable = |reason: String| StartFault::Collector { endpoint: endpoint.to_owned(), reason };
    if !endpoint.starts_with("http://") {
        return Err(unusable(
            "it does not begin with http://; run a collector beside the service, which can add TLS"
                .to_owned(),
        ));
    }
    let client = Background {
        client: HyperClient::with_default_connector(PATIENCE, None),
        runtime: Handle::current(),
    };
    let exporter = SpanExporter::builder()
        .with_http()
        .with_http_client(client)
        .with_protocol(Protocol::HttpBinary)
        .with_timeout(PATIENCE)
        .with_endpoint(format!("{}/v1/traces", endpoint.trim_end_matches('/')))
        .build()
        .map_err(|fault| unusable(fault.to_string()))?;
    let mut processor = BatchSpanProcessor::builder(exporter).build();
    let version = KeyValue::new("service.version", env!("CARGO_PKG_VERSION"));
    processor
        .set_resource(&Resource::builder().with_service_name("trunnion").with_attribute(version).build());
    Ok(Arc::new(Otlp { processor }))
}

#[derive(Debug)]
struct Otlp {
    processor: BatchSpanProcessor,
}

impl Exporter for Otlp {
    fn export(&self, span: &FinishedSpan<'_>) {
        self.processor.on_end(data(span));
    }

    fn close(&self) {
        if let Err(fault) = self.processor.shutdown_with_timeout(PATIENCE) {
            tracing::warn!(error = %fault, "the last spans were not sent");
        }
    }
}

fn data(span: &FinishedSpan<'_>) -> SpanData {
    let FinishedSpan { trace, operation, method, route, status, elapsed, .. } = *span;
    let end_time = SystemTime::from(span.ended_at);
    let mut attributes = vec![
        KeyValue::new("http.request.method", method),
        KeyValue::new("trunnion.request_id", span.request_id.to_owned()),
    ];
    let mut add = |name: &'static str, value: Option<&str>| {
        attributes.extend(value.map(|value| KeyValue::new(name, value.to_owned())));
    };
    add("http.route", route);
    add("trunnion.machine_id", span.machine_id);
    add("trunnion.job_id", span.job_id);
    attributes
        .extend(status.map(|status| KeyValue::new("http.response.status_code", i64::from(status.as_u16()))));
    let failed = status.is_none_or(|status| status.is_server_error());
    SpanData {
        span_context: SpanContext::new(
            TraceId::from(trace.trace_id),
            SpanId::from(trace.span_id),
            TraceFlags::SAMPLED,
            false,
            TraceState::NONE,
        ),
        parent_span_id: trace.parent_id.map_or(SpanId::INVALID, SpanId::from),
        parent_span_is_remote: trace.parent_id.is_some(),
        span_kind: SpanKind::Server,
        name: operation.to_owned().into(),
        start_time: end_time.checked_sub(elapsed).unwrap_or(end_time),
        end_time,
        attributes,
        dropped_attributes_count: 0,
        events: SpanEvents::default(),
        links: SpanLinks::default(),
        status: if failed { Status::error("") } else { Status::Unset },
        instrumentation_scope: InstrumentationScope::builder("trunnion").build(),
    }
}

/// A client that works on the service's runtime, whatever thread calls it.
#[derive(Debug)]
struct Background {
    client: HyperClient,
    runtime: Handle,
}

type Answer = Result<Response<Bytes>, HttpError>;

impl HttpClient for Background {
    fn send_bytes<'life, 'future>(
        &'life self,
        request: Request<Bytes>,
    ) -> Pin<Box<dyn Future<Output = Answer> + Send + 'future>>
    where
        'life: 'future,
        Self: 'future,
    {
        let client = self.client.clone();
        let sent = self.runtime.spawn(async move { client.send_bytes(request).await });
        Box::pin(async move {
            let answer = sent.await.map_err(HttpError::from).and_then(|answer| answer);
            match &answer {
                Ok(answer) if answer.status().is_success() => {}
                Ok(answer) => {
                    tracing::warn!(status = answer.status().as_u16(), "the collector refuses spans");
                }
                Err(fault) => tracing::warn!(error = %fault, "the collector cannot be reached"),
            }
            answer
        })
    }
}
