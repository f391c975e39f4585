//! `tune` and `measure` as a whole: the files that they write, and what they say of them.

use super::Folder;
use crate::support::numbers::is_rounded;

const PIPELINE: &str = r#"Pipeline(
    inputs: { "scene": Exposed },
    nodes: {
        "wide": Gaussian(source: "scene", sigma: 2.0),
        "lit": Composite(base: "scene", bloom: "wide"),
        "mapped": ToneMap(source: "lit"),
        "display": Encode(source: "mapped", transfer: Srgb),
    },
    outputs: { "display": "display" },
    tiers: { "low": { "wide": Off }, "high": {}, "own": {} },
)"#;

fn folder(test: &str) -> Folder {
    let folder = Folder::new(test);
    folder.with("p.ron", PIPELINE.as_bytes());
    std::fs::create_dir(folder.file("tuned")).expect("a folder");
    folder
}

/// The number after a word in the claim of a tier.
fn claimed(text: &str, tier: &str, figure: &str) -> f64 {
    let claim = text.lines().find(|line| line.contains(&format!("\"{tier}\": Claim("))).expect("it has a claim");
    let number = claim.split(&format!("{figure}: ")).nth(1).and_then(|rest| rest.split(',').next());
    number.and_then(|number| number.parse().ok()).expect("a number")
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn tiers_are_written_beside_those_of_the_pipeline() {
    let folder = folder("tune-tiers");
    let line = "tune p.ron --size 64x36 --walk 1 --no-charts --tiers=high:0.5,low:8 -o tuned/t.ron --allow .";
    let notes = folder.run(line).notes();
    let text = std::fs::read_to_string(folder.file("tuned/t.ron")).expect("it is written");
    let written: Vec<&str> =
        ["high", "low", "own"].into_iter().filter(|name| text.contains(&format!("{name:?}: Claim("))).collect();
    let inherited: Vec<String> =
        ["low", "high", "own"].iter().filter(|name| !written.contains(name)).map(|name| format!("`{name}`")).collect();
    assert!(written.contains(&"high") && !written.contains(&"own"), "{text}");
    assert!(notes.contains(&format!("the file inherits {} from the pipeline", inherited.join(" and "))), "{notes}");
    assert!(notes.contains("the file extends one of another folder; use it with `--allow "), "{notes}");
    assert!(text.contains("extends: \"../p.ron\"") && claimed(&text, "high", "p999") <= 0.5, "{text}");
    for name in &written {
        let line = notes.lines().find(|line| line.starts_with(&format!("`{name}`: "))).expect("its figures are told");
        let after = |words: &str| line.split(words).nth(1).and_then(|rest| rest.split([' ', ',']).next()).expect(words);
        let number = |words: &str| after(words).parse::<f64>().expect("a number");
        assert!(is_rounded(after(": "), claimed(&text, name, "ms")), "{line}");
        // A tenth above what was measured, and a little at least: each with three digits.
        let [codes, flip, lost] = [number("within "), number("FLIP "), 10.0 - number(&format!("{}, ", after("FLIP ")))];
        for (figure, found, wanted) in [
            ("p999", claimed(&text, name, "p999"), (1.1 * codes).max(codes + 0.05)),
            ("flip", claimed(&text, name, "flip"), (1.1 * flip).max(flip + 0.003)),
            ("jod", 10.0 - claimed(&text, name, "jod"), (1.1 * lost).max(lost + 0.02)),
        ] {
            assert!((found - wanted).abs() < 0.0017, "{figure}: {found}, not {wanted}: {line}");
        }
    }
    let good = folder.run("check --allow . tuned/t.ron").good();
    assert_eq!(good, "tuned/t.ron: good, also at `low`, `high`, `own`\n");
    folder.run("check tuned/t.ron").fails_saying(1, &["--allow"]);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn one_tier_has_the_name_and_the_error_that_are_asked_for() {
    let folder = folder("tune-one");
    let line = "tune p.ron --size 64x36 --walk 1 --error 2 --name quick -o t.ron";
    let notes = folder.run(line).notes();
    let text = std::fs::read_to_string(folder.file("t.ron")).expect("it is written");
    assert!(text.contains("extends: \"p.ron\"") && claimed(&text, "quick", "p999") <= 2.0, "{text}");
    assert!(!notes.contains("inherits") && !notes.contains("--allow"), "{notes}");
    assert_eq!(folder.run("check t.ron").good(), "t.ron: good, also at `low`, `high`, `own`, `quick`\n");
}

/// The cells of a line of a table.
fn cells(line: &str) -> Vec<&str> {
    line.trim_start_matches([' ', '●']).split("  ").map(str::trim).filter(|cell| !cell.is_empty()).collect()
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn figures_of_the_table_are_those_of_the_file() {
    let folder = folder("measure-table");
    let line = "measure p.ron --size 256x144 --size 32x18 --walk 2 --repeats 2 --tiers --json m.json";
    let text = folder.run(line).good();
    let json = std::fs::read(folder.file("m.json")).expect("it is written");
    let json: serde_json::Value = serde_json::from_slice(&json).expect("it is JSON");
    let [names, columns @ ..] = &cells(text.lines().find(|line| line.contains("p99.9")).expect("a heading"))[..] else {
        panic!("{text}")
    };
    assert_eq!((*names, columns.len()), ("variant", 13), "{text}");
    for row in json["rows"].as_array().expect("a list").iter().filter(|row| row["same_as"].is_null()) {
        let name = row["variant"].as_str().expect("a name");
        let is_it = |line: &&str| cells(line).first().is_some_and(|names| names.split(", ").any(|one| one == name));
        let line = text.lines().find(is_it).unwrap_or_else(|| panic!("{name}: {text}"));
        assert_eq!(line.contains('●'), row["pareto"] == true, "{line}");
        for (column, cell) in columns.iter().zip(&cells(line)[1..]) {
            let (key, unit) = match *column {
                "GPU ms" | "host ms" => ("gpu_ms", 1.0),
                "MiB" => ("bytes", 1.0 / 1024.0 / 1024.0),
                "moved" => ("bytes_moved", 1.0 / 1024.0 / 1024.0),
                "p99.9" => ("p999", 1.0),
                "PSNR" => ("psnr", 1.0),
                "SSIM" => ("ssim", 1.0),
                "dE2000" => ("ciede2000_mean", 1.0),
                "FLIP" => ("flip", 1.0),
                "JOD" => ("jod", 1.0),
                "flicker" => ("flicker_p999", 1.0),
                "without it" => ("p999_without_worst", 1.0),
                "worst on" => {
                    assert_eq!(*cell, row["worst_image"], "{line}");
                    continue;
                }
                max => (max, 1.0),
            };
            let number = cell.split(' ').next().unwrap_or_default().trim_start_matches('<');
            let value = row[key].as_f64().map(|value| value * unit);
            let is_it = value.map_or(*cell == "equal", |value| is_rounded(number, value));
            assert!(is_it, "{column} of {name} is {cell}, and {value:?} in the file");
        }
    }
}
