//! The table of memory in the documents is what the command prints, and says what it should.

use super::{Folder, Path};

#[test]
fn the_table_in_the_documents_is_what_the_command_prints() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let entries = std::fs::read_dir(root.join("pipelines")).expect("the repository has pipelines");
    let names = entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
    let mut words: Vec<String> = names.filter_map(|name| Some(format!("{{{}}}", name.strip_suffix(".ron")?))).collect();
    words.sort_by_key(|word| word.trim_matches(['{', '}']).to_owned() + ".ron");
    let folder = Folder::new("memory");
    let printed = folder.run(&format!("plan --memory {}", words.join(" "))).good();
    let kept = std::fs::read_to_string(root.join("graph/docs/memory.md")).expect("the table is in its place");
    assert_eq!(printed, kept, "`afterimage plan --memory pipelines/*.ron > graph/docs/memory.md` makes it anew");
    let rows: Vec<Vec<&str>> = printed.lines().filter(|line| line.ends_with(" % |")).map(cells).collect();
    assert_eq!(rows.len(), 3 * words.len() - 6, "two pipelines store nothing and have no share to tell");
    for row in &rows {
        assert!(per_cent(row[8]) <= 2.0, "{row:?}");
    }
    let tsushima = rows.iter().find(|row| row[0] == "tsushima" && row[1] == "3840x2160").expect("the richest pipeline");
    assert!((5.0..45.0).contains(&per_cent(tsushima[7])), "{tsushima:?}");
}

fn cells(line: &str) -> Vec<&str> {
    line.trim_matches('|').split('|').map(str::trim).collect()
}

fn per_cent(cell: &str) -> f64 {
    cell.trim_end_matches(" %").parse().unwrap_or_else(|_| panic!("`{cell}` is no share"))
}

#[test]
fn one_plan_is_shown_at_a_time() {
    let folder = Folder::new("one-plan");
    folder
        .run("plan {lynx} {caracal}")
        .fails(1, "error: this shows one pipeline at a time\n  hint: compare two with `--diff OTHER`");
    folder.run("plan --memory --size 64x64 {lynx}").fails_saying(1, &["--memory", "--size"]);
}

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
