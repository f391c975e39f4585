//! ColorLut: grades by a look-up table from a file.

use std::sync::Arc;

use afterimage_graph::image::Signedness;
use afterimage_graph::node::FunctionPass;
use afterimage_graph::prelude::*;

use afterimage_color::lut::{Interpolation, Lut, PngLayout, Table, TableImage};
use afterimage_color::lut_decoded::Decoded;
use afterimage_color::lut_file::LutFile;
use afterimage_color::process::{Conversion, LutSpace, LutState, Process, Step, function};
use afterimage_color::shaper::{Shape, Shaper};

static SHADER: Shader = shader!("color_lut");

choices! {
    /// The precision of a table's entries and weights.
    pub enum LutPrecision {
        /// 32 bits for both.
        Exact,
        /// Entries in 16 bits. Trilinear weights in the 8 bits of the device's filter, with one fetch instead of eight.
        Fast,
    }
}

node_kind! {
    /// Grades by a look-up table or another color file.
    ///
    /// The file is a `.cube` table, a PNG with a strip or rows of tiles or in HALD layout, or a `.clf` file in Common
    /// LUT Format (version 3, SMPTE ST 2136-1): tables, matrices, ranges, logarithms, powers and color decision lists
    /// in any order. Other formats are read by `OcioTransform`, of programs with the feature `ocio`.
    ///
    /// State in `from` the space that the table was made for, and in `to` that of its results. Without them, the author
    /// of the table decides, and the node belongs where the image is in that space. With them, the node converts. A
    /// look for sRGB works on light, before `Encode`, as it would after it, and a table that contains a display
    /// transform replaces `ToneMap` and `Encode`, with `state`. Colors outside of a table's domain use its border. For
    /// light above 1, state `from`, or set `shaper` to the spacing of the table's axes; the domain in the file applies
    /// after the shaper.
    ///
    /// The steps of a `.clf` file and the conversions are computed for each pixel, in 32 bits, and not baked into a
    /// table. An error in the file is reported with its line. The node is skipped if `strength` is 0 and the state
    /// stays; a table that changes nothing within its domain still limits colors to it.
    pub struct ColorLut {
        /// The file. Without a file the node changes nothing.
        pub file: FileValue = FileValue::default();
        /// The space of the colors that the table expects. An image in another space is converted to it.
        pub from: LutSpace = LutSpace::Same;
        /// The space of the colors that the table returns. They are converted to the result.
        pub to: LutSpace = LutSpace::Same;
        /// The color state of the result.
        pub state: LutState = LutState::Source;
        /// For `Pq`: the luminance of light of 1, which is SDR white.
        pub white_nits: f32 = 203.0 => within(1.0..=10000.0), usually(80.0..=400.0), unit("cd/m2"), replans();
        /// For a PNG: the layout of the table.
        pub layout: PngLayout = PngLayout::Tiles;
        /// How a color maps to a position in the table.
        pub shaper: Shaper = Shaper::None;
        /// For `Log2`: the darkest light of the table.
        pub low: f32 = -12.0 => within(-24.0..=4.0), usually(-16.0..=-6.0), unit("stops from 1");
        /// For `Log2` and `LogC`: the brightest light of the table.
        pub high: f32 = 6.0 => within(5.0..=16.0), usually(5.0..=10.0), unit("stops from 1");
        /// How a 3-D table is interpolated. A `.clf` file decides itself.
        pub interpolation: Interpolation = Interpolation::Tetrahedral;
        /// The precision of entries and weights. `.clf` files, and tables with `from` or `to`, are always `Exact`.
        pub precision: LutPrecision = LutPrecision::Exact => quality(LutPrecision::Exact, [LutPrecision::Fast]);
        /// Share of the table's result, in the space of `to`. 0 changes nothing.
        pub strength: f32 = 1.0 => within(0.0..=1.0), neutral(0.0);
    }

    const INPUTS: &'static [Input] =
        &[Input::image("source", "The image. Without `from`, in the state that the table was made for.").accepts(&[
            ColorState::Exposed,
            ColorState::DisplayLinear,
            ColorState::Encoded,
        ])];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::chosen("state"), "The graded image.").or_input("source")];
    const INVARIANTS: Invariants = Invariants::OF_COLOR;
}

