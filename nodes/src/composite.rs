//! Composite: combines bloom or glare with the image.

use afterimage_graph::prelude::*;

use crate::upsample::{Enlargement, MAX_RADIUS, UpsampleFilter};

static SHADER: Shader = shader!("composite");

choices! {
    /// Blend mode.
    pub enum CompositeBlend {
        /// Adds it: for light that a threshold has selected.
        Add,
        /// Replaces a share of the image by it: this keeps the energy, so it needs no threshold.
        Mix,
        /// Adds it in the distance that the image has to white, as two slides in one projector's light: for
        /// display-linear images, which it never takes above white. A channel at white or above stays.
        Screen,
    }
}

node_kind! {
    /// Combines light with an image: bloom before the tone curve, or glare in display-linear light after it.
    ///
    /// Both images must be in the same color state. The light may have any size and is resampled; light of the size of
    /// the image is not filtered. Beyond its border, light is its nearest texel; the tent of `Add` and `Screen` reads
    /// half of it. If no light is wired, or it is switched off, the result is the image.
    /// Results are limited to 65504. Alpha is that of the image, and for `Mix` it is mixed as the color is: what is
    /// moved beyond the edge of a transparent picture covers there.
    pub struct Composite {
        /// How the light is combined with the image.
        pub blend: CompositeBlend = CompositeBlend::Add;
        /// For `Add` and `Screen`: factor of the light. For `Mix`: its share, at most 1. 0 changes nothing.
        pub strength: f32 = 0.5 => within(0.0..=8.0), usually(0.0..=1.0), logarithmic(), neutral(0.0);
        /// The filter that resamples the light. `Bilinear` is for light that is smooth, as of an `Upsample` with
        /// `smooth` or a blur: it shows the grid of other light, which pulses as it moves.
        pub filter: UpsampleFilter = UpsampleFilter::Tent;
        /// Distance between the reads of the tent.
        pub radius: f32 = 1.0
            => within(0.0..=f64::from(MAX_RADIUS)), usually(0.5..=1.5), unit("texels of the bloom"),
               when("filter", [UpsampleFilter::Tent]);
    }

    const INPUTS: &'static [Input] = &[
        Input::image("base", "The image.").accepts(STATES),
        Input::image("bloom", "The light to combine with it, of any size.").accepts(STATES).optional(),
    ];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::same("base"), "The image with the light.").or_input("base")];
}

const STATES: &[ColorState] = &[ColorState::Scene, ColorState::Exposed, ColorState::DisplayLinear];

impl Composite {
    fn function(&self, enlargement: Enlargement) -> &'static str {
        match (self.blend, enlargement) {
            (CompositeBlend::Add, Enlargement::Bilinear) => "composite_add_bilinear",
            (CompositeBlend::Add, Enlargement::Tent { .. }) => "composite_add_tent",
            (CompositeBlend::Add, Enlargement::Whole { .. }) => "composite_add_whole",
            (CompositeBlend::Mix, Enlargement::Bilinear) => "composite_mix_bilinear",
            (CompositeBlend::Mix, Enlargement::Tent { .. }) => "composite_mix_tent",
            (CompositeBlend::Mix, Enlargement::Whole { .. }) => "composite_mix_whole",
            (CompositeBlend::Screen, Enlargement::Bilinear) => "composite_screen_bilinear",
            (CompositeBlend::Screen, Enlargement::Tent { .. }) => "composite_screen_tent",
            (CompositeBlend::Screen, Enlargement::Whole { .. }) => "composite_screen_whole",
        }
    }

    /// The function for light of the size of the image.
    fn pixel_function(&self) -> &'static str {
        match self.blend {
            CompositeBlend::Add => "composite_add_pixel",
            CompositeBlend::Mix => "composite_mix_pixel",
            CompositeBlend::Screen => "composite_screen_pixel",
        }
    }

    fn factor(&self) -> f32 {
        match self.blend {
            CompositeBlend::Add | CompositeBlend::Screen => self.strength,
            CompositeBlend::Mix => self.strength.min(1.0),
        }
    }
}

impl Node for Composite {
    fn is_identity(&self, inputs: &InputValues) -> bool {
        let adds_nothing = inputs.is_zero("bloom") && (self.blend != CompositeBlend::Mix || inputs.is_zero("base"));
        self.strength == 0.0 || inputs.is_absent("bloom") || adds_nothing
    }

    fn averages(&self, input: &str, _: bool) -> bool {
        input == "bloom" && self.blend == CompositeBlend::Mix
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let wired = pass.wired("bloom");
        // Without bloom this runs only if a history needs the result. The strength is then 0, so any input will do.
        let bloom = pass.image(if wired { "bloom" } else { "base" });
        let strength = if wired { self.factor() } else { 0.0 };
        // A black base has no size.
        let size = if pass.is_zero("base") {
            pass.frame_size
        } else {
            let base = pass.image("base");
            pass.desc(base).size
        };
        // The filter would blur light that has a texel for each pixel.
        let from = pass.desc(bloom).size;
        let enlargement = self.filter.enlargement([from, size], self.radius, pass.is_dynamic("radius"));
        let function = if from == size { self.pixel_function() } else { self.function(enlargement) };
        let call = pass.function(&SHADER, function).read("bloom", bloom);
        enlargement
            .set_taps(call, self.radius)
            .define("COMPOSITE_NARROW", enlargement.is_narrow())
            .set("strength", strength)
            .write("result", ImageDesc::new(size));
    }
}
