//! Runs the tests that reach a mutant, and tells whether one of them fails.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::{Command, ExitStatus, Stdio};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use crate::build::Program;

/// A test, how long it takes, and the mutants that it reaches.
pub(crate) struct Test {
    pub(crate) package: String,
    pub(crate) name: String,
    program: Program,
    time: Duration,
    reaches: BTreeSet<usize>,
}

/// The same random numbers in every run of a property.
const SEED: &str = "17";
/// Tests that take longer are left out. What they notice alone counts as not noticed.
const MAX_LENGTH: Duration = Duration::from_secs(120);

impl Test {
    /// Runs the test once, with a file for the mutants that it reaches. `None`, and a line, if it fails or takes long.
    fn traced(program: &Program, name: &str, trace: &Path) -> Option<Self> {
        let (package, name, program) = (program.package.clone(), name.to_owned(), program.clone());
        let mut test = Self { package, name, program, time: Duration::ZERO, reaches: BTreeSet::new() };
        std::fs::write(trace, "").expect("the folder can be written to");
        let begin = Instant::now();
        let status = ended(test.command().env("MUTANT_TRACE", trace), Duration::from_secs(600));
        test.time = begin.elapsed();
        let reached = std::fs::read_to_string(trace).expect("it was written");
        std::fs::remove_file(trace).expect("it was written");
        test.reaches = reached.lines().filter_map(|line| line.parse().ok()).collect();
        match status.is_some_and(|status| status.success()) {
            true if test.time < MAX_LENGTH => return Some(test),
            true => println!("{} takes {:.0} s and is left out", test.name, test.time.as_secs_f64()),
            false => println!("{} fails without a mutant and is left out", test.name),
        }
        None
    }

    fn command(&self) -> Command {
        let mut command = Command::new(&self.program.path);
        command.args(["--exact", &self.name, "--test-threads", "1"]).current_dir(&self.program.folder);
        command.env("CARGO_MANIFEST_DIR", &self.program.folder).env("PROPTEST_RNG_SEED", SEED);
        command.env("INSTA_UPDATE", "no").env("RUST_BACKTRACE", "0");
        command.stdout(Stdio::null()).stderr(Stdio::null());
        command
    }

    /// True if the test fails with a mutant, or does not end.
    fn notices(&self, number: usize) -> bool {
        let limit = 5 * self.time + Duration::from_secs(10);
        let status = ended(self.command().env("MUTANT", number.to_string()), limit);
        !status.is_some_and(|status| status.success())
    }
}

/// The end of the program; `None` after the limit. Address space is limited, because a mutant may ask for all of it.
fn ended(command: &mut Command, limit: Duration) -> Option<ExitStatus> {
    let mut child = command.spawn().expect("the test can be started");
    let begin = Instant::now();
    loop {
        if let Some(status) = child.try_wait().expect("the test can be waited for") {
            return Some(status);
        }
        if begin.elapsed() > limit {
            child.kill().expect("the test can be stopped");
            child.wait().expect("it ends");
            return None;
        }
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// Does all of a number of jobs, as many at a time as there are cores.
pub(crate) fn on_all_cores(count: usize, job: impl Fn(usize) + Sync) {
    let next = AtomicUsize::new(0);
    let work = || {
        loop {
            let at = next.fetch_add(1, Ordering::Relaxed);
            if at >= count {
                return;
            }
            job(at);
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().map_or(1, usize::from) {
            scope.spawn(work);
        }
    });
}

/// The tests of the programs, each run once without a mutant. Tests that fail then or take long are left out and
/// printed.
pub(crate) fn traced(programs: &[Program], folder: &Path) -> Vec<Test> {
    let all: Vec<(&Program, String)> =
        programs.iter().flat_map(|program| names(program).into_iter().map(move |name| (program, name))).collect();
    let tests = Mutex::new(Vec::new());
    on_all_cores(all.len(), |at| {
        let (program, name) = &all[at];
        if let Some(test) = Test::traced(program, name, &folder.join(format!("trace-{at}"))) {
            tests.lock().expect("no thread panics with it").push(test);
        }
    });
    let mut tests = tests.into_inner().expect("no thread panics with it");
    tests.sort_by_key(|test: &Test| test.time);
    tests
}

fn names(program: &Program) -> Vec<String> {
    let output =
        Command::new(&program.path).args(["--list", "--format", "terse"]).current_dir(&program.folder).output();
    let listed = output.expect("the test can be started").stdout;
    let lines = String::from_utf8_lossy(&listed).into_owned();
    lines.lines().filter_map(|line| line.strip_suffix(": test")).map(str::to_owned).collect()
}

/// The first test that notices a mutant, or why none does. Tests of its crate run first, the fast ones before the slow
/// ones.
pub(crate) fn outcome(number: usize, package: &str, tests: &[Test]) -> String {
    let reaching: Vec<&Test> = tests.iter().filter(|test| test.reaches.contains(&number)).collect();
    let (own, other): (Vec<&Test>, Vec<&Test>) = reaching.iter().partition(|test| test.package == package);
    match own.into_iter().chain(other).find(|test| test.notices(number)) {
        Some(test) => format!("noticed\t{}: {}", test.package, test.name),
        None if reaching.is_empty() => "unreached".into(),
        None => "survives".into(),
    }
}

/// The number of tests of each crate, and their time.
pub(crate) fn summary(tests: &[Test]) -> String {
    let mut by_crate: BTreeMap<&str, (usize, f64)> = BTreeMap::new();
    for test in tests {
        let (count, seconds) = by_crate.entry(&test.package).or_default();
        *count += 1;
        *seconds += test.time.as_secs_f64();
    }
    let line = |(name, (count, seconds)): (&&str, &(usize, f64))| format!("{name}: {count} tests, {seconds:.1} s\n");
    by_crate.iter().map(line).collect()
}
