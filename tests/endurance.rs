//! Hours in minutes: reloads with changing folder kinds, resizes, frames and openings of devices, over and over. What
//! the process holds is recorded after each round.
//!
//! [`endurance.sh`](endurance.sh) runs all rounds and plots the result; the ordinary test runs a few small ones.
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "the report of a run of many minutes")]

mod record;

use afterimage::offline::Session;
use afterimage_gpu::{FrameKind, FrameStep, Gpu, InputImage, Opening, Texels};
use afterimage_graph::check::{CheckOptions, Facts, Graph, check};
use afterimage_graph::document::parse;
use afterimage_graph::image::Size;
use afterimage_graph::node::{Registry, folder_kind_of};
use afterimage_plan::Options;

use record::{Record, Sample};

struct Round {
    reloads: u32,
    resizes: u32,
    frames: u32,
    openings: u32,
}

/// 200 of these are 10 000 reloads, 5 000 resizes, 20 000 frames and 200 openings.
const FULL: Round = Round { reloads: 50, resizes: 25, frames: 100, openings: 1 };
const SMALL: Round = Round { reloads: 3, resizes: 3, frames: 5, openings: 1 };

const SIZE: Size = Size { width: 64, height: 48, depth: 1 };

/// The color of every pixel of the input.
const LIGHT: f32 = 0.5;

/// The factor of the kind of this edit. It and the product are exact in 32 bits.
fn factor(edit: u32) -> f32 {
    1.0 + edit as f32 / 16384.0
}

/// A pipeline with a kind from a folder whose shader is another one after each edit.
fn edited(edit: u32) -> Graph {
    let declaration = r#"Kind(
        name: "Scaled", doc: "Multiplies.", inputs: { "source": Image(doc: "A picture.") },
        outputs: { "result": Image(doc: "Another.", state: Same("source"), function: "scaled") },
    )"#;
    let shader = format!("fn scaled(source: vec4f) -> vec4f {{ return source * {:?}; }}", factor(edit));
    let kind = folder_kind_of(("node.ron", declaration), &[("scaled.wgsl", &shader)]);
    let kinds = [kind.unwrap_or_else(|errors| panic!("{errors}"))];
    let registry = Registry::new(&[afterimage_nodes::ALL, &kinds]).expect("no two kinds share a name");
    let text = r#"Pipeline(
        inputs: { "scene": Color },
        nodes: {
            "scaled": Scaled(source: "scene"),
            "soft": Gaussian(source: "scaled", sigma: 2.0),
            "lit": Composite(base: "scaled", bloom: "soft@previous"),
        },
        outputs: { "scaled": "scaled", "lit": "lit" },
    )"#;
    let document = parse("endurance.ron", text).unwrap_or_else(|errors| panic!("{errors}"));
    check(&document, &registry, &CheckOptions::default()).unwrap_or_else(|errors| panic!("{errors}")).0
}

/// A program that runs long.
struct Program {
    gpu: Gpu,
    session: Session,
    edit: u32,
    resized: u32,
}

impl Program {
    fn open() -> Self {
        let opening = Opening { adapter: std::env::var("AFTERIMAGE_ADAPTER").ok(), ..Opening::default() };
        let gpu = Gpu::open(&opening).unwrap_or_else(|error| panic!("{error}"));
        let session = Session::new(&gpu, edited(0), Facts::default(), options());
        Self { gpu, session, edit: 0, resized: 0 }
    }

    fn round(&mut self, round: &Round) {
        for _ in 0..round.reloads {
            self.edit += 1;
            self.session.change(edited(self.edit), options());
            self.frame(SIZE, true);
            self.check(SIZE);
        }
        for _ in 0..round.resizes {
            self.resized += 1;
            let size = Size::new(33 + self.resized * 37 % 64, 17 + self.resized * 23 % 48);
            self.frame(size, true);
            self.check(size);
        }
        for frame in 0..round.frames {
            self.frame(SIZE, frame == 0);
        }
        if round.reloads + round.frames > 0 {
            self.check(SIZE);
        }
        for _ in 0..round.openings {
            let mut other = Self::open();
            other.frame(SIZE, true);
            other.check(SIZE);
        }
        self.gpu.wait().unwrap_or_else(|error| panic!("{error}"));
    }

    fn frame(&mut self, size: Size, reset: bool) {
        let pixels = vec![[LIGHT, LIGHT, LIGHT, 1.0]; (size.width * size.height) as usize];
        let texels = Texels::from_floats(size.width, size.height, &pixels);
        let image: Result<InputImage, _> = self.session.feed("scene", texels.desc, &texels.bytes);
        let image = image.unwrap_or_else(|error| panic!("{error}"));
        let step = FrameStep { time: 0.0, dt: 0.1, kind: FrameKind::cut_if(reset) };
        self.session.render(size, &[image], step).unwrap_or_else(|error| panic!("{error}"));
    }

    /// The output is that of the last edit, in the last size.
    fn check(&mut self, size: Size) {
        let texels = self.session.output("scaled").unwrap_or_else(|error| panic!("{error}"));
        let expected = LIGHT * factor(self.edit);
        assert_eq!(texels.desc.size, size);
        let wrong = texels.to_floats().into_iter().find(|pixel| pixel[..3] != [expected; 3]);
        assert_eq!(wrong, None, "edit {} is not {expected}", self.edit);
    }
}

fn options() -> Options {
    Options { exact: true, ..Options::default() }
}

/// A full round, or what `AFTERIMAGE_ENDURANCE_ONLY` names: one kind of work alone, twice as often.
fn asked_round() -> Round {
    let none = Round { reloads: 0, resizes: 0, frames: 0, openings: 0 };
    match std::env::var("AFTERIMAGE_ENDURANCE_ONLY").as_deref() {
        Err(_) | Ok("") => FULL,
        Ok("reloads") => Round { reloads: 2 * FULL.reloads, ..none },
        Ok("resizes") => Round { resizes: 2 * FULL.resizes, ..none },
        Ok("frames") => Round { frames: 2 * FULL.frames, ..none },
        Ok("openings") => Round { openings: 2 * FULL.openings, ..none },
        Ok(other) => panic!("`{other}` is none of `reloads`, `resizes`, `frames`, `openings`"),
    }
}

/// `AFTERIMAGE_ENDURANCE` is the number of full rounds and the folder of the record: `200 target/endurance`.
#[test]
#[cfg_attr(any(no_gpu, not(target_os = "linux")), ignore = "needs a GPU and the files of Linux about a process")]
fn memory_and_descriptors_stay_flat() {
    let asked = std::env::var("AFTERIMAGE_ENDURANCE").ok();
    let asked = asked.as_deref().and_then(|text| text.split_once(' '));
    let full = asked.map(|(rounds, folder)| (rounds.parse::<u32>().expect("a number of rounds"), folder));
    let (rounds, round) = full.map_or((4, SMALL), |(rounds, _)| (rounds, asked_round()));
    let mut program = Program::open();
    let mut record = Record::default();
    for number in 1..=rounds {
        program.round(&round);
        record.push(Sample::now());
        if full.is_some() {
            eprintln!("round {number} of {rounds}: {}", record.last());
        }
    }
    assert_eq!((program.edit, program.resized), (rounds * round.reloads, rounds * round.resizes));
    // In the ordinary test other tests run in the same process, and a few small rounds end before caches are full.
    if let Some((_, folder)) = full {
        record.write(folder);
        assert_eq!(record.more_descriptors(), 0, "descriptors of the second half");
        assert!(record.is_flat(), "{}", record.verdict());
    }
}
