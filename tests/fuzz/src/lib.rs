//! Fuzzing without a device: every input is accepted or refused with diagnostics, and none causes a panic.
//!
//! The same targets run under cargo-fuzz (`cargo +nightly fuzz run document --fuzz-dir tests/fuzz --features
//! libfuzzer`) and, with inputs that follow from a seed, on any compiler: `cargo run --profile fuzz -p afterimage-fuzz
//! -- --runs 10000000`.

mod bytes;
mod color_file;
mod corpus;
mod cube;
mod damage;
mod declaration;
mod document;
#[path = "../../../graph/wgsl/tests/hostile/mod.rs"]
#[allow(unreachable_pub, dead_code, reason = "tests of other crates use all of it")]
pub mod hostile;
mod image;
mod linker;
mod mutate;
mod pictures;
mod plan;
mod save;
mod tokens;
mod workgroup;

pub use declaration::SHADER as DECLARED_SHADER;
pub use linker::SECOND_FILE;
pub use workgroup::SEEDS as WORKGROUP_SHADERS;

use afterimage_generators::Rng;
use bytes::Bytes;
use corpus::Corpus;
use mutate::Mutator;

/// What is fuzzed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// The text of a pipeline: parsed, checked, planned; its diagnostics in every form.
    Document,
    /// The text of a pipeline, into which changes are saved.
    Save,
    /// A shipped pipeline changed by settings, tiers and switches, planned for any device and frame, and proved.
    Plan,
    /// The text of a `.cube` file.
    Cube,
    /// The text of another color file.
    ColorFile,
    /// The text of a `node.ron`.
    Declaration,
    /// A shader of a folder and a file that it imports: checked, and linked with another.
    Linker,
    /// A shader of a folder whose functions share memory of a workgroup.
    Workgroup,
    /// The bytes of an image.
    Image,
}

impl Target {
    /// Every target.
    pub const ALL: [Self; 9] = [
        Self::Document,
        Self::Save,
        Self::Plan,
        Self::Cube,
        Self::ColorFile,
        Self::Declaration,
        Self::Linker,
        Self::Workgroup,
        Self::Image,
    ];

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Document => "document",
            Self::Save => "save",
            Self::Plan => "plan",
            Self::Cube => "cube",
            Self::ColorFile => "color_file",
            Self::Declaration => "declaration",
            Self::Linker => "linker",
            Self::Workgroup => "workgroup",
            Self::Image => "image",
        }
    }

    /// The share in a mixed run: plans and images take longest, and texts have most ways to be wrong.
    pub fn share(self) -> u64 {
        match self {
            Self::Document => 4,
            Self::Cube | Self::ColorFile => 2,
            Self::Save | Self::Declaration | Self::Plan => 1,
            Self::Linker | Self::Workgroup | Self::Image => 1,
        }
    }

    /// One execution.
    ///
    /// # Panics
    /// If the product does, or breaks a promise: that is what fuzzing looks for.
    pub fn run(self, input: &[u8]) -> bool {
        match self {
            Self::Document => std::str::from_utf8(input).is_ok_and(document::survives),
            Self::Save => std::str::from_utf8(input).is_ok_and(save::survives),
            Self::Plan => plan::survives(&mut Bytes::new(input)),
            Self::Cube => std::str::from_utf8(input).is_ok_and(cube::survives),
            Self::ColorFile => std::str::from_utf8(input).is_ok_and(color_file::survives),
            Self::Declaration => std::str::from_utf8(input).is_ok_and(declaration::survives),
            Self::Linker => std::str::from_utf8(input).is_ok_and(linker::survives),
            Self::Workgroup => std::str::from_utf8(input).is_ok_and(workgroup::survives),
            Self::Image => image::survives(input),
        }
    }
}

/// Inputs of a target, each of which follows from its number alone.
pub struct Inputs {
    target: Target,
    seed: u64,
    mutator: Mutator,
    pictures: Vec<Vec<u8>>,
}

impl Inputs {
    /// The inputs of a target under a seed.
    pub fn new(target: Target, seed: u64) -> Self {
        let corpus = match target {
            Target::Document | Target::Save => Corpus::documents(),
            Target::Plan | Target::Image => Corpus::default(),
            Target::Cube => Corpus::cubes(),
            Target::ColorFile => Corpus::color_files(),
            Target::Declaration => Corpus::declarations(),
            Target::Linker => Corpus::shaders(),
            Target::Workgroup => Corpus::workgroup_shaders(),
        };
        let pictures = if target == Target::Image { pictures::pictures() } else { Vec::new() };
        Self { target, seed, mutator: Mutator::new(&corpus), pictures }
    }

    /// The input of that number.
    pub fn get(&self, number: u64) -> Vec<u8> {
        let mut rng = Rng::new(self.seed.wrapping_mul(0x2545_f491_4f6c_dd1d) ^ number);
        match self.target {
            Target::Plan => (0..plan::MAX_CHOICES).map(|_| rng.below(256) as u8).collect(),
            Target::Image => {
                let file = &self.pictures[rng.below(self.pictures.len())];
                damage::damaged(file, &mut rng)
            }
            _ => self.mutator.text(&mut rng).into_bytes(),
        }
    }
}
