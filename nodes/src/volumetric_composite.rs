//! VolumetricComposite: the scene behind a froxel volume of fog.

use afterimage_graph::prelude::*;

use crate::surface;

static SHADER: Shader = shader!("volumetric_composite");

choices! {
    /// Distribution of the slices of a volume between its nearest and its farthest distance.
    pub enum VolumetricSlices {
        /// Each slice ends at the same multiple of its beginning: near (far / near)^w, where w goes from 0 to 1.
        Exponential,
        /// All slices are equally thick: near + (far - near) w.
        Linear,
        /// near + (far - near) (e^(curve w) - 1) / (e^curve - 1).
        Curved,
    }
}

choices! {
    /// The distance that a texel of a volume belongs to.
    pub enum VolumetricTexels {
        /// That at which its slice ends: it holds the fog up to there.
        End,
        /// That of the middle of its slice.
        Middle,
    }
}

node_kind! {
    /// Puts the fog of a froxel volume before the scene.
    ///
    /// A froxel is a cell of a grid over the picture and the depth. A texel of the volume holds what a march from the
    /// camera has found up to its distance: the light that the fog scatters toward the camera in rgb, and the share of
    /// light that passes in alpha (Wronski, "Volumetric Fog", 2014). The result is source * (1 - amount * (1 - passed))
    /// + amount * light * scattered. Between texels the volume is filtered trilinearly, in w along the depth: the
    /// error falls with the square of the number of slices.
    /// Between `near` and the first texel, the fog begins with none; before `near` is none, and behind the last texel
    /// is that of the last texel. The depth is the distance along the view axis in meters; the sky has a large one.
    /// Place it before exposure. Alpha passes unchanged.
    pub struct VolumetricComposite {
        /// How the slices lie between `near` and `far`.
        pub slices: VolumetricSlices = VolumetricSlices::Exponential;
        /// The distance at which the first slice begins. Above 0 for exponential slices.
        pub near: f32 = 0.5 => within(0.0..=10000.0), usually(0.0..=5.0), unit("m");
        /// The distance at which the last slice ends. Above `near`.
        pub far: f32 = 64.0 => within(0.01..=60000.0), usually(10.0..=500.0), logarithmic(), unit("m");
        /// How much thinner near slices are than far ones, for curved slices. 0 is linear; the logarithm of
        /// `far / near` is exponential.
        pub curve: f32 = 3.0 => within(0.0..=20.0), usually(0.0..=6.0), when("slices", [VolumetricSlices::Curved]);
        /// The distance that a texel belongs to.
        pub texels: VolumetricTexels = VolumetricTexels::End;
        /// A factor of the scattered light, such as an exposure that is in the scene and not in the volume.
        pub light: f32 = 1.0 => within(0.0..=65504.0), usually(0.0..=4.0);
        /// The share of the fog. 0 changes nothing.
        pub amount: f32 = 1.0 => within(0.0..=1.0), neutral(0.0);
    }

    const INPUTS: &'static [Input] = &[
        Input::image("source", "The light of the scene.").accepts(&[ColorState::Scene]),
        Input::image("depth", "Distance along the view axis in meters, in x.").accepts(&[ColorState::Data]),
        Input::volume("volume", "Scattered light in rgb, the share that passes in alpha.")
            .accepts(&[ColorState::Scene]),
    ];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::same("source"), "The scene behind the fog.").or_input("source")];
}

impl VolumetricComposite {
    /// The curve of the distances, of which 0 is linear.
    fn curve(&self) -> f64 {
        match self.slices {
            VolumetricSlices::Exponential => (f64::from(self.far) / f64::from(self.near)).ln(),
            VolumetricSlices::Linear => 0.0,
            VolumetricSlices::Curved => f64::from(self.curve),
        }
    }
}

impl Node for VolumetricComposite {
    fn verify(&self) -> Result<(), String> {
        if self.near >= self.far {
            return Err("`far` must be above `near`".into());
        }
        if self.slices == VolumetricSlices::Exponential && self.near < MIN_NEAR {
            return Err(format!("`near` must be at least {MIN_NEAR} for exponential slices"));
        }
        Ok(())
    }

    fn is_identity(&self, _: &InputValues) -> bool {
        self.amount == 0.0
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let size = surface::size_of(pass, "source");
        let depth = surface::at_size(pass, "depth", size);
        let volume = pass.image("volume");
        let slices = pass.desc(volume).size.depth as f32;
        let curve = self.curve();
        // What the distance must be multiplied by, behind `near`.
        let bend = if curve < STRAIGHT { 0.0 } else { curve.exp_m1() };
        let end = if self.texels == VolumetricTexels::End { 1.0 } else { 0.5 };
        pass.function(&SHADER, "volumetric_composite")
            .read("depth", depth)
            .set("scale", 1.0 / (f64::from(self.far) - f64::from(self.near)))
            .set("bend", bend)
            .set("inverse_curve", if curve < STRAIGHT { 0.0 } else { 1.0 / curve })
            .set("slices", slices)
            .set("first", end)
            .write("result", ImageDesc::new(size));
    }
}

/// The least `near` of exponential slices, in meters: a curve over more has no slices left for the scene.
const MIN_NEAR: f32 = 1e-4;
/// Curves below this are straight to the precision of 32-bit floats.
const STRAIGHT: f64 = 1e-6;
