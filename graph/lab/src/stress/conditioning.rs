//! How much an error of the input grows: each kind gets light, and the same light one half-float unit brighter.

use afterimage_gpu::Gpu;
use afterimage_graph::image::{ColorState, Size};
use afterimage_graph::node::{NodeKind, PortType, Registry};
use afterimage_plan::Options;
use comfy_table::Table;
use comfy_table::presets::NOTHING;
use serde::{Deserialize, Serialize};

use super::images::Extreme;
use super::render::{Configuration, OutputPixels, RenderRequest, Renderer, Shot};
use super::settings::{arguments, sweep};
use super::subject::{Overrides, Subject};
use crate::Progress;

/// The conditioning of one kind.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Conditioning {
    /// The kind's name.
    pub kind: String,
    /// What the output's error is counted in.
    pub unit: ErrorUnit,
    /// The growth that half of all lights stay below, at the defaults.
    pub typical: f64,
    /// The worst light at the defaults.
    pub worst: WorstLight,
    /// The worst light at the worst value of any one parameter.
    pub over_domain: WorstLight,
}

/// What errors of an output are counted in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum ErrorUnit {
    /// The distance from one half float to the next, at the output's own magnitude and at least that at 2^-14.
    Half,
    /// A 255th: the picture is ready for a screen.
    Code,
    /// A 1024th, of the number itself where it is above 1: stops, logarithms and sums, which may be 0 without being
    /// dark.
    Fixed,
}

impl ErrorUnit {
    /// The name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Half => "half-float units",
            Self::Code => "8-bit codes",
            Self::Fixed => "1024ths",
        }
    }
}

/// Where an error grows most.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct WorstLight {
    /// Units at the output for one half-float unit at the input.
    pub growth: f64,
    /// The light in red; green and blue are equal to it, or a quarter and a sixteenth of it.
    pub light: f64,
    /// Whether green and blue are equal to red.
    pub gray: bool,
    /// The parameter that is not at its default, as `--set` takes it; empty at the defaults.
    pub set: String,
}

impl WorstLight {
    /// The light as text: `gray 0.5` or `red 0.5`.
    pub fn place(&self) -> String {
        format!("{} {}", if self.gray { "gray" } else { "red" }, self.light)
    }
}

/// One light of the measurement.
#[derive(Clone, Copy)]
struct Light {
    red: f32,
    gray: bool,
}

const SIZE: Size = Size { width: 4, height: 4, depth: 1 };
/// The lights reach from the least normal half float to the brightest power of two.
const DARKEST: i32 = -14;
const BRIGHTEST: i32 = 15;
/// What a screen shows ends here.
const WHITE: i32 = 0;

/// The distance from one half float to the next at this magnitude.
fn half_unit(x: f64) -> f64 {
    x.abs().max(2_f64.powi(DARKEST)).log2().floor().exp2() / 1024.0
}

impl Light {
    /// All lights up to a power of two.
    fn all(brightest: i32, per_octave: i32) -> Vec<Self> {
        let steps = (brightest - DARKEST) * per_octave;
        let red = |step: i32| half::f16::from_f32((DARKEST as f32 + step as f32 / per_octave as f32).exp2()).to_f32();
        (0..=steps).flat_map(|step| [true, false].map(|gray| Self { red: red(step), gray })).collect()
    }

    /// The light, with each channel brighter by this number of half-float units.
    fn shot(self, units: f32) -> Shot {
        let channels = if self.gray { [1.0; 3] } else { [1.0, 0.25, 0.0625] };
        let brighter = |share: f32| {
            let light = self.red * share;
            light + units * half_unit(f64::from(light)) as f32
        };
        let [r, g, b] = channels.map(brighter);
        Shot::still(Extreme::constant([r, g, b, 1.0]))
    }
}

/// Measures each kind among the subjects that has an image input. Optional values are left out: the kind's own error
/// counts, not that of a metering kind before it.
pub fn conditioning(
    gpu: &Gpu,
    registry: &Registry,
    subjects: &[Subject],
    progress: &dyn Progress,
) -> Vec<Conditioning> {
    let mut renderer = Renderer::new(gpu, false, Options::default());
    let mut all: Vec<Conditioning> = Vec::new();
    for subject in subjects.iter().filter(|subject| subject.is_kind && !subject.signed) {
        let name = subject.title.trim_end_matches(" (bare)");
        if registry.get(name).is_some_and(|kind| has_only_optional_values(kind) == subject.bare) {
            progress.begin(&subject.title);
            all.extend(of_kind(&mut renderer, registry, subject, name));
            progress.end();
        }
    }
    all
}

/// Whether there are optional inputs, all of them values.
fn has_only_optional_values(kind: &NodeKind) -> bool {
    let mut optional = kind.inputs().iter().filter(|port| port.optional).peekable();
    optional.peek().is_some() && optional.all(|port| port.ty == PortType::Value)
}

