//! The thread that writes: requests that come while the disk is busy share the next transaction.
//!
//! Each is answered once its transaction is on the disk. A single one is not slower for that, and hundreds of
//! participants cost a few synchronizations of the disk a second, not one for each chunk.

use super::limits::Log;
use crate::store::{Fault, Refusal, Store, StoreError, Writing};
use cocarry::error::words;
use serde_json::Value;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};
use tokio::sync::oneshot;

/// The largest number of requests in a transaction.
const MAX_TOGETHER: usize = 256;

/// Why a request has no answer of the store.
pub(super) enum Unwritten {
    /// It is refused.
    Refused(Refusal),
    /// Nothing can be stored just now.
    Failed,
}

type Answer = Result<Value, Unwritten>;
type Work = Box<dyn FnOnce(&Writing) -> Result<Value, Fault> + Send>;

/// Where requests for the store go.
pub(super) struct Writer(Sender<(Work, oneshot::Sender<Answer>)>);

impl Writer {
    /// Starts the thread, which ends with this value.
    pub fn new(store: Store, log: Arc<Log>) -> Self {
        let (sender, jobs) = channel();
        std::thread::spawn(move || write(store, &jobs, &log));
        Self(sender)
    }

    /// The answer to a request. It is on the disk.
    pub async fn ask(&self, work: impl FnOnce(&Writing) -> Result<Value, Fault> + Send + 'static) -> Answer {
        let (answer, heard) = oneshot::channel();
        // without the thread there is no answer either
        let _ = self.0.send((Box::new(work), answer));
        heard.await.unwrap_or(Err(Unwritten::Failed))
    }
}

fn write(mut store: Store, jobs: &Receiver<(Work, oneshot::Sender<Answer>)>, log: &Log) {
    while let Ok(first) = jobs.recv() {
        let more = jobs.try_iter().take(MAX_TOGETHER - 1);
        let (works, answers): (Vec<_>, Vec<_>) = std::iter::once(first).chain(more).unzip();
        // whose answers are dropped in a panic hears that it failed
        let written = catch_unwind(AssertUnwindSafe(|| together(&mut store, works)));
        match written {
            Ok(Ok(values)) => {
                for (answer, value) in answers.into_iter().zip(values) {
                    // whoever asked may have gone
                    let _ = answer.send(value.map_err(Unwritten::Refused));
                }
            }
            Ok(Err(error)) => log.line(format_args!("error: {}", words(&error))),
            Err(_) => log.line("error: a request ended at a fault of the program"),
        }
    }
}

/// Does all works in one transaction; a fault of the database is one of all.
fn together(store: &mut Store, works: Vec<Work>) -> Result<Vec<Result<Value, Refusal>>, StoreError> {
    store.alone(|writing| {
        let each = works.into_iter().map(|work| match work(writing) {
            Ok(value) => Ok(Ok(value)),
            Err(Fault::Refused(refusal)) => Ok(Err(refusal)),
            Err(fault) => Err(fault),
        });
        each.collect()
    })
}