impl Node for ColorLut {
    fn is_identity(&self, _: &InputValues) -> bool {
        self.state == LutState::Source && (self.strength == 0.0 || self.file.bytes.is_none())
    }

    fn verify(&self) -> Result<(), String> {
        let decoded = self.decoded();
        match decoded.content.as_ref().map_err(|error| format!("`{}`: {error}", self.file.path))? {
            LutFile::Table(lut) if self.shaper != Shaper::None && lut.curve.is_some() && lut.cube.is_some() => {
                return Err(format!("`{}` has a 1-D table as its shaper: remove `shaper`", self.file.path));
            }
            LutFile::Process(_) if self.shaper != Shaper::None => {
                return Err(format!("`{}` has steps of its own before its tables: remove `shaper`", self.file.path));
            }
            _ => {}
        }
        self.verify_state()
    }

    fn color(&self) -> ColorChange {
        let encoded = || self.result_space().colorimetry(f64::from(self.white_nits));
        match self.state {
            LutState::Source => ColorChange::Keep,
            LutState::DisplayLinear => ColorChange::ToDisplay,
            LutState::Encoded => encoded().map_or(ColorChange::Keep, ColorChange::Encode),
        }
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let decoded = self.decoded();
        match &decoded.content {
            Ok(LutFile::Process(process)) => self.record_process(pass, || process.clone()),
            Ok(LutFile::Table(lut)) if !self.is_plain() => self.record_process(pass, || self.process(lut)),
            Ok(LutFile::Table(lut)) => self.record_table(pass, &decoded, lut),
            // `verify` has rejected files that cannot be read.
            Err(_) => self.record_table(pass, &decoded, &Lut::identity()),
        }
    }
}

/// The pass of a process, which stays the same while `strength` moves.
struct ProcessPass {
    of: ProcessKey,
    shader: Arc<Shader>,
    images: Vec<TableImage>,
}

/// The inputs of the pass of a process, besides the file.
#[derive(Clone, Copy, PartialEq)]
struct ProcessKey {
    conversion: Conversion,
    layout: PngLayout,
    shaper: Shaper,
    shape: Shape,
    interpolation: Interpolation,
    is_extended: bool,
}

impl ColorLut {
    /// True if the table works on the numbers of the image.
    fn is_plain(&self) -> bool {
        self.from == LutSpace::Same && self.to == LutSpace::Same
    }

    fn decoded(&self) -> Arc<Decoded> {
        Decoded::of(&self.file, self.layout)
    }

    fn verify_state(&self) -> Result<(), String> {
        let state = self.state.name();
        match self.state {
            LutState::Source => Ok(()),
            _ if self.file.bytes.is_none() => Err(format!("`state: {state}` needs a `file`")),
            _ if self.is_plain() => Err(format!("`state: {state}` needs `to`: the space of the table's results")),
            LutState::Encoded if !self.result_space().is_for_displays() => {
                Err(format!("`{}` is no space of encoded images", self.result_space().name()))
            }
            _ => Ok(()),
        }
    }

    fn result_space(&self) -> LutSpace {
        if self.to == LutSpace::Same { self.from } else { self.to }
    }

    /// The shaper and the table as steps.
    fn process(&self, lut: &Lut) -> Process {
        let shaper = match self.shaper {
            Shaper::None => Vec::new(),
            Shaper::Srgb => LutSpace::Srgb.encode(f64::from(self.white_nits)),
            Shaper::Log2 | Shaper::LogC => vec![Step::Shape(self.shape())],
        };
        let table = Process::of_table(lut, self.interpolation);
        Process::new(shaper.into_iter().chain(table.steps))
    }

