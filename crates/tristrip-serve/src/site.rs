//! The routes of a server: files, packed files, thumbnails, the list of models, health and metrics.
//!
//! | route | answer |
//! |---|---|
//! | `/` and the paths of the viewer's files | the viewer |
//! | `/models.json` | the list of models |
//! | `/files/PATH` | an unchanged file |
//! | `/packed/PATH.glb` | a file as progressive GLB, packed on request |
//! | `/thumbnails/PATH.png` | the thumbnail of a file |
//! | `/healthz`, `/metrics` | `ok`; metrics for Prometheus |

use std::io;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use axum::Router;
use axum::extract::State;
use axum::http::header::{CONTENT_ENCODING, CONTENT_LENGTH, CONTENT_TYPE, ETAG};
use axum::http::{Extensions, HeaderMap, HeaderValue, StatusCode, Uri, Version};
use axum::middleware::map_response;
use axum::response::Response;
use axum::routing::any;
use tokio::sync::{Semaphore, watch};
use tower_http::compression::{CompressionLayer, CompressionLevel};

use crate::assets::Assets;
use crate::bytes_source::BytesSource;
use crate::cache::Made;
use crate::catalogue::Scanner;
use crate::content::{Store, list, open_resource};
use crate::deadline::Deadline;
use crate::folder::Folder;
use crate::media::is_compressible;
use crate::metrics::ServerMetrics;
use crate::options::PackingOptions;
use crate::packing::Source;
use crate::paths::{BadPath, SitePath};
use crate::replies::{Resource, text};
use crate::thumbnails;
use crate::workshop::{JobKey, JobKind, Refusal, Workshop};

/// The time for which a list of models is reused without another scan.
const LIST_TIME: Duration = Duration::from_secs(2);
/// The maximum number of attempts to get a list.
const MAX_LISTINGS: usize = 3;
/// The maximum number of simultaneous searches for source files.
const MAX_FINDS: usize = 4;
/// Smaller files are not compressed.
const FEWEST_COMPRESSED_BYTES: u64 = 1024;

/// The state that all requests share.
#[derive(Debug)]
pub(crate) struct Site {
    store: Store,
    /// `None` for files in memory, which need no packing and no cache.
    workshop: Option<Arc<Workshop>>,
    packing: PackingOptions,
    metrics: Arc<ServerMetrics>,
    assets: Arc<Assets>,
    scanner: Scanner,
    list: Mutex<Option<Listing>>,
    finds: Arc<Semaphore>,
    /// The permits to draw thumbnails of files in memory.
    drawings: Arc<Semaphore>,
}

/// The list of models and the time of its scan; `None` while the scan runs.
type Listing = watch::Receiver<Option<(Instant, Resource)>>;

impl Site {
    pub(crate) fn new(
        store: Store,
        workshop: Option<Arc<Workshop>>,
        packing: PackingOptions,
        metrics: Arc<ServerMetrics>,
    ) -> Self {
        Self {
            drawings: Arc::new(Semaphore::new((packing.at_once / 2).clamp(1, Semaphore::MAX_PERMITS))),
            store,
            workshop,
            packing,
            metrics,
            assets: Arc::new(Assets::default()),
            scanner: Scanner::default(),
            list: Mutex::new(None),
            finds: Arc::new(Semaphore::new(MAX_FINDS)),
        }
    }

    /// Returns the cached list or the list in progress, or starts a new scan. The scan runs in its
    /// own task for all clients, so there are never two scans. If no client waits for it any more,
    /// the scan is cancelled and its list is never sent.
    fn listing(self: &Arc<Self>) -> Listing {
        let mut list = self.list.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = &*list {
            let is_usable = match &*known.borrow() {
                Some((since, _)) => since.elapsed() < LIST_TIME,
                // If the sender is gone, the scan has failed.
                None => known.has_changed().is_ok(),
            };
            if is_usable {
                return known.clone();
            }
        }
        let (sender, watch) = watch::channel(None);
        *list = Some(watch.clone());
        let site = Arc::clone(self);
        tokio::task::spawn_blocking(move || {
            // One receiver belongs to the site itself.
            let is_wanted = || sender.receiver_count() > 1;
            // The sender is dropped here. It has sent no list if the scan failed or was cancelled.
            if let Some(resource) = site.scan(&is_wanted) {
                sender.send_replace(Some((Instant::now(), resource)));
            }
        });
        watch
    }

