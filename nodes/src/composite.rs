//! Composite: lays bloom or glare over the picture.

use afterimage_graph::prelude::*;

use crate::upsample::UpsampleFilter;

static SHADER: Shader = shader!("composite");

choices! {
    /// How light is laid over the picture.
    pub enum CompositeBlend {
        /// Adds it: for light that a threshold has picked out.
        Add,
        /// Replaces a share of the picture by it: energy stays, so it needs no threshold.
        Mix,
    }
}

params! {
    /// Lays light over a picture: bloom before the tone curve, glare on the display's linear light after it.
    ///
    /// Picture and light must mean the same: both exposed, or both not. The light may have any size and is enlarged on the way; where none
    /// is wired or it is switched off, the picture passes. Results are limited to 65504. Alpha is the picture's.
    pub struct Composite {
        /// How the light is laid over the picture.
        pub blend: CompositeBlend = CompositeBlend::Add;
        /// Factor of the light for Add, its share for Mix, where 1 is the most; 0 leaves the picture as it is.
        pub strength: f32 = 0.5 => within(0.0..=8.0), usually(0.0..=1.0), neutral(0.0);
        /// The filter that enlarges the light.
        pub filter: UpsampleFilter = UpsampleFilter::Tent => quality(UpsampleFilter::Tent, [UpsampleFilter::Bilinear]);
        /// Distance of the tent's reads.
        pub radius: f32 = 1.0 => within(0.0..=4.0), usually(0.5..=1.5), unit("texels of the bloom");
    }
}

const STATES: &[ColorState] = &[ColorState::Scene, ColorState::Exposed, ColorState::DisplayLinear];

impl Composite {
    fn function(&self) -> &'static str {
        match (self.blend, self.filter) {
            (CompositeBlend::Add, UpsampleFilter::Tent) => "composite_add_tent",
            (CompositeBlend::Add, UpsampleFilter::Bilinear) => "composite_add_bilinear",
            (CompositeBlend::Mix, UpsampleFilter::Tent) => "composite_mix_tent",
            (CompositeBlend::Mix, UpsampleFilter::Bilinear) => "composite_mix_bilinear",
        }
    }

    fn factor(&self) -> f32 {
        match self.blend {
            CompositeBlend::Add => self.strength,
            CompositeBlend::Mix => self.strength.min(1.0),
        }
    }
}

impl Node for Composite {
    const INPUTS: &'static [Input] = &[
        Input::image("base", "The picture.").accepts(STATES),
        Input::image("bloom", "The light to lay over it, of any size.").accepts(STATES).optional(),
    ];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::Same("base"), "The picture with the light.")];
    const FALLBACK: Fallback = Fallback::Input("base");

    fn identity(&self, arrivals: &Arrivals) -> Option<Fallback> {
        let adds_nothing = arrivals.is_zero("bloom") && (self.blend == CompositeBlend::Add || arrivals.is_zero("base"));
        let leaves_base = self.strength == 0.0 || arrivals.is_absent("bloom") || adds_nothing;
        leaves_base.then_some(Self::FALLBACK)
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let wired = pass.wired("bloom");
        // Without bloom this runs only where a history needs the result: the strength is then 0, whatever is read.
        let bloom = pass.image(if wired { "bloom" } else { "base" });
        let strength = if wired { self.factor() } else { 0.0 };
        // A black base has no size of its own.
        let size = if pass.is_zero("base") {
            pass.frame_size()
        } else {
            let base = pass.image("base");
            pass.desc(base).size
        };
        pass.function(&SHADER, self.function())
            .read("bloom", bloom)
            .reach(if self.filter == UpsampleFilter::Tent { self.radius } else { 0.0 })
            .set("strength", strength)
            .write("result", ImageDesc::new(size));
    }
}
