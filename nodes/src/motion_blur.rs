//! MotionBlur: what moves while the shutter is open is drawn out along its path.

use afterimage_graph::node::{CAMERA, FunctionPass};
use afterimage_graph::prelude::*;

use crate::surface;
use crate::tiles::{self, Vectors};

static SHADER: Shader = shader!("motion_blur");

choices! {
    /// The unit of a motion image.
    pub enum MotionUnit {
        /// Parts of the width and of the height.
        Uv,
        /// Pixels of the motion image.
        Pixels,
    }
}

node_kind! {
    /// Draws out what moves along the path that it covers while the shutter is open.
    ///
    /// Each pixel gathers light along the longest path nearby, from what moves over it, and along its own path, from
    /// its own surface and from what that uncovers; each counts by the time for which it is seen. The motion is where a
    /// pixel's surface is now minus where it was in the previous frame, in x and y of the image, v downwards. The path
    /// is straight, and the frame is in its middle. With a depth, a moving object does not draw out what is before it;
    /// without one, what moves faster counts as nearer. A pixel at a smooth edge moves as the object in front of it.
    /// Without a motion, a depth and the camera say how what stands still has moved in the image; without these,
    /// nothing is blurred. Samples are moved by a random number for each pixel, equal on every device. Place it before
    /// the tone curve. Alpha moves with the color, which it has been multiplied into. After McGuire and others, "A
    /// Reconstruction Filter for Plausible Motion Blur", I3D 2012, and Guertin and others, "A Fast and Stable
    /// Feature-Aware Motion Blur Filter", HPG 2014; graph/docs/measurements/depth.md compares it with rays.
    pub struct MotionBlur {
        /// How long the shutter is open: 360 degrees is the whole frame. 0 changes nothing.
        pub shutter: f32 = 180.0 => within(0.0..=360.0), unit("degrees"), neutral(0.0);
        /// The unit of the motion.
        pub unit: MotionUnit = MotionUnit::Uv;
        /// Half of the longest path. Faster surfaces are drawn out this far.
        pub largest: f32 = 0.03 => within(0.0..=0.1), usually(0.01..=0.06), unit("heights"), replans();
        /// Samples along both paths, half of them along each.
        pub samples: u32 = 16 => within(3.0..=64.0), quality(32u32, [16, 8]);
    }

    const INPUTS: &'static [Input] = &[
        Input::image("source", "The image, before the tone curve.").accepts(&[ColorState::Scene, ColorState::Exposed]),
        Input::image("motion", "Motion since the previous frame, in x and y.").accepts(&[ColorState::Data]).optional(),
        Input::image("depth", "Distance along the view axis, in x.").accepts(&[ColorState::Data]).optional(),
        Input::block("camera", &CAMERA, "The camera, for the motion of what stands still.").optional(),
    ];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::same("source"), "The image in motion.").or_input("source")];
    const INVARIANTS: Invariants = Invariants { symmetric: false, ..Invariants::DEFAULT };
}

#[derive(Clone, Copy)]
struct Numbers {
    scale: [f64; 2],
    max_radius: f64,
    tile: u32,
}

impl Numbers {
    fn set<'r, 'a>(self, pass: FunctionPass<'r, 'a>) -> FunctionPass<'r, 'a> {
        pass.set("scale", self.scale).set("max_radius", self.max_radius).set("tile", self.tile)
    }
}

impl MotionBlur {
    /// From the numbers of the motion image, or from uv without one, to half of a path in pixels of the result.
    fn scale(&self, pass: &mut Recorder<'_>, size: Size) -> [f64; 2] {
        let half = 0.5 * f64::from(self.shutter) / 360.0;
        let [width, height] = [size.width, size.height].map(f64::from);
        if self.unit == MotionUnit::Uv || !pass.wired("motion") {
            return [half * width, half * height];
        }
        let motion = pass.image("motion");
        let motion = pass.desc(motion).size;
        [half * width / f64::from(motion.width), half * height / f64::from(motion.height)]
    }

    /// Half of the path of each pixel, and its depth.
    fn path(pass: &mut Recorder<'_>, desc: ImageDesc, numbers: Numbers) -> ImageId {
        let path = pass.transient_signed("path", desc);
        if !pass.wired("motion") {
            let depth = surface::at_size(pass, "depth", desc.size);
            let call = pass.function(&SHADER, "motion_blur_path_camera").label("motion_blur_path");
            numbers.set(call.read("depth", depth)).write_to(path);
            return path;
        }
        let motion = surface::at_size(pass, "motion", desc.size);
        if pass.wired("depth") {
            let depth = surface::at_size(pass, "depth", desc.size);
            let call = pass.function(&SHADER, "motion_blur_path_depth").label("motion_blur_path");
            numbers.set(call.read("motion", motion).read("depth", depth)).write_to(path);
        } else {
            numbers.set(pass.function(&SHADER, "motion_blur_path").read("motion", motion)).write_to(path);
        }
        path
    }
}

impl Node for MotionBlur {
    fn is_identity(&self, inputs: &InputValues) -> bool {
        let is_unknown = inputs.is_absent("motion") && (inputs.is_absent("depth") || inputs.is_absent("camera"));
        let is_still = self.shutter == 0.0 || self.largest == 0.0 || inputs.is_zero("motion");
        is_still || is_unknown || inputs.is_zero("source")
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = ImageDesc::new(pass.desc(source).size);
        let max_radius = f64::from(self.largest) * f64::from(desc.size.height);
        let tile = tiles::side(max_radius);
        let is_known = pass.wired("motion") || pass.wired("depth") && pass.wired("camera");
        if !is_known {
            pass.function(&SHADER, "motion_blur_still").read("source", source).write("result", desc);
            return;
        }
        let numbers = Numbers { scale: self.scale(pass, desc.size), max_radius, tile };
        let path = Self::path(pass, desc, numbers);
        let around = tiles::longest_around(pass, path, Vectors::Paths, tile);
        let last = pass.function(&SHADER, "motion_blur").read("source", source);
        numbers.set(last.read("path", path).read("around", around)).write("result", desc);
    }
}
