//! Long-running jobs: packing and thumbnails. Each job runs once, however many clients request it.
//! The number of running jobs is limited, and results are cached.
//!
//! ```text
//! request ─▶ cache? ─ yes ─▶ result
//!              └ no ─▶ already running? ─ yes ─▶ wait for it
//!                           └ no ─▶ failed recently? queue full? ─ no ─▶ new task: permit ─▶ work ─▶ cache ─▶ all waiting clients
//! ```
//! A job continues when its clients leave; its result is available to later requests. A job holds a
//! permit only while it works, not while a client reads the result.
//!
//! Thumbnails have separate permits and threads, so a gallery does not wait for long packing jobs.
//!
//! There are two time limits. A request that has waited too long for a job gets 503 with
//! `Retry-After`. A job that takes much longer is cancelled at its next check of the [`Deadline`]:
//! between stages, and between the meshes of a scene. The simplification of a single mesh is not
//! interrupted.

use std::collections::HashMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use rayon::{ThreadPool, ThreadPoolBuilder};
use tokio::sync::{Semaphore, watch};
use tokio::time::timeout;

use crate::cache::{Cache, Made};
use crate::deadline::Deadline;
use crate::error::Error;
use crate::metrics::ServerMetrics;
use crate::options::PackingOptions;

/// The stack size of each packing thread, the same as for the threads of the command.
const STACK_BYTES: usize = 8 << 20;
/// The maximum number of simultaneous cache lookups.
const MAX_LOOKUPS: usize = 8;
/// The maximum number of remembered failures.
const MAX_FAILURES: usize = 1024;

/// The kind of a job.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum JobKind {
    Packing,
    Thumbnail,
}

impl JobKind {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Packing => "packing",
            Self::Thumbnail => "thumbnail",
        }
    }
}

/// The reason why a request gets no result.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Refusal {
    /// Too many jobs are waiting. A later request may succeed.
    Busy,
    /// The job takes longer than a request waits. The job continues.
    NotYet,
    /// The job failed, with this message.
    Failed(Arc<str>),
}

type Outcome = Result<Made, Refusal>;
type Watch = watch::Receiver<Option<Outcome>>;

/// The identity of a job: its kind, the key of its result, and its name.
#[derive(Debug, Clone)]
pub(crate) struct JobKey {
    pub(crate) kind: JobKind,
    pub(crate) key: String,
    /// The name for the log.
    pub(crate) name: String,
}

/// Runs jobs and caches their results.
#[derive(Debug)]
pub(crate) struct Workshop {
    cache: Cache,
    packings: Lane,
    thumbnails: Lane,
    most_waiting: usize,
    wait_time: Duration,
    job_time: Duration,
    failure_time: Duration,
    /// The permits for cache lookups. The first lookup of a large file reads all of it.
    lookups: Arc<Semaphore>,
    running: Mutex<HashMap<String, Watch>>,
    failures: Mutex<HashMap<String, (Instant, Arc<str>)>>,
    metrics: Arc<ServerMetrics>,
}

/// The threads and permits of one kind of job.
#[derive(Debug)]
struct Lane {
    pool: ThreadPool,
    permits: Semaphore,
    at_once: usize,
    /// The number of waiting and running jobs.
    unfinished: AtomicUsize,
}

impl Lane {
    /// Creates a lane for `at_once` simultaneous jobs that share `threads` threads; 0 threads mean
    /// one per core.
    fn new(at_once: usize, threads: usize) -> Result<Self, Error> {
        let at_once = at_once.clamp(1, Semaphore::MAX_PERMITS);
        let builder = ThreadPoolBuilder::new().stack_size(STACK_BYTES).num_threads(threads);
        let pool = builder.build().map_err(|error| Error::System(std::io::Error::other(error)))?;
        Ok(Self { pool, permits: Semaphore::new(at_once), at_once, unfinished: AtomicUsize::new(0) })
    }
}

impl Workshop {
    pub(crate) fn new(
        options: &PackingOptions,
        cache: Cache,
        metrics: Arc<ServerMetrics>,
    ) -> Result<Self, Error> {
        let drawn_at_once = (options.at_once / 2).max(1);
        let drawing_threads =
            options.threads.map_or(drawn_at_once, |threads| threads.clamp(1, drawn_at_once));
        metrics.cache_bytes.set(cache.used_bytes());
        Ok(Self {
            cache,
            packings: Lane::new(options.at_once, options.threads.unwrap_or(0))?,
            thumbnails: Lane::new(drawn_at_once, drawing_threads)?,
            most_waiting: options.waiting,
            wait_time: options.wait_time,
            job_time: options.job_time,
            failure_time: options.failure_time,
            lookups: Arc::new(Semaphore::new(MAX_LOOKUPS)),
            running: Mutex::default(),
            failures: Mutex::default(),
            metrics,
        })
    }

