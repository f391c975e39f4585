//! The fuzz targets for a few seconds, the same inputs in every run: what `tests/fuzz` runs millions of times.

use std::panic::catch_unwind;

use afterimage_fuzz::{Inputs, Target};

/// Runs a target over its first inputs; how many of them are accepted.
fn survives(target: Target, runs: u64) -> u64 {
    let inputs = Inputs::new(target, 2026);
    let accepted = |number: &u64| {
        let input = inputs.get(*number);
        catch_unwind(|| target.run(&input)).unwrap_or_else(|_| {
            let again =
                format!("cargo run -p afterimage-fuzz -- --target {} --seed 2026 --only {number}", target.name());
            panic!("again: {again}\n{}", String::from_utf8_lossy(&input))
        })
    };
    (0..runs).filter(accepted).count() as u64
}

#[test]
fn no_document_makes_the_checker_panic() {
    let accepted = survives(Target::Document, 3000);
    assert!(
        (150..2000).contains(&accepted),
        "{accepted} documents are right: mutation changes too little, or too much"
    );
}

#[test]
fn no_document_loses_what_is_saved_into_it() {
    let saved = survives(Target::Save, 1500);
    assert!((75..1000).contains(&saved), "{saved} documents can be saved: too few are right, or too many");
}

#[test]
fn no_device_no_frame_and_no_setting_makes_the_planner_panic() {
    let accepted = survives(Target::Plan, 1500);
    assert!((400..1400).contains(&accepted), "{accepted} can be planned: choices go too rarely beyond, or too often");
}

#[test]
fn no_table_makes_its_reader_panic() {
    let accepted = survives(Target::Cube, 20_000);
    assert!((500..15_000).contains(&accepted), "{accepted} tables are right: mutation changes too little, or too much");
}

#[test]
fn no_color_file_makes_its_reader_panic() {
    let accepted = survives(Target::ColorFile, 5000);
    assert!((100..4000).contains(&accepted), "{accepted} files are right: mutation changes too little, or too much");
}

#[test]
fn no_declaration_makes_the_reader_of_folders_panic() {
    let accepted = survives(Target::Declaration, 2000);
    assert!((20..1600).contains(&accepted), "{accepted} kinds are right: mutation changes too little, or too much");
}

#[test]
fn no_shader_makes_the_linker_panic() {
    let accepted = survives(Target::Linker, 1500);
    assert!((30..1200).contains(&accepted), "{accepted} shaders are right: mutation changes too little, or too much");
}

#[test]
fn no_shader_with_a_workgroup_makes_the_linker_panic() {
    let accepted = survives(Target::Workgroup, 1500);
    assert!((30..1200).contains(&accepted), "{accepted} shaders are right: mutation changes too little, or too much");
}

#[test]
fn no_image_makes_a_decoder_panic() {
    let accepted = survives(Target::Image, 2000);
    assert!((200..1800).contains(&accepted), "{accepted} images are right: damage is too small, or too large");
}

#[test]
fn an_input_follows_from_its_number() {
    for target in Target::ALL {
        let [first, again] = [5, 5].map(|seed| Inputs::new(target, seed));
        let other = Inputs::new(target, 6);
        assert!((0..50).all(|number| first.get(number) == again.get(number)), "{target:?}");
        assert!((0..50).any(|number| first.get(number) != other.get(number)), "{target:?}");
    }
}
