//! Rasterization: sides, biases of depth, several attachments, formats of vertices, strips, lines and
//! points.

use afterimage_graph::node::{Cull, DepthTest, Load, Raster, Recorder, Topology, VertexFormat};
use afterimage_graph::prelude::*;

use super::kinds::{CLEARS, FORMATS, LARGE, OTHER, PICK, RESULT, SHADER, SHIFTS, Vertex, buffer, desc};
use super::{SIZE, all_drawn, assert_texels, color_or, drawn, result};

choices! {
    /// The sides that are not drawn.
    pub enum Hidden {
        /// None.
        Neither,
        /// The front.
        Front,
        /// The back.
        Back,
    }
}

node_kind! {
    /// A triangle that goes around counterclockwise, and one that goes around clockwise.
    pub struct Sides {
        /// The side that is not drawn.
        pub hidden: Hidden = Hidden::Neither;
        /// True if clockwise is the front.
        pub clockwise: bool = false;
    }

    const OUTPUTS: &'static [Output] = RESULT;
}

impl Node for Sides {
    fn record(&self, pass: &mut Recorder<'_>) {
        let cull = match self.hidden {
            Hidden::Neither => Cull::None,
            Hidden::Front => Cull::Front,
            Hidden::Back => Cull::Back,
        };
        let vertices = buffer(pass, &[LARGE, OTHER].concat());
        let color = pass.output("result", desc(pass));
        let draw = pass.draw(&SHADER, "corner").fragment("colored").color(color, Load::Clear(CLEARS[0]));
        let draw = draw.raster(Raster { cull, clockwise: self.clockwise, ..Raster::default() });
        draw.vertices(vertices, &FORMATS).record(6, 1);
    }
}

/// Twice the area of a triangle in clip space, with y up: positive if it goes around counterclockwise.
fn turn([a, b, c]: &[Vertex; 3]) -> f64 {
    let [a, b, c] = [a, b, c].map(|vertex| vertex.0.map(f64::from));
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn sides_that_are_hidden_are_not_drawn() {
    assert!(turn(&LARGE) > 0.0 && turn(&OTHER) < 0.0);
    for clockwise in [false, true] {
        for hidden in ["Neither", "Front", "Back"] {
            let is_drawn = |triangle| match hidden {
                "Neither" => true,
                // A front has the direction that is asked for.
                _ => ((turn(triangle) < 0.0) == clockwise) == (hidden == "Back"),
            };
            let node = format!("Sides(hidden: {hidden}, clockwise: {clockwise})");
            assert_texels(&result(&node), SIZE, |pixel| {
                let first = if is_drawn(&LARGE) { color_or(&LARGE, SIZE, pixel, CLEARS[0]) } else { CLEARS[0] };
                if is_drawn(&OTHER) { color_or(&OTHER, SIZE, pixel, first) } else { first }
            });
        }
    }
}

node_kind! {
    /// The depth of a triangle that rises to the right, with a bias.
    pub struct Biased {
        /// Steps of the format.
        pub steps: i32 = 0 => within(0.0..=1e6), replans();
        /// Multiples of the slope.
        pub slopes: f32 = 0.0 => within(0.0..=10.0), replans();
    }

    const OUTPUTS: &'static [Output] = RESULT;
}

/// Depths from 0.55 to 0.95, which change along x alone.
const RISING: [Vertex; 3] = [
    ([-0.875, -0.75, 0.55], [1.0, 1.0, 1.0, 1.0]),
    ([0.925, -0.3125, 0.91], [1.0, 1.0, 1.0, 1.0]),
    ([-0.375, 0.875, 0.65], [1.0, 1.0, 1.0, 1.0]),
];

impl Node for Biased {
    fn record(&self, pass: &mut Recorder<'_>) {
        let vertices = buffer(pass, &RISING);
        let desc = desc(pass);
        let depth = pass.transient("depth", desc.format(Format::Depth32Float));
        let draw = pass.draw(&SHADER, "corner").depth(depth, DepthTest::default());
        let draw = draw.raster(Raster { bias: self.steps, slope_bias: self.slopes, ..Raster::default() });
        draw.vertices(vertices, &FORMATS).record(3, 1);
        pass.function(&PICK, "pick").read("source", depth).write("result", desc.format(Format::R32Float));
    }
}

/// A step of a depth of 32 bits is that of the largest depth of the triangle, which is between one half and one.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn depths_move_by_steps_and_by_slopes() {
    let step = 2.0_f64.powi(-24);
    let slope = f64::from(RISING[1].0[2] - RISING[0].0[2]) / (f64::from(RISING[1].0[0] - RISING[0].0[0]) / 2.0 * 64.0);
    let plain = result("Biased()");
    for (steps, slopes) in [(200_000, 0.0), (0, 4.0), (100_000, 2.0)] {
        let found = result(&format!("Biased(steps: {steps}, slopes: {slopes:?})"));
        let expected = f64::from(steps) * step + slopes * slope;
        let mut covered = 0;
        for (found, plain) in found.pixels.iter().zip(&plain.pixels) {
            let (found, plain) = (f64::from(found[0]), f64::from(plain[0]));
            let moved = if plain == 1.0 { 1.0 } else { plain + expected };
            assert!((found - moved).abs() < 1e-5, "{steps} steps, {slopes} slopes: {found} is not {moved}");
            covered += usize::from(plain != 1.0);
        }
        assert!(covered > 300, "the triangle covers {covered} pixels");
    }
}

