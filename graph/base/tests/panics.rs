//! The panics that are caught are silent, and all others are as before. In a process of its own, for its hook.

use std::panic::{catch_unwind, set_hook, take_hook};
use std::sync::atomic::{AtomicUsize, Ordering};

use afterimage_base::panics::catch_panic;

static PRINTED: AtomicUsize = AtomicUsize::new(0);

/// The panics that are printed while this is done.
fn printed(work: impl FnOnce()) -> usize {
    let before = PRINTED.load(Ordering::SeqCst);
    work();
    PRINTED.load(Ordering::SeqCst) - before
}

#[test]
fn caught_panics_are_silent_and_those_after_them_are_not() {
    let usual = take_hook();
    set_hook(Box::new(|_| _ = PRINTED.fetch_add(1, Ordering::SeqCst)));
    let fail = |what: &str| -> u32 { panic!("the {what} is damaged") };
    assert_eq!(catch_panic(|| 3), Ok(3));
    assert_eq!(printed(|| assert_eq!(catch_panic(|| fail("file")), Err("the file is damaged".to_owned()))), 0);
    assert_eq!(printed(|| assert!(catch_unwind(|| fail("file")).is_err())), 1);
    let nested = || {
        let inner = catch_panic(|| fail("shader")).expect_err("it panics");
        fail(&inner)
    };
    let both = || assert_eq!(catch_panic(nested), Err("the the shader is damaged is damaged".to_owned()));
    assert_eq!(printed(both), 0, "a panic after an inner one that was caught");
    let elsewhere = || std::thread::spawn(move || fail("thread")).join().map(drop).expect_err("it panics");
    assert_eq!(printed(|| drop(catch_panic(elsewhere))), 1, "other threads are not guarded");
    set_hook(usual);
}
