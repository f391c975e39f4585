//! Each target in a process of its own, which is this program again.
//!
//! A driver on a processor keeps every shader that it has compiled until its process ends, and a fault in a driver ends
//! the process: neither reaches the other targets.

use std::process::{Command, Output, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};

use afterimage_lab::Progress as _;
use afterimage_lab::stress::{Results, StressReport, Target};

use crate::args::stress::TARGET;
use crate::failure::Failure;
use crate::process::{Again, spawn};
use crate::progress::Bar;

/// Runs all targets, `jobs` of them at once. The report has their order.
pub(super) fn stress(again: &Again, targets: &[Target], jobs: usize) -> Result<StressReport, Failure> {
    let (next, bar) = (AtomicUsize::new(0), Bar::new(targets.len() as u64));
    let titles: Vec<&str> = targets.iter().map(|target| target.title.as_str()).collect();
    let stop = |_: &Failure| next.store(titles.len(), Ordering::Relaxed);
    let work = || -> Result<Vec<(usize, Ran)>, Failure> {
        let mut done = Vec::new();
        loop {
            let at = next.fetch_add(1, Ordering::Relaxed);
            let Some(title) = titles.get(at) else { return Ok(done) };
            bar.begin(title);
            done.push((at, ran(again.command().env(TARGET, at.to_string())).inspect_err(stop)?));
            bar.advance(title);
        }
    };
    let done = std::thread::scope(|scope| {
        let start = |_| spawn(scope, "target", work).inspect_err(stop);
        let workers = (0..jobs).map(start).collect::<Result<Vec<_>, Failure>>()?;
        let join = |worker: std::thread::ScopedJoinHandle<'_, _>| worker.join().expect("a worker does not panic");
        workers.into_iter().map(join).collect::<Result<Vec<_>, Failure>>()
    });
    let mut done = done?.concat();
    done.sort_by_key(|(at, _)| *at);
    let results = |(at, ran): (usize, Ran)| ran.unwrap_or_else(|why| Results::lost(&targets[at], why));
    Ok(StressReport { results: done.into_iter().map(results).collect() })
}

/// The results that a process prints, or the reason why it has none.
type Ran = Result<Results, String>;

/// Runs a process to its end.
fn ran(command: &mut Command) -> Result<Ran, Failure> {
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
    Ok(printed.ok_or_else(|| reason(&output)))
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

    fn of(script: &str) -> Ran {
        ran(Command::new("sh").args(["-c", script])).expect("a shell starts")
    }

    #[test]
    fn a_process_that_ends_without_results_has_a_reason() {
        for (script, why) in [
            ("kill -SEGV $$", "signal: 11"),
            ("echo one >&2; echo 'no memory' >&2; echo >&2; exit 3", "exit status: 3: no memory"),
            ("true", "exit status: 0"),
            ("echo '{}'", "exit status: 0"),
        ] {
            let found = of(script).expect_err(script);
            assert!(found.contains(why), "{script}: {found}");
        }
    }

    #[test]
    fn results_of_a_process_are_those_that_it_prints() {
        let text = r#"{"title":"a","cases":17,"refused":0,"verdicts":{"cut":2},"failures":[],"kernel_faults":[]}"#;
        let printed = of(&format!("echo '{text}'")).expect("they are printed");
        assert_eq!((printed.cases, printed.verdicts.get("cut")), (17, Some(&2)));
        assert!(of(&format!("echo '{text}'; exit 1")).is_err(), "it has failed after that");
    }

    #[test]
    fn a_program_that_does_not_start_is_an_error_and_one_that_fails_a_result() {
        let text = "Pipeline(inputs: {}, nodes: { \"scene\": DemoScene() }, outputs: { \"out\": \"scene\" })";
        let registry = afterimage_lab::stress::registry(&[]).expect("no two kinds share a name");
        let target = Target::pipeline("plain", "plain.ron", "plain.ron", text, &registry, &NoFiles);
        let target = target.expect("a pipeline");
        let again = |program: &str, words: &[&str]| {
            let again = Again { program: program.into(), words: words.iter().map(Into::into).collect(), folder: None };
            stress(&again, &[target.clone(), target.clone()], 2)
        };
        let failure = again("/no/such/program", &[]).expect_err("there is no program");
        assert!(failure.message().starts_with("this program cannot be started again: "), "{}", failure.message());
        assert_eq!(failure.status(), 2);
        // One that has no results is a failure of each target.
        let lost = again("sh", &["-c", "exit 7"]).expect("a shell starts");
        let failures: Vec<&str> = lost.failures().map(|failed| failed.command.as_str()).collect();
        assert_eq!(failures, ["afterimage stress plain.ron"; 2]);
    }
}
