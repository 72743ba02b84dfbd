//! The module's memory: the input, the output, and the open episodes.

use crate::episode::Open;
use cocarry::Error;
use serde::de::DeserializeOwned;
use serde_json::Value;
use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use std::error::Error as _;
use std::sync::Once;

/// The largest input, bytes.
const MAX_INPUT: usize = 64 << 20;
/// The largest number of episodes that are open at a time.
const MAX_OPEN: usize = 64;

/// The module's memory.
#[derive(Default)]
pub struct Module {
    input: Vec<u8>,
    output: Vec<u8>,
    episodes: BTreeMap<u32, Open>,
    /// The handle that was given last.
    last: u32,
}

thread_local! {
    static MODULE: RefCell<Module> = RefCell::default();
    /// The output: address and length.
    static OUTPUT: Cell<(*const u8, usize)> = const { Cell::new((std::ptr::null(), 0)) };
    /// What a panic said.
    static FAULT: RefCell<String> = const { RefCell::new(String::new()) };
}

/// Keeps what a panic says, for the host: a module that panics stops.
fn keep_faults() {
    static HOOK: Once = Once::new();
    if cfg!(target_family = "wasm") {
        HOOK.call_once(|| {
            std::panic::set_hook(Box::new(|panic| {
                FAULT.with_borrow_mut(|fault| {
                    *fault = format!("a fault in the module: {panic}");
                    OUTPUT.set((fault.as_ptr(), fault.len()));
                });
            }));
        });
    }
}

/// An error as one sentence, with its causes.
pub fn sentence(error: &Error) -> String {
    let mut sentence = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        let words = error.to_string();
        if !sentence.ends_with(&words) {
            sentence += &format!(": {}", words.trim_end());
        }
        cause = error.source();
    }
    sentence
}

/// Makes room for an input; its address, or null if it is too long.
pub fn input(length: usize) -> *mut u8 {
    keep_faults();
    MODULE.with_borrow_mut(|module| {
        module.input.clear();
        if length > MAX_INPUT {
            let error = format!("an input of {length} bytes; it must have at most {MAX_INPUT}");
            module.say(error.into_bytes());
            return std::ptr::null_mut();
        }
        module.input.shrink_to(1 << 20);
        // never a null address, also of an empty input
        module.input.resize(length.max(1), 0);
        module.input.truncate(length);
        module.input.as_mut_ptr()
    })
}

/// For hosts in Rust, such as tests: makes bytes the input, and reads the output, without addresses.
pub mod host {
    use super::MODULE;

    /// Makes bytes the input.
    pub fn write(bytes: &[u8]) {
        assert!(!super::input(bytes.len()).is_null(), "at most {} bytes", super::MAX_INPUT);
        MODULE.with_borrow_mut(|module| module.input.copy_from_slice(bytes));
    }

    /// The output.
    pub fn output() -> Vec<u8> {
        MODULE.with_borrow(|module| module.output.clone())
    }

    /// The state of an episode; `None` if there is none of this handle.
    pub fn state(handle: u32) -> Option<Vec<f64>> {
        MODULE.with_borrow(|module| Some(module.episodes.get(&handle)?.state().to_vec()))
    }
}

/// Address and length of the output.
pub fn output() -> (*const u8, usize) {
    OUTPUT.get()
}

/// Runs `act`; its error becomes the output, and the result `failed`.
pub fn with_module<T>(failed: T, act: impl FnOnce(&mut Module) -> Result<T, Error>) -> T {
    keep_faults();
    MODULE.with_borrow_mut(|module| match act(module) {
        Ok(done) => done,
        Err(error) => {
            module.say(sentence(&error).into_bytes());
            failed
        }
    })
}

/// Runs `act`, whose bytes, or whose error, become the output. 1, or 0 if it failed.
pub fn bytes(act: impl FnOnce(&mut Module) -> Result<Vec<u8>, Error>) -> u32 {
    with_module(0, |module| {
        let answer = act(module)?;
        module.say(answer);
        Ok(1)
    })
}

/// As [`bytes`], of an answer in JSON.
pub fn json(act: impl FnOnce(&mut Module) -> Result<Value, Error>) -> u32 {
    bytes(|module| Ok(act(module)?.to_string().into_bytes()))
}

impl Module {
    fn say(&mut self, answer: Vec<u8>) {
        self.output = answer;
        OUTPUT.set((self.output.as_ptr(), self.output.len()));
    }

    /// The input's bytes, which are forgotten.
    pub fn take_bytes(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.input)
    }

    /// The input as text, called `what` in errors.
    ///
    /// # Errors
    /// It is not UTF-8.
    pub fn take_text(&mut self, what: &str) -> Result<String, Error> {
        String::from_utf8(self.take_bytes()).map_err(|_| Error::new(format!("{what} is not UTF-8")))
    }

    /// The input as JSON, called `what` in errors.
    ///
    /// # Errors
    /// It is not JSON, or has another form.
    pub fn take_json<T: DeserializeOwned>(&mut self, what: &str) -> Result<T, Error> {
        let bytes = self.take_bytes();
        serde_json::from_slice(&bytes)
            .map_err(|error| Error::new(format!("{what} is not valid")).because(error))
    }

    /// Opens an episode; its handle.
    ///
    /// # Errors
    /// Too many are open.
    pub fn open(&mut self, open: Open) -> Result<u32, Error> {
        if self.episodes.len() >= MAX_OPEN {
            return Err(Error::new(format!("{MAX_OPEN} episodes are open; close one first")));
        }
        self.last += 1;
        self.episodes.insert(self.last, open);
        Ok(self.last)
    }

    /// An open episode.
    ///
    /// # Errors
    /// There is none of this handle.
    pub fn episode(&mut self, handle: u32) -> Result<&mut Open, Error> {
        self.episodes.get_mut(&handle).ok_or_else(|| unknown(handle))
    }

    /// Closes an episode.
    ///
    /// # Errors
    /// There is none of this handle.
    pub fn close(&mut self, handle: u32) -> Result<u32, Error> {
        self.episodes.remove(&handle).map(|_| 1).ok_or_else(|| unknown(handle))
    }
}

fn unknown(handle: u32) -> Error {
    Error::new(format!("{handle} is not the handle of an open episode"))
}