static BOTH: Shader = Shader::new(
    "draw_both.wgsl",
    "struct Corner { @builtin(position) place: vec4f, @location(0) color: vec4f }
struct Pair { @location(0) first: vec4f, @location(1) second: vec4f }
@vertex fn both(@location(0) place: vec3f, @location(1) color: vec4f, @location(2) shift: vec4f) -> Corner {
    return Corner(vec4f(place + shift.xyz, 1.0), color * shift.w);
}
@fragment fn pair(corner: Corner) -> Pair { return Pair(corner.color, 1.0 - corner.color); }",
);

node_kind! {
    /// Two instances of a triangle, drawn into two images at once.
    pub struct Two {}

    const OUTPUTS: &'static [Output] = &[
        Output::image("result", OutputState::Always(ColorState::Data), "The colors.").or(Fallback::Absent),
        Output::image("rest", OutputState::Always(ColorState::Data), "One minus them.").or(Fallback::Absent),
    ];
}

impl Node for Two {
    fn record(&self, pass: &mut Recorder<'_>) {
        let vertices = buffer(pass, &LARGE);
        let shifts: Vec<u8> = SHIFTS.as_flattened().iter().flat_map(|number| number.to_le_bytes()).collect();
        let shifts = pass.constant_buffer("shifts", shifts);
        let desc = desc(pass);
        let (first, second) = (pass.output("result", desc), pass.output("rest", desc));
        let draw = pass.draw(&BOTH, "both").fragment("pair").color(first, Load::Clear(CLEARS[0]));
        let draw = draw.color(second, Load::Clear(CLEARS[1])).vertices(vertices, &FORMATS);
        draw.instances(shifts, &[VertexFormat::Float32x4]).record(3, 2);
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn instances_are_drawn_into_two_images_at_once() {
    let moved = SHIFTS.map(|[x, y, z, light]| {
        LARGE.map(|(place, color)| ([place[0] + x, place[1] + y, place[2] + z], color.map(|channel| channel * light)))
    });
    let (_, found) = all_drawn("\"result\": Two()", "result,result.rest");
    assert_texels(&found[0], SIZE, |pixel| {
        color_or(&moved[1], SIZE, pixel, color_or(&moved[0], SIZE, pixel, CLEARS[0]))
    });
    let rest = moved.map(|triangle| triangle.map(|(place, color)| (place, color.map(|channel| 1.0 - channel))));
    assert_texels(&found[1], SIZE, |pixel| color_or(&rest[1], SIZE, pixel, color_or(&rest[0], SIZE, pixel, CLEARS[1])));
}

static PACKED: Shader = Shader::new(
    "draw_packed.wgsl",
    "struct Corner { @builtin(position) place: vec4f, @location(0) @interpolate(flat) color: vec4f }
@vertex fn packed(@location(0) x: f32, @location(1) y: vec2f, @location(2) light: u32, @location(3) tint: vec4f) -> Corner {
    return Corner(vec4f(x, y.y, 0.25, 1.0), tint * f32(light));
}
@fragment fn colored(corner: Corner) -> @location(0) vec4f { return corner.color; }",
);

choices! {
    /// The primitives of the vertices.
    pub enum Shape {
        /// A square of two triangles.
        Strip,
        /// A line along the middle of a row.
        Line,
        /// Four points.
        Points,
    }
}

node_kind! {
    /// Four vertices of numbers of many formats.
    pub struct Shapes {
        /// The primitives that they form.
        pub shape: Shape = Shape::Strip;
    }

    const OUTPUTS: &'static [Output] = RESULT;
}

/// Columns and rows of the centers of the four vertices, in pixels.
const CORNERS: [[u32; 2]; 4] = [[8, 6], [40, 6], [8, 22], [40, 22]];
const LIGHT: u32 = 3;
const TINT: [u8; 4] = [51, 102, 255, 0];

impl Node for Shapes {
    fn record(&self, pass: &mut Recorder<'_>) {
        let topology = match self.shape {
            Shape::Strip => Topology::TriangleStrip,
            Shape::Line => Topology::Lines,
            Shape::Points => Topology::Points,
        };
        let vertex = |[column, row]: [u32; 2]| {
            let x = (column as f32 + 0.5) / SIZE.width as f32 * 2.0 - 1.0;
            let y = 1.0 - (row as f32 + 0.5) / SIZE.height as f32 * 2.0;
            let numbers = [x, 0.0, y].map(f32::to_le_bytes).concat();
            [numbers, LIGHT.to_le_bytes().to_vec(), TINT.to_vec()].concat()
        };
        let vertices = pass.constant_buffer("vertices", CORNERS.map(vertex).concat());
        let color = pass.output("result", desc(pass));
        let draw = pass.draw(&PACKED, "packed").fragment("colored").color(color, Load::Clear(CLEARS[0]));
        let formats = [VertexFormat::Float32, VertexFormat::Float32x2, VertexFormat::Uint32, VertexFormat::Unorm8x4];
        let draw = draw.raster(Raster { topology, ..Raster::default() }).vertices(vertices, &formats);
        draw.record(if self.shape == Shape::Line { 2 } else { 4 }, 1);
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn strips_lines_and_points_have_the_numbers_of_their_vertices() {
    let tint = TINT.map(|code| f64::from(code) / 255.0 * f64::from(LIGHT));
    let ([left, top], [right, bottom]) = (CORNERS[0], CORNERS[3]);
    for shape in ["Strip", "Line", "Points"] {
        let (_, found) = drawn(&format!("\"result\": Shapes(shape: {shape})"), "result");
        let mut covered = 0;
        for (x, y) in (0..SIZE.height).flat_map(|y| (0..SIZE.width).map(move |x| (x, y))) {
            // Which pixels the ends of a line and the border of a square cover is the device's.
            let (is_inside, is_open) = match shape {
                "Strip" => (
                    (left + 1..right).contains(&x) && (top + 1..bottom).contains(&y),
                    [left, right].contains(&x) || [top, bottom].contains(&y),
                ),
                "Line" => (y == top && (left + 1..right).contains(&x), y == top && [left, right].contains(&x)),
                _ => (CORNERS.contains(&[x, y]), false),
            };
            if is_open {
                continue;
            }
            let expected = if is_inside { tint } else { CLEARS[0] };
            let texel = found.at(x, y).map(f64::from);
            let differs = (0..4).any(|channel| (texel[channel] - expected[channel]).abs() > 1e-5);
            assert!(!differs, "{shape} {x}, {y}: {texel:?} is not {expected:?}");
            covered += usize::from(is_inside);
        }
        assert!(covered >= 4, "{shape}: {covered} pixels");
    }
}
