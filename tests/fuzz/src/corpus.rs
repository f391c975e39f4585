//! The seeds of mutation: the shipped pipelines, the broken documents of the tests, and tables.

use std::path::{Path, PathBuf};

use crate::declaration::{DECLARATIONS, WORDS as WORDS_OF_DECLARATIONS};
use crate::hostile::{Pair, pair};
use crate::linker::text;
use crate::workgroup::SEEDS as WORKGROUP_SHADERS;

/// Texts, and words that none of them need have.
#[derive(Default)]
pub(crate) struct Corpus {
    pub(crate) texts: Vec<String>,
    pub(crate) words: Vec<String>,
}

/// Words of pipeline files that the shipped ones do not use.
const WORDS: &[&str] = &[
    "extends",
    "set",
    "tiers",
    "facts",
    "when",
    "off",
    "label",
    "format",
    "optional",
    "allow_negative",
    "needs_alpha",
    "\"seen\": Output(source: \"scene\", alpha: Coverage)",
    "scale",
    "true",
    "false",
    "None",
    "Some",
    "@previous",
    "@previous(2)",
    "@previous(17)",
    "night",
    "night > 0.5",
    "!(a && b) || c",
    "unit",
    "Color",
    "Data",
    "Depth",
    "Motion",
    "Camera",
    "\"camera\": Camera(optional: true)",
    "\"depth\": Depth",
    "Pipeline",
    "self.ron",
    "lynx.ron",
    "/*",
    "*/",
    "//",
    "r#\"",
    "\"#",
    "b'",
    "\\u{10ffff}",
    "ä",
    "\u{1F600}",
    "\0",
    "\u{feff}",
];

/// Pairs of shaders that mutation begins with.
const PAIRS: u64 = 24;

/// Words of WGSL that the generated shaders do not use, and pieces that need another piece.
const SHADER_WORDS: &[&str] = &[
    "var<workgroup>",
    "var<private>",
    "var<uniform>",
    "var<immediate>",
    "@group(0)",
    "@binding(0)",
    "@compute",
    "@fragment",
    "@workgroup_size(1)",
    "@id(1)",
    "override",
    "const_assert",
    "alias",
    "enable f16;",
    "requires unrestricted_pointer_parameters;",
    "diagnostic(off, derivative_uniformity);",
    "import super::shared::{help as other};",
    "import afterimage::math;",
    "import package::lib::nothing::{a, b::{c}};",
    "super::shared::help",
    "afterimage::math::power",
    "::",
    "as",
    "array<vec4f, 17>",
    "array<f32>",
    "atomic<u32>",
    "ptr<function, f32>",
    "texture_2d<f32>",
    "texture_storage_2d<rgba16float, write>",
    "sampler",
    "mat4x4f",
    "vec4<f16>",
    "vec3u",
    "i64",
    "f64",
    "Point",
    "Frame",
    "switch",
    "case",
    "default",
    "loop",
    "break",
    "continue",
    "continuing",
    "discard",
    "if",
    "else",
    "while",
    "for",
    "workgroupBarrier()",
    "dpdx(source)",
    "pow",
    "bitcast<u32>",
    "textureLoad",
    "tap",
    "texel",
    "_",
    "__",
    "0x1p-126",
    "1u",
    "1i",
    "1h",
    "1lf",
    "-2147483648",
    "4294967295u",
    "&",
    "&&",
    "->",
    "<<",
    ">>=",
    "/",
    "%",
    "é",
    "\u{2028}",
];

/// Tables of each sort.
const CUBES: &[&str] = &[
    "LUT_3D_SIZE 2\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 0 1\n1 0 1\n0 1 1\n1 1 1\n",
    "TITLE \"a curve\"\nLUT_1D_SIZE 4\nDOMAIN_MIN -0.1 0 0\nDOMAIN_MAX 1 2 100\n0 0 0\n.25 .5 0.75\n5e-1 +1.0 -0.1\n1 1 1\n",
    "# both\nLUT_1D_SIZE 2\nLUT_1D_INPUT_RANGE 0.0 4.0\nLUT_3D_SIZE 2\nLUT_3D_INPUT_RANGE 0.0 1.0\n0 0 0\n1 1 1\n\
     0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 0 1\n1 0 1\n0 1 1\n1 1 1\n",
    "LUT_3D_SIZE 2\r\nDOMAIN_MIN 0 0 0\r\nDOMAIN_MAX 1 1 1\r\n\r\n0 0 0\r\n1 0 0\r\n0 1 0\r\n1 1 0\r\n0 0 1\r\n1 0 1\r\n0 1 1\r\n1 1 1",
    "LUT_1D_SIZE 2\n0 0 0\n1 1 1\n",
    "",
];

