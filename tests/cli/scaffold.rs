//! New node kinds: `afterimage nodes --new`.

use std::fs;
use std::path::Path;
use std::process::Command;

use afterimage_media::{Source, read};

use super::{Folder, Outcome};

/// The kind in Rust, before it has a name.
#[path = "../../graph/cli/src/scaffold/crate/src/lib.rs"]
mod template;

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_new_folder_has_a_kind_that_runs_and_keeps_its_files() {
    let folder = Folder::new("new-folder");
    let said = folder.run("nodes --new SoftGlow").good();
    let render = "render soft_glow/soft_glow.ron -o soft_glow.png --size 640x360";
    assert!(said.contains(&format!("afterimage {render}")), "{said}");
    assert!(said.contains("afterimage stress --kind SoftGlow --quick --nodes soft_glow"), "{said}");
    let mut names: Vec<_> =
        fs::read_dir(folder.file("soft_glow")).expect("the folder").collect::<Result<_, _>>().unwrap();
    names.sort_by_key(fs::DirEntry::file_name);
    let names: Vec<_> = names.iter().map(fs::DirEntry::file_name).collect();
    assert_eq!(names, ["node.ron", "soft_glow.ron", "soft_glow.wgsl"]);
    assert!(folder.run("nodes SoftGlow --nodes soft_glow").good().contains("Share of the effect"));
    folder.run(&render.replace("640x360", "32x18")).good();
    let picture = |name: &str| read(&Source::file(folder.file(name))).expect("the picture was written").pixels.to_f32();
    let tinted = picture("soft_glow.png");
    assert!(tinted.iter().skip(3).step_by(4).all(|alpha| *alpha == 1.0), "a viewer shows it");
    folder.run(&format!("{} --set changed.amount=0.0", render.replace("640x360", "32x18"))).good();
    let plain = picture("soft_glow.png");
    let sums = [&tinted, &plain].map(|all| [0, 2].map(|channel| all.iter().skip(channel).step_by(4).sum::<f32>()));
    assert!(sums[0][0] == sums[1][0] && sums[0][1] < 0.9 * sums[1][1], "the tint lowers blue alone: {sums:?}");
    let changed = b"Kind(name: \"Mine\")";
    folder.with("soft_glow/node.ron", changed);
    folder.run("nodes --new SoftGlow").fails_saying(1, &["`soft_glow` exists, and nothing in it is replaced"]);
    assert_eq!(fs::read(folder.file("soft_glow/node.ron")).expect("the file"), changed);
}

#[test]
fn names_that_no_kind_can_have_write_nothing() {
    let folder = Folder::new("new-names");
    for (name, why) in [
        ("softGlow", "it begins with a capital letter"),
        ("../Glow", "it begins with a capital letter"),
        ("Off", "pipeline files use this name themselves"),
        ("Target", "`target` is a word of WGSL"),
        ("Vignette", "there is a kind `Vignette`"),
        ("Core --rust", "a crate cannot be called `core`"),
        ("Glow --rust --repository .", "`.` is not the repository of Afterimage"),
    ] {
        folder.run(&format!("nodes --new {name}")).fails_saying(1, &[why]);
    }
    assert_eq!(folder.names(), Vec::<String>::new());
}

#[test]
fn a_new_crate_has_its_name_in_every_file() {
    let folder = Folder::new("new-crate");
    let repository = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").canonicalize().expect("the repository");
    let line = format!("nodes --new SoftGlow --rust --repository {}", repository.display());
    let said = folder.run(&line).good();
    let mut texts = String::new();
    for file in
        ["Cargo.toml", "src/lib.rs", "src/soft_glow.wgsl", "tests/contract.rs", "examples/program.rs", "soft_glow.ron"]
    {
        assert!(said.contains(&format!("soft_glow/{file}")), "{said}");
        texts += &fs::read_to_string(folder.file(&format!("soft_glow/{file}"))).expect(file);
    }
    for placeholder in ["MyKind", "my_kind", "REPOSITORY"] {
        assert!(!texts.contains(placeholder), "{placeholder} is left in:\n{texts}");
    }
}

/// A manifest of cargo fails only when it is built, which takes minutes: `tests/new_crate.sh`.
#[test]
fn a_new_crate_depends_on_crates_that_exist() {
    let folder = Folder::new("new-crate-paths");
    let repository = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").canonicalize().expect("the repository");
    folder.run(&format!("nodes --new SoftGlow --rust --repository {}", repository.display())).good();
    let text = fs::read_to_string(folder.file("soft_glow/Cargo.toml")).expect("the manifest");
    let mut count = 0;
    for line in text.lines() {
        let Some((name, place)) = line.split_once(" = { path = \"") else { continue };
        let place = Path::new(place.trim_end_matches("\" }"));
        assert!(place.starts_with(&repository), "{line}");
        let manifest = fs::read_to_string(place.join("Cargo.toml")).unwrap_or_else(|error| panic!("{line}: {error}"));
        assert!(manifest.contains(&format!("name = \"{name}\"\n")), "{line}");
        count += 1;
    }
    assert_eq!(count, 4, "{text}");
}

#[test]
fn a_new_crate_without_a_repository_depends_on_packages() {
    let folder = Folder::new("new-crate-packages");
    // The program that all tests run lies in the repository.
    let program = folder.file("afterimage");
    fs::copy(env!("CARGO_BIN_EXE_afterimage-under-test"), &program).expect("a program");
    let words = ["nodes", "--new", "SoftGlow", "--rust"];
    let output = Command::new(program).args(words).current_dir(&folder.0).output().expect("the program starts");
    Outcome::of(&output).good();
    let text = fs::read_to_string(folder.file("soft_glow/Cargo.toml")).expect("the manifest");
    for name in ["graph", "plan", "cli", "nodes"] {
        let line = format!("\nafterimage-{name} = \"{}\"\n", env!("CARGO_PKG_VERSION"));
        assert!(text.contains(&line), "{text}");
    }
}

#[test]
fn the_kind_of_a_new_crate_keeps_the_contract() {
    afterimage_plan::contract(template::ALL).unwrap_or_else(|complaints| panic!("{}", complaints.join("\n")));
}
