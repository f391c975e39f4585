//! Signals, variables of drivers, and threads of this process.

use std::error::Error as _;
use std::ffi::OsString;
use std::path::PathBuf;
use std::process::Command;
use std::thread::{Builder, Scope, ScopedJoinHandle};

use afterimage_gpu::GpuError;
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::failure::Failure;

/// Prepares the process while it has one thread.
pub(crate) fn prepare() {
    silence_driver();
    #[cfg(target_os = "linux")]
    signals::prepare();
}

/// The program that this process runs, to start it again with the same arguments.
pub(crate) struct Again {
    pub(crate) program: PathBuf,
    /// The arguments, without the name of the program.
    pub(crate) words: Vec<OsString>,
    /// The folder in which it was started.
    pub(crate) folder: Option<PathBuf>,
}

impl Again {
    /// This program, its arguments and its folder; `None` if the system does not tell the program.
    pub(crate) fn of_this_process() -> Option<Self> {
        let (program, words) = (std::env::current_exe().ok()?, std::env::args_os().skip(1).collect());
        Some(Self { program, words, folder: std::env::current_dir().ok() })
    }

    pub(crate) fn command(&self) -> Command {
        let mut command = Command::new(&self.program);
        command.args(&self.words);
        if let Some(folder) = &self.folder {
            command.current_dir(folder);
        }
        command
    }
}

/// Asks a layer of Mesa, which sorts adapters as wgpu does, to stay out of the process: it prints lines of its own.
#[allow(unsafe_code, reason = "drivers take this from variables only")]
fn silence_driver() {
    const LAYER: &str = "NODEVICE_SELECT";
    let is_alone = || std::fs::read_dir("/proc/self/task").is_ok_and(|tasks| tasks.count() == 1);
    if std::env::var_os(LAYER).is_none() && is_alone() {
        // SAFETY: this is the only thread, so nothing reads variables meanwhile.
        unsafe { std::env::set_var(LAYER, "1") };
    }
}

/// Starts a thread of a scope.
///
/// # Errors
/// The system has no further thread.
pub(crate) fn spawn<'scope, T: Send + 'scope>(
    scope: &'scope Scope<'scope, '_>,
    name: &str,
    work: impl FnOnce() -> T + Send + 'scope,
) -> Result<ScopedJoinHandle<'scope, T>, Failure> {
    check_room()?;
    Builder::new().name(name.to_owned()).spawn_scoped(scope, work).map_err(no_thread)
}

/// Threads that share work.
///
/// # Errors
/// The system has no further thread.
pub(crate) fn pool(name: &'static str) -> Result<ThreadPool, Failure> {
    check_room()?;
    let pool = |builder: ThreadPoolBuilder| builder.thread_name(move |index| format!("{name} {index}")).build();
    pool(ThreadPoolBuilder::new()).or_else(|_| pool(ThreadPoolBuilder::new().num_threads(1))).map_err(no_thread)
}

/// Starts rayon's global threads. Where they start by themselves and the system has no further thread, the program
/// would end.
///
/// # Errors
/// The system has no further thread.
pub(crate) fn start_threads() -> Result<(), Failure> {
    check_room()?;
    match ThreadPoolBuilder::new().build_global() {
        // Without a reason of the system, they are started already.
        Err(why) if why.source().is_some() => Err(no_thread(why)),
        _ => Ok(()),
    }
}

/// Memory for the stacks of a few threads.
const ROOM: usize = 16 << 20;

/// A thread that has no memory for the stack of its signals ends the program, so there must be some before it starts.
///
/// # Errors
/// The process has no memory for threads.
fn check_room() -> Result<(), Failure> {
    Vec::<u8>::new().try_reserve_exact(ROOM).map_err(no_thread)
}

fn no_thread(why: impl std::fmt::Display) -> Failure {
    GpuError::NoThreads { why: why.to_string() }.into()
}

#[cfg(target_os = "linux")]
#[allow(unsafe_code, reason = "the standard library handles no signals")]
mod signals {
    use std::sync::OnceLock;

    use afterimage_media::memory_limit;

    /// The message where memory is limited and the process cannot go on.
    static OUT_OF_MEMORY: OnceLock<String> = OnceLock::new();

    /// A file that becomes too large is an error of writing, not the end of the process. Where memory is limited, a
    /// driver that gets none, or this program, ends the process by a signal: it says why before.
    pub(super) fn prepare() {
        // SAFETY: the signal is ignored, so that no code runs for it.
        unsafe { libc::signal(libc::SIGXFSZ, libc::SIG_IGN) };
        let Some(limit) = memory_limit() else { return };
        OUT_OF_MEMORY.get_or_init(|| {
            format!(
                "error: the program cannot go on with {} MiB of memory\n  hint: this process may use no more (`ulimit \
                 -v`)\n",
                limit >> 20
            )
        });
        for signal in [libc::SIGABRT, libc::SIGSEGV, libc::SIGBUS] {
            // SAFETY: the handler only writes a text that is made above, and ends the process; both are safe in a
            // handler (POSIX.1-2017, 2.4.3).
            unsafe { libc::signal(signal, end as *const () as libc::sighandler_t) };
        }
    }

    extern "C" fn end(_: libc::c_int) {
        let text = OUT_OF_MEMORY.get().map_or("", String::as_str);
        // SAFETY: the pointer and the length are those of a text that is never changed.
        unsafe {
            libc::write(2, text.as_ptr().cast(), text.len());
            libc::_exit(2)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_system_without_threads_is_an_error_of_the_machine() {
        let failure = no_thread(std::io::Error::from_raw_os_error(11));
        assert_eq!(failure.status(), 2);
        assert!(failure.message().starts_with("the system has no further thread for this program: "));
    }
}