    /// Lists the models. May block.
    fn scan(&self, is_wanted: &dyn Fn() -> bool) -> Option<Resource> {
        let catalogue = match &self.store {
            Store::Memory(store) => list(store),
            Store::Folder(folder) => self.scanner.scan(folder, self.packing.on_demand, is_wanted)?,
        };
        let json = serde_json::to_vec(&catalogue).ok()?;
        let tag = format!("{:x}-{:08x}", json.len(), crc32fast::hash(&json));
        let source = BytesSource::Memory(json.into());
        Some(Resource { source, media_type: "application/json", tag, modified: None })
    }
}

/// Builds the routes.
pub(crate) fn router(site: Arc<Site>) -> Router {
    let compression = CompressionLayer::new().quality(CompressionLevel::Fastest).compress_when(pays);
    Router::new()
        .route("/models.json", any(models))
        .route("/files/{*path}", any(files))
        .layer(compression)
        .layer(map_response(weaken))
        .route("/packed/{*path}", any(packed))
        .route("/thumbnails/{*path}", any(thumbnail))
        .route("/healthz", any(async || text(StatusCode::OK, "ok")))
        .route("/metrics", any(metrics))
        .fallback(asset)
        .with_state(site)
}

/// Returns the name of a route for the metrics.
pub(crate) fn route_name(path: &str) -> &'static str {
    match path.split('/').nth(1).unwrap_or_default() {
        "files" => "files",
        "packed" => "packed",
        "thumbnails" => "thumbnails",
        "models.json" => "models",
        "healthz" => "healthz",
        "metrics" => "metrics",
        name if name.is_empty() || crate::assets::has(path.trim_start_matches('/')) => "viewer",
        _ => "other",
    }
}

/// Checks whether a response is worth compressing: it is complete, not small, and of a compressible
/// type.
fn pays(status: StatusCode, _: Version, headers: &HeaderMap, _: &Extensions) -> bool {
    let length = headers.get(CONTENT_LENGTH).and_then(|value| value.to_str().ok()?.parse::<u64>().ok());
    let media_type = headers.get(CONTENT_TYPE).and_then(|value| value.to_str().ok());
    status == StatusCode::OK
        && length.is_some_and(|length| length >= FEWEST_COMPRESSED_BYTES)
        && media_type.is_some_and(is_compressible)
}

/// Makes the tag of a compressed response weak: the compressed bytes can differ between responses.
async fn weaken(mut response: Response) -> Response {
    if response.headers().contains_key(CONTENT_ENCODING)
        && let Some(tag) = response.headers().get(ETAG).and_then(|tag| tag.to_str().ok())
        && !tag.starts_with("W/")
        && let Ok(weak) = HeaderValue::from_str(&format!("W/{tag}"))
    {
        response.headers_mut().insert(ETAG, weak);
    }
    response
}

async fn asset(State(site): State<Arc<Site>>, uri: Uri, headers: HeaderMap) -> Response {
    let name = match uri.path() {
        "/" => "index.html",
        path => path.strip_prefix('/').unwrap_or(path),
    };
    site.assets.reply(name, &headers).await.unwrap_or_else(not_found)
}

async fn metrics(State(site): State<Arc<Site>>) -> Response {
    let mut response = text(StatusCode::OK, site.metrics.text().trim_end());
    let media_type = HeaderValue::from_static("application/openmetrics-text; version=1.0.0; charset=utf-8");
    response.headers_mut().insert(CONTENT_TYPE, media_type);
    response
}

