//! Upsample: combines the levels of a pyramid into one image, from the coarsest to the finest.

use afterimage_graph::node::FunctionPass;
use afterimage_graph::prelude::*;

use crate::downsample::{Border, octaves};

static SHADER: Shader = shader!("upsample");

choices! {
    /// The filter that enlarges an image.
    pub enum UpsampleFilter {
        /// 3x3 reads with the weights of a tent: no visible steps of the coarse grid.
        Tent,
        /// One read: the coarse grid is visible as diamonds.
        Bilinear,
    }
}

choices! {
    /// Combination of a level with the coarser ones.
    pub enum UpsampleBlend {
        /// Weighted mean: the coarser levels have the weight `spread`, the level itself the rest. The weights of all
        /// levels sum to 1.
        Mix,
        /// Sum: all levels have equal weight.
        Add,
    }
}

node_kind! {
    /// Combines the levels of a pyramid into one image of the finest level's size.
    ///
    /// It starts with the coarsest level and enlarges with a filter at each step.
    ///
    /// With `Mix`, the level of index i of L levels has the weight (1 - spread) spread^i, and the coarsest
    /// spread^(L-1). With `Add`, each has 1/L, or 1 without `normalize`. In a frame of another height than `lines`, the
    /// weight of a level goes to the level of the same share of the picture, or to the two around it.
    /// Without `smooth`, a pyramid of one level is returned unchanged. Results are limited to 65504. Alpha is combined
    /// like color.
    pub struct Upsample {
        /// How a level is combined with the coarser ones.
        pub blend: UpsampleBlend = UpsampleBlend::Mix;
        /// For `Mix`: the weight of the coarser levels at each step. 0 keeps only the finest level, 1 only the
        /// coarsest.
        pub spread: f32 = 0.7 => within(0.0..=1.0), when("blend", [UpsampleBlend::Mix]);
        /// For `Add`: whether to divide by the number of levels, so that a constant stays the same and strength has the
        /// same meaning for any number of levels.
        pub normalize: bool = true => when("blend", [UpsampleBlend::Add]);
        /// Height of the frame for which the weights are meant, as the `lines` of the pyramid. With 0, they hold for
        /// every frame.
        pub lines: u32 = 0 => within(0.0..=16384.0), logarithmic(), unit("pixels");
        /// Whether a level fades in over the frames between two halvings of `lines`. A `GaussianPyramid` with `lines`
        /// has levels of the same share of the picture in all of them, which keep their weights.
        pub fade: bool = true => unless("lines", [0u32]);
        /// The filter of each enlargement.
        pub filter: UpsampleFilter = UpsampleFilter::Tent => quality(UpsampleFilter::Tent, [UpsampleFilter::Bilinear]);
        /// Distance between the reads of the tent. Above 1.5 the gaps between them become visible.
        pub radius: f32 = 1.0
            => within(0.0..=f64::from(MAX_RADIUS)), usually(0.5..=1.5), unit("texels of the coarser level"),
               when("filter", [UpsampleFilter::Tent]);
        /// Smooths the result by the mean of 3x3 reads, 14/11 of a texel apart. Then a `Composite` enlarges it with one
        /// read a pixel (`Bilinear`), and the glow of a light that moves by a pixel varies less than with a `Tent`: of
        /// one of 2x2 pixels by 3 to 6 %, with a tent by 4 to 17 %, with neither by 30 to 70 %.
        pub smooth: bool = false;
        /// What lies beyond the border of a level.
        pub border: Border = Border::Open;
    }

    const INPUTS: &'static [Input] = &[Input::new("source", PortType::Pyramid, "The levels to combine.")];
    const OUTPUTS: &'static [Output] = &[Output::image(
        "result",
        OutputState::same("source"),
        "One image of the size of the finest level with a weight.",
    )];
}

/// Levels of the largest pyramid, and more.
const MAX_LEVELS: usize = 32;

/// The largest radius of the tent.
pub(crate) const MAX_RADIUS: f32 = 4.0;

