//! Hostile input, given to the program: `afterimage-hostile PROGRAM [--class NAME] [--only N] [--share PERCENT]
//! [--seed N] [--jobs N] [--markdown FILE]`. What each case is given follows from the seed and its number.
#![allow(clippy::print_stdout, reason = "a program of the tests says what it found")]

mod cameras;
mod case;
mod classes;
mod frames;
mod images;
mod lines;
mod outcome;
mod places;
mod shaders;
mod table;
mod texts;

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

use classes::{Class, Sources, classes};
use outcome::{Outcome, run};
use table::{Row, markdown};

struct Wanted {
    program: PathBuf,
    class: Option<String>,
    only: Option<u64>,
    share: u64,
    seed: u64,
    jobs: usize,
    markdown: Option<PathBuf>,
}

fn wanted() -> Result<Wanted, String> {
    let mut words = std::env::args().skip(1);
    let program = words.next().ok_or("the path of the program is missing")?;
    let program = Path::new(&program).canonicalize().map_err(|error| format!("{program}: {error}"))?;
    let mut wanted = Wanted { program, class: None, only: None, share: 100, seed: 1, jobs: 2, markdown: None };
    while let Some(word) = words.next() {
        let value = words.next().ok_or_else(|| format!("`{word}` needs a value"))?;
        let number = || value.parse::<u64>().map_err(|_| format!("`{value}` is not a number"));
        match word.as_str() {
            "--class" => wanted.class = Some(value),
            "--only" => wanted.only = Some(number()?),
            "--share" => wanted.share = number()?,
            "--seed" => wanted.seed = number()?,
            "--jobs" => wanted.jobs = number()?.max(1) as usize,
            "--markdown" => wanted.markdown = Some(value.into()),
            _ => return Err(format!("`{word}` is no option")),
        }
    }
    Ok(wanted)
}

fn main() -> ExitCode {
    let wanted = match wanted() {
        Ok(wanted) => wanted,
        Err(why) => {
            println!("{why}");
            return ExitCode::from(2);
        }
    };
    let sources = Sources::new(wanted.seed);
    let chosen = classes().into_iter().filter(|class| wanted.class.as_deref().is_none_or(|name| name == class.name));
    let rows: Vec<Row> = chosen.map(|class| of_class(&class, &sources, &wanted)).collect();
    if let Some(path) = &wanted.markdown {
        std::fs::write(path, markdown(&rows)).expect("the table can be written");
    }
    let faults: u64 = rows.iter().map(Row::faults).sum();
    println!("{} cases, {faults} faults", rows.iter().map(Row::cases).sum::<u64>());
    ExitCode::from(u8::from(faults > 0))
}

/// Runs the cases of a class, several at a time.
fn of_class(class: &Class, sources: &Sources, wanted: &Wanted) -> Row {
    let (row, next) = (Mutex::new(Row::new(class)), AtomicU64::new(wanted.only.unwrap_or(0)));
    let end = wanted.only.map_or((class.cases * wanted.share).div_ceil(100), |only| only + 1);
    let root = std::env::temp_dir().join(format!("afterimage-hostile-{}", std::process::id()));
    std::thread::scope(|scope| {
        for job in 0..wanted.jobs {
            let (row, next, folder) = (&row, &next, root.join(job.to_string()));
            scope.spawn(move || {
                while let Some(number) = Some(next.fetch_add(1, Ordering::Relaxed)).filter(|number| *number < end) {
                    let outcome = of_case(class, sources, wanted, number, &folder);
                    row.lock().unwrap_or_else(PoisonError::into_inner).add(
                        number,
                        outcome.verdict,
                        outcome.seconds,
                        outcome.megabytes,
                    );
                }
            });
        }
    });
    // Unpacked cases are of no more use.
    let _ = std::fs::remove_dir_all(&root);
    let row = row.into_inner().unwrap_or_else(PoisonError::into_inner);
    println!("{}", row.line());
    row
}

fn of_case(class: &Class, sources: &Sources, wanted: &Wanted, number: u64, folder: &Path) -> Outcome {
    let _ = std::fs::remove_dir_all(folder);
    let case = (class.make)(sources, number);
    let outcome = run(&wanted.program, &case, folder, class.budget)
        .unwrap_or_else(|error| panic!("{} {number} cannot be run: {error}", class.name));
    if outcome.verdict.is_fault() || wanted.only.is_some() {
        let printed: String = outcome.printed.chars().take(1500).collect();
        println!("{} {number}: {:?}, {:.2} s, {} MB", class.name, outcome.verdict, outcome.seconds, outcome.megabytes);
        println!("  again: --class {} --seed {} --only {number}", class.name, wanted.seed);
        println!("  words: {:?}\n  {printed:?}", case.words());
    }
    outcome
}
