//! Runs the tests that reach a mutant, and tells whether one of them fails.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::{Command, ExitStatus, Stdio};
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

impl Test {
    fn command(&self) -> Command {
        let mut command = Command::new(&self.program.path);
        command.args(["--exact", &self.name, "--test-threads", "1"]).current_dir(&self.program.folder);
        command.env("CARGO_MANIFEST_DIR", &self.program.folder).env("PROPTEST_RNG_SEED", SEED);
        command.env("INSTA_UPDATE", "no").env("RUST_BACKTRACE", "0");
        command.stdout(Stdio::null()).stderr(Stdio::null());
        command
    }

    /// Whether the test fails with a mutant, or does not end.
    fn notices(&self, number: usize) -> bool {
        let limit = 5 * self.time + Duration::from_secs(10);
        let status = ended(self.command().env("MUTANT", number.to_string()), limit);
        !status.is_some_and(|status| status.success())
    }
}

/// How the program ended; `None` after the limit. Address space is limited, because a mutant may ask for all of it.
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

/// All tests of the programs, each run once without a mutant. Tests that fail then are left out and printed.
pub(crate) fn traced(programs: &[Program], folder: &Path) -> Vec<Test> {
    let mut tests = Vec::new();
    for program in programs {
        for name in names(program) {
            let mut test = Test {
                package: program.package.clone(),
                name,
                program: program.clone(),
                time: Duration::ZERO,
                reaches: BTreeSet::new(),
            };
            let trace = folder.join("trace");
            std::fs::write(&trace, "").expect("the folder can be written to");
            let begin = Instant::now();
            let status = ended(test.command().env("MUTANT_TRACE", &trace), Duration::from_secs(600));
            test.time = begin.elapsed();
            let reached = std::fs::read_to_string(&trace).expect("it was written");
            test.reaches = reached.lines().filter_map(|line| line.parse().ok()).collect();
            if status.is_some_and(|status| status.success()) {
                tests.push(test);
            } else {
                println!("{} fails without a mutant and is left out", test.name);
            }
        }
    }
    tests.sort_by_key(|test| test.time);
    tests
}

fn names(program: &Program) -> Vec<String> {
    let output =
        Command::new(&program.path).args(["--list", "--format", "terse"]).current_dir(&program.folder).output();
    let listed = output.expect("the test can be started").stdout;
    let lines = String::from_utf8_lossy(&listed).into_owned();
    lines.lines().filter_map(|line| line.strip_suffix(": test")).map(str::to_owned).collect()
}

/// What happened to a mutant.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Outcome {
    /// A test of its crate notices it.
    Own(String),
    /// A test of another pure crate notices it.
    Other(String),
    /// Tests reach it and pass.
    Survives,
    /// No test reaches it.
    Unreached,
}

impl Outcome {
    pub(crate) fn of(number: usize, package: &str, tests: &[Test]) -> Self {
        let reaching: Vec<&Test> = tests.iter().filter(|test| test.reaches.contains(&number)).collect();
        let (own, other): (Vec<&Test>, Vec<&Test>) = reaching.iter().partition(|test| test.package == package);
        let notices = |tests: &[&Test]| tests.iter().find(|test| test.notices(number)).map(|test| test.name.clone());
        if let Some(name) = notices(&own) {
            return Self::Own(name);
        }
        match notices(&other) {
            Some(name) => Self::Other(name),
            None if reaching.is_empty() => Self::Unreached,
            None => Self::Survives,
        }
    }

    pub(crate) fn text(&self) -> String {
        match self {
            Self::Own(test) => format!("own {test}"),
            Self::Other(test) => format!("other {test}"),
            Self::Survives => "survives".into(),
            Self::Unreached => "unreached".into(),
        }
    }
}

/// How many tests each crate has, and how long they take.
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
