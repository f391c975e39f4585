//! Threads that compile plans. They stay for the life of the process.
//!
//! wgpu 30 keeps a list of error scopes for each thread that ever opened one, for as long as the device is open
//! (`ErrorSinkRaw::scopes` in `backend/wgpu_core.rs`: nothing removes an entry). With new threads for each plan, the
//! memory of a program that reloads would grow with each reload.

use std::any::Any;
use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::{Arc, Condvar, LazyLock, Mutex};

use crate::error::GpuError;
use crate::platform::TaskPool;
use afterimage_wgsl::limits;
use rayon::{ThreadPool, ThreadPoolBuilder};

/// The threads of plans that the caller waits for.
static LOADING: LazyLock<Pool> = LazyLock::new(|| pool("load", ALL_CORES, limits::STACK_BYTES));
/// The threads of plans that are prepared while another one renders. They are others, so that a plan that is loaded
/// does not wait for one that is prepared.
static PREPARING: LazyLock<Pool> = LazyLock::new(|| pool("prepare", ALL_CORES, limits::STACK_BYTES));
/// The thread of plans that the caller waits for, if the host has a pool: its tasks help. The caller may have a small
/// stack.
static LOADING_WITH_HOST: LazyLock<Pool> = LazyLock::new(|| pool("load", 1, limits::STACK_BYTES));

/// As many threads as there are cores.
const ALL_CORES: usize = 0;

/// Threads, or why there are none.
type Pool = Result<ThreadPool, GpuError>;

/// Threads on which wgpu parses shaders: its parser recurses. One does all the work where there is no memory for more.
fn pool(name: &'static str, threads: usize, stack_bytes: usize) -> Pool {
    let pool = |threads: usize| {
        let builder = ThreadPoolBuilder::new().num_threads(threads).stack_size(stack_bytes);
        builder.thread_name(move |index| format!("afterimage-{name}-{index}")).build()
    };
    pool(threads).or_else(|_| pool(1)).map_err(|error| GpuError::NoThreads { why: error.to_string() })
}

