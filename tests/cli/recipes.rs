//! The recipes of the documentation, as their readers run them. Blocks of Rust are documentation tests of the library
//! of this crate.

use std::fs;

use afterimage_media::{Encoding, Picture, Pixels, write_image};

use super::{Folder, room, save};

const PAGE: &str = include_str!("../../graph/docs/recipes.md");

/// The title of a recipe, and its blocks of code with their languages.
type Recipe = (&'static str, Vec<(&'static str, &'static str)>);

fn recipes() -> Vec<Recipe> {
    let recipe = |section: &'static str| {
        let blocks = section.split("\n```").skip(1).step_by(2);
        let blocks = blocks.map(|block| block.split_once('\n').expect("a block has a language and lines"));
        (section.lines().next().expect("a section has a title"), blocks.collect())
    };
    PAGE.split("\n## ").skip(1).map(recipe).collect()
}

fn is_of_films((_, blocks): &Recipe) -> bool {
    blocks.iter().any(|(_, text)| text.contains(".mov"))
}

/// A folder with the files that readers have.
fn folder(test: &str) -> Folder {
    let folder = Folder::new(test);
    let whole = room(64, 36);
    let values = whole.pixels.to_f32();
    let part = |value: &dyn Fn(usize, f32) -> f32| {
        let channel = |(at, number): (usize, &f32)| if at % 4 == 3 { 1.0 } else { value(at / 4, *number) };
        let pixels = values.iter().enumerate().map(channel).collect();
        Picture::new(64, 36, Pixels::Float(pixels))
    };
    save(&folder.file("scene.exr"), &whole);
    save(&folder.file("lamps.exr"), &part(&|_, number| if number > 10.0 { number } else { 0.0 }));
    for frame in 1..=4_u8 {
        save(&folder.file(&format!("shot.000{frame}.exr")), &part(&|_, number| number * f32::from(frame)));
    }
    let hole = |(at, number): (usize, &f32)| if at / 4 % 64 < 20 { 0.0 } else { *number };
    let pixels = values.iter().enumerate().map(hole).collect();
    save(&folder.file("cutout.exr"), &Picture::new(64, 36, Pixels::Float(pixels)));
    let mask = part(&|at, _| if at % 64 < 20 { 1.0 } else { 0.0 });
    write_image(&folder.file("mask.png"), &mask, &Encoding::PNG).expect("a mask can be written");
    folder
}

/// The files that a command line names for its results.
fn results(line: &str) -> Vec<&str> {
    let words: Vec<&str> = line.split(' ').collect();
    let named = words.windows(2).filter(|pair| ["-o", "--write", "--json", "--output"].contains(&pair[0]));
    named.map(|pair| pair[1].rsplit('=').next().unwrap_or_default()).collect()
}

/// Writes the files of a recipe, and runs its commands, each of which leaves the files that it names.
fn follow((title, blocks): &Recipe, folder: &Folder) {
    for (language, text) in blocks.iter().filter(|(language, _)| *language != "rust") {
        if *language != "sh" {
            let name = text.lines().next().and_then(|line| line.strip_prefix("// ")).expect("a file has its name");
            fs::create_dir_all(folder.file(name).parent().expect("a folder")).expect("the folder can be made");
            folder.with(name, text.as_bytes());
            continue;
        }
        for line in text.lines() {
            let outcome = folder.run(line.strip_prefix("afterimage ").expect("a command is one of the program"));
            assert_eq!(outcome.status, Some(0), "{title}: {line}\n{}", outcome.err);
            for result in results(line) {
                let (before, after) = result.split_once("####").unwrap_or((result, ""));
                let is_it = |name: &String| name.starts_with(before) && name.ends_with(after);
                assert!(folder.names().iter().any(is_it), "{title}: {line} leaves no {result}");
            }
        }
    }
}

#[test]
fn every_recipe_is_short_and_in_the_index() {
    let recipes = recipes();
    assert!(recipes.len() >= 10, "only {} recipes are found", recipes.len());
    for (title, blocks) in recipes {
        assert!(PAGE.contains(&format!("| [{title}](#")), "{title} is in no row of the table");
        let lines: usize = blocks.iter().map(|(_, text)| text.lines().count()).sum();
        assert!((5..=30).contains(&lines), "{title} has {lines} lines of code");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn every_recipe_makes_its_pictures() {
    for (index, recipe) in recipes().iter().enumerate().filter(|(_, recipe)| !is_of_films(recipe)) {
        let folder = folder(&format!("recipe-{index}"));
        follow(recipe, &folder);
        let names = folder.names();
        let made = names.iter().filter(|name| name.ends_with(".png") && *name != "mask.png");
        let pictures: Vec<(&String, Vec<u8>)> =
            made.map(|name| (name, fs::read(folder.file(name)).expect("a picture"))).collect();
        for (at, (name, picture)) in pictures.iter().enumerate() {
            for (other, same) in &pictures[..at] {
                // Ranges of a sequence have the pixels of the whole sequence. All else has an effect.
                let endings = [name, other].map(|name| name.split_once('.').expect("an ending").1);
                let is_same_frame = endings[0] == endings[1] && endings[0] != "png";
                assert_eq!(picture == same, is_same_frame, "{}: {name} and {other}", recipe.0);
            }
        }
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
#[cfg_attr(no_ffmpeg, ignore = "ffmpeg is not on the PATH")]
fn every_recipe_of_films_makes_its_films() {
    let recipes: Vec<Recipe> = recipes().into_iter().filter(is_of_films).collect();
    assert!(!recipes.is_empty());
    for recipe in &recipes {
        let folder = folder("recipe-film");
        folder.run("render exposure shot.####.exr -o in.mov").good();
        follow(recipe, &folder);
    }
}
