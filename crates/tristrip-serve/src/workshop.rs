//! Jobs that take time: each is done once however many clients ask for it, few are done at once, and results are cached.
//!
//! ```text
//! request ─▶ cache? ─ yes ─▶ result
//!              └ no ─▶ running already? ─ yes ─▶ wait for it
//!                           └ no ─▶ failed lately? too many waiting? ─ no ─▶ a task of its own: permit ─▶ work ─▶ cache ─▶ all who wait
//! ```
//! A job goes on when its clients leave, so that its result is there when they come back. It holds a permit only while it works: not while a client
//! reads the result.

use std::collections::HashMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use rayon::{ThreadPool, ThreadPoolBuilder};
use tokio::sync::{Semaphore, watch};

use crate::cache::{Cache, Made};
use crate::error::Error;
use crate::metrics::Metrics;
use crate::options::PackingOptions;

/// The stack of each thread that packs, as that of the command's threads.
const STACK_BYTES: usize = 8 << 20;
/// The failures that are remembered.
const MOST_FAILURES: usize = 1024;

/// Why there is no result.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Refusal {
    /// Too many jobs wait: later there may be room.
    Busy,
    /// The job failed, with this message.
    Failed(Arc<str>),
}

type Outcome = Result<Made, Refusal>;
type Watch = watch::Receiver<Option<Outcome>>;

/// What is to be made: the key of its result, and what it is for the figures.
#[derive(Debug, Clone)]
pub(crate) struct JobKey {
    pub(crate) kind: &'static str,
    pub(crate) key: String,
    /// The name in the log.
    pub(crate) name: String,
}

/// Runs jobs and keeps their results.
#[derive(Debug)]
pub(crate) struct Workshop {
    cache: Cache,
    pool: ThreadPool,
    permits: Semaphore,
    at_once: usize,
    most_waiting: usize,
    failure_time: Duration,
    /// Jobs that wait or run.
    unfinished: AtomicUsize,
    running: Mutex<HashMap<String, Watch>>,
    failures: Mutex<HashMap<String, (Instant, Arc<str>)>>,
    metrics: Arc<Metrics>,
}

impl Workshop {
    pub(crate) fn new(options: &PackingOptions, cache: Cache, metrics: Arc<Metrics>) -> Result<Self, Error> {
        let builder =
            ThreadPoolBuilder::new().stack_size(STACK_BYTES).num_threads(options.threads.unwrap_or(0));
        let pool = builder.build().map_err(|error| Error::System(std::io::Error::other(error)))?;
        let at_once = options.at_once.clamp(1, Semaphore::MAX_PERMITS);
        metrics.cache_bytes.set(cache.used_bytes());
        Ok(Self {
            cache,
            pool,
            permits: Semaphore::new(at_once),
            at_once,
            most_waiting: options.waiting,
            failure_time: options.failure_time,
            unfinished: AtomicUsize::new(0),
            running: Mutex::default(),
            failures: Mutex::default(),
            metrics,
        })
    }

    /// Returns the result of a job: from the cache, from a job that runs already, or from `work`.
    pub(crate) async fn get(
        self: &Arc<Self>,
        job: JobKey,
        work: impl FnOnce() -> Result<Vec<u8>, String> + Send + 'static,
    ) -> Outcome {
        if let Some(made) = self.cached(&job.key).await {
            self.metrics.cache_hits.inc();
            return Ok(made);
        }
        let mut watch = self.watch(job, work)?;
        match watch.wait_for(Option::is_some).await.map(|outcome| outcome.clone()) {
            Ok(Some(outcome)) => outcome,
            _ => Err(Refusal::Failed("the job was stopped".into())),
        }
    }

    async fn cached(self: &Arc<Self>, key: &str) -> Option<Made> {
        let (this, key) = (Arc::clone(self), key.to_owned());
        tokio::task::spawn_blocking(move || this.cache.get(&key)).await.ok().flatten()
    }

