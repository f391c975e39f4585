//! Taa: temporal anti-aliasing.

use afterimage_graph::node::CAMERA;
use afterimage_graph::prelude::*;

use crate::motion_blur::MotionUnit;
use crate::surface;

static SHADER: Shader = shader!("taa");

choices! {
    /// The filter that reads the frame before.
    pub enum HistoryFilter {
        /// A Catmull-Rom spline over sixteen texels: stays sharp while the camera moves.
        Bicubic,
        /// Four texels: softer.
        Bilinear,
    }
}

node_kind! {
    /// Smooths edges over time: a renderer moves its samples by a part of a pixel in each frame, and the frames before
    /// fill in what one frame does not show.
    ///
    /// Wire the node's own result of the frame before to `history`: `"taa": Taa(history: "taa@previous", ...)`. The
    /// result is read where each surface was, by `motion`, or without it by depth and camera for what stands still. It
    /// is not used where the depth of the frame before is that of another surface (`previous_depth:
    /// "linear@previous"`), and limited to the mean and the variance of the nine pixels around in YCoCg, so that
    /// nothing stays that is not there any more. The jitter is a part of the camera. Karis, "High Quality Temporal
    /// Supersampling", SIGGRAPH 2014; Salvi, "An Excursion in Temporal Supersampling", GDC 2016.
    ///
    /// Place it before motion blur, depth of field and bloom. On exposed light, wire the exposure and that of the frame
    /// before (`meter: "metered", previous_exposure: "taa.exposure@previous"`), and the history is as bright as the new
    /// frame when the exposure changes. A light `Sharpen` or `Cas` after it gives back what the filter takes. Alpha is
    /// mixed with the color, which it has been multiplied into.
    ///
    /// With `double`, the result is twice as large as the source: temporal upscaling. A frame then says more about some
    /// of the four pixels than about others, and counts by that; jitter should have at least 16 places, and
    /// textures be filtered for the larger size. With a `blend` of 0.12 to 0.2 it settles in eight frames.
    pub struct Taa {
        /// The share of the new frame. 1 uses no history.
        pub blend: f32 = 0.08 => within(0.01..=1.0), usually(0.04..=0.2);
        /// The least share of the new frame where the history is read in the middle of four texels, and less of it
        /// nearer to one: each reading between texels softens what moves. 0 has the least shimmer, 1 the sharpest edges
        /// in motion. What stands still has `blend`.
        pub moving: f32 = 0.5 => within(0.0..=1.0), neutral(0.0);
        /// How many standard deviations of the pixels around the history may lie from their mean: less has no ghosts
        /// and shimmers more. With `double` it is twice as many.
        pub variance: f32 = 1.25 => within(0.0..=8.0), usually(0.75..=2.0);
        /// The difference of depths, as a share, beyond which a surface was not seen in the frame before.
        pub depth_threshold: f32 = 0.05 => within(0.001..=1.0), usually(0.01..=0.2);
        /// The light that counts half as much as dark light in means, so that bright samples do not flicker: white.
        pub white: f32 = 1.0 => within(0.01..=1000.0), usually(0.1..=10.0), logarithmic();
        /// The light above which there are only lamps and the sun. The part above it counts in full in means, so that a
        /// sun of a few pixels keeps its energy for flares, bloom and bright discs out of focus. The edges of such
        /// light have steps, and single samples that are as bright sparkle. Light wider than 16 pixels, such as a sky,
        /// is no lamp. At 65504 there are none.
        pub keep_above: f32 = 65504.0
            => within(0.01..=65504.0), usually(8.0..=65504.0), logarithmic(), neutral(65504.0);
        /// The filter that reads the frame before.
        pub filtering: HistoryFilter = HistoryFilter::Bicubic
            => quality(HistoryFilter::Bicubic, [HistoryFilter::Bilinear]);
        /// The result is twice as large as the source.
        pub double: bool = false;
        /// The unit of the motion.
        pub unit: MotionUnit = MotionUnit::Uv => when_wired("motion", true);
    }

    const INPUTS: &'static [Input] = &[
        Input::image("source", "The light of this frame, whose samples the camera's jitter has moved.").accepts(STATES),
        Input::image("history", "The result of the frame before: `\"taa@previous\"` for a node `taa`.").accepts(STATES),
        Input::image("depth", "Distance along the view axis, in x.").accepts(&[ColorState::Data]),
        Input::block("camera", &CAMERA, "The camera, with that of the frame before and the jitter of both."),
        Input::image("motion", "Motion since the frame before without the jitter, in x and y.")
            .accepts(&[ColorState::Data])
            .optional(),
        Input::image("previous_depth", "`depth` of the frame before: `\"linear@previous\"` for a node `linear`.")
            .accepts(&[ColorState::Data])
            .optional(),
        Input::new("meter", PortType::Value, "The exposure of exposed light.").content("exposure").only_x().optional(),
        Input::image("previous_exposure", "`exposure` of the frame before: `\"taa.exposure@previous\"`.")
            .accepts(&[ColorState::Data])
            .optional(),
    ];
    const OUTPUTS: &'static [Output] = &[
        Output::image("result", OutputState::same("source"), "The smooth image.").or_input("source"),
        Output::image("exposure", OutputState::Always(ColorState::Data), "The stops of `meter`, for the next frame."),
    ];
    const INVARIANTS: Invariants = Invariants { symmetric: false, ..Invariants::DEFAULT };
}

