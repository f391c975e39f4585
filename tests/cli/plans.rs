//! `plan` as a user reads it: switches, tiers, facts, and what differs.

use super::Folder;
use crate::support::numbers::is_rounded;

fn plan(line: &str) -> String {
    Folder::new(&format!("plan-{}", line.replace(['{', '}', ' ', '='], ""))).run(&format!("plan {line}")).good()
}

/// Passes and batches, from the first line.
fn counts(text: &str) -> (usize, usize) {
    let mut numbers = text.split(' ').filter_map(|word| word.parse().ok());
    (numbers.next().expect("passes"), numbers.next().expect("batches"))
}

#[test]
fn switches_turn_off_what_they_say() {
    let (passes, batches) = counts(&plan("{tsushima}"));
    assert!(batches < passes, "some passes overlap");
    assert_eq!(counts(&plan("{tsushima} --plan batches=serial")), (passes, passes));
    let (fewer_passes, fewer_waves) = counts(&plan("{tsushima} --plan batches=fewest"));
    assert!(fewer_passes == passes && fewer_waves <= batches);
    assert!(counts(&plan("{tsushima} --plan fuse=off")).0 > passes);
    let in_use = |flag: &str| {
        let text = plan(&format!("{{tsushima}} {flag}"));
        let line = text.lines().find(|line| line.ends_with("in use")).expect("one row is marked");
        line.split("  ").find(|cell| !cell.is_empty()).expect("the row has a name").trim().to_owned()
    };
    assert_eq!(in_use("--plan alias=none"), "stored, without sharing");
    assert_eq!(in_use("--plan alias=pool"), "stored, pooled");
    assert_eq!(in_use("--plan batches=serial"), "stored, placed");
}

#[test]
fn a_pipeline_whose_passes_a_host_fills_can_be_looked_at_and_not_rendered() {
    let folder = Folder::new("host-draws");
    let text = r#"Pipeline(
        inputs: {},
        nodes: {
            "samples": DrawSamples(reversed: true),
            "scene": Resolve(source: "samples"),
            "exposed": Exposure(source: "scene", stops: 1.0),
            "mapped": ToneMap(source: "exposed", curve: Reinhard),
            "encoded": Encode(source: "mapped", transfer: Srgb),
        },
        outputs: { "display": "encoded" },
    )"#;
    folder.with("host.ron", text.as_bytes());
    assert!(folder.run("check --plan host.ron").good().contains("its plans are verified"));
    let plan = folder.run("plan host.ron --size 64x32").good();
    assert!(plan.contains("draws of the host") && plan.contains("samples.result, samples.depth"), "{plan}");
    folder.run("render host.ron -o out.png --size 64x32").fails_saying(2, &["no draws were given for node `samples`"]);
    assert!(folder.names() == ["host.ron"], "{:?}", folder.names());
}

#[test]
fn a_fact_leaves_a_branch_out_and_the_plan_says_why() {
    let dark = plan("{caracal} --fact emissive=false");
    assert!(dark.contains("skipped\n") && dark.contains("`when: emissive` does not hold"), "{dark}");
    let passes: Vec<&str> = dark.lines().take_while(|line| *line != "skipped").collect();
    assert!(!passes.iter().any(|line| line.contains("downsample") || line.contains("upsample")), "{passes:?}");
    assert!(plan("{caracal} --fact emissive=true").contains("downsample"));
}

/// Most colors are nearer than nearly all of them, and those nearer than the farthest.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_errors_of_tables_of_colors_follow_the_plan() {
    let folder = Folder::new("plan-bake-error");
    let text = r#"Pipeline(
        inputs: { "scene": Exposed },
        nodes: { "mapped": ToneMap(source: "scene", bake: 33), "shown": Encode(source: "mapped") },
        outputs: { "display": "shown" },
    )"#;
    folder.with("table.ron", text.as_bytes());
    let [plan, both] = ["", " --bake-error"].map(|flag| folder.run(&format!("plan table.ron{flag}")).good());
    let errors = both.strip_prefix(&*plan).expect("the plan is the same");
    assert!(errors.lines().any(|line| line.contains("mapped") && line.contains("size 33  grays ")), "{errors}");
    for gamut in ["Rec.709", "P3", "Rec.2020", "AP1"] {
        let row = errors.lines().find_map(|line| line.trim_start().strip_prefix(gamut)).expect("each gamut has a row");
        let numbers: Vec<f64> = row.split_whitespace().map(|word| word.parse().expect("a number")).collect();
        let [most, nearly_all, all] = numbers[..] else { panic!("{errors}") };
        assert!(0.0 < most && most <= nearly_all && nearly_all <= all, "{errors}");
    }
}

#[test]
fn plans_of_tiers_and_files_are_compared() {
    let tiers = plan("{tsushima} --diff-tier low");
    assert!(tiers.contains("passes ") && tiers.contains("bytes moved ") && tiers.contains("peak memory "), "{tiers}");
    assert!(tiers.lines().any(|line| line.starts_with("~ mips.result.0: ")), "{tiers}");
    let files = plan("{tsushima} --diff {lynx}");
    assert!(files.lines().any(|line| line.starts_with("- metered: ")), "{files}");
    assert_eq!(plan("{lynx} --diff {lynx}"), "the plans do the same work in the same memory\n");
}

