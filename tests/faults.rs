//! Calls of the driver that fail, one after another: each is an error or changes nothing, and the old plan runs on or
//! says why not.
//!
//! All calls: `AFTERIMAGE_FAULTS=all cargo test -p afterimage-tests faults:: -- --nocapture`. The runs are in processes
//! of their own, because wgpu 30 does not close a device properly after some of these errors.
#![allow(clippy::print_stdout, reason = "the report of the trials")]

mod limits;
mod scenario;
mod trial;
mod vulkan;

use std::collections::BTreeMap;
use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};

use trial::{Trials, Verdict};
use vulkan::Kind;

/// Tells a process which calls fail: the name of the kind and the numbers.
const CHILD: &str = "AFTERIMAGE_FAULTS_CHILD";

/// About how many calls of each kind fail in an ordinary test.
const SAMPLES: u64 = 10;

/// Calls that fail for a kind of error, all of them if the environment says so.
fn numbers(calls: u64) -> Vec<u64> {
    let is_all = std::env::var("AFTERIMAGE_FAULTS").is_ok_and(|asked| asked == "all");
    let step = if is_all { 1 } else { (calls / SAMPLES).max(1) };
    (1..=calls).step_by(step as usize).collect()
}

/// The results of the trials of all kinds.
#[derive(Default)]
struct Report {
    /// For each kind and verdict the number of trials.
    counts: BTreeMap<(String, String), u64>,
    bad: Vec<String>,
    /// Devices that wgpu could not close after the error was reported, by the call that failed.
    unclosed: BTreeMap<String, u64>,
}

/// A trial as its process tells it.
#[derive(Default)]
struct Trial {
    number: u64,
    call: String,
    verdict: Option<String>,
    is_closed: bool,
}

impl Report {
    /// Runs the trials of a kind, in one process after another: a trial that ends a process is the last of it.
    fn run(&mut self, kind: Kind, numbers: &[u64]) {
        let mut rest = numbers;
        while !rest.is_empty() {
            let ended = tell(kind, rest);
            assert!(!ended.is_empty(), "the process of {kind:?} {} tells nothing", rest[0]);
            ended.iter().for_each(|trial| self.count(kind, trial));
            rest = &rest[ended.len()..];
        }
    }

    fn count(&mut self, kind: Kind, trial: &Trial) {
        let verdict = trial.verdict.clone().unwrap_or_else(|| "the process ends".into());
        if !trial.verdict.as_ref().is_some_and(|verdict| Verdict::is_good(verdict)) {
            self.bad.push(format!("{kind:?} {} {}: {verdict}", trial.number, trial.call));
        } else if !trial.is_closed {
            *self.unclosed.entry(trial.call.clone()).or_default() += 1;
        }
        *self.counts.entry((format!("{kind:?}"), verdict)).or_default() += 1;
    }

    fn print(&self) {
        for ((kind, verdict), count) in &self.counts {
            println!("{count:6} {kind}: {verdict}");
        }
        for (call, count) in &self.unclosed {
            println!("{count:6} devices that wgpu could not close after {call}");
        }
    }
}

/// The trials of a process until it ends, the last one perhaps in the middle.
fn tell(kind: Kind, numbers: &[u64]) -> Vec<Trial> {
    let list: Vec<String> = numbers.iter().map(u64::to_string).collect();
    let program = std::env::current_exe().expect("the test knows its file");
    let mut child = Command::new(program)
        .args(["faults::each_call_of_the_driver_may_fail", "--exact", "--nocapture"])
        .env(CHILD, format!("{kind:?} {}", list.join(" ")))
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .expect("the test can run itself");
    let lines = BufReader::new(child.stdout.take().expect("it is piped")).lines();
    let mut all: Vec<Trial> = Vec::new();
    for line in lines.map_while(Result::ok) {
        match line.split_once('\t') {
            Some(("begin", number)) => {
                all.push(Trial { number: number.parse().expect("a number"), ..Trial::default() });
            }
            Some(("ran", text)) => {
                let last = all.last_mut().expect("it has begun");
                let (call, verdict) = text.split_once('\t').expect("a call and a verdict");
                (last.call, last.verdict) = (call.to_owned(), Some(verdict.to_owned()));
            }
            Some(("closed", _)) => all.last_mut().expect("it has begun").is_closed = true,
            _ => {}
        }
    }
    child.wait().expect("the process has ended");
    all
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn each_call_of_the_driver_may_fail() {
    let trials = Trials::new();
    if let Ok(asked) = std::env::var(CHILD) {
        return trials.tell(&asked);
    }
    let mut report = Report::default();
    for kind in Kind::ALL {
        let calls = trials.calls(kind);
        let numbers = numbers(calls);
        println!("{kind:?}: {calls} calls, {} fail", numbers.len());
        report.run(kind, &numbers);
    }
    report.print();
    assert!(report.counts.len() > Kind::ALL.len(), "each kind has more than one end: {:?}", report.counts);
    assert!(report.bad.is_empty(), "{}", report.bad.join("\n"));
    let known = |call: &&String| !UNCLOSED.contains(&call.as_str());
    assert_eq!(report.unclosed.keys().find(known), None, "wgpu closes the device after other errors");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn what_a_device_has_made_is_destroyed_with_it() {
    const NAME: &str = "faults::what_a_device_has_made_is_destroyed_with_it";
    if std::env::var(CHILD).is_err() {
        // In a process of its own: the numbers are those of the process.
        let program = std::env::current_exe().expect("the test knows its file");
        let ran = Command::new(program).args([NAME, "--exact"]).env(CHILD, NAME).output().expect("it runs itself");
        assert!(ran.status.success(), "{}", String::from_utf8_lossy(&ran.stdout));
        return;
    }
    let [open, closed] = Trials::new().objects();
    let of = |name: &str| open.iter().find(|(known, _)| *known == name).expect("it is counted").1;
    assert!(of("vkAllocateMemory") > 0 && of("vkCreateBuffer") > 0, "the device is open: {open:?}");
    assert!(closed.iter().all(|(_, count)| *count == 0), "{closed:?}");
}

/// wgpu 30.0.1 does not close a device after an error of these calls: it asserts that an encoder is open, or destroys
/// what belongs to the device after it. No call fails before the end where the fault comes while the device is closed.
const UNCLOSED: &[&str] = &["vkCreateSemaphore", "vkEndCommandBuffer", "no call"];
