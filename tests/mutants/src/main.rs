//! Mutants of the pure crates, and whether a test notices them: `tests/mutants.sh`.
//!
//! The mutants are those of `cargo mutants --list`. All of a sample are compiled at once, each behind a condition on its
//! number, and each test is run once to see which of them it reaches. A mutant then costs only the tests that reach it,
//! and no compilation.
#![allow(clippy::print_stdout, reason = "a tool for the command line")]

mod build;
mod list;
mod report;
mod run;
mod sites;
mod weave;

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use build::{CRATES, Tree};
use list::Mutant;
use report::Report;
use run::{Outcome, summary, traced};

/// The seed of the order of mutants.
const SEED: u64 = 17;

fn main() {
    let words: Vec<usize> = std::env::args().skip(1).map(|word| word.parse().expect("a number")).collect();
    let [from, count] = words[..] else { panic!("two numbers: the first mutant of the sample, and how many") };
    let folder = std::env::current_dir().expect("there is a folder").join("target/mutants");
    std::fs::create_dir_all(&folder).expect("the folder can be made");
    let packages = CRATES.map(|(name, _)| name);
    let all = list::shuffled(&packages, SEED);
    let sample: Vec<Mutant> = all.iter().skip(from).take(count).cloned().collect();
    println!("{} of {} mutants, from {from} on", sample.len(), all.len());
    let results = folder.join(format!("results-{from}.tsv"));
    run_sample(&folder, &sample, &results);
    print!("{}", Report::read(&results, &sample));
}

/// Runs the mutants that the table of results does not have yet.
fn run_sample(folder: &Path, sample: &[Mutant], results: &PathBuf) {
    let tree = Tree::copy(folder);
    let refused = tree.weave(sample);
    let tests = traced(&tree.programs(), folder);
    print!("{}", summary(&tests));
    let mut known = std::fs::read_to_string(results).unwrap_or_default();
    for (number, mutant) in sample.iter().enumerate() {
        if known.lines().any(|line| line.split('\t').next() == Some(&mutant.name)) {
            continue;
        }
        let outcome = match refused.contains(&number) {
            true => "refused".to_owned(),
            false => Outcome::of(number, &mutant.package, &tests).text(),
        };
        println!("{number} {} {outcome}", mutant.name);
        writeln!(known, "{}\t{outcome}", mutant.name).expect("a text has room");
        std::fs::write(results, &known).expect("the folder can be written to");
    }
}
