//! Command lines of random words.

use std::ffi::OsString;
use std::os::unix::ffi::OsStringExt as _;

use afterimage_generators::Rng;

use crate::case::Case;
use crate::classes::Sources;
use crate::shaders::scene;
use crate::texts::shipped;

/// Commands that end soon by themselves.
const COMMANDS: [&str; 4] = ["check", "plan", "nodes", "render"];
/// Commands that measure for long: an option that does not exist ends them.
const LONG: [&str; 7] = ["demo", "bench", "measure", "tune", "stress", "help", ""];

const WORDS: [&str; 74] = [
    "exposure.ron",
    "lynx.ron",
    "tsushima.ron",
    "in.exr",
    "in.exr",
    "in.exr#",
    "in.exr#layer",
    "in.####.exr",
    "no.exr",
    "no.ron",
    "-o",
    "-o",
    "-o",
    "out.png",
    "out.png",
    "out.exr",
    "out.jpg",
    "out.avif",
    "out.tif",
    "out.####.png",
    "exposure.ron",
    ".",
    "..",
    "/",
    "",
    " ",
    "--",
    "-",
    "---",
    "-h",
    "--help",
    "--version",
    "--json",
    "--plan",
    "--size",
    "1x1",
    "64x36",
    "0x0",
    "4294967295x1",
    "99999999999x1",
    "-1x-1",
    "x",
    "NaNxinf",
    "--set",
    "meter.low=0.5",
    "meter.low=NaN",
    "meter.low=1e999",
    "meter=1",
    "=",
    "a=b=c",
    "mapped.curve=AgX",
    "--fact",
    "night=true",
    "--tier",
    "low",
    "ultra",
    "nothing",
    "--input",
    "scene=in.exr",
    "--output",
    "display",
    "display=b.png",
    "--frames",
    "1-3",
    "3-1",
    "1-99999999999999999999",
    "1-4000000000",
    "--depth",
    "16",
    "--fps",
    "1e-40",
    "--memory",
    "1K",
    "--nodes",
];

/// A word that is no text, or that speaks to the terminal.
fn odd_word(rng: &mut Rng) -> OsString {
    match rng.below(4) {
        0 => OsString::from_vec((0..1 + rng.below(12)).map(|_| 1 + rng.below(255) as u8).collect()),
        1 => OsString::from("\u{1b}]0;title\u{7}\u{9b}31m"),
        2 => OsString::from("x".repeat(1 << (4 + rng.below(12)))),
        _ => OsString::from("(".repeat(1 + rng.below(3000))),
    }
}

pub(crate) fn line(sources: &Sources, number: u64) -> Case {
    let mut rng = Rng::new(!(sources.seed << 32 | number));
    let is_long = rng.below(6) == 0;
    let case = match is_long {
        true => Case::new(LONG[rng.below(LONG.len())]).word("--no-such-option"),
        false => Case::new(COMMANDS[rng.below(COMMANDS.len())]),
    };
    let case = shipped().iter().fold(case, |case, (name, text)| case.with(name, text.clone()));
    let case = case.with("in.exr", scene());
    // Most lines begin like right ones.
    let case = if rng.below(3) > 0 { case.word("exposure.ron") } else { case };
    (0..rng.below(8)).fold(case, |case, _| {
        let word = if rng.below(12) == 0 { odd_word(&mut rng) } else { WORDS[rng.below(WORDS.len())].into() };
        case.word(word)
    })
}