impl Taa {
    /// From the numbers of the motion image to uv.
    fn scale(&self, motion: Size) -> [f64; 2] {
        match self.unit {
            MotionUnit::Uv => [1.0, 1.0],
            MotionUnit::Pixels => [motion.width, motion.height].map(|side| 1.0 / f64::from(side)),
        }
    }
}

/// The image of an optional input at this size, or another one that stands for it, and 1 or 0.
fn optional(pass: &mut Recorder<'_>, port: &'static str, size: Size, otherwise: ImageId) -> (ImageId, f64) {
    if pass.wired(port) { (surface::at_size(pass, port, size), 1.0) } else { (otherwise, 0.0) }
}

const STATES: &[ColorState] = &[ColorState::Scene, ColorState::Exposed];

impl Node for Taa {
    fn record(&self, pass: &mut Recorder<'_>) {
        let size = surface::size_of(pass, "source");
        let (source, history) = (pass.image("source"), pass.image("history"));
        let depth = surface::at_size(pass, "depth", size);
        let scale = if pass.wired("motion") {
            let motion = pass.image("motion");
            self.scale(pass.desc(motion).size)
        } else {
            [1.0, 1.0]
        };
        let (motion, has_motion) = optional(pass, "motion", size, depth);
        let (before, has_depth) = optional(pass, "previous_depth", size, depth);
        let has_exposure = pass.wired("meter") && pass.wired("previous_exposure");
        let exposure = if has_exposure { pass.image("previous_exposure") } else { depth };
        let name = match self.filtering {
            HistoryFilter::Bicubic => "taa",
            HistoryFilter::Bilinear => "taa_bilinear",
        };
        let call = pass.function(&SHADER, name).read("source", source).read("history", history);
        let call = call.read("depth", depth).read("previous_depth", before).read("motion", motion);
        let call = call.set("scale", scale).set("has_motion", has_motion).set("has_depth", has_depth);
        let call = call.read("previous_exposure", exposure).set("has_exposure", f64::from(u8::from(has_exposure)));
        let larger = if self.double { 2 } else { 1 };
        let call = call.set("size", f64::from(larger)).set("texel", 1.0 / f64::from(larger));
        call.write("result", ImageDesc::new(Size::new(larger * size.width, larger * size.height)));
        if pass.is_output_used("exposure") {
            let desc = ImageDesc::new(Size::new(1, 1)).format(Format::R32Float);
            pass.function(&SHADER, "taa_exposure").write("exposure", desc);
        }
    }
}
