//! The classes of input, with what each may take.

use afterimage_fuzz::{Inputs, Target};
use afterimage_generators::BOMBS;

use crate::case::Case;
use crate::outcome::Budget;
use crate::{cameras, frames, images, lines, places, shaders, texts};

/// Cases of one sort.
pub(crate) struct Class {
    pub(crate) name: &'static str,
    pub(crate) what: &'static str,
    pub(crate) cases: u64,
    pub(crate) budget: Budget,
    pub(crate) make: fn(&Sources, u64) -> Case,
}

/// The generators of mutated files.
pub(crate) struct Sources {
    pub(crate) seed: u64,
    pub(crate) documents: Inputs,
    pub(crate) declarations: Inputs,
    pub(crate) shaders: Inputs,
    pub(crate) workgroups: Inputs,
    pub(crate) cubes: Inputs,
    pub(crate) color_files: Inputs,
    pub(crate) images: Inputs,
}

impl Sources {
    pub(crate) fn new(seed: u64) -> Self {
        let of = |target| Inputs::new(target, seed);
        Self {
            seed,
            documents: of(Target::Document),
            declarations: of(Target::Declaration),
            shaders: of(Target::Linker),
            workgroups: of(Target::Workgroup),
            cubes: of(Target::Cube),
            color_files: of(Target::ColorFile),
            images: of(Target::Image),
        }
    }
}

/// Checking and planning. [`limits.md`](../../../../graph/docs/limits.md) has the limits that keep them short.
const PLAN: Budget = Budget { seconds: 3.0, megabytes: 500 };
/// The limits for compiling a kind, and all that the program does beside it.
const KERNEL: Budget = Budget { seconds: 2.0, megabytes: 300 };
/// A device on the processor takes about 170 MB.
const RENDER: Budget = Budget { seconds: 5.0, megabytes: 500 };
/// The same, and images of at most 128 MB.
const DECODE: Budget = Budget { seconds: 5.0, megabytes: 600 };

/// All classes, in the order of the table.
pub(crate) fn classes() -> Vec<Class> {
    let class = |name, what, cases, budget, make| Class { name, what, cases, budget, make };
    let bombs = (BOMBS.len() * texts::SIZES.len()) as u64;
    vec![
        class("pipelines", "shipped and broken pipelines, mutated; `check --plan`", 4000, PLAN, texts::pipeline),
        class("bombs", "expensive pipelines of six sizes; `plan` at 3840x2160", bombs, PLAN, texts::bomb),
        class("texts", "pipeline files that are no text, or nested without end", 1000, PLAN, texts::odd),
        class("tables", "color files, mutated", 3000, PLAN, texts::table),
        class("declarations", "`node.ron`, mutated", 2000, PLAN, shaders::declaration),
        class("shaders", "shaders of folders, mutated; `check --plan`", 4000, PLAN, shaders::checked),
        class("kernels", "shaders of folders, generated and mutated; rendered", 10_000, KERNEL, shaders::rendered),
        class("shader-bombs", "expensive shaders of nine sizes; rendered", shaders::bombs(), KERNEL, shaders::bomb),
        class(
            "workgroups",
            "shaders of folders with memory of a workgroup: mutated, or expensive; rendered",
            1000,
            KERNEL,
            shaders::workgroup,
        ),
        class("images", "EXR, Radiance and PNG files, mutated; rendered", 4000, DECODE, images::mutated),
        class("image-bombs", "small images that claim to be large; rendered", images::bombs(), DECODE, images::bomb),
        class(
            "frames",
            "images of NaN, infinities, huge and zero numbers for each kind that reads images, depth or motion; rendered",
            frames::cases(),
            RENDER,
            frames::case,
        ),
        class(
            "cameras",
            "files of cameras that are none, for a folder kind and a built-in one, and images as in `frames`; rendered",
            600,
            RENDER,
            cameras::case,
        ),
        class(
            "places",
            "pipes, devices, sockets, folders, links in place of each file",
            places::cases(),
            RENDER,
            places::case,
        ),
        class("lines", "command lines of random words", 3000, RENDER, lines::line),
    ]
}