async fn models(State(site): State<Arc<Site>>, headers: HeaderMap) -> Response {
    // A scan may have been cancelled just before this request.
    for _ in 0..MAX_LISTINGS {
        let mut listing = site.listing();
        if let Ok(Some((_, resource))) = listing.wait_for(Option::is_some).await.as_deref() {
            return resource.reply(&headers);
        }
    }
    failed()
}

async fn files(State(site): State<Arc<Site>>, uri: Uri, headers: HeaderMap) -> Response {
    let path = match site_path(&uri, "/files/") {
        Ok(path) => path,
        Err(response) => return *response,
    };
    match &site.store {
        Store::Memory(store) => {
            store.get(&path).map_or_else(not_found, |stored| stored.resource().reply(&headers))
        }
        Store::Folder(folder) => {
            let folder = Arc::clone(folder);
            match tokio::task::spawn_blocking(move || open_resource(&folder, &path)).await {
                Ok(Ok(resource)) => resource.reply(&headers),
                Ok(Err(error)) => not_opened(&error),
                Err(_) => failed(),
            }
        }
    }
}

async fn packed(State(site): State<Arc<Site>>, uri: Uri, headers: HeaderMap) -> Response {
    let path = match site_path(&uri, "/packed/") {
        Ok(path) => path,
        Err(response) => return *response,
    };
    let Some(path) = path.without_extension("glb").filter(|_| site.packing.on_demand) else {
        return not_found();
    };
    let options = site.packing.pack;
    let most_bytes = site.packing.largest_input_bytes;
    let work =
        move |source: &Source, folder: &Folder, deadline| source.pack(folder, most_bytes, &options, deadline);
    let key = format!("{options:?} {most_bytes}");
    made(&site, path, JobKind::Packing, &key, "model/gltf-binary", &headers, work).await
}

async fn thumbnail(State(site): State<Arc<Site>>, uri: Uri, headers: HeaderMap) -> Response {
    let path = match site_path(&uri, "/thumbnails/") {
        Ok(path) => path,
        Err(response) => return *response,
    };
    let Some(path) = path.without_extension("png") else { return not_found() };
    if let Store::Memory(store) = &site.store {
        let Some(stored) = store.get(&path) else { return not_found() };
        return match stored.thumbnail(&site.drawings).await {
            Ok(resource) => resource.reply(&headers),
            Err(message) => text(StatusCode::UNPROCESSABLE_ENTITY, &message),
        };
    }
    let most_bytes = site.packing.largest_input_bytes;
    let work = move |source: &Source, folder: &Folder, deadline| {
        thumbnails::of_source(source, folder, most_bytes, deadline)
    };
    let key = format!("{} {most_bytes}", thumbnails::OPTIONS);
    made(&site, path, JobKind::Thumbnail, &key, "image/png", &headers, work).await
}

/// Answers with the result of a job, new or from the cache.
async fn made(
    site: &Site,
    path: SitePath,
    kind: JobKind,
    options: &str,
    media_type: &'static str,
    headers: &HeaderMap,
    work: impl FnOnce(&Source, &Folder, Deadline) -> Result<Vec<u8>, String> + Send + 'static,
) -> Response {
    let (Store::Folder(folder), Some(workshop)) = (&site.store, &site.workshop) else { return not_found() };
    let found = {
        let Ok(permit) = Arc::clone(&site.finds).acquire_owned().await else { return failed() };
        let (folder, path) = (Arc::clone(folder), path.clone());
        tokio::task::spawn_blocking(move || {
            // Held until the search ends, even if the client leaves.
            let _permit = permit;
            Source::find(&folder, &path)
        })
        .await
    };
    let Ok(Some(source)) = found else { return not_found() };
    let key = source.key(options);
    let job = JobKey { kind, key: key.clone(), name: path.encoded().to_string() };
    let folder = Arc::clone(folder);
    let work = move |deadline| {
        let made = work(&source, &folder, deadline)?;
        // The bytes read may come from two versions of the file, but the key belongs to the first.
        if source.is_current(&folder) {
            Ok(made)
        } else {
            Err("the file changed while it was read; request it again".into())
        }
    };
    match workshop.get(job, work).await {
        Ok(Made { source, checksum }) => {
            let tag = format!("{}-{checksum:08x}", &key[..16]);
            Resource { source, media_type, tag, modified: None }.reply(headers)
        }
        Err(Refusal::Busy) => {
            text(StatusCode::SERVICE_UNAVAILABLE, "too many jobs are waiting; try again later")
        }
        Err(Refusal::NotYet) => {
            text(StatusCode::SERVICE_UNAVAILABLE, "not finished yet; the job continues, try again later")
        }
        Err(Refusal::Failed(message)) => text(StatusCode::UNPROCESSABLE_ENTITY, &message),
    }
}

