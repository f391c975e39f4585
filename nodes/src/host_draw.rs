//! Draw, DrawSamples and DrawDepth: passes that a host fills with its own draws.

use afterimage_graph::node::{DepthTest, Load};
use afterimage_graph::prelude::*;

choices! {
    /// The format of a depth.
    pub enum DepthFormat {
        /// A float.
        Depth32Float,
        /// 16 bits: steps of 1/65535.
        Depth16Unorm,
    }
}

node_kind! {
    /// Color and depth that the host draws, with one sample in each pixel.
    ///
    /// The plan makes the images and clears them, and the host records the draws: `Post::encode_drawing` takes them by
    /// the name of the node, and `Post::draw_targets` states what its pipelines are made for. `format` is that of the
    /// color, `Rgba16Float` without it. Numbers that are not finite are limited where the images are read.
    pub struct Draw {
        /// Pixels across; 0 for those of the frame.
        pub width: u32 = 0 => within(0.0..=8192.0), unit("pixels");
        /// Pixels down; 0 for those of the frame.
        pub height: u32 = 0 => within(0.0..=8192.0), unit("pixels");
        /// The color before the first draw.
        pub clear: [f32; 4] = [0.0, 0.0, 0.0, 0.0] => within(-65504.0..=65504.0), usually(0.0..=1.0), replans();
        /// Whether the near plane has depth 1, so that the depth begins with 0; else it begins with 1.
        pub reversed: bool = false;
    }

    const OUTPUTS: &'static [Output] = &[
        Output::image("result", OutputState::Always(ColorState::Scene), "The color."),
        Output::image("depth", OutputState::Always(ColorState::Data), "What the projection writes, in x.")
            .or(Fallback::Absent),
    ];
}

node_kind! {
    /// Color and depth that the host draws, with four samples in each pixel: for a `Resolve` of each.
    ///
    /// All else is as for `Draw`. No device has to draw samples of four 32-bit floats.
    pub struct DrawSamples {
        /// Pixels across; 0 for those of the frame.
        pub width: u32 = 0 => within(0.0..=8192.0), unit("pixels");
        /// Pixels down; 0 for those of the frame.
        pub height: u32 = 0 => within(0.0..=8192.0), unit("pixels");
        /// The color before the first draw.
        pub clear: [f32; 4] = [0.0, 0.0, 0.0, 0.0] => within(-65504.0..=65504.0), usually(0.0..=1.0), replans();
        /// Whether the near plane has depth 1, so that the depth begins with 0; else it begins with 1.
        pub reversed: bool = false;
    }

    const OUTPUTS: &'static [Output] = &[
        Output::new("result", PortType::Multisampled, OutputState::Always(ColorState::Scene), "The color."),
        Output::new(
            "depth",
            PortType::Multisampled,
            OutputState::Always(ColorState::Data),
            "What the projection writes, in x.",
        ),
    ];
}

node_kind! {
    /// A depth that the host draws: the map of a light for `ShadowMask`.
    ///
    /// All else is as for `Draw`.
    pub struct DrawDepth {
        /// Pixels across; 0 for those of the frame.
        pub width: u32 = 2048 => within(0.0..=8192.0), unit("pixels");
        /// Pixels down; 0 for those of the frame.
        pub height: u32 = 2048 => within(0.0..=8192.0), unit("pixels");
        /// The format of the depth.
        pub depth: DepthFormat = DepthFormat::Depth32Float;
        /// Whether the near plane has depth 1, so that the depth begins with 0; else it begins with 1.
        pub reversed: bool = false;
    }

    const OUTPUTS: &'static [Output] =
        &[Output::image("depth", OutputState::Always(ColorState::Data), "What the projection writes, in x.")
            .or(Fallback::Absent)];
}

/// An image of that size, where 0 is the side of the frame.
fn desc(pass: &Recorder<'_>, width: u32, height: u32) -> ImageDesc {
    let frame = pass.frame_size;
    let side = |asked: u32, frame: u32| if asked == 0 { frame } else { asked };
    ImageDesc::new(Size::new(side(width, frame.width), side(height, frame.height)))
}

fn test(reversed: bool) -> DepthTest {
    if reversed { DepthTest::REVERSED } else { DepthTest::default() }
}

/// A pass of the host with color and depth, which go to these ports.
fn color_and_depth(pass: &mut Recorder<'_>, port: &str, desc: ImageDesc, clear: [f32; 4], reversed: bool) {
    let color = pass.output(port, desc);
    // The format that a file asks for is that of the color.
    let depth = pass.transient("depth", desc.format(Format::Depth32Float));
    pass.set_output("depth", InputValue::Image(depth));
    let draw = pass.host_draw("draws of the host").color(color, Load::Clear(clear.map(f64::from)));
    draw.depth(depth, test(reversed)).record();
}

impl Node for Draw {
    fn record(&self, pass: &mut Recorder<'_>) {
        let desc = desc(pass, self.width, self.height);
        color_and_depth(pass, "result", desc, self.clear, self.reversed);
    }
}

impl Node for DrawSamples {
    fn verify_format(&self, format: Format) -> Result<(), String> {
        match format {
            Format::Rgba32Float => Err("no device has to draw samples of the format `Rgba32Float`".into()),
            _ => Ok(()),
        }
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let desc = desc(pass, self.width, self.height).multisampled(4);
        color_and_depth(pass, "result", desc, self.clear, self.reversed);
    }
}

impl Node for DrawDepth {
    fn record(&self, pass: &mut Recorder<'_>) {
        let format = match self.depth {
            DepthFormat::Depth32Float => Format::Depth32Float,
            DepthFormat::Depth16Unorm => Format::Depth16Unorm,
        };
        let desc = desc(pass, self.width, self.height);
        let depth = pass.transient("depth", desc.format(format));
        pass.set_output("depth", InputValue::Image(depth));
        pass.host_draw("draws of the host").depth(depth, test(self.reversed)).record();
    }
}
