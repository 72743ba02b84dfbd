//! Runs third-party parsers so that they cannot end the program: on a thread with its own stack, where a
//! panic becomes an error.

use std::any::Any;
use std::cell::Cell;
use std::panic::{self, AssertUnwindSafe};
use std::sync::Once;
use std::thread;

/// The stack of the thread, bytes: the same for all callers, also where the system gives threads little.
const STACK: usize = 16 << 20;

thread_local! {
    /// Whether panics of this thread become errors; their message is then not printed.
    static IS_GUARDED: Cell<bool> = const { Cell::new(false) };
}

/// Runs a third-party parser on its own thread. Its input must be bounded: neither a parser that does not end
/// nor one that takes all memory can be stopped.
///
/// # Errors
/// The words of its panic.
pub fn on_thread<T: Send>(parse: impl FnOnce() -> T + Send) -> Result<T, String> {
    let (mut parse, mut done) = (Some(parse), None);
    let mut run = || done = parse.take().map(here);
    thread::scope(|scope| {
        // where there are no threads, as in a browser, `run` is still to be called
        let _ = thread::Builder::new().stack_size(STACK).spawn_scoped(scope, &mut run);
    });
    if let Some(parse) = parse {
        done = Some(here(parse));
    }
    done.unwrap_or_else(|| Err(NO_WORDS.to_owned()))
}

/// As [`on_thread`], on this thread.
///
/// # Errors
/// The words of its panic.
pub fn here<T>(act: impl FnOnce() -> T) -> Result<T, String> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let usual = panic::take_hook();
        panic::set_hook(Box::new(move |panic| {
            if !IS_GUARDED.get() {
                usual(panic);
            }
        }));
    });
    let before = IS_GUARDED.replace(true);
    let done = panic::catch_unwind(AssertUnwindSafe(act));
    IS_GUARDED.set(before);
    done.map_err(|panic| words(&*panic).to_owned())
}

const NO_WORDS: &str = "no reason is given";

/// The message of a panic.
fn words(panic: &(dyn Any + Send)) -> &str {
    let words = panic.downcast_ref::<String>().map(String::as_str);
    words.or(panic.downcast_ref::<&str>().copied()).unwrap_or(NO_WORDS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_an_error_with_its_words() {
        assert_eq!(on_thread(|| 1 + 1), Ok(2));
        let words = format!("index {}", 7);
        assert_eq!(on_thread(|| -> u8 { panic!("{words}") }), Err("index 7".to_owned()));
        assert_eq!(here(|| -> u8 { panic!("plain") }), Err("plain".to_owned()));
        assert_eq!(here(|| here(|| 1)), Ok(Ok(1)));
    }

    #[test]
    fn a_parser_has_a_stack_of_its_own() {
        // 1 MiB of it, which a thread of the smallest stack has not
        #[inline(never)]
        fn deep(levels: usize) -> usize {
            let part = std::hint::black_box([levels as u8; 1024]);
            if levels == 0 { 0 } else { 1 + deep(levels - 1) + usize::from(part[levels % 1024] != part[0]) }
        }
        let small = thread::Builder::new().stack_size(256 << 10);
        let done = small.spawn(|| on_thread(|| deep(1024))).unwrap().join().unwrap();
        assert_eq!(done, Ok(1024));
    }
}