/// A filter as it is computed from an image of one size to another.
#[derive(Clone, Copy)]
pub(crate) enum Enlargement {
    Bilinear,
    Tent {
        is_narrow: bool,
    },
    /// A narrow tent to exactly two or four times the size.
    Whole {
        texels: u32,
    },
}

impl UpsampleFilter {
    /// The way to compute the filter. A radius that the host changes may become any.
    pub(crate) fn enlargement(self, [from, to]: [Size; 2], radius: f32, is_dynamic: bool) -> Enlargement {
        let is_narrow = radius <= 1.0 && !is_dynamic;
        let is_whole = |texels: &u32| to.width == texels * from.width && to.height == texels * from.height;
        match (self, [2, 4].into_iter().find(is_whole)) {
            (Self::Bilinear, _) => Enlargement::Bilinear,
            (Self::Tent, Some(texels)) if is_narrow => Enlargement::Whole { texels },
            (Self::Tent, _) => Enlargement::Tent { is_narrow },
        }
    }
}

impl Enlargement {
    pub(crate) fn is_narrow(self) -> bool {
        matches!(self, Self::Tent { is_narrow: true })
    }

    /// Sets the numbers of `TentTaps` in a shader.
    pub(crate) fn set_taps<'r, 'p>(self, pass: FunctionPass<'r, 'p>, radius: f32) -> FunctionPass<'r, 'p> {
        let texels = if let Self::Whole { texels } = self { texels } else { 2 };
        let [outer, inner] = if texels == 2 { [0.25; 2] } else { [0.375, 0.125] };
        pass.set("texels", texels).set("outer", tent_taps(radius, outer)).set("inner", tent_taps(radius, inner))
    }
}

/// The numbers of `TentTaps` for a place so far beside the middle of a texel. The radius counts up to 1.
fn tent_taps(radius: f32, away: f32) -> [f32; 4] {
    let radius = radius.min(1.0);
    let hat = |away: f32| (1.0 - away.abs()).max(0.0);
    let share = |away: f32| 0.5 * hat(away) + 0.25 * (hat(away - radius) + hat(away + radius));
    let (near, far) = (share(away) + share(1.0 + away), share(1.0 - away) + share(2.0 - away));
    [away + share(1.0 + away) / near, 1.0 - away + share(2.0 - away) / far, near, far]
}

/// The kernel of a step.
fn function(enlargement: Enlargement, border: Border) -> &'static str {
    match (enlargement, border) {
        (Enlargement::Bilinear, Border::Open) => "upsample_bilinear",
        (Enlargement::Bilinear, Border::Edge) => "upsample_edge_bilinear",
        (Enlargement::Tent { .. }, Border::Open) => "upsample_tent",
        (Enlargement::Tent { .. }, Border::Edge) => "upsample_edge_tent",
        (Enlargement::Whole { .. }, Border::Open) => "upsample_whole",
        (Enlargement::Whole { .. }, Border::Edge) => "upsample_edge_whole",
    }
}

/// The kernel of the last step with the smoothing of its result, by workgroups of [`TILE`] texels.
fn smoothing_function(border: Border) -> &'static str {
    match border {
        Border::Open => "upsample_whole_smooth",
        Border::Edge => "upsample_edge_whole_smooth",
    }
}

/// Texels that a workgroup makes, across and down, of a step with its smoothing.
const TILE: [u32; 2] = [16, 16];

/// Returns whether the device smooths the result of a step in the same pass.
fn smooths(enlargement: Enlargement, pass: &Recorder<'_>) -> bool {
    let caps = pass.caps;
    let fits = caps.fast_workgroup_memory && TILE[0] * TILE[1] <= caps.workgroup_invocations;
    fits && matches!(enlargement, Enlargement::Whole { .. })
}