fn threads(pool: &'static Pool) -> Result<&'static ThreadPool, GpuError> {
    pool.as_ref().map_err(Clone::clone)
}

thread_local! {
    /// True if this thread runs a task of the host's pool.
    static OF_HOST: Cell<bool> = const { Cell::new(false) };
}

/// Runs the same work on several threads, and waits for all of them. Panics propagate to the caller. If the host has a
/// pool, one thread is ours and the others are the pool's; a task of the pool runs the work alone.
///
/// # Errors
/// The system has no threads.
pub(crate) fn on_threads(
    pool: Option<&TaskPool>,
    count: usize,
    work: impl Fn() + Send + Sync + 'static,
) -> Result<(), GpuError> {
    if count == 0 {
        return Ok(());
    }
    if OF_HOST.get() {
        work();
        return Ok(());
    }
    if let Some(pool) = pool {
        return on_threads_of_host(pool, count, Arc::new(work));
    }
    // Work that is part of a preparation stays on the threads of preparations.
    let is_preparation = rayon::current_thread_index().is_some()
        && threads(&PREPARING).is_ok_and(|preparing| preparing.current_thread_index().is_some());
    let pool = threads(if is_preparation { &PREPARING } else { &LOADING })?;
    pool.scope(|scope| (0..count).for_each(|_| scope.spawn(|_| work())));
    Ok(())
}

fn on_threads_of_host(pool: &TaskPool, count: usize, work: Arc<dyn Fn() + Send + Sync>) -> Result<(), GpuError> {
    let own = threads(&LOADING_WITH_HOST)?;
    let helpers = Arc::new(Helpers::default());
    for _ in 1..count {
        let (helpers, work) = (helpers.clone(), work.clone());
        pool(Box::new(move || helpers.run(&*work)));
    }
    own.install(|| helpers.run(&*work));
    helpers.finish();
    Ok(())
}

/// Threads that do the same work until it is over.
#[derive(Default)]
struct Helpers {
    state: Mutex<HelperState>,
    done: Condvar,
}

#[derive(Default)]
struct HelperState {
    /// Threads that do the work now.
    running: usize,
    /// The work is over: later calls do nothing.
    is_over: bool,
    panic: Option<Box<dyn Any + Send>>,
}

impl Helpers {
    fn run(&self, work: &dyn Fn()) {
        {
            let mut state = self.state.lock().expect(UNBROKEN);
            if state.is_over {
                return;
            }
            state.running += 1;
        }
        let done = catch_unwind(AssertUnwindSafe(work));
        let mut state = self.state.lock().expect(UNBROKEN);
        state.running -= 1;
        if let Err(panic) = done {
            state.panic.get_or_insert(panic);
        }
        self.done.notify_all();
    }

    /// Waits for the threads that do the work. Panics propagate to the caller.
    fn finish(&self) {
        let mut state = self.state.lock().expect(UNBROKEN);
        state.is_over = true;
        let mut state = self.done.wait_while(state, |state| state.running > 0).expect(UNBROKEN);
        if let Some(panic) = state.panic.take() {
            drop(state);
            resume_unwind(panic);
        }
    }
}

/// Work on a thread of the preparations or in the host's pool. It continues if this is dropped.
pub struct Worker<T>(Arc<Outcome<T>>);

/// The result of work or its panic, and a signal when it arrives. A task that the host's pool dropped has no result.
struct Outcome<T> {
    result: Mutex<Option<Option<std::thread::Result<T>>>>,
    done: Condvar,
}

const UNBROKEN: &str = "no thread panics with the lock";

impl<T: Send + 'static> Worker<T> {
    /// Starts work, in the host's pool if there is one.
    pub fn new(pool: Option<&TaskPool>, work: impl FnOnce() -> T + Send + 'static) -> Self {
        let outcome = Arc::new(Outcome { result: Mutex::new(None), done: Condvar::new() });
        let promise = Promise(outcome.clone());
        let task = move || promise.keep(catch_unwind(AssertUnwindSafe(work)));
        match pool {
            // Without threads the task is dropped, and says so.
            None => drop(threads(&PREPARING).map(|preparing| preparing.spawn(task))),
            Some(spawn) => spawn(Box::new(move || {
                OF_HOST.set(true);
                task();
                OF_HOST.set(false);
            })),
        }
        Self(outcome)
    }

    /// `true` once [`join`](Self::join) returns at once.
    pub fn is_finished(&self) -> bool {
        self.0.result.lock().expect(UNBROKEN).is_some()
    }

    /// Waits for the result. Panics propagate to the caller.
    ///
    /// # Errors
    /// The host's pool has dropped the work, or the system has no threads.
    pub fn join(self) -> Result<T, GpuError> {
        let empty = self.0.result.lock().expect(UNBROKEN);
        let mut result = self.0.done.wait_while(empty, |result| result.is_none()).expect(UNBROKEN);
        let result = result.take().expect("the wait ends with a result").ok_or(GpuError::TaskDropped)?;
        Ok(result.unwrap_or_else(|panic| resume_unwind(panic)))
    }
}

/// Passes the result of a task to its worker.
struct Promise<T>(Arc<Outcome<T>>);

impl<T> Promise<T> {
    fn keep(self, result: std::thread::Result<T>) {
        *self.0.result.lock().expect(UNBROKEN) = Some(Some(result));
    }
}

