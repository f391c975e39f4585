//! Downsample: a pyramid of images, each half the size of the previous one.

use afterimage_graph::prelude::*;

static SHADER: Shader = shader!("downsample");
static ANY_SIZE: Shader = shader!("downsample_any");
static ROWS: Shader = shader!("downsample_rows");

choices! {
    /// The filter of one halving, from the cheapest to the one with the least aliasing.
    pub enum DownsampleFilter {
        /// 2x2 texels, 1 read: fine bright detail flickers.
        Box,
        /// 4x4 texels of equal weight, 4 reads.
        Tap4,
        /// 4x4 texels with the weights 1 3 3 1 along each axis, 4 reads: a tent.
        Tap9,
        /// Five overlapping squares, 6x6 texels, 13 reads: the least aliasing (Jimenez, 2014).
        Tap13,
        /// 6x6 texels with the weights 1 5 10 10 5 1 along each axis, 9 reads: the glow of a small light changes the
        /// least when the light moves. A first halving with `firefly` is that of `Tap13`.
        Binomial,
    }
}

choices! {
    /// How the first halving weights bright pixels down. The weights take energy from every small light, and how much
    /// depends on where it lies between texels, so its bloom flickers when it moves. `fireflies: Limit` of `Extract`
    /// does not. Energy that `Tap13` keeps of a light of 200 times white, over its positions between pixels: with `Off`
    /// 100 %; with `Groups` 39 to 69 % of 1x1 pixels, 33 to 64 % of 2x2 and 53 to 73 % of 4x4; with `Taps` 2 to 8 %, 2
    /// to 4 % and 2 to 17 %.
    pub enum Firefly {
        /// It does not: small lights keep all of their energy.
        Off,
        /// The five squares of `Tap13` are weighted by 1 / (1 + brightness). With a cheaper filter the first halving is
        /// a `Tap4` whose corners are weighted together with the center, 5 reads, so that a change of the filter keeps
        /// the look.
        Groups,
        /// Each tap is weighted by 1 / (1 + brightness): the strongest. It also dims small lights that are intended
        /// (Karis, 2013). `Box` has one tap, so its four texels are weighted.
        Taps,
    }
}

choices! {
    /// What lies beyond the border of an image.
    pub enum Border {
        /// Half of its nearest pixel: for light that spreads. Levels end at the border, so black would lose the light
        /// that comes back from beyond it, and the nearest pixel would reflect all. Where a `Composite` with
        /// `blend: Mix` reads the result, it is a mean of the picture, and this is as `Edge`.
        Open,
        /// Its nearest pixel: for means, such as a blurred picture. A constant image stays the same.
        Edge,
    }
}

node_kind! {
    /// Makes a pyramid of images, each half the size of the previous one.
    ///
    /// The first level is half the size of the source. Sizes are rounded down and at least 1.
    ///
    /// The weights of every filter sum to 1, so away from the border a constant image stays the same on every level.
    /// Without `firefly`, each pixel has the same weight in the sum of a level, but for those at the border, also where
    /// a side is odd: the light of a moving lamp stays the same. Alpha is filtered like color.
    pub struct Downsample {
        /// Number of levels. A small source has fewer: halving ends at one texel.
        pub levels: u32 = 6 => within(1.0..=16.0), usually(2.0..=8.0);
        /// Height of the frame for which `levels` is meant. Other frames have as many more or fewer levels as they are
        /// larger or smaller by halves, so that the coarsest keeps its share of the picture. With 0, `levels` holds for
        /// every frame.
        pub lines: u32 = 0 => within(0.0..=16384.0), logarithmic(), unit("pixels");
        /// The filter of each halving.
        pub filter: DownsampleFilter = DownsampleFilter::Tap13 => quality(
            DownsampleFilter::Tap13,
            [DownsampleFilter::Tap9, DownsampleFilter::Tap4, DownsampleFilter::Box]
        );
        /// How the first halving limits single very bright pixels. Brightness is the largest channel.
        pub firefly: Firefly = Firefly::Off => neutral(Firefly::Off);
        /// What lies beyond the border of the image.
        pub border: Border = Border::Open;
    }

    const INPUTS: &'static [Input] = &[Input::image("source", "The image to downsample.")];
    const OUTPUTS: &'static [Output] = &[
        Output::new("result", PortType::Pyramid, OutputState::same("source"), "The levels, finest first."),
        Output::image("coarsest", OutputState::same("source"), "The coarsest level: a small image for wide blurs."),
    ];
}

impl DownsampleFilter {
    /// Distance of the outermost taps from the center, in texels.
    fn reach(self) -> f32 {
        match self {
            Self::Box => 0.0,
            Self::Tap4 | Self::Tap9 => 1.0,
            Self::Tap13 | Self::Binomial => 2.0,
        }
    }
}

/// By how many halvings a frame is larger than one of `lines`; 0 for 0 lines. Nearly whole numbers are whole: a level
/// with next to no weight would be made for nothing.
pub(crate) fn octaves(frame: Size, lines: u32) -> f64 {
    if lines == 0 {
        return 0.0;
    }
    let octaves = (f64::from(frame.height) / f64::from(lines)).log2();
    let whole = octaves.round();
    if (octaves - whole).abs() < 0.02 { whole } else { octaves }
}

/// Records one halving of a picture by `Tap13`.
pub(crate) fn halve(pass: &mut Recorder<'_>, source: ImageId, level: ImageId) {
    let downsample = Downsample { filter: DownsampleFilter::Tap13, firefly: Firefly::Off, ..Downsample::default() };
    downsample.halve(pass, source, level, false, Border::Edge);
}

