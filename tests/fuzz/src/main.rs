//! Fuzzing on any compiler: `--runs N`, `--seed N`, `--target NAME`, and `--only N` for one input again.
#![allow(clippy::print_stdout, reason = "a program of the tests says what it found")]

use std::collections::BTreeMap;
use std::panic::catch_unwind;
use std::time::{Duration, Instant};

use afterimage_fuzz::{Inputs, Target};

/// An input that takes longer than this is a fault, too.
const TOO_LONG: Duration = Duration::from_secs(2);
/// Inputs between two words of progress.
const STRIDE: u64 = 100_000;

struct Wanted {
    runs: u64,
    seed: u64,
    target: Option<Target>,
    only: Option<u64>,
}

fn wanted() -> Result<Wanted, String> {
    let mut wanted = Wanted { runs: 100_000, seed: 1, target: None, only: None };
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        let value = words.next().ok_or_else(|| format!("`{word}` needs a value"))?;
        let number = || value.parse::<u64>().map_err(|_| format!("`{value}` is not a number"));
        match word.as_str() {
            "--runs" => wanted.runs = number()?,
            "--seed" => wanted.seed = number()?,
            "--only" => wanted.only = Some(number()?),
            "--target" => {
                let found = Target::ALL.into_iter().find(|target| target.name() == value);
                wanted.target = Some(found.ok_or_else(|| format!("no target is called `{value}`"))?);
            }
            _ => return Err(format!("`{word}` is none of `--runs`, `--seed`, `--target`, `--only`")),
        }
    }
    Ok(wanted)
}

/// The results of a target.
#[derive(Default)]
struct Tally {
    accepted: u64,
    /// For each fault the number of the first input that shows it.
    faults: BTreeMap<String, u64>,
    slowest: Duration,
}

fn run(target: Target, runs: u64, seed: u64) -> Tally {
    let inputs = Inputs::new(target, seed);
    let mut tally = Tally::default();
    let begin = Instant::now();
    for number in 0..runs {
        let input = inputs.get(number);
        let begin_of_one = Instant::now();
        let fault = match catch_unwind(|| target.run(&input)) {
            Ok(accepted) => {
                tally.accepted += u64::from(accepted);
                (begin_of_one.elapsed() > TOO_LONG).then(|| "takes too long".to_owned())
            }
            Err(panic) => Some(words(panic.as_ref())),
        };
        tally.slowest = tally.slowest.max(begin_of_one.elapsed());
        if let Some(fault) = fault.filter(|fault| !tally.faults.contains_key(fault)) {
            println!("{} {number}: {fault}", target.name());
            tally.faults.insert(fault, number);
        }
        if (number + 1) % STRIDE == 0 {
            let (name, faults) = (target.name(), tally.faults.len());
            println!("{name}: {} of {runs}, {faults} faults, {:.0} s", number + 1, begin.elapsed().as_secs_f64());
        }
    }
    report(target, runs, seed, begin.elapsed(), &tally);
    tally
}

fn report(target: Target, runs: u64, seed: u64, took: Duration, tally: &Tally) {
    println!(
        "{}: {runs} executions in {:.0} s, {} accepted, the slowest {:.0} ms, {} faults",
        target.name(),
        took.as_secs_f64(),
        tally.accepted,
        tally.slowest.as_secs_f64() * 1e3,
        tally.faults.len()
    );
    for (fault, number) in &tally.faults {
        println!("  {fault}\n    again: --target {} --seed {seed} --only {number}", target.name());
    }
}

fn words(panic: &(dyn std::any::Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str).or(panic.downcast_ref::<&str>().copied());
    text.unwrap_or("panics").chars().take(200).collect()
}

fn main() {
    let wanted = match wanted() {
        Ok(wanted) => wanted,
        Err(why) => {
            println!("{why}");
            std::process::exit(2);
        }
    };
    if let (Some(target), Some(number)) = (wanted.target, wanted.only) {
        let input = Inputs::new(target, wanted.seed).get(number);
        println!("{}", String::from_utf8_lossy(&input));
        println!("{}", if target.run(&input) { "accepted" } else { "refused" });
        return;
    }
    // Each panic is reported once, at the end.
    std::panic::set_hook(Box::new(|_| {}));
    let targets = Target::ALL.into_iter().filter(|target| wanted.target.is_none_or(|wanted| wanted == *target));
    let targets: Vec<Target> = targets.collect();
    let shares: u64 = targets.iter().map(|target| target.share()).sum();
    let mut faults = 0;
    for target in targets {
        faults += run(target, wanted.runs * target.share() / shares, wanted.seed).faults.len();
    }
    std::process::exit(i32::from(faults > 0));
}