impl Upsample {
    /// The weight of each of `count` levels, finest first, in a frame that is so many halvings larger than `lines`.
    fn weights(&self, count: usize, octaves: f64) -> [f64; MAX_LEVELS] {
        // Levels in a frame of `lines`.
        let all = (count as i64 - octaves.ceil() as i64).max(1);
        let spread = f64::from(self.spread);
        let mut weights = [0.0; MAX_LEVELS];
        for level in 0..all {
            let weight = match (self.blend, self.normalize) {
                (UpsampleBlend::Mix, _) if level == all - 1 => spread.powi(level as i32),
                (UpsampleBlend::Mix, _) => (1.0 - spread) * spread.powi(level as i32),
                (UpsampleBlend::Add, true) => 1.0 / all as f64,
                (UpsampleBlend::Add, false) => 1.0,
            };
            let place = (level as f64 + octaves).clamp(0.0, count as f64 - 1.0);
            let below = place as usize;
            // The mean of the squared widths of both, 1 and 4, is that of the level between them.
            let share = (4.0_f64.powf(place.fract()) - 1.0) / 3.0;
            weights[below] += (1.0 - share) * weight;
            weights[(below + 1).min(count - 1)] += share * weight;
        }
        weights
    }
}

impl Node for Upsample {
    fn is_identity(&self, inputs: &InputValues) -> bool {
        inputs.is_zero("source")
    }

    fn invariants(&self, declared: Invariants) -> Invariants {
        let is_mean = self.border == Border::Edge;
        let is_normalized = self.normalize || self.blend != UpsampleBlend::Add;
        Invariants { constant: is_mean, keeps_constant: is_mean && is_normalized, ..declared }
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let levels = pass.pyramid("source");
        let octaves = octaves(pass.frame_size, self.lines);
        let octaves = if self.fade { octaves } else { octaves.ceil() };
        let weights = self.weights(levels.len(), octaves);
        // Levels that are finer than the finest in a frame of `lines` have no weight: the result is smaller.
        let finest = (octaves.max(0.0) as usize).min(levels.len() - 1);
        let is_finest_alone = self.blend == UpsampleBlend::Mix && self.spread == 0.0 && !pass.is_dynamic("spread");
        let coarsest = if is_finest_alone { weights.iter().rposition(|weight| *weight > 0.0) } else { None };
        let coarsest = coarsest.unwrap_or(levels.len() - 1);
        let is_mean = self.normalize || self.blend == UpsampleBlend::Mix;
        let border = if pass.is_output_averaged("result") { Border::Edge } else { self.border };
        let mut joined = levels[coarsest];
        // The weight of all levels in `joined`.
        let mut rest = weights[coarsest..].iter().sum::<f64>();
        let mut is_smooth = false;
        for index in (finest..coarsest).rev() {
            let desc = ImageDesc::new(pass.desc(levels[index]).size);
            let result = pass.level(format_args!("result.{index}"), desc);
            let all = rest + weights[index];
            // A running mean, not a sum divided at the end: sums of bright levels overflow half floats.
            let whole = if all > 0.0 && is_mean { all } else { 1.0 };
            let sizes = [pass.desc(joined).size, desc.size];
            let enlargement = self.filter.enlargement(sizes, self.radius, pass.is_dynamic("radius"));
            is_smooth = self.smooth && index == finest && smooths(enlargement, pass);
            let function = if is_smooth { smoothing_function(border) } else { function(enlargement, border) };
            let call = pass.function(&SHADER, function);
            let call = if is_smooth { call.workgroup(TILE) } else { call };
            enlargement
                .set_taps(call, self.radius)
                .define("UPSAMPLE_NARROW", enlargement.is_narrow())
                .label(format_args!("{function} {}", desc.size))
                .read("level", levels[index])
                .read("coarser", joined)
                .set("own", (weights[index] / whole) as f32)
                .set("rest", (if is_mean { rest / whole } else { 1.0 }) as f32)
                .write_to(result);
            (joined, rest) = (result, all);
        }
        if self.smooth && !is_smooth {
            let desc = ImageDesc::new(pass.desc(joined).size);
            let result = pass.level("result.smooth", desc);
            let function = if border == Border::Open { "upsample_smooth" } else { "upsample_edge_smooth" };
            let call = pass.function(&SHADER, function).label(format_args!("{function} {}", desc.size));
            call.read("joined", joined).write_to(result);
            joined = result;
        }
        pass.set_output("result", InputValue::Image(joined));
    }
}
