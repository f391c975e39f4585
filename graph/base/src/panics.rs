//! Decoders and compilers of other people must not take the program down. A panic on damaged bytes or on a shader
//! becomes an error, and its message does not reach the terminal.

use std::any::Any;
use std::cell::Cell;
use std::panic::{self, AssertUnwindSafe};
use std::sync::Once;

thread_local! {
    static GUARDED: Cell<bool> = const { Cell::new(false) };
}

static QUIET: Once = Once::new();

/// Runs `work` and turns a panic of this thread into its message.
///
/// The first call puts a filter before the process's panic hook, which stays silent only for
/// threads inside this function. Work that is spread over other threads must call this on each.
pub fn catch_panic<T>(work: impl FnOnce() -> T) -> Result<T, String> {
    QUIET.call_once(install_filter);
    let outer = GUARDED.replace(true);
    let result = panic::catch_unwind(AssertUnwindSafe(work));
    GUARDED.set(outer);
    result.map_err(|payload| message_of(payload.as_ref()))
}

fn install_filter() {
    let previous = panic::take_hook();
    panic::set_hook(Box::new(move |info| {
        if !GUARDED.get() {
            previous(info);
        }
    }));
}

/// The message of a panic.
pub fn message_of(payload: &(dyn Any + Send)) -> String {
    let text = payload.downcast_ref::<&str>().map(|text| (*text).to_owned());
    text.or_else(|| payload.downcast_ref::<String>().cloned()).unwrap_or_else(|| "no reason is given".to_owned())
}
