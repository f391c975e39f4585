//! Figures of the code's structure.

use std::io::Write as _;
use std::process::ExitCode;

use afterimage_tidy::cycles::{cycles, describe};
use afterimage_tidy::functions::{self, Lengths};
use afterimage_tidy::lines::{self, Lines};
use afterimage_tidy::modules::Tree;
use afterimage_tidy::revision::Revision;
use afterimage_tidy::workspace::{Crate, Workspace};
use afterimage_tidy::{files, layers, licenses, packages, unsafes};

const HELP: &str = "\
afterimage-tidy layers                dependencies that break the layers of the crates
afterimage-tidy packages              library crates that need files from outside of their folder
afterimage-tidy cycles                cycles of imports in each crate
afterimage-tidy files                 files with wide lines or without a header
afterimage-tidy functions [REVISION]  lengths of functions by crate
afterimage-tidy licenses              dependencies whose license or source is not allowed
afterimage-tidy unsafe                every `unsafe` block, with its reason
afterimage-tidy lines [REVISION]      lines of code by crate

A REVISION is one of git; without it the work tree is read.
";

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    let text = match words[..] {
        [command] => answer(command, &Workspace::this()),
        [command, revision] => {
            let unpacked = Revision::unpack(&Workspace::this().root, revision);
            answer(command, &Workspace::at(unpacked.root()))
        }
        _ => None,
    };
    // A reader that went away has read enough.
    let _ = std::io::stdout().write_all(text.as_deref().unwrap_or(HELP).as_bytes());
    ExitCode::from(u8::from(text.is_none() && words != ["help"]))
}

fn answer(command: &str, workspace: &Workspace) -> Option<String> {
    Some(match command {
        "layers" => list(&layers::violations(&workspace.product().collect::<Vec<_>>())),
        "packages" => list(&packages::violations(&workspace.product().collect::<Vec<_>>())),
        "cycles" => of_cycles(workspace),
        "files" => list(&files::violations(workspace, &files::of_product(workspace))),
        "functions" => of_functions(workspace),
        "licenses" => list(&licenses::violations(workspace)),
        "unsafe" => of_unsafe(workspace),
        "lines" => of_lines(&lines::by_crate(workspace)),
        _ => return None,
    })
}

fn list(violations: &[String]) -> String {
    format!(
        "{}{} violations\n",
        violations.iter().map(|text| format!("{text}\n")).collect::<String>(),
        violations.len()
    )
}

fn of_cycles(workspace: &Workspace) -> String {
    let of_root = |root| {
        let cycles = cycles(&Tree::of(root));
        let steps: String = cycles.iter().map(|cycle| format!("{}\n\n", describe(cycle))).collect();
        format!("{}: {} cycles\n{steps}", workspace.short(root).display(), cycles.len())
    };
    workspace.product().flat_map(|member| &member.roots).map(|root| of_root(root)).collect()
}

fn of_functions(workspace: &Workspace) -> String {
    let of_crate = |member: &Crate| {
        let Lengths { count, median, percentile, long } = functions::of_crate(member);
        let mut text = format!("{:20} {count:9} {median:8} {percentile:6}\n", member.name);
        for (file, function) in long {
            let file = workspace.short(&file).display();
            text += &format!("    {file}:{}: `{}` has {} lines\n", function.line, function.name, function.lines);
        }
        text
    };
    let head = format!("{:20} functions   median   99 %\n", "crate");
    head + &workspace.product().map(of_crate).collect::<String>()
}

fn of_unsafe(workspace: &Workspace) -> String {
    let line = |one: &unsafes::Unsafe| {
        let reason = one.reason.as_deref().unwrap_or("no reason");
        format!("{}:{}: {reason}\n", one.file.display(), one.line)
    };
    unsafes::all(workspace).iter().map(line).collect()
}

fn of_lines(counts: &[(String, Lines)]) -> String {
    let line = |name: &str, code: usize, all: usize| format!("{name:20} {code:8} {all:8}\n");
    let crates: String = counts.iter().map(|(name, lines)| line(name, lines.code, lines.all)).collect();
    let sum = |part: fn(&Lines) -> usize| counts.iter().map(|(_, lines)| part(lines)).sum();
    format!(
        "{:20}     code      all\n{crates}{}",
        "crate",
        line("sum", sum(|lines| lines.code), sum(|lines| lines.all))
    )
}
