//! `check --fix` and `check --deny warnings`.

use super::Folder;

/// Two misspelt names and two words in wrong quotes; the misspelt parameter is found once its kind is known.
const WRONG: &str = r#"// a look
Pipeline(
    inputs: { "scene": Color },
    nodes: {
        "exposed": Exposre(source: "scene", stop: 1.0),
        "mapped": ToneMap(source: "exposd", curve: "Reinhard"),
        "display": Encode(source: mapped),
    },
    outputs: { "display": "display" },
)
"#;

fn mended() -> String {
    let words = [("Exposre", "Exposure"), ("stop:", "stops:"), ("exposd", "exposed"), ("\"Reinhard\"", "Reinhard")];
    let text = words.iter().fold(WRONG.to_owned(), |text, (wrong, right)| text.replace(wrong, right));
    text.replace("source: mapped", "source: \"mapped\"")
}

#[test]
fn names_that_are_sure_are_written_and_told() {
    let folder = Folder::new("fix");
    folder.with("look.ron", format!("\u{feff}{WRONG}").as_bytes());
    let outcome = folder.run("check look.ron --fix");
    let notes = outcome.notes();
    let first = "mended: look.ron:5:20: `Exposre` is now `Exposure`";
    assert!(notes.starts_with(first) && notes.lines().count() == 5, "{notes}");
    assert_eq!(std::fs::read_to_string(folder.file("look.ron")).expect("it is there"), format!("\u{feff}{}", mended()));
    assert_eq!(folder.run("check look.ron --fix").notes(), "");
}

#[test]
fn a_second_byte_order_mark_is_what_is_wrong() {
    let folder = Folder::new("fix-marks");
    folder.with("look.ron", format!("\u{feff}\u{feff}{}", mended()).as_bytes());
    let outcome = folder.run("check look.ron --fix");
    assert!(!outcome.err.contains("has changed"), "{}", outcome.err);
    assert!(outcome.err.contains("look.ron:1:1"), "{}", outcome.err);
}

#[test]
fn json_has_the_bytes_to_replace() {
    let folder = Folder::new("fix-json");
    folder.with("look.ron", WRONG.as_bytes());
    let outcome = folder.run("check look.ron --json");
    assert_eq!(outcome.status, Some(1));
    let json: serde_json::Value = serde_json::from_str(&outcome.out).expect("it is JSON");
    let fixes: Vec<_> = json.as_array().expect("a list").iter().filter_map(|one| one.get("fix")).collect();
    assert!(fixes.len() >= 3, "{json:#}");
    for fix in fixes {
        let at = |name: &str| fix[name].as_u64().expect("a number") as usize;
        let wrong = &WRONG[at("start")..at("end")];
        assert!(["Exposre", "exposd", "\"Reinhard\"", "mapped"].contains(&wrong), "{wrong}");
        assert_eq!(fix["file"], "look.ron");
    }
}

#[test]
fn what_is_not_sure_stays_and_is_reported() {
    let folder = Folder::new("fix-unsure");
    // As near to `exposed` as to `exposer`.
    let text = WRONG.replace(
        "\"exposed\": Exposre(source: \"scene\", stop: 1.0)",
        "\"exposed\": Exposure(source: \"scene\"), \"exposer\": Exposure(source: \"scene\")",
    );
    let text =
        text.replace("\"exposd\", curve: \"Reinhard\"", "\"expose\"").replace("source: mapped", "source: \"mapped\"");
    folder.with("look.ron", text.as_bytes());
    let outcome = folder.run("check look.ron --fix");
    outcome.fails_saying(1, &["no input or node is called `expose`", "did you mean `exposed` or `exposer`?"]);
    assert_eq!(std::fs::read_to_string(folder.file("look.ron")).expect("it is there"), text);
    folder.run("check tsushima --fix").fails_saying(1, &["built-in", "afterimage pipelines tsushima --write"]);
}

#[test]
fn warnings_can_be_denied() {
    let folder = Folder::new("deny");
    let text = mended().replace("\"scene\": Color", "\"scene\": Color, \"mask\": Mask");
    folder.with("look.ron", text.as_bytes());
    folder.run("check look.ron").good();
    let denied = folder.run("check look.ron --deny warnings");
    denied.fails_saying(1, &["warning[unread-input]", "look.ron: `--deny warnings` permits no warning"]);
    assert_eq!(folder.run("check look.ron --deny warnings --json").status, Some(1));
    assert_eq!(folder.run("check look.ron --json").status, Some(0));
    folder.with("look.ron", mended().as_bytes());
    folder.run("check look.ron --deny warnings").good();
}
