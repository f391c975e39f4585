//! The outcome of a case: the program runs in a process of its own, with limits on its time and memory.

use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{Cursor, Result};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use afterimage_media::codec::decode;
use afterimage_media::{Picture, Pixels};

use crate::case::Case;

/// A process that runs longer is stopped.
const MAX_LENGTH: Duration = Duration::from_secs(60);
/// A process with more memory is stopped, in MB.
const MAX_MEGABYTES: u64 = 6000;
/// Between two looks at the process.
const PAUSE: Duration = Duration::from_millis(2);

/// The limits of a case.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Budget {
    /// Processor time, in seconds.
    pub(crate) seconds: f64,
    /// The most memory at once, in MB.
    pub(crate) megabytes: u64,
}

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Verdict {
    /// With a result.
    Good,
    /// With status 1 and a message, or with status 2 and that of the system.
    Refused,
    /// By a signal: a failed assertion, no memory, a stack that ran over, a segmentation fault.
    Abort,
    Panic,
    /// It was stopped after [`MAX_LENGTH`].
    Hang,
    OverBudget,
    /// With another status, without a message, with control characters, with a file that nobody asked for, or with an
    /// image that has a number which is not finite.
    Unclean,
}

impl Verdict {
    pub(crate) const ALL: [Self; 7] =
        [Self::Good, Self::Refused, Self::Abort, Self::Panic, Self::Hang, Self::OverBudget, Self::Unclean];

    pub(crate) fn is_fault(self) -> bool {
        !matches!(self, Self::Good | Self::Refused)
    }
}

/// The cost of a run, and its end.
pub(crate) struct Outcome {
    pub(crate) verdict: Verdict,
    pub(crate) seconds: f64,
    pub(crate) megabytes: u64,
    /// What it printed.
    pub(crate) printed: String,
}

/// The end of a process.
struct End {
    status: i32,
    seconds: f64,
    megabytes: u64,
    is_stopped: bool,
}

/// Runs the program on a case in `folder`, which is empty.
pub(crate) fn run(program: &Path, case: &Case, folder: &Path, budget: Budget) -> Result<Outcome> {
    let (inner, printed) = (folder.join("in"), folder.join("printed"));
    fs::create_dir_all(&inner)?;
    case.unpack(&inner)?;
    let before = names(&inner)?;
    let mut command = Command::new(program);
    command.args(case.words()).current_dir(&inner).env("XDG_CACHE_HOME", folder.with_extension("cache"));
    command.env("XDG_RUNTIME_DIR", folder);
    let file = File::create(&printed)?;
    command.stdin(Stdio::null()).stdout(file.try_clone()?).stderr(file);
    let end = wait(command.spawn()?)?;
    let mut printed = String::from_utf8_lossy(&fs::read(&printed)?).into_owned();
    let mut verdict = verdict(&end, &printed, names(&inner)? == before, budget);
    if verdict == Verdict::Good {
        for name in ["out.exr", "far.exr"] {
            if let Some(why) = wrong(&inner.join(name)) {
                verdict = Verdict::Unclean;
                printed += &format!("{name}: {why}\n");
            }
        }
    }
    Ok(Outcome { verdict, seconds: end.seconds, megabytes: end.megabytes, printed })
}

/// The fault of an image that was written: it cannot be read, or has a number that is not finite. Nothing if none
/// was written.
fn wrong(path: &Path) -> Option<String> {
    let bytes = fs::read(path).ok()?;
    let length = bytes.len();
    let is_finite = match decode(Cursor::new(bytes), None, afterimage_media::Budget(1 << 30)) {
        Ok(Picture { pixels: Pixels::Half(numbers), .. }) => numbers.iter().all(|number| number.is_finite()),
        Ok(Picture { pixels: Pixels::Float(numbers), .. }) => numbers.iter().all(|number| number.is_finite()),
        Err(error) => return Some(format!("{length} bytes cannot be read: {error}")),
    };
    (!is_finite).then(|| "a number is not finite".to_owned())
}

fn names(folder: &Path) -> Result<Vec<OsString>> {
    let mut names: Vec<OsString> = fs::read_dir(folder)?.flatten().map(|entry| entry.file_name()).collect();
    names.sort();
    Ok(names)
}

fn verdict(end: &End, printed: &str, nothing_is_written: bool, budget: Budget) -> Verdict {
    let is_clean = printed.chars().all(|c| matches!(c, '\n' | '\t') || !c.is_control());
    let is_refused = is_clean && nothing_is_written && printed.contains("error");
    if end.is_stopped {
        return if end.megabytes > MAX_MEGABYTES { Verdict::OverBudget } else { Verdict::Hang };
    }
    if printed.contains("panicked at") {
        return Verdict::Panic;
    }
    if !libc::WIFEXITED(end.status) {
        return Verdict::Abort;
    }
    match libc::WEXITSTATUS(end.status) {
        101 => Verdict::Panic,
        _ if end.seconds > budget.seconds || end.megabytes > budget.megabytes => Verdict::OverBudget,
        0 if is_clean => Verdict::Good,
        1 if is_refused => Verdict::Refused,
        // The system could not read or write something.
        2 if is_refused && printed.contains("(os error") => Verdict::Refused,
        _ => Verdict::Unclean,
    }
}

fn wait(mut child: Child) -> Result<End> {
    let (start, status) = (Instant::now(), PathBuf::from(format!("/proc/{}/status", child.id())));
    let (mut is_stopped, mut seen) = (false, 0);
    loop {
        if let Some((status, usage)) = ended(child.id()) {
            let seconds = |time: libc::timeval| time.tv_sec as f64 + time.tv_usec as f64 * 1e-6;
            // A child starts with about the most memory of its parent in its account.
            let counted = usage.ru_maxrss as u64 * 1024 / 1_000_000;
            let megabytes = if counted > 2 * peak(Path::new("/proc/self/status")) { counted } else { seen };
            return Ok(End {
                status,
                seconds: seconds(usage.ru_utime) + seconds(usage.ru_stime),
                megabytes,
                is_stopped,
            });
        }
        seen = seen.max(peak(&status));
        if start.elapsed() > MAX_LENGTH || seen > MAX_MEGABYTES {
            child.kill()?;
            is_stopped = true;
        }
        std::thread::sleep(PAUSE);
    }
}

/// The most memory that a process has had, in MB.
fn peak(status: &Path) -> u64 {
    let text = fs::read_to_string(status).unwrap_or_default();
    let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap_or_default();
    let kilobytes: u64 = line.trim().trim_end_matches("kB").trim().parse().unwrap_or(0);
    kilobytes * 1024 / 1_000_000
}

/// The status of a child that has ended, and what it took.
#[allow(unsafe_code, reason = "the standard library does not tell what a child took")]
fn ended(process: u32) -> Option<(i32, libc::rusage)> {
    let mut status = 0;
    // SAFETY: all zeros are a value of `rusage`, which has whole numbers only. `wait4` writes to the two places that it
    // is given, and the process is a child that nothing else waits for.
    unsafe {
        let mut usage = std::mem::zeroed();
        let found = libc::wait4(process as libc::pid_t, &raw mut status, libc::WNOHANG, &raw mut usage);
        (found == process as libc::pid_t).then_some((status, usage))
    }
}
