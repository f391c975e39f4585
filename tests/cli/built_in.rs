//! Built-in pipelines by name, and what the program needs no repository for.

use std::fs;

use super::{Folder, room, save};

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_name_is_a_pipeline_wherever_it_stands() {
    let folder = Folder::new("by-name");
    save(&folder.file("room.exr"), &room(12, 8));
    folder.run("render {grade} room.exr -o file.png").good();
    folder.run("render grade room.exr -o name.png").good();
    folder.run("render room.exr grade -o swapped.png").good();
    let bytes = |name: &str| fs::read(folder.file(name)).expect("it was written");
    assert!(bytes("file.png") == bytes("name.png") && bytes("name.png") == bytes("swapped.png"));
    // A file of that name wins.
    folder.run("pipelines exposure --write grade").good();
    folder.run("render grade room.exr -o own.png").good();
    folder.run("render exposure room.exr -o exposure.png").good();
    assert!(bytes("own.png") == bytes("exposure.png") && bytes("own.png") != bytes("name.png"));
}

#[test]
fn pipelines_are_listed_shown_and_written_with_what_they_use() {
    let folder = Folder::new("written");
    let list = folder.run("pipelines").good();
    assert!(list.contains("exposure") && list.contains("Auto exposure and a tone curve"), "{list}");
    let shown = folder.run("pipelines grade").good();
    assert_eq!(shown.trim_end(), fs::read_to_string(super::built_in("grade")).expect("it is there").trim_end());
    folder.run("pipelines cinematic --write look.ron").good();
    folder.run("pipelines grade --write graded.ron").good();
    let names = folder.names();
    assert!(
        ["graded.ron", "look.ron", "looks", "tsushima.ron"].iter().all(|name| names.contains(&(*name).into())),
        "{names:?}"
    );
    folder.run("check look.ron graded.ron cinematic").good();
    // Again it is as good as written, and a file that was edited is not replaced.
    folder.run("pipelines cinematic --write look.ron").good();
    folder.with("tsushima.ron", b"// mine");
    let refused = folder.run("pipelines cinematic --write other.ron");
    refused.fails_saying(1, &["tsushima.ron: this file exists, and is not replaced by a new one"]);
    folder.with("look.ron", b"// mine");
    folder.run("pipelines grade --write look.ron").fails_saying(1, &["look.ron: this file exists"]);
    assert_eq!(folder.names(), names, "nothing is left of what failed");
    assert_eq!(fs::read(folder.file("look.ron")).expect("it is there"), b"// mine");
}

#[test]
#[cfg(target_os = "linux")]
fn a_built_in_pipeline_is_not_written_through_a_link() {
    let folder = Folder::new("written-links");
    fs::create_dir(folder.file("elsewhere")).expect("a folder");
    folder.link("looks", "elsewhere");
    folder.run("pipelines grade --write look.ron").fails_saying(1, &["`looks` is a link"]);
    assert_eq!(folder.names(), ["elsewhere", "looks"]);
    assert_eq!(fs::read_dir(folder.file("elsewhere")).expect("a folder").count(), 0);
}

#[test]
fn completions_know_the_commands() {
    let folder = Folder::new("completions");
    // The command of each shell that registers completions.
    for (shell, words) in [
        ("bash", "complete -F"),
        ("zsh", "#compdef afterimage"),
        ("fish", "complete -c afterimage"),
        ("powershell", "Register-ArgumentCompleter"),
    ] {
        let script = folder.run(&format!("completions {shell}")).good();
        assert!(script.contains("preroll") && script.contains("pipelines") && script.contains(words), "{shell}");
    }
}

/// `new` is the first file of a beginner: it is valid, it renders, and so does each part that is switched off.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_new_pipeline_renders_with_all_that_it_proposes() {
    let folder = Folder::new("new");
    save(&folder.file("scene.exr"), &room(32, 18));
    let run = folder.run("new my.look.ron");
    assert!(run.err.contains("afterimage render my.look.ron scene.exr -o out.png"), "{}", run.err);
    assert_eq!(run.good(), "my.look.ron\n");
    folder.run("check my.look.ron --deny warnings").good();
    folder.run("render my.look.ron scene.exr -o out.png").good();
    let text = fs::read_to_string(folder.file("my.look.ron")).expect("it was written");
    assert!(text.starts_with("// my.look: ") && !text.contains("FILE") && !text.contains("NAME"), "{text}");
    folder.with("look.cube", b"LUT_3D_SIZE 2\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 0 1\n1 0 1\n0 1 1\n1 1 1\n");
    let all = text.replace("// \"", "\"");
    let all = all.replace("source: \"scene\", stops", "source: \"scene\", meter: \"meter\", stops");
    let all = all.replace("WhiteBalance(source: \"exposed\"", "WhiteBalance(source: \"lit\"");
    let all = all.replace("Encode(source: \"mapped\"", "Encode(source: \"look\"");
    folder.with("all.ron", all.as_bytes());
    folder.run("check all.ron --deny warnings").good();
    folder.run("render all.ron scene.exr -o all.png").good();
    folder.with("my.look.ron", b"mine");
    folder.run("new my.look.ron").fails_saying(1, &["this file exists, and is not replaced by a new one"]);
    let spaced = folder.command("new").arg("a b.ron").output().expect("the program starts");
    assert!(String::from_utf8_lossy(&spaced.stderr).contains("afterimage check 'a b.ron'\n"), "{spaced:?}");
    folder.run("new look.png").fails_saying(1, &["`look.png` is no name of a pipeline"]);
}
