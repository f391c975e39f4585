//! A process as a kernel function, and the tables that it reads as textures.

use std::fmt::Write as _;

use glam::DVec3;

use super::{Antilog, CdlStep, Logarithm, Power, Process, Step};
use crate::lut::{Interpolation, Table, TableImage};

/// The tables of a process: 1-D tables in the rows of one image, and a volume per 3-D table.
#[derive(Debug, Default)]
pub struct Textures<'a> {
    curves: Vec<[f32; 3]>,
    cubes: Vec<&'a Table>,
}

impl Textures<'_> {
    /// Adds the entries of a 1-D table, and returns the index of the first.
    fn add_curve(&mut self, entries: &[[f32; 3]]) -> usize {
        let first = self.curves.len();
        self.curves.extend(entries);
        first
    }

    /// The tables as images for the arguments of the kernel function.
    pub fn images(&self) -> Vec<TableImage> {
        let curves = (!self.curves.is_empty()).then(|| TableImage::curve("curves", &self.curves, false));
        let cubes = self.cubes.iter().enumerate();
        let cubes = cubes.map(|(index, cube)| TableImage::cube(format!("cube{index}"), cube, false));
        curves.into_iter().chain(cubes).collect()
    }

    fn arguments(&self) -> String {
        let curves = if self.curves.is_empty() { "" } else { "curves: texture_2d<f32>, " };
        let cubes: String = (0..self.cubes.len()).map(|index| format!("cube{index}: texture_3d<f32>, ")).collect();
        format!("{curves}{cubes}")
    }
}

/// Parts of a kernel function of a color.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Parts {
    /// Code that comes first.
    pub before: Process,
    /// Code that makes the unchanged color of the result of `before`, for the parameter `strength`.
    pub unchanged: Process,
    /// Code that makes the changed color of the result of `before`.
    pub changed: Process,
    /// Code that comes last, on the mixed color.
    pub after: Process,
    /// True if a color that is not changed is that of the image. Otherwise it is what the steps make of it, which end
    /// at the limits of their space.
    pub keeps_source: bool,
    /// True if the result is scene-linear color, whose luminance is not below 0.
    pub is_scene_light: bool,
}

/// Imports for the code of steps.
const IMPORTS: &str = "import afterimage::color::extended_light;
import afterimage::cube::{cube_tetrahedral, cube_trilinear};
import afterimage::grade::bounded;
import afterimage::math::between3;
import afterimage::process::{
    process_antilog, process_cdl, process_cdl_reverse, process_curve, process_half_curve, process_hlg_decode,
    process_hlg_encode, process_limited, process_logarithm, process_matrix, process_power, process_pq_decode,
    process_pq_encode, process_range, process_sign,
};
import afterimage::shaper::shape3;

";

/// The text of a module with one kernel function.
pub fn function<'a>(name: &str, parts: &'a Parts) -> (String, Textures<'a>) {
    let mut textures = Textures::default();
    let Parts { before, unchanged, changed, after, keeps_source, is_scene_light } = parts;
    let result = match (is_scene_light, keeps_source) {
        (true, _) => "extended_light(bounded(v))",
        (false, true) => "max(bounded(v), vec3f(0.0))",
        (false, false) => "bounded(v)",
    };
    let [before, unchanged, changed, after] = [before, unchanged, changed, after].map(|part| body(part, &mut textures));
    let arguments = textures.arguments();
    let mixed = "between3(unchanged, v, params.strength)";
    let mix = if *keeps_source {
        // What the way through the space loses of the source comes back with the share that is not changed.
        format!(
            "    let mixed = {mixed};\n    v = unchanged;\n{after}    let lost = source.rgb - v;\n    v = mixed;\n\
             {after}    v += (1.0 - params.strength) * lost;\n"
        )
    } else {
        format!("    v = {mixed};\n{after}")
    };
    let text = format!(
        "{IMPORTS}struct ColorLut {{\n    strength: f32,\n}}\n\n\
         fn {name}(source: vec4f, {arguments}params: ColorLut) -> vec4f {{\n    var v = source.rgb;\n\
         {before}    let begin = v;\n{unchanged}    let unchanged = v;\n    v = begin;\n\
         {changed}{mix}    return vec4f({result}, source.a);\n}}\n"
    );
    (text, textures)
}

fn body<'a>(process: &'a Process, textures: &mut Textures<'a>) -> String {
    let mut text = String::new();
    for step in &process.steps {
        let call = call(step, textures);
        let _ = writeln!(text, "    v = process_limited({call});");
    }
    text
}

