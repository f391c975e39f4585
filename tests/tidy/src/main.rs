//! Figures of the code's structure.

use std::io::Write as _;
use std::path::Path;
use std::process::ExitCode;

use afterimage_tidy::cycles::{cycles, describe};
use afterimage_tidy::flows::{Figures, Flow};
use afterimage_tidy::functions::{self, Lengths};
use afterimage_tidy::lines::{self, Lines};
use afterimage_tidy::modules::Tree;
use afterimage_tidy::revision::Revision;
use afterimage_tidy::words::Words;
use afterimage_tidy::workspace::{Crate, Workspace, files_in, read};
use afterimage_tidy::{files, layers, licenses, packages, unsafes, words};

const HELP: &str = "\
afterimage-tidy layers                dependencies that break the layers of the crates
afterimage-tidy packages              library crates that need files from outside of their folder
afterimage-tidy cycles                cycles of imports in each crate
afterimage-tidy files                 files that are too long or too wide
afterimage-tidy functions [REVISION]  lengths of functions by crate
afterimage-tidy licenses              dependencies whose license or source is not allowed
afterimage-tidy unsafe                every `unsafe` block, with its reason
afterimage-tidy words                 words that the glossary replaces
afterimage-tidy flows [REVISION]      files and returns of the flows in tests/tidy/flows or tests/tidy/flows/REVISION
afterimage-tidy lines [REVISION]      lines of code by crate

A REVISION is one of git; without it the work tree is read.
";

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    let text = match words[..] {
        [command] => answer(command, &Workspace::this(), ""),
        [command, revision] => {
            let unpacked = Revision::unpack(&Workspace::this().root, revision);
            answer(command, &Workspace::at(unpacked.root()), revision)
        }
        _ => None,
    };
    // A reader that went away has read enough.
    let _ = std::io::stdout().write_all(text.as_deref().unwrap_or(HELP).as_bytes());
    ExitCode::from(u8::from(text.is_none() && words != ["help"]))
}

fn answer(command: &str, workspace: &Workspace, revision: &str) -> Option<String> {
    Some(match command {
        "layers" => list(&layers::violations(&workspace.product().collect::<Vec<_>>())),
        "packages" => list(&packages::violations(&workspace.product().collect::<Vec<_>>())),
        "cycles" => of_cycles(workspace),
        "files" => list(&files::violations(workspace, &files::of_product(workspace))),
        "functions" => of_functions(workspace),
        "words" => {
            let Words { replaced, pending } = Words::this();
            list(&words::violations(workspace, &[replaced, pending].concat()))
        }
        "licenses" => list(&licenses::violations(workspace)),
        "unsafe" => of_unsafe(workspace),
        "flows" => of_flows(workspace, &Workspace::this().root.join("tests/tidy/flows").join(revision)),
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
        let Lengths { count, median, percentile, long, excess } = functions::of_crate(member);
        let mut text = format!("{:20} {count:9} {median:8} {percentile:6} {excess:7}\n", member.name);
        for (file, function) in long {
            let file = workspace.short(&file).display();
            text += &format!("    {file}:{}: `{}` has {} lines\n", function.line, function.name, function.lines);
        }
        text
    };
    let head = format!("{:20} functions   median   99 %  excess\n", "crate");
    head + &workspace.product().map(of_crate).collect::<String>()
}

fn of_unsafe(workspace: &Workspace) -> String {
    let line = |one: &unsafes::Unsafe| {
        let reason = one.reason.as_deref().unwrap_or("no reason");
        format!("{}:{}: {reason}\n", one.file.display(), one.line)
    };
    unsafes::all(workspace).iter().map(line).collect()
}

fn of_flows(workspace: &Workspace, folder: &Path) -> String {
    let of_file = |file: &Path| {
        let flow = Flow::parse(&read(file));
        let Figures { stations, files, returns } = flow.figures();
        let name = file.file_name().unwrap_or_default().display();
        let stays: String = flow.stays().lines().map(|stay| format!("    {stay}\n")).collect();
        let faults: String = flow.violations(&workspace.root).iter().map(|fault| format!("  {fault}\n")).collect();
        format!("{name}: {stations} functions, {files} files, {returns} returns\n{stays}{faults}")
    };
    let files = files_in(folder, &["txt"]);
    files.iter().filter(|file| file.parent() == Some(folder)).map(|file| of_file(file)).collect()
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