#[test]
fn the_json_has_all_that_programs_ask_for() {
    let text = plan("{tsushima} --format json --size 3840x2160");
    let json: serde_json::Value = serde_json::from_str(&text).expect("it is JSON");
    for list in ["passes", "batches", "skipped"] {
        assert!(json[list].as_array().is_some_and(|list| !list.is_empty()), "{list}");
    }
    assert!(json["hash"].as_str().is_some_and(|hash| hash.len() >= 16), "{}", json["hash"]);
    let bytes = ["unaliased", "pooled", "placed", "lower_bound"]
        .map(|key| json["memory"][key].as_u64().unwrap_or_else(|| panic!("{key} is missing")));
    assert!(bytes.is_sorted_by(|a, b| a >= b) && bytes[3] > 0, "{bytes:?}");
    assert!(bytes[2] as f64 <= 0.45 * bytes[0] as f64 && bytes[2] as f64 <= 1.02 * bytes[3] as f64, "{bytes:?}");
}

#[test]
fn differences_of_plans_are_json_if_json_is_requested() {
    let json = |line: &str| -> serde_json::Value { serde_json::from_str(&plan(line)).expect("it is JSON") };
    let tiers = json("{tsushima} --diff-tier low --format json");
    let changed = tiers["changed"].as_array().expect("a list");
    assert!(changed.iter().any(|change| change["image"] == "mips.result.0"), "{tiers:#}");
    let moved = tiers["bytes_moved"].as_array().expect("two numbers");
    assert!(moved[0].as_u64() > moved[1].as_u64() && moved[1].as_u64() > Some(0), "{tiers:#}");
    // The text has the same figures, with the change in percent.
    let text = plan("{tsushima} --diff-tier low");
    for (start, key, unit) in [
        ("passes ", "passes", 1.0),
        ("batches ", "batches", 1.0),
        ("bytes moved ", "bytes_moved", 1024.0 * 1024.0),
        ("peak memory ", "peak_memory", 1024.0 * 1024.0),
    ] {
        let line = text.lines().find(|line| line.starts_with(start)).expect("a line of each");
        let values = [0, 1].map(|at| tiers[key][at].as_f64().expect("a number"));
        let change = (values[0] != values[1]).then_some(100.0 * (values[1] / values[0] - 1.0));
        let wanted: Vec<f64> = values.iter().map(|value| value / unit).chain(change).collect();
        let found = line.split([' ', '(']).filter(|word| word.parse::<f64>().is_ok());
        assert!(found.clone().count() == wanted.len() && found.zip(&wanted).all(|(a, b)| is_rounded(a, *b)), "{line}");
    }
    let changes = text.lines().filter(|line| line.starts_with("~ ")).count();
    assert_eq!(changes, changed.len(), "{text}");
    let same = json("{lynx} --diff {lynx} --format json");
    assert!(same["added"] == serde_json::json!([]) && same["passes"][0] == same["passes"][1], "{same:#}");
    let folder = Folder::new("plan-diff-drawing");
    folder.run("plan {lynx} --diff {lynx} --format svg").fails_saying(1, &["--format json"]);
}

#[test]
fn a_plan_is_of_the_size_the_digits_and_the_dynamic_parameters_that_are_asked_for() {
    let exact = plan("{lynx} --exact --size 640x360");
    let first = exact.lines().next().expect("a line");
    assert!(first.contains(" at 640x360;") && exact.contains("Rgba32Float") && !exact.contains("16Float"), "{exact}");
    assert!(plan("{lynx}").lines().next().expect("a line").contains(" at 1920x1080;"), "the size by default");
    // A node that changes nothing is left out, unless the host may change it.
    let does =
        |line: &str| plan(line).lines().take_while(|line| *line != "skipped").any(|line| line.contains("saturat"));
    assert!(!does("{grade}") && does("{grade} --dynamic saturated.amount"));
    let folder = Folder::new("plan-dynamic");
    for (name, why) in [
        ("mips.levels", "each change of `mips.levels` needs a new plan"),
        ("mips.levls", "`levels`"),
        ("mip.levels", "`mips`"),
    ] {
        folder.run(&format!("plan {{tsushima}} --dynamic {name}")).fails_saying(1, &[why]);
    }
}

#[test]
fn errors_are_json_if_json_is_requested() {
    let folder = Folder::new("plan-json-errors");
    folder.with("broken.ron", b"Pipeline(nodes: { \"a\": Nothing() }, outputs: { \"a\": \"a\" })");
    let codes = |line: &str| -> Vec<String> {
        let outcome = folder.run(line);
        assert_eq!((outcome.status, outcome.err.as_str()), (Some(1), ""), "{line}");
        let all: serde_json::Value =
            serde_json::from_str(&outcome.out).unwrap_or_else(|_| panic!("{line}: {}", outcome.out));
        let all = all.as_array().expect("a list of diagnostics").iter();
        all.map(|one| one["code"].as_str().expect("a code").to_owned()).collect()
    };
    assert_eq!(codes("plan missing.ron --format json"), ["unreadable-file"]);
    assert!(codes("plan broken.ron --format json").contains(&"unknown-kind".to_owned()));
    assert_eq!(codes("plan {lynx} --format json --diff missing.ron"), ["unreadable-file"]);
    assert_eq!(codes("check missing.ron --json"), ["unreadable-file"]);
    assert_eq!(codes("check . --json"), ["unreadable-file"]);
    let both = codes("check missing.ron broken.ron --json");
    assert!(both.contains(&"unreadable-file".to_owned()) && both.contains(&"unknown-kind".to_owned()), "{both:?}");
    assert_eq!(codes("check {lynx} --json --set stops"), ["arguments"]);
    assert_eq!(codes("check {lynx} --json --nodes missing"), ["unreadable-file"]);
}
