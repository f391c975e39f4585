//! The fuzz targets with the same inputs in every run: what `tests/fuzz` runs millions of times.

use std::ops::RangeInclusive;
use std::panic::catch_unwind;

use afterimage_fuzz::{Inputs, Target};

use crate::support::sweep;

/// Runs a target over its first inputs, `all` in a whole sweep. The share in percent that the target accepts must be
/// in this range: outside of it, inputs are changed too little or too much.
fn survives(target: Target, all: u64, accepted: RangeInclusive<u64>) {
    let inputs = Inputs::new(target, 2026);
    let runs = sweep::cases(all);
    let mut count = 0;
    for number in 0..runs {
        let input = inputs.get(number);
        count += u64::from(catch_unwind(|| target.run(&input)).unwrap_or_else(|_| {
            let again =
                format!("cargo run -p afterimage-fuzz -- --target {} --seed 2026 --only {number}", target.name());
            panic!("again: {again}\n{}", String::from_utf8_lossy(&input))
        }));
    }
    assert!(accepted.contains(&(100 * count / runs)), "{count} of {runs} inputs are accepted");
}

#[test]
fn no_document_makes_the_checker_panic() {
    survives(Target::Document, 3000, 5..=66);
}

#[test]
fn no_document_loses_what_is_saved_into_it() {
    survives(Target::Save, 1500, 5..=66);
}

#[test]
fn no_device_no_frame_and_no_setting_makes_the_planner_panic() {
    survives(Target::Plan, 1500, 27..=93);
}

#[test]
fn no_table_makes_its_reader_panic() {
    survives(Target::Cube, 20_000, 2..=75);
}

#[test]
fn no_color_file_makes_its_reader_panic() {
    survives(Target::ColorFile, 5000, 2..=80);
}

#[test]
fn no_declaration_makes_the_reader_of_folders_panic() {
    survives(Target::Declaration, 2000, 1..=80);
}

#[test]
fn no_shader_makes_the_linker_panic() {
    survives(Target::Linker, 1500, 2..=80);
}

#[test]
fn no_shader_with_a_workgroup_makes_the_linker_panic() {
    survives(Target::Workgroup, 1500, 2..=80);
}

#[test]
fn no_image_makes_a_decoder_panic() {
    survives(Target::Image, 2000, 10..=90);
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
