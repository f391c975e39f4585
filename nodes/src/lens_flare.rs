//! LensFlare: reflections between the surfaces of a lens.

use afterimage_graph::prelude::*;

static SHADER: Shader = shader!("lens_flare");

node_kind! {
    /// Makes the reflections of bright lights in a lens from the image itself: ghosts and a ring.
    ///
    /// Wire light that an `Extract` has selected and a `Downsample` has blurred (its `coarsest`, or an `Upsample` of
    /// the coarse levels), and add the result with a `Composite`. Ghost i is the image with the magnification -1, 2,
    /// -3, 4 and so on times `spacing`, in the colors of coatings: all ghosts of a light lie on the line through the
    /// center of the image. Light within a tenth of the border fades, and there is none outside: a light that leaves
    /// the image takes its ghosts with it. After Chapman, "Pseudo Lens Flare", 2013. Alpha is 0.
    pub struct LensFlare {
        /// What each channel of the light has to exceed: flares are made of the rest. A sun is thousands of times
        /// white, and a sky, a lit carpet or a window a few times.
        pub threshold: f32 = 0.0 => within(0.0..=65504.0), usually(0.0..=64.0), neutral(0.0);
        /// The light that no flare exceeds: its largest channel, after the threshold, stays the same up to half of the
        /// limit and approaches it from there on. With a limit, the flame of a candle that fills many pixels has ghosts
        /// like those of a small sun.
        pub limit: f32 = 65504.0 => within(1.0..=65504.0), usually(16.0..=4096.0), logarithmic();
        /// Number of ghosts.
        pub ghosts: u32 = 5 => within(0.0..=8.0);
        /// The magnification of the first ghost, and the step from one to the next.
        pub spacing: f32 = 0.35 => within(0.05..=2.0), usually(0.1..=1.0);
        /// Factor of the mean of the ghosts.
        pub ghost_strength: f32 = 0.3 => within(0.0..=64.0), usually(0.0..=2.0), neutral(0.0);
        /// Radius of the ring that a light in the center makes.
        pub halo_radius: f32 = 0.4 => within(0.0..=1.0), unit("heights");
        /// Factor of the ring.
        pub halo_strength: f32 = 0.1 => within(0.0..=64.0), usually(0.0..=2.0), neutral(0.0);
        /// How far red and blue are from green in a ghost, as a share of the distance from the center. In the ring it
        /// is four times as much.
        pub dispersion: f32 = 0.01 => within(0.0..=0.2), neutral(0.0);
    }

    const INPUTS: &'static [Input] =
        &[Input::image("source", "The light that makes flares, blurred, black elsewhere.").accepts(&[
            ColorState::Scene,
            ColorState::Exposed,
            ColorState::DisplayLinear,
        ])];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::same("source"), "The flares, of the size of the source.")];
    const INVARIANTS: Invariants = Invariants { constant: false, ..Invariants::DEFAULT };
}

impl Node for LensFlare {
    fn is_identity(&self, inputs: &InputValues) -> bool {
        let has_ghosts = self.ghosts > 0 && self.ghost_strength > 0.0;
        !has_ghosts && self.halo_strength == 0.0 || inputs.is_zero("source")
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = ImageDesc::new(pass.desc(source).size);
        pass.function(&SHADER, "lens_flare")
            .read("source", source)
            .set("aspect", desc.size.aspect())
            .write("result", desc);
    }
}