fn here(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// The pipelines of a folder with their names, in order.
fn files(folder: &str) -> Vec<(String, String)> {
    let entries = std::fs::read_dir(here(folder)).into_iter().flatten().flatten();
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.path()).collect();
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "ron"));
    paths.sort();
    let named =
        |path: PathBuf| Some((path.file_name()?.to_string_lossy().into_owned(), std::fs::read_to_string(&path).ok()?));
    paths.into_iter().filter_map(named).collect()
}

/// A color file of each kind.
const COLOR_FILES: [&str; 4] = [
    include_str!("../../../graph/color/tests/files/display.clf"),
    include_str!("../../../graph/color/tests/files/teal.clf"),
    include_str!("../../../graph/color/tests/files/warm.cc"),
    include_str!("../../../graph/color/tests/files/edit.cdl"),
];

/// The shipped pipelines with their names.
pub(crate) fn shipped() -> Vec<(String, String)> {
    files("../../pipelines")
}

impl Corpus {
    /// Shipped pipelines, broken documents, and every name of the built-in kinds.
    pub(crate) fn documents() -> Self {
        let broken = files("../../graph/core/tests/errors");
        assert!(broken.len() > 50, "the broken documents are elsewhere");
        let files = shipped().into_iter().chain(broken);
        let mut words: Vec<String> = WORDS.iter().map(|word| (*word).to_owned()).collect();
        for kind in afterimage_nodes::ALL {
            words.push(kind.name().to_owned());
            words.extend(kind.params().iter().map(|param| param.name.to_string()));
            words.extend(kind.inputs().iter().map(|port| port.name.to_string()));
            words.extend(kind.outputs().iter().map(|port| port.name.to_string()));
        }
        Self { texts: files.map(|(_, text)| text).collect(), words }
    }

    /// Declarations of kinds in folders.
    pub(crate) fn declarations() -> Self {
        let owned = |words: &[&str]| words.iter().map(|word| (*word).to_owned()).collect();
        Self { texts: owned(&DECLARATIONS), words: owned(WORDS_OF_DECLARATIONS) }
    }

    /// Shaders with unkind names, and words of the language that they do not use.
    pub(crate) fn shaders() -> Self {
        let kernels = (0..PAIRS).flat_map(|seed| {
            let Pair { hostile, tame } = pair(seed);
            hostile.into_iter().chain(tame)
        });
        let words = SHADER_WORDS.iter().map(|word| (*word).to_owned());
        Self { texts: kernels.map(|kernel| text(&kernel)).collect(), words: words.collect() }
    }

    /// Shaders that share memory of a workgroup, and words of the language that they do not use.
    pub(crate) fn workgroup_shaders() -> Self {
        let owned = |words: &[&str]| words.iter().map(|word| (*word).to_owned()).collect();
        Self { texts: owned(&WORKGROUP_SHADERS), words: owned(SHADER_WORDS) }
    }

    /// Tables of each sort.
    pub(crate) fn cubes() -> Self {
        let words = [
            "LUT_1D_SIZE",
            "LUT_3D_SIZE",
            "DOMAIN_MIN",
            "DOMAIN_MAX",
            "LUT_3D_INPUT_RANGE",
            "TITLE",
            "#",
            "\t",
            "\u{feff}",
        ];
        Self {
            texts: CUBES.iter().map(|text| (*text).to_owned()).collect(),
            words: words.iter().map(|word| (*word).to_owned()).collect(),
        }
    }

    /// Color files of each kind.
    pub(crate) fn color_files() -> Self {
        let words = [
            "<LUT1D inBitDepth=\"32f\" outBitDepth=\"32f\"><Array dim=\"2 1\">0 1</Array></LUT1D>",
            "<ExponentParams exponent=\"2\"/>",
            "halfDomain=\"true\"",
            "rawHalfs=\"true\"",
            "style=\"log2\"",
            "channel=\"R\"",
            "<Info>",
            "</Info>",
            "nan",
            "1e300",
            "-0",
        ];
        Self {
            texts: COLOR_FILES.iter().map(|text| (*text).to_owned()).collect(),
            words: words.iter().map(|word| (*word).to_owned()).collect(),
        }
    }
}