    fn record_process(&self, pass: &mut Recorder<'_>, process: impl Fn() -> Process) {
        let source = pass.color("source").colorimetry;
        let result = pass.output_color("result").colorimetry.primaries;
        let (from, to, state, white_nits) = (self.from, self.to, self.state, f64::from(self.white_nits));
        let is_extended = pass.output_color("result").state.signedness() == Signedness::Extended;
        let key = ProcessKey {
            conversion: Conversion { from, to, state, white_nits, source, result },
            layout: self.layout,
            shaper: self.shaper,
            shape: self.shape(),
            interpolation: self.interpolation,
            is_extended: is_extended && !self.is_plain(),
        };
        let make = || ProcessPass::new(key, process());
        let known = match &self.file.bytes {
            Some(bytes) => bytes.read(|known: &ProcessPass| known.of == key, |_| make()),
            None => Arc::new(make()),
        };
        let source = pass.image("source");
        let desc = ImageDesc::new(pass.desc(source).size);
        let kernel = pass.function(known.shader.clone(), ProcessPass::FUNCTION);
        known.images.iter().fold(kernel, with_table).write("result", desc);
    }

    fn record_table(&self, pass: &mut Recorder<'_>, decoded: &Decoded, lut: &Lut) {
        let source = pass.image("source");
        let desc = ImageDesc::new(pass.desc(source).size);
        let half = self.precision == LutPrecision::Fast && !pass.exact;
        let ([curve_low, curve_scale], [cube_low, cube_scale]) = (domain(&lut.curve), domain(&lut.cube));
        let shape = self.shape();
        let kernel = pass
            .function(&SHADER, self.kernel(lut))
            .set("line", shape.line)
            .set("shaper_curve", shape.curve)
            .set("curve_count", lut.curve.as_ref().map_or(2, |table| table.size as u32))
            .set("curve_low", curve_low)
            .set("curve_scale", curve_scale)
            .set("cube_low", cube_low)
            .set("cube_scale", cube_scale);
        decoded.images(lut, half).iter().fold(kernel, with_table).write("result", desc);
    }

    fn shape(&self) -> Shape {
        match self.shaper {
            Shaper::None | Shaper::Srgb => Shape::NONE,
            Shaper::Log2 => Shape::log2(f64::from(self.low), f64::from(self.high)),
            Shaper::LogC => Shape::log_c(f64::from(self.high)),
        }
    }

    fn kernel(&self, lut: &Lut) -> &'static str {
        let [plain, srgb] = match (lut.curve.is_some(), lut.cube.is_some()) {
            (true, false) => ["color_lut_curve", "color_lut_curve_srgb"],
            (true, true) => [self.kernel_of_both(); 2],
            _ => self.kernels_of_cube(),
        };
        if self.shaper == Shaper::Srgb { srgb } else { plain }
    }

    fn kernels_of_cube(&self) -> [&'static str; 2] {
        match (self.interpolation, self.precision) {
            (Interpolation::Tetrahedral, _) => ["color_lut_tetrahedral", "color_lut_tetrahedral_srgb"],
            (Interpolation::Trilinear, LutPrecision::Exact) => ["color_lut_trilinear", "color_lut_trilinear_srgb"],
            (Interpolation::Trilinear, LutPrecision::Fast) => ["color_lut_fetched", "color_lut_fetched_srgb"],
        }
    }

    fn kernel_of_both(&self) -> &'static str {
        match (self.interpolation, self.precision) {
            (Interpolation::Tetrahedral, _) => "color_lut_both_tetrahedral",
            (Interpolation::Trilinear, LutPrecision::Exact) => "color_lut_both_trilinear",
            (Interpolation::Trilinear, LutPrecision::Fast) => "color_lut_both_fetched",
        }
    }
}

fn domain(table: &Option<Table>) -> [[f64; 3]; 2] {
    match table {
        Some(table) => [table.low.map(f64::from), table.scale()],
        None => [[0.0; 3], [1.0; 3]],
    }
}

impl ProcessPass {
    const FUNCTION: &str = "color_lut_process";

    fn new(of: ProcessKey, process: Process) -> Self {
        let mut parts = of.conversion.around(process);
        parts.is_scene_light = of.is_extended;
        let (text, textures) = function(Self::FUNCTION, &parts);
        Self { of, shader: Arc::new(Shader::loaded("color_lut.wgsl".into(), text)), images: textures.images() }
    }
}

fn with_table<'r, 'a>(kernel: FunctionPass<'r, 'a>, table: &TableImage) -> FunctionPass<'r, 'a> {
    let TableImage { argument, name, desc, bytes } = table;
    kernel.read_constant(argument.clone(), name, *desc, bytes.clone())
}