impl<T> Drop for Promise<T> {
    fn drop(&mut self) {
        self.0.result.lock().expect(UNBROKEN).get_or_insert(None);
        self.0.done.notify_one();
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;
    use std::sync::atomic::{AtomicUsize, Ordering};
    use std::sync::mpsc::channel;
    use std::thread::{ThreadId, current};

    use super::*;

    #[test]
    fn threads_are_used_again() {
        let seen: Arc<Mutex<HashSet<ThreadId>>> = Arc::default();
        let runs = Arc::new(AtomicUsize::new(0));
        for _ in 0..100 {
            let (seen, runs) = (seen.clone(), runs.clone());
            on_threads(None, 3, move || {
                seen.lock().expect(UNBROKEN).insert(current().id());
                runs.fetch_add(1, Ordering::Relaxed);
            })
            .expect("there are threads");
        }
        assert_eq!(runs.load(Ordering::Relaxed), 300);
        assert!(seen.lock().expect(UNBROKEN).len() <= threads(&LOADING).expect("there are some").current_num_threads());
        let prepared: HashSet<ThreadId> =
            (0..100).map(|_| Worker::new(None, || current().id()).join().expect("it is ours")).collect();
        assert!(prepared.len() <= threads(&PREPARING).expect("there are some").current_num_threads());
    }

    #[test]
    fn a_system_without_memory_for_threads_is_an_error() {
        let error = pool("test", 2, usize::MAX / 4).expect_err("no system has so much");
        assert!(error.to_string().starts_with("the system has no further thread for this program: "), "{error}");
    }

    #[test]
    fn work_of_a_preparation_stays_on_its_threads_and_a_loaded_plan_does_not_wait_for_it() {
        let (begin, begun) = channel();
        let hold = Arc::new(Mutex::new(()));
        let held = hold.lock().expect(UNBROKEN);
        let waits = hold.clone();
        let worker = Worker::new(None, move || {
            let here: Arc<Mutex<Vec<bool>>> = Arc::default();
            let pushed = here.clone();
            on_threads(None, 1, move || {
                let preparing = threads(&PREPARING).expect("it works on one");
                pushed.lock().expect(UNBROKEN).push(preparing.current_thread_index().is_some());
            })
            .expect("there are threads");
            begin.send(here.lock().expect(UNBROKEN).clone()).expect("the test waits");
            drop(waits.lock());
            7
        });
        assert_eq!(begun.recv().expect("the work begins"), [true]);
        on_threads(None, 2, || assert!(threads(&LOADING).is_ok_and(|pool| pool.current_thread_index().is_some())))
            .expect("there are threads");
        assert!(!worker.is_finished());
        drop(held);
        assert_eq!(worker.join().expect("it is ours"), 7);
    }

    #[test]
    fn a_panic_propagates_to_the_caller_that_waits() {
        let worker = Worker::new(None, || -> u32 { panic!("of the work") });
        let panic = catch_unwind(AssertUnwindSafe(|| worker.join())).expect_err("the work panics");
        assert_eq!(panic.downcast_ref::<&str>(), Some(&"of the work"));
        drop(catch_unwind(|| on_threads(None, 2, || panic!("of all"))).expect_err("the work panics"));
        assert_eq!(Worker::new(None, || 3).join().expect("it is ours"), 3, "the threads continue");
    }

    #[test]
    fn the_hosts_pool_does_the_work_alone_and_may_drop_it() {
        type Task = Box<dyn FnOnce() + Send>;
        let tasks: Arc<Mutex<Vec<Task>>> = Arc::default();
        let kept = tasks.clone();
        let pool: TaskPool = Arc::new(move |task| kept.lock().expect(UNBROKEN).push(task));
        let next = || tasks.lock().expect(UNBROKEN).pop().expect("a task was given");
        let work = || {
            let here: Arc<Mutex<Vec<ThreadId>>> = Arc::default();
            let pushed = here.clone();
            on_threads(None, 3, move || pushed.lock().expect(UNBROKEN).push(current().id())).expect("it is here");
            here.lock().expect(UNBROKEN).clone()
        };
        let worker = Worker::new(Some(&pool), work);
        assert!(!worker.is_finished());
        next()();
        assert!(worker.is_finished());
        assert_eq!(worker.join().expect("it was done"), [current().id()]);
        assert!(!OF_HOST.get(), "the thread is the host's again");
        let dropped = Worker::new(Some(&pool), work);
        drop(next());
        assert!(dropped.is_finished());
        assert!(matches!(dropped.join(), Err(GpuError::TaskDropped)));
    }

    /// A frame that waits for its plan uses the host's threads and one of ours, and not the pool of all cores.
    #[test]
    fn the_hosts_pool_helps_a_thread_that_waits() {
        type Task = Box<dyn FnOnce() + Send>;
        let late: Arc<Mutex<Vec<Task>>> = Arc::default();
        let kept = late.clone();
        let pool: TaskPool = Arc::new(move |task| kept.lock().expect(UNBROKEN).push(task));
        let names: Arc<Mutex<Vec<Option<String>>>> = Arc::default();
        let work = {
            let names = names.clone();
            move || names.lock().expect(UNBROKEN).push(current().name().map(str::to_owned))
        };
        on_threads(Some(&pool), 3, work.clone()).expect("there are threads");
        assert_eq!(*names.lock().expect(UNBROKEN), [Some("afterimage-load-0".to_owned())]);
        let tasks = std::mem::take(&mut *late.lock().expect(UNBROKEN));
        assert_eq!(tasks.len(), 2, "the host is asked for the other threads");
        tasks.into_iter().for_each(|task| task());
        assert_eq!(names.lock().expect(UNBROKEN).len(), 1, "the work is over");
        let at_once: TaskPool = Arc::new(|task| task());
        on_threads(Some(&at_once), 3, work).expect("there are threads");
        assert_eq!(names.lock().expect(UNBROKEN).len(), 4);
        catch_unwind(AssertUnwindSafe(|| on_threads(Some(&at_once), 2, || panic!("of all")))).expect_err("it panics");
    }
}