fn of_kind(renderer: &mut Renderer, registry: &Registry, subject: &Subject, name: &str) -> Option<Conditioning> {
    let graph = subject.graph(registry, &Overrides::new()).ok()?;
    if graph.inputs.is_empty() {
        return None;
    }
    let mut configuration = renderer.configure(|_, options| options.exact = true, false);
    let (growths, unit) = growths(renderer, &mut configuration, registry, subject, &Overrides::new(), 4)?;
    let worst = worst(&growths, &Overrides::new())?;
    let mut over_domain = worst.clone();
    for change in sweep(subject, &graph, 0).iter().skip(1).filter(|change| change.overrides.len() == 1) {
        let Some((growths, _)) = self::growths(renderer, &mut configuration, registry, subject, &change.overrides, 1)
        else {
            continue;
        };
        let found = self::worst(&growths, &change.overrides).filter(|found| found.growth > over_domain.growth);
        over_domain = found.unwrap_or(over_domain);
    }
    let mut sorted: Vec<f64> = growths.iter().map(|(growth, _)| *growth).collect();
    sorted.sort_by(f64::total_cmp);
    let typical = round(sorted[sorted.len() / 2]);
    Some(Conditioning { kind: name.to_owned(), unit, typical, worst, over_domain })
}

/// The growth of each light, in the unit of the kind's first output.
fn growths(
    renderer: &mut Renderer,
    configuration: &mut Configuration,
    registry: &Registry,
    subject: &Subject,
    overrides: &Overrides,
    per_octave: i32,
) -> Option<(Vec<(f64, Light)>, ErrorUnit)> {
    let graph = subject.graph(registry, overrides).ok()?;
    let is_shown = graph.inputs.iter().any(|input| unit_of(input.state) == ErrorUnit::Code);
    let lights = Light::all(if is_shown { WHITE } else { BRIGHTEST }, per_octave);
    let shots: Vec<Shot> = lights.iter().flat_map(|light| [light.shot(0.0), light.shot(1.0)]).collect();
    let request = RenderRequest { subject, graph: &graph, size: SIZE, shots: &shots, together: true };
    let ran = renderer.run(configuration, request).ok()?;
    let first = |frame: &Vec<OutputPixels>| frame.first().cloned();
    let mut unit = ErrorUnit::Half;
    let mut all = Vec::new();
    for (light, pair) in lights.iter().zip(ran.frames.chunks_exact(2)) {
        let (exact, off) = (first(&pair[0])?, first(&pair[1])?);
        unit = unit_of(exact.state);
        all.push((growth(&exact, &off, unit), *light));
    }
    Some((all, unit))
}

fn unit_of(state: ColorState) -> ErrorUnit {
    match state {
        ColorState::DisplayLinear | ColorState::Encoded => ErrorUnit::Code,
        ColorState::Data | ColorState::LogLuminance => ErrorUnit::Fixed,
        _ => ErrorUnit::Half,
    }
}

/// The largest error of a color, in units.
fn growth(exact: &OutputPixels, off: &OutputPixels, unit: ErrorUnit) -> f64 {
    let pairs = exact.pixels.iter().zip(&off.pixels).flat_map(|(a, b)| a[..3].iter().zip(&b[..3]));
    let errors = pairs.map(|(a, b)| {
        let (a, b) = (f64::from(*a), f64::from(*b));
        match unit {
            ErrorUnit::Half => (a - b).abs() / half_unit(a),
            ErrorUnit::Code => (a - b).abs() * 255.0,
            ErrorUnit::Fixed => (a - b).abs() / a.abs().max(1.0) * 1024.0,
        }
    });
    errors.fold(0.0, f64::max)
}

fn worst(growths: &[(f64, Light)], overrides: &Overrides) -> Option<WorstLight> {
    let (growth, light) = growths.iter().max_by(|a, b| a.0.total_cmp(&b.0))?;
    let set = arguments(overrides).trim_start_matches(" --set ").replace("it.", "").replace('\'', "");
    Some(WorstLight { growth: round(*growth), light: round(f64::from(light.red)), gray: light.gray, set })
}

/// Three digits: drivers differ in the rest.
fn round(x: f64) -> f64 {
    format!("{x:.2e}").parse().unwrap_or(x)
}

/// The figures of all kinds as text.
pub fn conditioning_table(all: &[Conditioning]) -> String {
    let mut table = Table::new();
    table.load_style(NOTHING).set_header(["", "typical", "worst", "at", "over the domain", "at", "in"]);
    for row in all {
        let over = match row.over_domain.set.as_str() {
            "" => row.over_domain.place(),
            set => format!("{}, {set}", row.over_domain.place()),
        };
        table.add_row([
            row.kind.clone(),
            row.typical.to_string(),
            row.worst.growth.to_string(),
            row.worst.place(),
            row.over_domain.growth.to_string(),
            over,
            row.unit.name().to_owned(),
        ]);
    }
    table.to_string()
}

#[cfg(test)]
mod tests {
    use super::{BRIGHTEST, Light, half_unit};

    #[test]
    fn units_are_those_of_half_floats() {
        assert_eq!(half_unit(1.0), 1.0 / 1024.0);
        assert_eq!(half_unit(1.99), 1.0 / 1024.0);
        assert_eq!(half_unit(0.0), 2_f64.powi(-24));
        assert_eq!(half_unit(-65504.0), 32.0);
    }

    #[test]
    fn lights_cover_the_range_of_halves() {
        let lights = Light::all(BRIGHTEST, 1);
        assert_eq!(lights.len(), 60);
        assert_eq!(lights[0].red, 2_f32.powi(-14));
        assert_eq!(lights[59].red, 32768.0);
    }
}