/// Returns the path after the prefix of a route.
fn site_path(uri: &Uri, route: &str) -> Result<SitePath, Box<Response>> {
    let raw = uri.path().strip_prefix(route).unwrap_or_default();
    SitePath::decode(raw).map_err(|bad| {
        Box::new(match bad {
            BadPath::Malformed => {
                text(StatusCode::BAD_REQUEST, "found a malformed path, expected the path of a file")
            }
            BadPath::Hidden => not_found(),
        })
    })
}

fn not_found() -> Response {
    text(StatusCode::NOT_FOUND, "not found")
}

fn failed() -> Response {
    text(StatusCode::INTERNAL_SERVER_ERROR, "internal error")
}

/// Answers a request for a file that cannot be opened. The file is missing, outside the directory
/// or not a regular file, or the server has too many open files.
fn not_opened(error: &io::Error) -> Response {
    #[cfg(unix)]
    if let Some(code) = error.raw_os_error()
        && [rustix::io::Errno::MFILE, rustix::io::Errno::NFILE]
            .map(rustix::io::Errno::raw_os_error)
            .contains(&code)
    {
        return text(StatusCode::SERVICE_UNAVAILABLE, "too many open files");
    }
    tracing::debug!(%error, "could not open a file");
    not_found()
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc;

    use tokio::runtime::Builder;

    use super::*;
    use crate::content::Content;

    #[test]
    fn a_scan_that_nobody_waits_for_ends_and_the_next_client_gets_a_new_one() {
        let dir = tempfile::tempdir().unwrap();
        std::fs::write(dir.path().join("a.stl"), "").unwrap();
        let store = Store::open(Content::Folder(dir.path().to_path_buf())).unwrap();
        let packing = PackingOptions::default().with_on_demand(true);
        let site = Arc::new(Site::new(store, None, packing, Arc::new(ServerMetrics::new())));
        // One thread for all blocking work: nothing is scanned before the gate opens.
        let runtime = Builder::new_current_thread().max_blocking_threads(1).enable_time().build().unwrap();
        runtime.block_on(async {
            let (open, gate) = mpsc::channel::<()>();
            let gate = tokio::task::spawn_blocking(move || gate.recv());
            let left = site.listing();
            let stored = left.clone();
            drop(left);
            let shared = site.listing();
            drop((shared, stored));
            open.send(()).unwrap();
            gate.await.unwrap().unwrap();
            // The cancelled scan or a new one: a request never fails because of it.
            let response = models(State(Arc::clone(&site)), HeaderMap::new()).await;
            assert_eq!(response.status(), 200);
            let (open, gate) = mpsc::channel::<()>();
            let gate = tokio::task::spawn_blocking(move || gate.recv());
            *site.list.lock().unwrap() = None;
            drop(site.listing());
            open.send(()).unwrap();
            gate.await.unwrap().unwrap();
            // When the single thread has done this, it has ended the scan.
            tokio::task::spawn_blocking(|| ()).await.unwrap();
            let known = site.list.lock().unwrap().clone().unwrap();
            assert!(known.borrow().is_none() && known.has_changed().is_err());
            assert_eq!(models(State(Arc::clone(&site)), HeaderMap::new()).await.status(), 200);
        });
    }
}
