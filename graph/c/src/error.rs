//! The last error of a thread, as text.

use std::any::Any;
use std::cell::RefCell;
use std::ffi::{CString, NulError, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind};

thread_local! {
    static LAST: RefCell<CString> = RefCell::default();
}

/// The error of a call, as text.
pub(crate) struct Fault(pub(crate) String);

impl From<afterimage::Error> for Fault {
    fn from(error: afterimage::Error) -> Self {
        Self(error.to_string())
    }
}

impl From<NulError> for Fault {
    fn from(error: NulError) -> Self {
        Self(error.to_string())
    }
}

/// The text of the last error.
pub(crate) fn last() -> *const c_char {
    LAST.with_borrow(|last| last.as_ptr())
}

/// Calls `call`; keeps the text of its error, or of its panic, and returns `failed` then.
pub(crate) fn guarded<T>(failed: T, call: impl FnOnce() -> Result<T, Fault>) -> T {
    // A pipeline whose call has panicked is not used again.
    let text = match catch_unwind(AssertUnwindSafe(call)) {
        Ok(Ok(result)) => return result,
        Ok(Err(Fault(text))) => text,
        Err(panic) => format!("an error in Afterimage: {}", message(&*panic)),
    };
    let text = CString::new(text.replace('\0', " ")).expect("it has no zero");
    LAST.with_borrow_mut(|last| *last = text);
    failed
}

fn message(panic: &(dyn Any + Send)) -> &str {
    let owned = panic.downcast_ref::<String>().map(String::as_str);
    owned.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("unknown")
}

#[cfg(test)]
mod tests {
    use std::ffi::CStr;

    use super::{Fault, guarded, last};

    #[track_caller]
    fn fails(call: impl FnOnce() -> Result<i32, Fault>, text: &str) {
        assert_eq!(guarded(-1, call), -1);
        // SAFETY: the text is of this thread, and no call follows before it is compared.
        assert_eq!(unsafe { CStr::from_ptr(last()) }.to_str(), Ok(text));
    }

    #[test]
    fn errors_and_panics_are_texts() {
        assert_eq!(guarded(-1, || Ok(1)), 1);
        fails(|| Err(Fault("no\0such node".to_owned())), "no such node");
        fails(|| panic!("at {}", 3), "an error in Afterimage: at 3");
        fails(|| panic!("at once"), "an error in Afterimage: at once");
        // One that went well leaves the text.
        assert_eq!(guarded(-1, || Ok(2)), 2);
        // SAFETY: as above.
        assert!(unsafe { CStr::from_ptr(last()) }.to_string_lossy().ends_with("at once"));
    }
}
