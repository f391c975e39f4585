//! Trials: runs of the scenario in which one call fails.
#![allow(clippy::print_stdout, reason = "the process that counts trials reads them")]

use std::io::Write as _;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::mpsc::channel;
use std::time::Duration;

use afterimage::host::PostError;
use afterimage_gpu::{GpuError, Texels};

use super::scenario::{self, Pipelines, Seen};
use super::vulkan::{self, Kind};

/// A run without faults takes a hundredth of it.
const HANG: Duration = Duration::from_secs(30);

/// The end of a trial, as text.
pub struct Verdict(String);

impl Verdict {
    /// True if it is the end as without the fault, or an error of the fault's kind after which the old plan runs on or
    /// says why not.
    pub fn is_good(text: &str) -> bool {
        text.starts_with("unharmed") || text.starts_with("error: ")
    }

    fn of(kind: Kind, run: Run, clean: &[(&'static str, Vec<Texels>)]) -> Self {
        let (result, seen) = match run {
            Run::Hangs => return Self("hangs".into()),
            Run::Panics(text) => return Self(format!("panics: {text}")),
            Run::Ends(result, seen) => (result, seen),
        };
        if let Some(((step, _), _)) = seen.shown.iter().zip(clean).find(|(shown, clean)| shown != clean) {
            return Self(format!("shows a wrong image after `{step}`"));
        }
        let Err(error) = result else { return Self("unharmed".into()) };
        let after = match seen.after {
            None => "before a plan",
            Some(Err(_)) => "the old plan says why not",
            Some(Ok(texels)) if clean.iter().any(|(_, known)| *known == texels) => "the old plan runs on",
            Some(Ok(_)) => return Self("shows a wrong image of the old plan".into()),
        };
        match (name(&error), kind) {
            (Some("lost"), Kind::TimeOut) | (None, _) => {
                Self(format!("reports another error: {}", error.to_string().lines().collect::<Vec<_>>().join(" ")))
            }
            (Some(name), _) => Self(format!("error: {name}, {after}")),
        }
    }
}

/// The errors that a failing call may return.
fn name(error: &PostError) -> Option<&'static str> {
    match error {
        PostError::Gpu(GpuError::OutOfMemory { .. }) => Some("out of memory"),
        PostError::Gpu(GpuError::DeviceLost { .. }) => Some("lost"),
        PostError::Gpu(GpuError::TimedOut) => Some("timed out"),
        PostError::Gpu(GpuError::NoAdapter { .. } | GpuError::NoDevice { .. }) => Some("no device"),
        _ => None,
    }
}

enum Run {
    Ends(Result<(), PostError>, Box<Seen>),
    Panics(String),
    Hangs,
}

pub struct Trials(Arc<(wgpu::Instance, Pipelines)>);

impl Trials {
    pub fn new() -> Self {
        Self(Arc::new((vulkan::instance(), Pipelines::new())))
    }

    /// The number of calls of a run without faults that could return this error.
    pub fn calls(&self, kind: Kind) -> u64 {
        vulkan::arm(kind, 0);
        self.clean();
        vulkan::disarm()
    }

    /// The objects of the driver that are there while a run without faults has its device, and after it.
    pub fn objects(&self) -> [Vec<(&'static str, i64)>; 2] {
        let Run::Ends(result, seen) = self.run() else { panic!("without a fault") };
        result.unwrap_or_else(|error| panic!("without a fault: {error}"));
        let open = vulkan::alive();
        drop(seen);
        [open, vulkan::alive()]
    }

    fn clean(&self) -> Vec<(&'static str, Vec<Texels>)> {
        match self.run() {
            Run::Ends(result, seen) => {
                result.unwrap_or_else(|error| panic!("without a fault: {error}"));
                seen.shown
            }
            Run::Panics(text) => panic!("without a fault: {text}"),
            Run::Hangs => panic!("without a fault: no end"),
        }
    }

    /// Runs the scenario. The device is still open in what is seen.
    fn run(&self) -> Run {
        let (sender, receiver) = channel();
        let stand = self.0.clone();
        let thread = std::thread::spawn(move || {
            let mut seen = Box::<Seen>::default();
            let ran = catch_unwind(AssertUnwindSafe(|| scenario::run(&stand.0, &stand.1, &mut seen)));
            let run = match ran {
                Ok(result) => Run::Ends(result, seen),
                Err(panic) => Run::Panics(text_of(&*panic)),
            };
            // The trial may have given up waiting.
            sender.send(run).ok();
        });
        let Ok(run) = receiver.recv_timeout(HANG) else { return Run::Hangs };
        // The thread may be the last that holds the instance. Closing it unloads the driver, which must not happen while
        // the process ends and runs the driver's exit handlers.
        thread.join().expect("what the scenario panics with is caught");
        run
    }

    /// Runs the trials that the text lists and prints each: its beginning, its verdict, and that its device is closed.
    pub fn tell(&self, asked: &str) {
        let mut words = asked.split(' ');
        let name = words.next().expect("the name of a kind");
        let kind = Kind::ALL.into_iter().find(|kind| format!("{kind:?}") == name).expect("a known kind");
        let clean = self.clean();
        for number in words.map(|word| word.parse().expect("the number of a call")) {
            println!("\nbegin\t{number}");
            vulkan::arm(kind, number);
            let mut run = self.run();
            let gpu = if let Run::Ends(_, seen) = &mut run { seen.gpu.take() } else { None };
            let verdict = Verdict::of(kind, run, &clean);
            println!("ran\t{}\t{}", vulkan::failed().unwrap_or("no call"), verdict.0);
            // Closing may end the process.
            std::io::stdout().flush().expect("the parent reads");
            let is_closed = catch_unwind(AssertUnwindSafe(|| drop(gpu))).is_ok();
            vulkan::disarm();
            if is_closed {
                println!("closed\t");
            }
        }
    }
}

fn text_of(panic: &(dyn std::any::Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    let text = text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or_default();
    text.lines().take(6).collect::<Vec<_>>().join(" ")
}
