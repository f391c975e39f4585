//! Upsample: combines the levels of a pyramid into one image, from the coarsest to the finest.

use afterimage_graph::prelude::*;

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
    /// How a level is combined with the coarser ones.
    pub enum UpsampleBlend {
        /// Weighted mean: the coarser levels have the weight `spread`, the level itself the rest. The weights of all
        /// levels sum to 1.
        Mix,
        /// Sum: all levels have equal weight.
        Add,
    }
}

params! {
    /// Combines the levels of a pyramid into one image of the finest level's size.
    ///
    /// It starts with the coarsest level and enlarges with a filter at each step.
    ///
    /// With `Mix`, the level of index i of L levels has the weight (1 - spread) spread^i, and the coarsest
    /// spread^(L-1). With `Add`, each has 1/L, or 1 without `normalize`. A pyramid of one level is returned unchanged.
    /// Results are limited to 65504. Alpha is combined like color.
    pub struct Upsample {
        /// How a level is combined with the coarser ones.
        pub blend: UpsampleBlend = UpsampleBlend::Mix;
        /// For `Mix`: the weight of the coarser levels at each step. 0 keeps only the finest level, 1 only the
        /// coarsest.
        pub spread: f32 = 0.7 => within(0.0..=1.0);
        /// For `Add`: whether to divide by the number of levels, so that a constant stays the same and strength has the
        /// same meaning for any number of levels.
        pub normalize: bool = true;
        /// The filter of each enlargement.
        pub filter: UpsampleFilter = UpsampleFilter::Tent => quality(UpsampleFilter::Tent, [UpsampleFilter::Bilinear]);
        /// Distance between the reads of the tent. Above 1.5 the gaps between them become visible.
        pub radius: f32 = 1.0
            => within(0.0..=f64::from(MAX_RADIUS)), usually(0.5..=1.5), unit("texels of the coarser level");
    }
}

/// The largest radius of the tent.
pub(crate) const MAX_RADIUS: f32 = 4.0;

impl UpsampleFilter {
    fn function(self) -> &'static str {
        match self {
            Self::Tent => "upsample_tent",
            Self::Bilinear => "upsample_bilinear",
        }
    }
}

/// The weights of a level and of the combined coarser levels.
struct Shares {
    own: f32,
    rest: f32,
}

impl Upsample {
    /// The weights of a level that has `coarser` coarser levels.
    fn shares(&self, coarser: usize) -> Shares {
        match (self.blend, self.normalize) {
            (UpsampleBlend::Mix, _) => Shares { own: 1.0 - self.spread, rest: self.spread },
            // A running mean, not a sum divided at the end: sums of bright levels overflow half floats.
            (UpsampleBlend::Add, true) => {
                let all = coarser as f32 + 1.0;
                Shares { own: 1.0 / all, rest: coarser as f32 / all }
            }
            (UpsampleBlend::Add, false) => Shares { own: 1.0, rest: 1.0 },
        }
    }

    fn is_finest_alone(&self) -> bool {
        self.blend == UpsampleBlend::Mix && self.spread == 0.0
    }
}

impl Node for Upsample {
    const INPUTS: &'static [Input] = &[Input::new("source", PortType::Pyramid, "The levels to combine.")];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::same("source"), "One image of the size of the finest level.")];

    fn is_identity(&self, inputs: &InputValues) -> bool {
        inputs.is_zero("source")
    }

    fn promises(&self) -> Promises {
        Promises { keeps_constant: self.normalize || self.blend != UpsampleBlend::Add, ..Promises::DEFAULT }
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let levels = pass.pyramid("source");
        let used = if self.is_finest_alone() && !pass.is_dynamic("spread") { &levels[..1] } else { &levels[..] };
        let (coarsest, finer) = used.split_last().expect("a pyramid has a level");
        let mut joined = *coarsest;
        for (index, level) in finer.iter().enumerate().rev() {
            let desc = ImageDesc::new(pass.desc(*level).size);
            let result = pass.level(format_args!("result.{index}"), desc);
            let Shares { own, rest } = self.shares(finer.len() - index);
            let function = self.filter.function();
            pass.function(&SHADER, function)
                .label(format_args!("{function} {}", desc.size))
                .read("level", *level)
                .read("coarser", joined)
                .set("own", own)
                .set("rest", rest)
                .write_to(result);
            joined = result;
        }
        pass.give("result", InputValue::Image(joined));
    }
}
