//! `tune` as a whole: the file that it writes, and what it says of it.

use super::Folder;

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
        assert!(notes.contains(&format!("`{name}`: {:.3} ms", claimed(&text, name, "ms"))), "{notes}");
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
