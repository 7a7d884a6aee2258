//! The answers of a server: files, packed files, pictures, the list of models, health and figures, by their routes.
//!
//! | route | answer |
//! |---|---|
//! | `/` and the paths of the viewer's files | the viewer |
//! | `/models.json` | the list of models |
//! | `/files/PATH` | a file as it is |
//! | `/packed/PATH.glb` | a file as progressive GLB, packed now or before |
//! | `/thumbnails/PATH.png` | a picture of a file |
//! | `/healthz`, `/metrics` | `ok`; figures for Prometheus |

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

/// How long a list of models is answered without another scan.
const LIST_TIME: Duration = Duration::from_secs(2);
/// How often a list is asked for that does not come.
const MAX_LISTINGS: usize = 3;
/// The folders whose files are looked at for packings at once.
const MAX_FINDS: usize = 4;
/// Smaller files are not compressed.
const FEWEST_COMPRESSED_BYTES: u64 = 1024;

/// What all requests share.
#[derive(Debug)]
pub(crate) struct Site {
    store: Store,
    /// `None` where nothing is packed and no picture is kept: files in memory.
    workshop: Option<Arc<Workshop>>,
    packing: PackingOptions,
    metrics: Arc<ServerMetrics>,
    assets: Arc<Assets>,
    scanner: Scanner,
    list: Mutex<Option<Listing>>,
    finds: Arc<Semaphore>,
    /// The pictures of files in memory that are drawn now.
    drawings: Arc<Semaphore>,
}

/// The list of models, and when it was made; `None` as long as it is.
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

    /// Returns the list that was made lately, the one that is being made, or a new one. It is made in a task of its own for all clients, so that there are never two scans. Once the
    /// last client has left, the scan ends early, and its list never comes.
    fn listing(self: &Arc<Self>) -> Listing {
        let mut list = self.list.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = &*list {
            let is_usable = match &*known.borrow() {
                Some((since, _)) => since.elapsed() < LIST_TIME,
                // Without its sender, the scan has failed.
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
            // The site itself keeps one receiver.
            let is_wanted = || sender.receiver_count() > 1;
            // The sender ends here; without a list if the scan has failed or was not wanted.
            if let Some(resource) = site.scan(&is_wanted) {
                sender.send_replace(Some((Instant::now(), resource)));
            }
        });
        watch
    }

    /// Lists the models. It may block.
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

/// Returns the name of a route for the figures.
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

/// Checks whether a response is worth compressing: whole, of a type that shrinks, and not small.
fn pays(status: StatusCode, _: Version, headers: &HeaderMap, _: &Extensions) -> bool {
    let length = headers.get(CONTENT_LENGTH).and_then(|value| value.to_str().ok()?.parse::<u64>().ok());
    let media_type = headers.get(CONTENT_TYPE).and_then(|value| value.to_str().ok());
    status == StatusCode::OK
        && length.is_some_and(|length| length >= FEWEST_COMPRESSED_BYTES)
        && media_type.is_some_and(is_compressible)
}

/// Makes the tag of a response weak that is compressed on its way: its bytes may differ from one time to the next.
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
    // A scan may have been given up just before this client came.
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

/// Answers with what is made of a file, now or before.
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
            // Held to the end, also if the client leaves.
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
        // What was read may be parts of two versions, and the key is that of the first.
        if source.is_current(&folder) {
            Ok(made)
        } else {
            Err("the file changed while it was read: ask again".into())
        }
    };
    match workshop.get(job, work).await {
        Ok(Made { source, checksum }) => {
            let tag = format!("{}-{checksum:08x}", &key[..16]);
            Resource { source, media_type, tag, modified: None }.reply(headers)
        }
        Err(Refusal::Busy) => text(StatusCode::SERVICE_UNAVAILABLE, "too many files are being packed"),
        Err(Refusal::NotYet) => {
            text(StatusCode::SERVICE_UNAVAILABLE, "not finished yet: the work goes on, ask again")
        }
        Err(Refusal::Failed(message)) => text(StatusCode::UNPROCESSABLE_ENTITY, &message),
    }
}

/// Returns the path behind a route.
fn site_path(uri: &Uri, route: &str) -> Result<SitePath, Box<Response>> {
    let raw = uri.path().strip_prefix(route).unwrap_or_default();
    SitePath::decode(raw).map_err(|bad| {
        Box::new(match bad {
            BadPath::Malformed => text(StatusCode::BAD_REQUEST, "not a path of a file"),
            BadPath::Hidden => not_found(),
        })
    })
}

fn not_found() -> Response {
    text(StatusCode::NOT_FOUND, "not found")
}

fn failed() -> Response {
    text(StatusCode::INTERNAL_SERVER_ERROR, "an error in the program ended the request")
}

/// Answers for a file that is not opened: it is missing, leads out of the folder, or is none; or the server has too many open files.
fn not_opened(error: &io::Error) -> Response {
    #[cfg(unix)]
    if let Some(code) = error.raw_os_error()
        && [rustix::io::Errno::MFILE, rustix::io::Errno::NFILE]
            .map(rustix::io::Errno::raw_os_error)
            .contains(&code)
    {
        return text(StatusCode::SERVICE_UNAVAILABLE, "too many open files");
    }
    tracing::debug!(%error, "not opened");
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
        // One thread for all that blocks: nothing is scanned before the gate opens.
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
            // The scan that was given up, or a new one: a client never fails by it.
            let response = models(State(Arc::clone(&site)), HeaderMap::new()).await;
            assert_eq!(response.status(), 200);
            let (open, gate) = mpsc::channel::<()>();
            let gate = tokio::task::spawn_blocking(move || gate.recv());
            *site.list.lock().unwrap() = None;
            drop(site.listing());
            open.send(()).unwrap();
            gate.await.unwrap().unwrap();
            // The one thread has ended the scan when it has done this.
            tokio::task::spawn_blocking(|| ()).await.unwrap();
            let known = site.list.lock().unwrap().clone().unwrap();
            assert!(known.borrow().is_none() && known.has_changed().is_err());
            assert_eq!(models(State(Arc::clone(&site)), HeaderMap::new()).await.status(), 200);
        });
    }
}