impl Downsample {
    fn function(&self, is_first: bool) -> &'static str {
        let firefly = if is_first { self.firefly } else { Firefly::Off };
        match (self.filter, firefly) {
            (DownsampleFilter::Tap13 | DownsampleFilter::Binomial, Firefly::Groups) => "downsample_tap13_groups",
            (_, Firefly::Groups) => "downsample_tap4_groups",
            (DownsampleFilter::Box, Firefly::Off) => "downsample_box",
            (DownsampleFilter::Box, Firefly::Taps) => "downsample_box_taps",
            (DownsampleFilter::Tap4, Firefly::Off) => "downsample_tap4",
            (DownsampleFilter::Tap4, Firefly::Taps) => "downsample_tap4_taps",
            (DownsampleFilter::Tap9, Firefly::Off) => "downsample_tap9",
            (DownsampleFilter::Tap9, Firefly::Taps) => "downsample_tap9_taps",
            (DownsampleFilter::Tap13, Firefly::Off) => "downsample_tap13",
            (DownsampleFilter::Tap13 | DownsampleFilter::Binomial, Firefly::Taps) => "downsample_tap13_taps",
            (DownsampleFilter::Binomial, Firefly::Off) => "downsample_binomial",
        }
    }
}

impl Downsample {
    /// Distance of the outermost taps of a halving from the center, in texels.
    fn reach(&self, is_first: bool) -> f32 {
        let weighs = is_first && self.firefly == Firefly::Groups;
        if weighs { self.filter.reach().max(1.0) } else { self.filter.reach() }
    }

    /// The function for sides that are not exactly halved.
    fn any_size_function(&self, is_first: bool) -> &'static str {
        let firefly = if is_first { self.firefly } else { Firefly::Off };
        match (self.filter, firefly) {
            (DownsampleFilter::Tap13 | DownsampleFilter::Binomial, Firefly::Groups) => "downsample_any_tap13_groups",
            (_, Firefly::Groups) => "downsample_any_tap4_groups",
            (DownsampleFilter::Box, Firefly::Off) => "downsample_any_box",
            (DownsampleFilter::Box, Firefly::Taps) => "downsample_any_box_taps",
            (DownsampleFilter::Tap4, Firefly::Off) => "downsample_any_tap4",
            (DownsampleFilter::Tap4, Firefly::Taps) => "downsample_any_tap4_taps",
            (DownsampleFilter::Tap9, Firefly::Off) => "downsample_any_tap9",
            (DownsampleFilter::Tap9, Firefly::Taps) => "downsample_any_tap9_taps",
            (DownsampleFilter::Tap13, Firefly::Off) => "downsample_any_tap13",
            (DownsampleFilter::Tap13 | DownsampleFilter::Binomial, Firefly::Taps) => "downsample_any_tap13_taps",
            (DownsampleFilter::Binomial, Firefly::Off) => "downsample_any_binomial",
        }
    }

    fn halve(&self, pass: &mut Recorder<'_>, source: ImageId, level: ImageId, is_first: bool, border: Border) {
        let edge = f32::from(u8::from(border == Border::Edge));
        let (from, to) = (pass.desc(source).size, pass.desc(level).size);
        // Taps of a texture unit are means of whole texels at this ratio, and at no other.
        let is_exact = from.width == 2 * to.width && from.height == 2 * to.height;
        let (shader, function) =
            if is_exact { (&SHADER, self.function(is_first)) } else { (&ANY_SIZE, self.any_size_function(is_first)) };
        pass.function(shader, function)
            .label(format_args!("{function} {to}"))
            .read("source", source)
            .set("edge", edge)
            .by_rows(self.by_rows(is_first, border, is_exact))
            .write_to(level);
    }

    /// By rows, a tent is of whole texels: it has no form for sides that are not exactly halved.
    fn by_rows(&self, is_first: bool, border: Border, is_exact: bool) -> Option<ByRows> {
        let function = match self.function(is_first) {
            "downsample_box" => "downsample_rows_box",
            "downsample_tap4" => "downsample_rows_tap4",
            "downsample_tap9" if is_exact => "downsample_rows_tap9",
            "downsample_tap13" => "downsample_rows_tap13",
            "downsample_tap13_groups" => "downsample_rows_tap13_groups",
            "downsample_binomial" => "downsample_rows_binomial",
            _ => return None,
        };
        let (reach, is_open) = (self.reach(is_first), border == Border::Open);
        Some(ByRows { shader: &ROWS, function, state: "DownsampleRows", reach, is_open })
    }
}

impl Node for Downsample {
    fn invariants(&self, declared: Invariants) -> Invariants {
        let is_mean = self.border == Border::Edge;
        Invariants { constant: is_mean, keeps_constant: is_mean, keeps_sum: self.firefly == Firefly::Off, ..declared }
    }

    fn is_identity(&self, inputs: &InputValues) -> bool {
        inputs.is_zero("source")
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let is_averaged = pass.is_output_averaged("result") || pass.is_output_averaged("coarsest");
        let border = if is_averaged { Border::Edge } else { self.border };
        let mut above = pass.image("source");
        let mut desc = ImageDesc::new(pass.desc(above).size);
        let more = octaves(pass.frame_size, self.lines).ceil() as i64;
        let count = (i64::from(self.levels) + more).min(i64::from(desc.size.levels())).max(1);
        for index in 0..count {
            desc = desc.half();
            let level = pass.level(format_args!("result.{index}"), desc);
            self.halve(pass, above, level, index == 0, border);
            pass.add_output_level("result", level);
            above = level;
        }
        pass.set_output("coarsest", InputValue::Image(above));
    }
}
