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

fn fail(what: &str) -> u32 {
    panic!("the {what} is damaged")
}

fn fail_twice() -> u32 {
    let inner = catch_panic(|| fail("shader")).expect_err("it panics");
    fail(&inner)
}

fn fail_elsewhere() {
    std::thread::spawn(|| fail("thread")).join().expect_err("it panics");
}

#[test]
fn caught_panics_are_silent_and_those_after_them_are_not() {
    let usual = take_hook();
    set_hook(Box::new(|_| _ = PRINTED.fetch_add(1, Ordering::SeqCst)));
    assert_eq!(catch_panic(|| 3), Ok(3));
    assert_eq!(printed(|| assert_eq!(catch_panic(|| fail("file")), Err("the file is damaged".to_owned()))), 0);
    assert_eq!(printed(|| assert!(catch_unwind(|| fail("file")).is_err())), 1);
    let twice = Err("the the shader is damaged is damaged".to_owned());
    assert_eq!(printed(|| assert_eq!(catch_panic(fail_twice), twice)), 0, "a panic after one that was caught");
    assert_eq!(printed(|| drop(catch_panic(fail_elsewhere))), 1, "other threads are not guarded");
    set_hook(usual);
}
