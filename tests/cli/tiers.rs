//! Tiers of a pipeline file.

use super::{Folder, room, save};

/// A malformed tier is reported even if it is not selected.
#[test]
fn every_tier_is_checked() {
    let folder = Folder::new("tiers");
    let other = r#"Pipeline(inputs: { "scene": Color }, nodes: { "twice": Exposure(source: "nobody") }, outputs: { "out": "twice" })"#;
    folder.with("other.ron", other.as_bytes());
    let text = |tier: &str| {
        format!(
            r#"Pipeline(
                inputs: {{ "scene": Color }},
                nodes: {{ "twice": Exposure(source: "scene", stops: 1.0) }},
                outputs: {{ "out": "twice" }},
                tiers: {{ "half": {{ "twice.stops": -1.0 }}, "same": {{}}, "other": {tier} }},
            )"#
        )
    };
    folder.with("good.ron", text("{ \"twice\": Off }").as_bytes());
    assert_eq!(
        folder.run("check --plan good.ron").good(),
        "good.ron: good, also at `half`, `same`, `other`; its plans are verified\n"
    );
    assert_eq!(folder.run("check --tier half good.ron").good(), "good.ron: good\n");
    folder.with("bad.ron", text("\"other.ron\"").as_bytes());
    folder.run("check bad.ron").fails_saying(1, &["nobody", "other.ron", "1 of 1 pipelines cannot be used"]);
    folder.run("check --json bad.ron").fails(1, "");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_tier_that_is_asked_for_is_named_once() {
    let folder = Folder::new("tiers-named");
    let text = r#"Pipeline(inputs: { "scene": Color }, nodes: { "soft": Gaussian(source: "scene", sigma: 4.0) },
        outputs: { "light": "soft" }, tiers: { "low": { "soft.sigma": 2.0 } })"#;
    folder.with("soft.ron", text.as_bytes());
    save(&folder.file("room.exr"), &room(8, 8));
    let table = folder.run("measure soft.ron room.exr --tiers --tier low --repeats 1").good();
    assert!(table.contains("as written, tier low ") && !table.contains("low, tier low"), "{table}");
    assert!(table.ends_with("the median of 1 frame\n"), "{table}");
}
