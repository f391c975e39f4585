//! The table of a run: its layout, and the passes that fill it and read it.

use afterimage_base::image::{Format, ImageDesc, Signedness, Size};
use afterimage_graph::node::{Arg, ImageId, KernelCall, Origin, Pass, Recording, VirtualImage};
use afterimage_wgsl::{Shader, UniformValue};

use super::run::Run;

#[allow(unsafe_code, reason = "the shader was unchecked")]
// SAFETY: all texels that it reads are clamped to the table, and it has no loops and no buffers.
static SHADER: Shader = unsafe { Shader::unchecked("bake.wgsl", include_str!("bake.wgsl")) };

/// Texels in a row, at least: with half as many, grays of the smallest table would be off by a quarter of a code of 8
/// bits.
const MIN_WIDTH: u32 = 4096;

/// Random colors for which a table is compared with its nodes, and below them the grays.
const COMPARED: Size = Size { width: 1024, height: 1024 + 64, depth: 1 };

/// Parts of a table of each kind: for colors without a negative channel, and for others.
const PARTS: u32 = 3;

/// The layout of a table.
///
/// A color is its largest channel, its level, and the ratios of the other two to it. The three channels that may be the
/// largest have two parts of the table each: one for colors without a negative channel, and one for the others. Tone
/// curves bend along the levels alone, and hues and gamuts along the ratios, which makes the errors of a table with
/// these axes about a third of those of a cube with as many entries.
#[derive(Clone, Copy)]
pub(super) struct Table {
    /// Texels in a row: a power of two, so that the place of a texel as a share of the row is exact, and a gray is no
    /// mixture with other colors.
    width: u32,
    /// Steps between levels, in the parts for colors without a negative channel and in the others.
    levels: [u32; 2],
    /// Steps between ratios. The others have twice as many: colors of wide gamuts change fast along them.
    ratios: [u32; 2],
    /// Steps between negative ratios, in the parts for colors with a negative channel.
    negative: u32,
}

impl Table {
    /// The table of that [size](afterimage_graph::node::Bake::size).
    pub(super) fn new(size: u32) -> Self {
        let inside = size * 3 / 4;
        let width = (2 * size * (inside + 1)).next_power_of_two().max(MIN_WIDTH);
        let ratios = [inside, 2 * inside];
        Self { width, levels: ratios.map(|steps| width / (steps + 1) - 1), ratios, negative: 2 * inside * 2 / 3 }
    }

    /// One ratio within the levels from left to right, the other one within the parts from top to bottom.
    fn texels(self) -> Size {
        Size::new(self.width, self.ratios.iter().map(|steps| PARTS * (steps + 1)).sum())
    }

    /// The longest side of its image.
    pub(super) fn side(self) -> u32 {
        self.width
    }

    /// The pass that fills the table by `kernels`, whose first one reads the kernel before it, and the one that reads
    /// it; if its error is measured, the one that compares both.
    pub(super) fn passes(
        self,
        recording: &mut Recording,
        run: &Run,
        nodes: &[String],
        kernels: Vec<KernelCall>,
        measures_error: bool,
    ) -> Vec<Pass> {
        let node = nodes.first().map_or("", String::as_str);
        let result = recording.image(run.result);
        let signedness = result.signedness;
        // What each frame fills is like any image of a frame.
        let origin = if run.reads_value { Origin::Transient } else { Origin::Retained };
        let desc = ImageDesc::new(self.texels()).format(Format::Rgba16Float);
        let label = format!("{node}.table");
        let table = recording.add_image(VirtualImage { label, desc, origin, finite: true, signedness });
        let uniform = self.uniform(signedness);
        let call = |function: &'static str, args: &[(&str, Arg)]| KernelCall {
            uniform: uniform.clone(),
            ..KernelCall::function(node, &SHADER, function, args)
        };
        let of_nodes = |label: &str, kernels: Vec<KernelCall>, image: ImageId| {
            Pass::of_functions(nodes.to_vec(), label.to_owned(), kernels, image)
        };
        let look_up = |source: Arg| {
            let table = ("table", Arg::Texture(table));
            call("bake", &[("source", source), table, ("linear", Arg::Sampler), ("params", Arg::Params)])
        };
        let mut passes = Vec::new();
        if measures_error {
            let desc = ImageDesc::new(COMPARED).format(Format::Rgba32Float);
            // Several tables may begin with one node.
            let last = nodes.last().map_or("", String::as_str);
            let (label, origin) = (format!("{last}.table_error"), Origin::Transient);
            let error = recording.add_image(VirtualImage {
                label,
                desc,
                origin,
                finite: true,
                signedness: Signedness::Unsigned,
            });
            let plain =
                |function: &'static str, args: &[(&str, Arg)]| KernelCall::function(node, &SHADER, function, args);
            let colors = if run.is_exposed { "bake_random_exposed" } else { "bake_random_display" };
            let mut compare = [vec![plain(colors, &[("at", Arg::Point)])], kernels.clone()].concat();
            compare.push(look_up(Arg::Kernel(0)));
            let last = kernels.len();
            compare.push(plain("bake_error", &[("exact", Arg::Kernel(last)), ("shown", Arg::Kernel(last + 1))]));
            passes.push(of_nodes("compare table", compare, error));
        }
        let colors = call("bake_color", &[("at", Arg::Point), ("params", Arg::Params)]);
        passes.insert(0, of_nodes("fill table", [vec![colors], kernels].concat(), table));
        passes.push(of_nodes("look up", vec![look_up(Arg::Pixel(run.source))], run.result));
        passes
    }

    fn uniform(self, signedness: Signedness) -> Vec<u8> {
        let lowest = if signedness == Signedness::Unsigned { 0.0 } else { -65504.0 };
        let floats = |numbers: &[u32]| numbers.iter().map(|number| *number as f32).collect();
        let Size { width, height, .. } = self.texels();
        let values = [
            ("levels", floats(&self.levels)),
            ("ratios", floats(&self.ratios)),
            ("rows", vec![0.5, 0.5 + (PARTS * (self.ratios[0] + 1)) as f32]),
            ("negative", floats(&[self.negative])),
            ("lowest", vec![lowest]),
            ("texel", vec![1.0 / width as f32, 1.0 / height as f32]),
        ]
        .map(|(name, numbers)| (name, UniformValue::Floats(numbers)));
        let reflection = SHADER.reflect().expect("the shader is valid");
        reflection.pack("Bake", &values).expect("the struct has these numbers")
    }
}
