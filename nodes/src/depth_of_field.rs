//! DepthOfField: what is not in focus is blurred as a lens blurs it.

use afterimage_graph::node::FunctionPass;
use afterimage_graph::prelude::*;

use crate::surface;
use crate::tiles::{self, Vectors};

static SHADER: Shader = shader!("depth_of_field");

node_kind! {
    /// Blurs what is nearer or farther than the focus, as a lens does.
    ///
    /// The circle of confusion on the sensor has the diameter F^2 / N / (s - F) |z - s| / z, for the focal length F,
    /// the f-number N, the distance s of the focus and the depth z. Each pixel gathers the light whose circles cover
    /// it, each with its light spread over its area. Light from behind does not bleed over a sharp foreground, and a
    /// blurred foreground covers what is behind it by its share; what it hides there is filled with what is seen around
    /// it. A pixel at a smooth edge belongs to the surface in front if that or the one behind is in focus.
    ///
    /// Place it before the tone curve, so that bright lights become bright discs. The depth is the distance along the
    /// view axis in meters. Samples lie on rings, 6 on the first, 12 on the second and so on, nearer to each other in
    /// the middle of the largest circle. Alpha is blurred with the color, which it has been multiplied into. After
    /// Jimenez, "Next Generation Post Processing in Call of Duty: Advanced Warfare", SIGGRAPH 2014.
    pub struct DepthOfField {
        /// Factor of the circles. 0 changes nothing, 1 is the lens.
        pub amount: f32 = 1.0 => within(0.0..=4.0), usually(0.0..=1.0), neutral(0.0);
        /// The distance of the focus.
        pub focus: f32 = 5.0 => within(0.5..=10000.0), usually(0.5..=50.0), logarithmic(), unit("m"),
            when("autofocus", [false]);
        /// Focuses on the nearest surface around `place`. It has no memory: the focus jumps with what is there.
        pub autofocus: bool = false;
        /// The place at which the focus is found.
        pub place: [f32; 2] = [0.5, 0.5] => within(0.0..=1.0), unit("uv"), when("autofocus", [true]);
        /// The radius around `place` in which surfaces count. At 1, the nearest of nearly the whole image.
        pub area: f32 = 0.02 => within(0.0..=1.0), usually(0.0..=0.2), unit("heights"), when("autofocus", [true]);
        /// The f-number: the focal length over the diameter of the aperture.
        pub f_stop: f32 = 2.0 => within(0.5..=64.0), usually(1.4..=16.0);
        /// The focal length.
        pub focal_length: f32 = 50.0 => within(5.0..=400.0), usually(18.0..=200.0), unit("mm");
        /// The height of the sensor: 24 mm of a 35 mm camera.
        pub sensor: f32 = 24.0 => within(1.0..=100.0), unit("mm");
        /// The largest radius of a circle. A larger one needs more rings.
        pub largest: f32 = 0.02 => within(0.0..=0.1), usually(0.005..=0.05), unit("heights"), replans();
        /// Rings of samples in the largest circle nearby.
        pub rings: u32 = 8 => within(1.0..=16.0), quality(12u32, [8, 5, 3]);
        /// Blades of the aperture, 5 to 9 mostly. Below 3 it is round.
        pub blades: u32 = 0 => within(0.0..=16.0);
        /// The direction of a corner of the aperture.
        pub rotation: f32 = 0.0 => within(-360.0..=360.0), unit("degrees");
        /// The height of a circle over its width: 2 for the ovals of an anamorphic lens.
        pub squeeze: f32 = 1.0 => within(1.0..=3.0), usually(1.0..=2.0);
    }

    const INPUTS: &'static [Input] = &[
        Input::image("source", "The image, before the tone curve.").accepts(&[ColorState::Scene, ColorState::Exposed]),
        Input::image("depth", "Distance along the view axis in meters, in x.").accepts(&[ColorState::Data]),
    ];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::same("source"), "The image in focus.").or_input("source")];
}

impl DepthOfField {
    /// The radius of the circle of confusion of an infinite distance, in pixels of an image of this height, times the
    /// distance in millimeters between the focus and the focal length.
    fn strength(&self, height: f64) -> f64 {
        let focal = f64::from(self.focal_length);
        let aperture = focal * focal / f64::from(self.f_stop);
        0.5 * f64::from(self.amount) * aperture / f64::from(self.sensor) * height
    }

    /// The circles of all pixels, around the focus of the parameters or the one that is found.
    fn circles(&self, pass: &mut Recorder<'_>, depth: ImageId, numbers: Numbers, desc: ImageDesc) -> ImageId {
        let circle = pass.transient("circle", desc);
        if !self.autofocus {
            numbers.set(pass.function(&SHADER, "depth_of_field_circle").read("depth", depth)).write_to(circle);
            return circle;
        }
        let focus = pass.transient("focus", ImageDesc::new(Size::new(1, 1)).format(Format::R32Float));
        numbers.set(pass.function(&SHADER, "depth_of_field_focus").read("depth", depth)).write_to(focus);
        let found = pass.function(&SHADER, "depth_of_field_circle_found").read("depth", depth).read("focus", focus);
        numbers.set(found).write_to(circle);
        circle
    }
}

#[derive(Clone, Copy)]
struct Numbers {
    strength: f64,
    max_radius: f64,
    tile: u32,
    rotation: f64,
}

impl Numbers {
    fn set<'r, 'a>(self, pass: FunctionPass<'r, 'a>) -> FunctionPass<'r, 'a> {
        let pass = pass.set("strength", self.strength).set("max_radius", self.max_radius).set("tile", self.tile);
        pass.set("rotation", self.rotation)
    }
}

impl Node for DepthOfField {
    fn is_identity(&self, inputs: &InputValues) -> bool {
        self.amount == 0.0 || self.largest == 0.0 || inputs.is_zero("source")
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = ImageDesc::new(pass.desc(source).size);
        let height = f64::from(desc.size.height);
        let max_radius = f64::from(self.largest) * height;
        let tile = tiles::side(max_radius);
        let rotation = f64::from(self.rotation).to_radians();
        let numbers = Numbers { strength: self.strength(height), max_radius, tile, rotation };
        let depth = surface::at_size(pass, "depth", desc.size);
        let circle = self.circles(pass, depth, numbers, desc);
        let around = tiles::longest_around(pass, circle, Vectors::Radii, tile);
        let function = if self.blades >= 3 { "depth_of_field_polygon" } else { "depth_of_field" };
        let last = pass.function(&SHADER, function).read("source", source);
        numbers.set(last.read("circle", circle).read("around", around)).write("result", desc);
    }
}
