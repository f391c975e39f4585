//! Mutants of the pure crates, and whether a test notices them: `tests/mutants.sh`.
//!
//! The mutants are those of `cargo mutants --list`. All of a sample are compiled at once, each behind a condition on
//! its number, and each test is run once to see which of them it reaches. A mutant then costs only the tests that reach
//! it, and no compilation.
#![allow(clippy::print_stdout, reason = "a tool for the command line")]

mod build;
mod faults;
mod list;
mod report;
mod run;
mod sites;
mod weave;

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::Path;

use build::{Crates, GROUPS, PURE, Tree, WITH_GPU};
use list::Mutant;
use report::Report;
use run::{Test, outcome, summary, traced};

/// The seed of the order of mutants.
const SEED: u64 = 17;

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let here = std::env::current_dir().expect("there is a folder");
    let folder = |name: &str| {
        let folder = here.join("target/mutants").join(name);
        std::fs::create_dir_all(&folder).expect("the folder can be made");
        folder
    };
    match words.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["sample", from, count] => sample(&folder("pure"), number(from), number(count)),
        ["faults", "planner"] => seeded(&folder("pure"), "planner", &PURE, &[""]),
        ["faults", "gpu"] => seeded(&folder("gpu"), "gpu", &WITH_GPU, GROUPS),
        _ => panic!("`sample FIRST COUNT`, `faults planner` or `faults gpu`"),
    }
}

fn number(word: &str) -> usize {
    word.parse().unwrap_or_else(|error| panic!("`{word}`: {error}"))
}

/// Runs a sample of the mutants of the pure crates.
fn sample(folder: &Path, from: usize, count: usize) {
    let packages = PURE.map(|(name, _)| name);
    let all = list::shuffled(&packages, SEED);
    let sample: Vec<Mutant> = all.iter().skip(from).take(count).cloned().collect();
    println!("{} of {} mutants, from {from} on", sample.len(), all.len());
    let tree = Tree::copy(folder, &PURE);
    let refused = tree.weave(&sample);
    let tests = traced(&tree.programs(), folder, &[""]);
    let results = folder.join(format!("results-{from}.tsv"));
    run(&sample, &refused, &tests, &results);
    print!("{}", Report::read(&results, &sample));
}

/// Runs the faults of a list.
fn seeded(folder: &Path, list: &str, crates: &'static Crates, groups: &[&str]) {
    let faults = faults::read(&format!("tests/mutants/{list}.txt"));
    println!("{} faults", faults.len());
    let tree = Tree::copy(folder, crates);
    tree.seed(&faults);
    let tests = traced(&tree.programs(), folder, groups);
    let mutants: Vec<Mutant> = faults.iter().map(faults::Fault::mutant).collect();
    let results = folder.join("results-faults.tsv");
    run(&mutants, &BTreeSet::new(), &tests, &results);
    print!("{}", Report::read(&results, &mutants));
}

/// Runs the mutants that the table of results does not have yet.
fn run(mutants: &[Mutant], refused: &BTreeSet<usize>, tests: &[Test], results: &Path) {
    print!("{}", summary(tests));
    let mut known = std::fs::read_to_string(results).unwrap_or_default();
    for (number, mutant) in mutants.iter().enumerate() {
        if known.lines().any(|line| line.split('\t').next() == Some(&mutant.name)) {
            continue;
        }
        let outcome = match refused.contains(&number) {
            true => "refused".to_owned(),
            false => outcome(number, &mutant.package, tests),
        };
        println!("{number} {}\t{outcome}", mutant.name);
        writeln!(known, "{}\t{outcome}", mutant.name).expect("a string grows");
        std::fs::write(results, &known).expect("the folder can be written to");
    }
}
