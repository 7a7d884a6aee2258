//! HTTP/2 streams that can be ended individually.
//!
//! hyper polls a body only while the client reads. A body whose client has stopped reading
//! therefore cannot end its stream with an error. However, hyper runs each stream as a task of an
//! executor that the server provides. This executor can drop the task, which drops the body with
//! its file and ends the stream with `RST_STREAM`. The other streams of the connection are not
//! affected.

use std::sync::Arc;

use hyper::rt::Executor;
use tokio::sync::Notify;

tokio::task_local! {
    /// The handle that ends the stream of this task.
    static END: StreamEnd;
}

/// A handle that ends a stream.
#[derive(Debug, Clone, Default)]
pub(crate) struct StreamEnd(Arc<Notify>);

impl StreamEnd {
    /// Returns the handle of the stream whose task calls this function. Returns `None` outside
    /// streams, for example for HTTP/1.1.
    pub(crate) fn of_task() -> Option<Self> {
        END.try_with(Clone::clone).ok()
    }

    /// Ends the stream the next time its task runs.
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