    fn lane(&self, kind: JobKind) -> &Lane {
        match kind {
            JobKind::Packing => &self.packings,
            JobKind::Thumbnail => &self.thumbnails,
        }
    }

    /// Returns the result of a job: from the cache, from a running job, or from `work`.
    pub(crate) async fn get(
        self: &Arc<Self>,
        job: JobKey,
        work: impl FnOnce(Deadline) -> Result<Vec<u8>, String> + Send + 'static,
    ) -> Outcome {
        if let Some(made) = self.cached(&job.key).await {
            self.metrics.cache_hits.inc();
            return Ok(made);
        }
        let mut watch = self.watch(job, work)?;
        match timeout(self.wait_time, watch.wait_for(Option::is_some)).await {
            Ok(Ok(outcome)) => outcome.clone().unwrap_or(Err(Refusal::NotYet)),
            Ok(Err(_)) => Err(Refusal::Failed("the job was cancelled".into())),
            Err(_) => Err(Refusal::NotYet),
        }
    }

    async fn cached(self: &Arc<Self>, key: &str) -> Option<Made> {
        let permit = Arc::clone(&self.lookups).acquire_owned().await.ok()?;
        let (this, key) = (Arc::clone(self), key.to_owned());
        let lookup = tokio::task::spawn_blocking(move || {
            // Held until the lookup ends, even if the client leaves.
            let _permit = permit;
            this.cache.get(&key)
        });
        lookup.await.ok().flatten()
    }

    /// Joins a running job or starts a new one.
    fn watch(
        self: &Arc<Self>,
        job: JobKey,
        work: impl FnOnce(Deadline) -> Result<Vec<u8>, String> + Send + 'static,
    ) -> Result<Watch, Refusal> {
        let mut running = lock(&self.running);
        if let Some(watch) = running.get(&job.key) {
            self.metrics.shared.inc();
            return Ok(watch.clone());
        }
        if let Some((since, message)) = lock(&self.failures).get(&job.key)
            && since.elapsed() < self.failure_time
        {
            return Err(Refusal::Failed(Arc::clone(message)));
        }
        let lane = self.lane(job.kind);
        if lane.unfinished.load(Ordering::Relaxed) >= lane.at_once + self.most_waiting {
            self.metrics.count_job(job.kind.name(), "refused");
            return Err(Refusal::Busy);
        }
        lane.unfinished.fetch_add(1, Ordering::Relaxed);
        let (sender, watch) = watch::channel(None);
        running.insert(job.key.clone(), watch.clone());
        drop(running);
        let this = Arc::clone(self);
        tokio::spawn(async move {
            let outcome = this.run(&job, work).await;
            if let Err(Refusal::Failed(message)) = &outcome {
                this.remember(&job.key, message);
            }
            lock(&this.running).remove(&job.key);
            this.lane(job.kind).unfinished.fetch_sub(1, Ordering::Relaxed);
            // There may be no waiting client any more.
            sender.send_replace(Some(outcome));
        });
        Ok(watch)
    }

    async fn run(
        self: &Arc<Self>,
        job: &JobKey,
        work: impl FnOnce(Deadline) -> Result<Vec<u8>, String> + Send + 'static,
    ) -> Outcome {
        // A job with the same key may have ended since the first cache lookup.
        if let Some(made) = self.cached(&job.key).await {
            self.metrics.cache_hits.inc();
            return Ok(made);
        }
        self.metrics.cache_misses.inc();
        self.metrics.waiting.inc();
        let permit = self.lane(job.kind).permits.acquire().await;
        self.metrics.waiting.dec();
        let Ok(_permit) = permit else { return Err(Refusal::Busy) };
        self.metrics.running.inc();
        let started = Instant::now();
        let (this, key, kind) = (Arc::clone(self), job.key.clone(), job.kind);
        let done = tokio::task::spawn_blocking(move || {
            let deadline = Deadline::after(this.job_time);
            let late = |message| {
                if deadline.is_over() {
                    format!("the job takes longer than {:?}", this.job_time)
                } else {
                    message
                }
            };
            let bytes = this.lane(kind).pool.install(|| work(deadline)).map_err(late)?;
            let made = this.cache.put(&key, bytes);
            this.metrics.cache_bytes.set(this.cache.used_bytes());
            Ok::<_, String>(made)
        });
        let outcome = done.await.unwrap_or_else(|_| Err("internal error".into()));
        self.metrics.running.dec();
        let milliseconds = started.elapsed().as_millis() as u64;
        let (kind, name) = (kind.name(), &job.name);
        match outcome {
            Ok(made) => {
                self.metrics.count_job(kind, "done");
                tracing::info!(kind, name, bytes = made.source.len(), milliseconds, "job done");
                Ok(made)
            }
            Err(message) => {
                self.metrics.count_job(kind, "failed");
                // Quoted: the message may contain text from the file.
                tracing::warn!(kind, name, error = ?message, milliseconds, "job failed");
                Err(Refusal::Failed(message.into()))
            }
        }
    }