    /// Joins a job that runs, or starts it.
    fn watch(
        self: &Arc<Self>,
        job: JobKey,
        work: impl FnOnce() -> Result<Vec<u8>, String> + Send + 'static,
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
        if self.unfinished.load(Ordering::Relaxed) >= self.at_once + self.most_waiting {
            self.metrics.count_job(job.kind, "refused");
            return Err(Refusal::Busy);
        }
        self.unfinished.fetch_add(1, Ordering::Relaxed);
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
            this.unfinished.fetch_sub(1, Ordering::Relaxed);
            // Nobody may wait any more.
            sender.send_replace(Some(outcome));
        });
        Ok(watch)
    }

    async fn run(
        self: &Arc<Self>,
        job: &JobKey,
        work: impl FnOnce() -> Result<Vec<u8>, String> + Send + 'static,
    ) -> Outcome {
        // A job of the same key may have ended since the cache was asked.
        if let Some(made) = self.cached(&job.key).await {
            self.metrics.cache_hits.inc();
            return Ok(made);
        }
        self.metrics.cache_misses.inc();
        self.metrics.waiting.inc();
        let permit = self.permits.acquire().await;
        self.metrics.waiting.dec();
        let Ok(_permit) = permit else { return Err(Refusal::Busy) };
        self.metrics.running.inc();
        let started = Instant::now();
        let (this, key) = (Arc::clone(self), job.key.clone());
        let done = tokio::task::spawn_blocking(move || {
            let bytes = this.pool.install(work)?;
            let made = this.cache.put(&key, bytes);
            this.metrics.cache_bytes.set(this.cache.used_bytes());
            Ok::<_, String>(made)
        });
        let outcome = done.await.unwrap_or_else(|_| Err("an error in the program ended the job".into()));
        self.metrics.running.dec();
        let milliseconds = started.elapsed().as_millis() as u64;
        let (kind, name) = (job.kind, &job.name);
        match outcome {
            Ok(made) => {
                self.metrics.count_job(kind, "done");
                tracing::info!(kind, name, bytes = made.source.len(), milliseconds, "made");
                Ok(made)
            }
            Err(message) => {
                self.metrics.count_job(kind, "failed");
                // Quoted: parts of the file may be in it.
                tracing::warn!(kind, name, error = ?message, milliseconds, "failed");
                Err(Refusal::Failed(message.into()))
            }
        }
    }

    /// Remembers a failure for a while; with too many of them, the old ones are forgotten.
    fn remember(&self, key: &str, message: &Arc<str>) {
        let mut failures = lock(&self.failures);
        if failures.len() >= MOST_FAILURES {
            failures.retain(|_, (since, _)| since.elapsed() < self.failure_time);
        }
        if failures.len() < MOST_FAILURES {
            failures.insert(key.to_owned(), (Instant::now(), Arc::clone(message)));
        }
    }
}

/// Locks a map; that a thread panicked while it held the lock leaves no map half changed.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc;

    use super::*;

    fn workshop(options: &PackingOptions, dir: &std::path::Path) -> Arc<Workshop> {
        let cache = Cache::open(dir, 1 << 30).unwrap();
        Arc::new(Workshop::new(options, cache, Arc::new(Metrics::new())).unwrap())
    }

    fn job(key: &str) -> JobKey {
        JobKey { kind: "packing", key: key.into(), name: key.into() }
    }

    #[tokio::test(flavor = "multi_thread", worker_threads = 2)]
    async fn a_job_is_done_once_for_all_who_ask() {
        let dir = tempfile::tempdir().unwrap();
        let workshop = workshop(&PackingOptions::default(), dir.path());
        let runs = Arc::new(AtomicUsize::new(0));
        let asked = (0..50).map(|_| {
            let (workshop, runs) = (Arc::clone(&workshop), Arc::clone(&runs));
            tokio::spawn(async move {
                let work = move || {
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
        assert_eq!(workshop.unfinished.load(Ordering::SeqCst), 0);
    }

    #[tokio::test(flavor = "multi_thread", worker_threads = 2)]
    async fn failures_and_panics_are_remembered_for_a_while() {
        let dir = tempfile::tempdir().unwrap();
        let options =
            PackingOptions { failure_time: Duration::from_millis(100), ..PackingOptions::default() };
        let workshop = workshop(&options, dir.path());
        let failed = |message: &str| Some(Refusal::Failed(message.into()));
        assert_eq!(workshop.get(job("a"), || Err("first".into())).await.err(), failed("first"));
        assert_eq!(workshop.get(job("a"), || Err("second".into())).await.err(), failed("first"));
        tokio::time::sleep(Duration::from_millis(120)).await;
        assert!(workshop.get(job("a"), || Ok(vec![1])).await.is_ok());
        let panicked = workshop.get(job("b"), || panic!("as a test")).await;
        assert_eq!(panicked.err(), failed("an error in the program ended the job"));
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
                workshop.get(job("a"), move || gate.recv().map(|()| vec![1]).map_err(|_| "gate".into())).await
            }
        });
        while workshop.metrics.running.get() == 0 {
            tokio::time::sleep(Duration::from_millis(1)).await;
        }
        let second = tokio::spawn({
            let workshop = Arc::clone(&workshop);
            async move { workshop.get(job("b"), || Ok(vec![2])).await }
        });
        while workshop.metrics.waiting.get() == 0 {
            tokio::time::sleep(Duration::from_millis(1)).await;
        }
        assert_eq!(workshop.get(job("c"), || Ok(vec![3])).await.err(), Some(Refusal::Busy));
        // A client that leaves does not stop its job.
        second.abort();
        go.send(()).unwrap();
        assert!(first.await.unwrap().is_ok());
        while workshop.unfinished.load(Ordering::SeqCst) > 0 {
            tokio::time::sleep(Duration::from_millis(1)).await;
        }
        assert!(workshop.cache.get("b").is_some());
    }
}
