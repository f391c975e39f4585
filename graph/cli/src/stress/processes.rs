//! Each target in a process of its own, which is this program again.
//!
//! A driver on a processor keeps every shader that it has compiled until its process ends, and a fault in a driver ends
//! the process: neither reaches the other targets.

use std::process::{Command, Output, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};

use afterimage_lab::stress::{Results, StressReport, Target};

use crate::args::stress::TARGET;
use crate::failure::Failure;
use crate::process::{Again, spawn};
use crate::progress::Bar;

/// Runs all targets, `jobs` of them at once. The report has their order.
pub(super) fn stress(again: &Again, targets: &[Target], jobs: usize) -> Result<StressReport, Failure> {
    let (next, bar) = (AtomicUsize::new(0), Bar::new(targets.len() as u64));
    let stop = |_: &Failure| next.store(targets.len(), Ordering::Relaxed);
    let work = || -> Result<Vec<(usize, Results)>, Failure> {
        let mut done = Vec::new();
        loop {
            let at = next.fetch_add(1, Ordering::Relaxed);
            let Some(target) = targets.get(at) else { return Ok(done) };
            bar.begin(&target.title);
            let mut command = again.command();
            done.push((at, results(command.env(TARGET, at.to_string()), target).inspect_err(stop)?));
            bar.advance(&target.title);
        }
    };
    let done = std::thread::scope(|scope| {
        let start = |_| spawn(scope, "target", &work).inspect_err(stop);
        let workers = (0..jobs).map(start).collect::<Result<Vec<_>, Failure>>()?;
        let join = |worker: std::thread::ScopedJoinHandle<'_, _>| worker.join().expect("a worker does not panic");
        workers.into_iter().map(join).collect::<Result<Vec<_>, Failure>>()
    });
    let mut done: Vec<(usize, Results)> = done?.concat();
    done.sort_by_key(|(at, _)| *at);
    Ok(StressReport { results: done.into_iter().map(|(_, results)| results).collect() })
}

/// The results that the process prints. One that ends without them is a failure of its target.
fn results(command: &mut Command, target: &Target) -> Result<Results, Failure> {
    let pipes = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let ran = pipes.spawn().and_then(|mut child| {
        // While this end is open, this process lives.
        let _open = child.stdin.take();
        child.wait_with_output()
    });
    let output = ran.map_err(|error| {
        Failure::machine(format!("this program cannot be started again: {error}"))
            .hint("`--jobs 1` needs no further process")
    })?;
    let printed = serde_json::from_slice(&output.stdout).ok().filter(|_| output.status.success());
    Ok(printed.unwrap_or_else(|| Results::lost(target, reason(&output))))
}

/// The exit status, and the last line of standard error.
fn reason(output: &Output) -> String {
    let text = String::from_utf8_lossy(&output.stderr);
    let last = text.lines().rfind(|line| !line.trim().is_empty());
    let last = last.map_or(String::new(), |line| format!(": {}", line.trim()));
    format!("its process ended without results, {}{last}", output.status)
}

/// Ends this process when the one that has started it is gone.
///
/// # Errors
/// The system has no further thread.
pub(super) fn end_with_parent() -> Result<(), Failure> {
    let watch = || {
        let _ = std::io::copy(&mut std::io::stdin(), &mut std::io::sink());
        std::process::exit(2);
    };
    std::thread::Builder::new().name("parent".to_owned()).spawn(watch).map(drop).map_err(Failure::machine)
}

#[cfg(all(test, unix))]
mod tests {
    use afterimage_graph::check::NoFiles;

    use super::*;

    fn of(script: &str) -> Results {
        let text = "Pipeline(inputs: { \"in\": Color }, nodes: {}, outputs: { \"out\": \"in\" })";
        let target = Target::pipeline("plain", "plain.ron", "plain.ron", text, &NoFiles).expect("a pipeline");
        results(Command::new("sh").args(["-c", script]), &target).expect("a shell starts")
    }

    #[test]
    fn a_process_that_ends_without_results_is_a_failure_of_its_target() {
        for (script, why) in [
            ("kill -SEGV $$", "signal: 11"),
            ("echo one >&2; echo 'no memory' >&2; echo >&2; exit 3", "exit status: 3: no memory"),
            ("true", "exit status: 0"),
            ("echo '{}'", "exit status: 0"),
        ] {
            let lost = of(script);
            assert_eq!((lost.title.as_str(), lost.failures.len()), ("plain", 1), "{script}");
            assert_eq!(lost.failures[0].command, "afterimage stress plain.ron");
            assert!(lost.failures[0].why.contains(why), "{script}: {}", lost.failures[0].why);
        }
    }

    #[test]
    fn results_of_a_process_are_those_that_it_prints() {
        let mut printed = of("exit 1");
        printed.cases = 17;
        let text = serde_json::to_string(&printed).expect("results are JSON");
        assert_eq!(of(&format!("echo '{text}'")).cases, 17);
        assert_eq!(of(&format!("echo '{text}'; exit 1")).cases, 0, "it has failed after that");
    }

    #[test]
    fn a_program_that_is_not_there_is_an_error() {
        let text = "Pipeline(inputs: {}, nodes: { \"scene\": DemoScene() }, outputs: { \"out\": \"scene\" })";
        let target = Target::pipeline("plain", "plain.ron", "plain.ron", text, &NoFiles).expect("a pipeline");
        let again = Again { program: "/no/such/program".into(), words: Vec::new(), folder: None };
        let failure = stress(&again, &[target.clone(), target], 2).expect_err("there is no program");
        assert!(failure.message().starts_with("this program cannot be started again: "), "{}", failure.message());
        assert_eq!(failure.status(), 2);
    }
}
