//! The result of `tune`: a pipeline file with more tiers.

use std::path::{Path, PathBuf};

use afterimage_graph::check::{CheckOptions, check};
use afterimage_graph::document::parse;
use afterimage_graph::node::Registry;
use afterimage_lab::measure::Errors;
use afterimage_lab::tune::{Measured, Tier, Tuned, claimed_flip, claimed_jod};
use afterimage_media::real_path;

use crate::args::measure::TuneArgs;
use crate::failure::Failure;
use crate::files::Files;

pub(crate) fn figures(tier: &Tier) -> String {
    let Measured { ms, p999, p999_without_worst, max, bytes, .. } = tier.measured;
    let mebibytes = bytes as f64 / f64::from(1 << 20);
    let others = p999_without_worst.map_or(String::new(), |others| format!(" ({others:.3} without the worst image)"));
    let errors = format!("99.9 % of pixels within {p999:.3} codes{others} and all within {max:.3}");
    let Errors { flip, jod, .. } = tier.errors;
    format!("{ms:.3} ms, {errors}, FLIP {flip:.3}, {jod:.3} JOD for {}, {mebibytes:.1} MiB", tier.display)
}

/// Refuses a name that RON cannot hold.
pub(crate) fn check_name(args: &TuneArgs, registry: &Registry, name: &str) -> Result<(), Failure> {
    let text = document(args, &[tier_entry(name, &[])], "");
    let document = parse("the tuned pipeline", &text)?;
    let files = Files::of(&args.pipeline, &args.sequences.options.kinds);
    let options = CheckOptions { tier: Some(name.to_owned()), sets: Vec::new(), loader: &files };
    // Only the name is checked here; the file itself was checked before.
    match document.tiers.first() {
        Some((known, _)) if known.value == name => Ok(()),
        _ => check(&document, registry, &options).map(|_| ()).map_err(Failure::from),
    }
}

/// The file: it extends the pipeline, and holds the tiers, which change these `entries`, with their claims.
pub(crate) fn text(
    args: &TuneArgs,
    registry: &Registry,
    entries: &[Vec<String>],
    tuned: &Tuned,
) -> Result<String, Failure> {
    let tiers: Vec<String> =
        tuned.tiers.iter().zip(entries).map(|(tier, entries)| tier_entry(&tier.name, entries)).collect();
    let claims: String = tuned.tiers.iter().map(claim).collect();
    let text = document(args, &tiers, &format!("    claims: {{\n{claims}    }},\n"));
    let path = args.out.clone().unwrap_or_else(|| args.pipeline.with_file_name("tuned.ron"));
    let files = Files::of(&args.pipeline, &args.sequences.options.kinds);
    let document = parse(&path.to_string_lossy(), &text)?;
    for tier in &tuned.tiers {
        let options = CheckOptions { tier: Some(tier.name.clone()), sets: Vec::new(), loader: &files };
        check(&document, registry, &options)?;
    }
    Ok(text)
}

/// The line of a tier among the claims.
fn claim(tier: &Tier) -> String {
    let Tier { name, measured, errors, display, conditions, .. } = tier;
    let (ms, p999) = (measured.ms, measured.claimed_p999());
    let (flip, jod) = (claimed_flip(errors.flip), claimed_jod(errors.jod));
    let seen = format!("jod: {jod:.3}, p999: {p999:.3}, flip: {flip:.3}, for: {display:?}");
    format!("        {name:?}: Claim(ms: {ms:.3}, {seen}, on: {conditions:?}),\n")
}

/// The folder of the pipeline, if the file is neither in it nor above it: then `--allow` must name it.
pub(crate) fn foreign_folder(args: &TuneArgs) -> Option<PathBuf> {
    let pipeline = real_path(&args.pipeline).ok()?;
    let folder = real_path(args.out.as_ref()?.parent()?).ok()?;
    if pipeline.starts_with(&folder) { None } else { Some(pipeline.parent()?.to_owned()) }
}

/// A tier that changes these entries.
fn tier_entry(name: &str, entries: &[String]) -> String {
    let list: String = entries.iter().map(|entry| format!("            {entry},\n")).collect();
    let body = if list.is_empty() { "{}".to_owned() } else { format!("{{\n{list}        }}") };
    format!("        {name:?}: {body},\n")
}

fn document(args: &TuneArgs, tiers: &[String], claims: &str) -> String {
    let base = base(args);
    format!("Pipeline(\n    extends: {base:?},\n    tiers: {{\n{}    }},\n{claims})\n", tiers.concat())
}

/// The path of the pipeline in the new file: relative to its folder where both share a root.
fn base(args: &TuneArgs) -> String {
    let beside = || args.pipeline.file_name().map_or(String::new(), |name| name.to_string_lossy().into_owned());
    let Some(out) = &args.out else { return beside() };
    let folder = out.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    match (std::fs::canonicalize(folder), std::fs::canonicalize(&args.pipeline)) {
        (Ok(folder), Ok(pipeline)) => relative(&folder, &pipeline).to_string_lossy().into_owned(),
        _ => beside(),
    }
}

/// `to` as seen from the folder `from`; both are whole paths.
fn relative(from: &Path, to: &Path) -> PathBuf {
    let shared = from.components().zip(to.components()).take_while(|(a, b)| a == b).count();
    let up = from.components().skip(shared).map(|_| std::path::Component::ParentDir);
    up.chain(to.components().skip(shared)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_relative_to_the_new_file() {
        let relative = |from: &str, to: &str| relative(Path::new(from), Path::new(to)).to_string_lossy().into_owned();
        assert_eq!(relative("/a/b", "/a/b/lynx.ron"), "lynx.ron");
        assert_eq!(relative("/a/b/c", "/a/lynx.ron"), "../../lynx.ron");
        assert_eq!(relative("/a/out", "/a/pipelines/lynx.ron"), "../pipelines/lynx.ron");
    }
}