    /// Remembers a failure for a while. If there are too many, the expired ones are forgotten.
    fn remember(&self, key: &str, message: &Arc<str>) {
        let mut failures = lock(&self.failures);
        if failures.len() >= MAX_FAILURES {
            failures.retain(|_, (since, _)| since.elapsed() < self.failure_time);
        }
        if failures.len() < MAX_FAILURES {
            failures.insert(key.to_owned(), (Instant::now(), Arc::clone(message)));
        }
    }
}

/// Locks a map. A poisoned lock is safe to use: no panic can leave a map half changed.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc;

    use super::*;

    fn workshop(options: &PackingOptions, dir: &std::path::Path) -> Arc<Workshop> {
        let cache = Cache::open(dir, 1 << 30).unwrap();
        Arc::new(Workshop::new(options, cache, Arc::new(ServerMetrics::new())).unwrap())
    }

    fn job(key: &str) -> JobKey {
        JobKey { kind: JobKind::Packing, key: key.into(), name: key.into() }
    }

    #[tokio::test(flavor = "multi_thread", worker_threads = 2)]
    async fn a_job_is_done_once_for_all_who_ask() {
        let dir = tempfile::tempdir().unwrap();
        let workshop = workshop(&PackingOptions::default(), dir.path());
        let runs = Arc::new(AtomicUsize::new(0));
        let asked = (0..50).map(|_| {
            let (workshop, runs) = (Arc::clone(&workshop), Arc::clone(&runs));
            tokio::spawn(async move {
                let work = move |_| {
                    runs.fetch_add(1, Ordering::SeqCst);
                    std::thread::sleep(Duration::from_millis(50));
                    Ok(b"result".to_vec())
                };
                workshop.get(job("a"), work).await.map(|made| made.source.read().unwrap())
            })
        });
        for answer in asked.collect::<Vec<_>>() {
            assert_eq!(answer.await.unwrap(), Ok(b"result".to_vec()));
        }
        assert_eq!(runs.load(Ordering::SeqCst), 1);
        assert_eq!(workshop.packings.unfinished.load(Ordering::SeqCst), 0);
    }

    #[tokio::test(flavor = "multi_thread", worker_threads = 2)]
    async fn failures_and_panics_are_remembered_for_a_while() {
        let dir = tempfile::tempdir().unwrap();
        let options =
            PackingOptions { failure_time: Duration::from_millis(100), ..PackingOptions::default() };
        let workshop = workshop(&options, dir.path());
        let failed = |message: &str| Some(Refusal::Failed(message.into()));
        assert_eq!(workshop.get(job("a"), |_| Err("first".into())).await.err(), failed("first"));
        assert_eq!(workshop.get(job("a"), |_| Err("second".into())).await.err(), failed("first"));
        tokio::time::sleep(Duration::from_millis(120)).await;
        assert!(workshop.get(job("a"), |_| Ok(vec![1])).await.is_ok());
        let panicked = workshop.get(job("b"), |_| panic!("as a test")).await;
        assert_eq!(panicked.err(), failed("internal error"));
    }

    #[tokio::test(flavor = "multi_thread", worker_threads = 2)]
    async fn few_jobs_run_and_wait() {
        let dir = tempfile::tempdir().unwrap();
        let options = PackingOptions::default().with_at_once(1).with_waiting(1);
        let workshop = workshop(&options, dir.path());
        let (go, gate) = mpsc::channel::<()>();
        let first = tokio::spawn({
            let workshop = Arc::clone(&workshop);
            async move {
                workshop
                    .get(job("a"), move |_| gate.recv().map(|()| vec![1]).map_err(|_| "gate".into()))
                    .await
            }
        });
        while workshop.metrics.running.get() == 0 {
            tokio::time::sleep(Duration::from_millis(1)).await;
        }
        let second = tokio::spawn({
            let workshop = Arc::clone(&workshop);
            async move { workshop.get(job("b"), |_| Ok(vec![2])).await }
        });
        while workshop.metrics.waiting.get() == 0 {
            tokio::time::sleep(Duration::from_millis(1)).await;
        }
        assert_eq!(workshop.get(job("c"), |_| Ok(vec![3])).await.err(), Some(Refusal::Busy));
        // A client that leaves does not stop the job.
        second.abort();
        go.send(()).unwrap();
        assert!(first.await.unwrap().is_ok());
        while workshop.packings.unfinished.load(Ordering::SeqCst) > 0 {
            tokio::time::sleep(Duration::from_millis(1)).await;
        }
        assert!(workshop.cache.get("b").is_some());
    }

    #[tokio::test(flavor = "multi_thread", worker_threads = 2)]
    async fn thumbnails_do_not_wait_for_packings() {
        let dir = tempfile::tempdir().unwrap();
        let options = PackingOptions::default().with_at_once(2).with_waiting(0).with_threads(Some(1));
        let workshop = workshop(&options, dir.path());
        let (go, gate) = mpsc::channel::<()>();
        let gate = Arc::new(Mutex::new(gate));
        let packing = |key: &'static str| {
            let (workshop, gate) = (Arc::clone(&workshop), Arc::clone(&gate));
            let work = move |_| gate.lock().unwrap().recv().map(|()| vec![1]).map_err(|_| "gate".into());
            tokio::spawn(async move { workshop.get(job(key), work).await })
        };
        let packings = [packing("a"), packing("b")];
        while workshop.metrics.running.get() < 2 {
            tokio::time::sleep(Duration::from_millis(1)).await;
        }
        assert_eq!(workshop.get(job("c"), |_| Ok(vec![3])).await.err(), Some(Refusal::Busy));
        let thumbnail = JobKey { kind: JobKind::Thumbnail, ..job("d") };
        let drawn = timeout(Duration::from_secs(20), workshop.get(thumbnail, |_| Ok(vec![4]))).await;
        assert_eq!(drawn.unwrap().unwrap().source.read().unwrap(), [4]);
        go.send(()).unwrap();
        go.send(()).unwrap();
        for packing in packings {
            assert!(packing.await.unwrap().is_ok());
        }
    }

    #[tokio::test(flavor = "multi_thread", worker_threads = 2)]
    async fn a_request_does_not_wait_for_a_long_job_and_the_job_goes_on() {
        let dir = tempfile::tempdir().unwrap();
        let options = PackingOptions::default().with_wait_time(Duration::from_millis(50));
        let workshop = workshop(&options, dir.path());
        let (go, gate) = mpsc::channel::<()>();
        let work = move |_| gate.recv().map(|()| vec![1]).map_err(|_| "gate".into());
        assert_eq!(workshop.get(job("a"), work).await.err(), Some(Refusal::NotYet));
        assert_eq!(workshop.get(job("a"), |_| Ok(vec![2])).await.err(), Some(Refusal::NotYet));
        go.send(()).unwrap();
        while workshop.packings.unfinished.load(Ordering::SeqCst) > 0 {
            tokio::time::sleep(Duration::from_millis(1)).await;
        }
        let made = workshop.get(job("a"), |_| Ok(vec![3])).await.unwrap();
        assert_eq!(made.source.read().unwrap(), [1]);
    }

    #[tokio::test(flavor = "multi_thread", worker_threads = 2)]
    async fn a_job_is_given_up_at_its_deadline() {
        let dir = tempfile::tempdir().unwrap();
        let options = PackingOptions::default().with_job_time(Duration::from_millis(50));
        let workshop = workshop(&options, dir.path());
        let endless = |deadline: Deadline| loop {
            deadline.check()?;
            std::thread::sleep(Duration::from_millis(1));
        };
        let given_up = workshop.get(job("a"), endless).await.err();
        assert_eq!(given_up, Some(Refusal::Failed("the job takes longer than 50ms".into())));
        // A finished result is kept, even if it is late.
        let late = |_| {
            std::thread::sleep(Duration::from_millis(60));
            Ok(vec![1])
        };
        assert!(workshop.get(job("b"), late).await.is_ok());
        assert!(!Deadline::after(Duration::MAX).is_over());
    }
}
