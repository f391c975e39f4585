//! Figures of the code's structure.
#![allow(clippy::print_stdout, reason = "a program that prints figures")]

use std::process::ExitCode;

use afterimage_tidy::cycles::{cycles, describe};
use afterimage_tidy::flows::{Figures, Flow};
use afterimage_tidy::functions::{self, Lengths};
use afterimage_tidy::lines::{self, Lines};
use afterimage_tidy::modules::Tree;
use afterimage_tidy::workspace::{Workspace, files_in, read};
use afterimage_tidy::{files, layers, words};

const HELP: &str = "\
afterimage-tidy layers            dependencies that break the layers of the crates
afterimage-tidy cycles            cycles of imports in each crate
afterimage-tidy files             files that are too long or too wide
afterimage-tidy functions         lengths of functions by crate
afterimage-tidy words             words that the glossary replaces
afterimage-tidy flows             files and returns of each flow in tests/tidy/flows
afterimage-tidy lines [REVISION]  lines of code by crate, of the work tree or of a revision of git";

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    let workspace = Workspace::this();
    match words[..] {
        ["layers"] => print_all(&layers::violations(&workspace.product().collect::<Vec<_>>())),
        ["cycles"] => print_cycles(&workspace),
        ["files"] => print_all(&files::violations(&workspace, &files::of_product(&workspace))),
        ["functions"] => print_functions(&workspace),
        ["words"] => print_all(&words::violations(&workspace, &[words::REPLACED, words::PENDING].concat())),
        ["flows"] => print_flows(&workspace),
        ["lines"] => print_lines(&lines::by_crate(&workspace)),
        ["lines", revision] => print_lines(&lines::at_revision(&workspace, revision)),
        _ => {
            println!("{HELP}");
            return ExitCode::from(u8::from(words != ["help"]));
        }
    }
    ExitCode::SUCCESS
}

fn print_all(violations: &[String]) {
    violations.iter().for_each(|violation| println!("{violation}"));
    println!("{} violations", violations.len());
}

fn print_cycles(workspace: &Workspace) {
    for root in workspace.product().flat_map(|member| &member.roots) {
        let cycles = cycles(&Tree::of(root));
        println!("{}: {} cycles", workspace.short(root).display(), cycles.len());
        cycles.iter().for_each(|cycle| println!("{}\n", describe(cycle)));
    }
}

fn print_functions(workspace: &Workspace) {
    println!("{:24} functions   median   99 %", "crate");
    for member in workspace.product() {
        let Lengths { count, median, percentile, long } = functions::of_crate(member);
        println!("{:24} {count:9} {median:8} {percentile:6}", member.name);
        for (file, function) in long {
            let file = workspace.short(&file).display();
            println!("    {file}:{}: `{}` has {} lines", function.line, function.name, function.lines);
        }
    }
}

fn print_flows(workspace: &Workspace) {
    for file in files_in(&workspace.root.join("tests/tidy/flows"), &["txt"]) {
        let flow = Flow::parse(&read(&file));
        let Figures { stations, files, returns } = flow.figures();
        println!("{}: {stations} functions, {files} files, {returns} returns", workspace.short(&file).display());
        flow.stays().lines().for_each(|stay| println!("    {stay}"));
        flow.violations(&workspace.root).iter().for_each(|violation| println!("  {violation}"));
    }
}

fn print_lines(counts: &[(String, Lines)]) {
    println!("{:24}     code      all", "crate");
    for (name, Lines { code, all }) in counts {
        println!("{name:24} {code:8} {all:8}");
    }
    let (code, all) = counts.iter().fold((0, 0), |(code, all), (_, lines)| (code + lines.code, all + lines.all));
    println!("{:24} {code:8} {all:8}", "sum");
}
