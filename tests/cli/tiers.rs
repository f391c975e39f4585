//! Tiers of a pipeline file.

use super::Folder;

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