/// The expression of a step, of the color `v`.
fn call<'a>(step: &'a Step, textures: &mut Textures<'a>) -> String {
    match step {
        Step::Matrix(rows) => format!("process_matrix(v, {})", list(rows.map(vec4))),
        Step::Range { slope, offset, low, high } => {
            format!("process_range(v, {})", list([slope, offset, low, high].map(|x| number(*x))))
        }
        Step::Cdl(cdl) => cdl_call(cdl),
        Step::Logarithm(curves) => format!("process_logarithm(v, {})", logarithm(curves)),
        Step::Antilog(curves) => format!("process_antilog(v, {})", antilog(curves)),
        Step::Power(curves) => power_call(curves),
        Step::PqEncode(white) => format!("process_pq_encode(v * {})", number(*white)),
        Step::PqDecode(white) => format!("process_pq_decode(v) * {}", number(white.recip())),
        Step::HlgEncode(hlg) => {
            format!("process_hlg_encode(v * {}, {})", number(hlg.white / hlg.peak), number(hlg.powers()[1]))
        }
        Step::HlgDecode(hlg) => {
            format!("process_hlg_decode(v, {}) * {}", number(hlg.powers()[0]), number(hlg.peak / hlg.white))
        }
        Step::Shape(shape) => format!("shape3(v, {}, {})", vec4(shape.line), vec4(shape.curve)),
        Step::Curve(table) => {
            let first = textures.add_curve(&table.entries);
            let [low, scale] = domain(table);
            format!("process_curve(curves, {first}u, {}u, (v - {low}) * {scale})", table.size)
        }
        Step::HalfCurve(entries) => format!("process_half_curve(curves, {}u, v)", textures.add_curve(entries)),
        Step::Cube(table, interpolation) => {
            let [low, scale] = domain(table);
            let function = match interpolation {
                Interpolation::Tetrahedral => "cube_tetrahedral",
                Interpolation::Trilinear => "cube_trilinear",
            };
            textures.cubes.push(table);
            format!("{function}(cube{}, (v - {low}) * {scale})", textures.cubes.len() - 1)
        }
    }
}

fn domain(table: &Table) -> [String; 2] {
    [table.low.map(f64::from), table.scale()].map(vec3)
}

fn cdl_call(cdl: &CdlStep) -> String {
    let name = if cdl.is_reverse { "process_cdl_reverse" } else { "process_cdl" };
    let triples = [cdl.slope, cdl.offset, cdl.power].map(|v: DVec3| vec3(v.to_array()));
    let [low, high] = cdl.limits();
    format!("{name}(v, {}, {})", list(triples), list([cdl.saturation, low, high].map(number)))
}

fn logarithm(curves: &[Logarithm; 3]) -> String {
    let member = |f: fn(&Logarithm) -> f64| vec3(curves.each_ref().map(f));
    list([
        member(|c| c.slope),
        member(|c| c.offset),
        member(|c| c.end),
        member(|c| c.a),
        member(|c| c.b),
        member(|c| c.scale),
        member(|c| c.shift),
    ])
}

fn antilog(curves: &[Antilog; 3]) -> String {
    let member = |f: fn(&Antilog) -> f64| vec3(curves.each_ref().map(f));
    list([
        member(|c| c.slope),
        member(|c| c.offset),
        member(|c| c.end),
        member(|c| c.a),
        member(|c| c.b),
        member(|c| c.scale),
        member(|c| c.shift),
    ])
}

fn power_call(curves: &[Power; 3]) -> String {
    let member = |f: fn(&Power) -> f64| vec3(curves.each_ref().map(f));
    let constants = list([
        member(|c| c.slope),
        member(|c| c.end),
        member(|c| c.a),
        member(|c| c.b),
        member(|c| c.exponent),
        member(|c| c.scale),
        member(|c| c.shift),
    ]);
    // The curves of a step are all mirrored or none: files state it once.
    match curves[0].is_mirrored {
        true => format!("process_sign(v) * process_power(abs(v), {constants})"),
        false => format!("process_power(v, {constants})"),
    }
}

fn list<const N: usize>(parts: [String; N]) -> String {
    parts.join(", ")
}

/// A literal of the nearest number in 32 bits.
fn number(x: f64) -> String {
    format!("{:?}f", x.clamp(f64::from(f32::MIN), f64::from(f32::MAX)) as f32)
}

fn vec3(v: [f64; 3]) -> String {
    format!("vec3f({})", list(v.map(number)))
}

fn vec4(v: [f64; 4]) -> String {
    format!("vec4f({})", list(v.map(number)))
}
