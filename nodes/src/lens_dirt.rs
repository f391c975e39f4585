//! LensDirt: dirt on the front glass, seen where bloom and flares are.

use afterimage_graph::prelude::*;

static SHADER: Shader = shader!("lens_dirt");

node_kind! {
    /// Brightens light where the lens is dirty: for the bloom or the flares before they are added to the image.
    ///
    /// The light is multiplied by 1 + `strength` times the dirt. The dirt is an image, or without one, round smudges in
    /// three sizes at random places, equal on every device. Alpha passes unchanged.
    pub struct LensDirt {
        /// Factor of the dirt. 0 changes nothing.
        pub strength: f32 = 1.0 => within(0.0..=64.0), usually(0.0..=8.0), neutral(0.0);
        /// Without an image: the number of large smudges along the height of the image.
        pub scale: f32 = 6.0 => within(0.5..=64.0), usually(2.0..=16.0), when_wired("dirt", false);
        /// Without an image: another number gives other smudges.
        pub seed: u32 = 0 => within(0.0..=65535.0), live(), when_wired("dirt", false);
    }

    const INPUTS: &'static [Input] = &[
        Input::image("source", "The light of a bloom or of flares.").accepts(STATES),
        Input::image("dirt", "The dirt, of any size: 0 where the glass is clean.")
            .accepts(&[ColorState::Data])
            .optional(),
    ];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::same("source"), "The light with the dirt in it.").or_input("source")];
    const INVARIANTS: Invariants = Invariants { constant: false, symmetric: false, ..Invariants::DEFAULT };
}

const STATES: &[ColorState] = &[ColorState::Scene, ColorState::Exposed, ColorState::DisplayLinear];

impl Node for LensDirt {
    fn is_identity(&self, inputs: &InputValues) -> bool {
        self.strength == 0.0 || inputs.is_zero("source") || inputs.is_zero("dirt")
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = ImageDesc::new(pass.desc(source).size);
        let function = if pass.wired("dirt") { "lens_dirt_image" } else { "lens_dirt" };
        pass.function(&SHADER, function).set("aspect", desc.size.aspect()).write("result", desc);
    }
}
