//! Streams of HTTP/2 that can be ended alone.
//!
//! hyper asks a body for bytes only while the client takes some, so that a body cannot end its stream by an error when its client has stopped reading. But hyper runs each stream
//! as a task of an executor that the server chooses. This one can drop the task: with it go the body, its file, and the stream, which tells the client by `RST_STREAM`. The other
//! streams of the connection do not notice.

use std::sync::Arc;

use hyper::rt::Executor;
use tokio::sync::Notify;

tokio::task_local! {
    /// The end of the stream whose task this is.
    static END: StreamEnd;
}

/// Ends a stream.
#[derive(Debug, Clone, Default)]
pub(crate) struct StreamEnd(Arc<Notify>);

impl StreamEnd {
    /// Returns the end of the stream in whose task this is called; `None` outside of streams, as for HTTP/1.1.
    pub(crate) fn of_task() -> Option<Self> {
        END.try_with(Clone::clone).ok()
    }

    /// Ends the stream as soon as its task runs.
    pub(crate) fn end(&self) {
        self.0.notify_one();
    }
}

/// Runs the tasks of streams.
#[derive(Debug, Clone, Copy)]
pub(crate) struct StreamExecutor;

impl<F: Future<Output = ()> + Send + 'static> Executor<F> for StreamExecutor {
    fn execute(&self, stream: F) {
        let end = StreamEnd::default();
        tokio::spawn(END.scope(end.clone(), async move {
            tokio::select! {
                () = stream => (),
                () = end.0.notified() => (),
            }
        }));
    }
}
