//! The recordings that the contract makes of a kind, and what none of them uses of its declaration.

use super::passes;
use super::recorded::{Recorded, Tables, Use, Wiring};
use super::violations::Violations;
use crate::node::{Fallback, InputValue, NodeInstance, NodeKind, Pass, Recording, Resource};
use afterimage_base::image::Size;
use afterimage_base::value::{Param, Type, Value, When};

/// An image as tests have it, a single pixel, and the largest images that every device has.
const SIZES: [(u32, u32); 4] = [SMALL, (1, 1), (7680, 4320), (8192, 8192)];
const SMALL: (u32, u32) = (64, 36);

fn small() -> Size {
    Size::new(SMALL.0, SMALL.1)
}

/// Records a kind at its defaults and at each parameter's extremes, and calls `seen` with each recording. Returns why
/// no pass is checked of a kind that never records.
pub(super) fn look(
    kind: &NodeKind,
    violations: &mut Violations,
    seen: &mut dyn FnMut(&Recording) -> Vec<String>,
) -> Option<String> {
    let defaults: Vec<Value> = kind.params().iter().map(|param| param.default.clone()).collect();
    let dynamic: Vec<usize> = (0..kind.params().len()).filter(|index| !kind.params()[*index].replan).collect();
    let mut uses = Uses::new(kind);
    let mut fixed_passes = [None, None];
    for (param, value) in std::iter::once(None).chain(tried_values(kind)).map(Option::unzip) {
        let mut values = defaults.clone();
        let is_extreme =
            param.zip(value.as_ref()).is_some_and(|(index, value)| extremes(&kind.params()[index]).contains(value));
        if let (Some(param), Some(value)) = (param, value) {
            values[param] = value;
        }
        let node = NodeInstance::new(kind.clone(), values);
        // The defaults are used in every way; each extreme with everything wired, which is where it can do most.
        let variants: &[_] = match param {
            None => &[(Wiring::All, false), (Wiring::Required, false), (Wiring::All, true)],
            Some(_) if is_extreme => &[(Wiring::All, false)],
            Some(_) => &[],
        };
        for (wiring, is_exact) in variants.iter().copied() {
            let mut computed = Tables::new();
            for size in SIZES.map(|(width, height)| Size::new(width, height)) {
                let used = Use { node: &node, wiring, size, dynamic: &[], is_exact };
                let Some(recorded) = used.record(std::mem::take(&mut computed), violations) else {
                    uses.add_refused(param);
                    continue;
                };
                // A recording may bake a table, which no size changes, so it is repeated only for one size.
                let again =
                    (param.is_none() && size == small()).then(|| used.record(Tables::new(), violations)).flatten();
                violations.require(again.is_none_or(|again| recorded == again), || {
                    "two recordings at equal values differ".into()
                });
                computed.clone_from(&recorded.recording.computed);
                passes::look(kind, &recorded, size, violations);
                seen(&recorded.recording).into_iter().for_each(|violation| violations.add(violation));
                uses.add(size, param, recorded);
            }
        }
        // A parameter that needs no new plan changes uniforms only: the host may set it while a plan runs.
        if param.is_none_or(|param| dynamic.contains(&param)) && !dynamic.is_empty() {
            for (wiring, fixed) in [Wiring::All, Wiring::Required].into_iter().zip(&mut fixed_passes) {
                let used = Use { node: &node, wiring, size: small(), dynamic: &dynamic, is_exact: false };
                let recorded = used.record(Tables::new(), violations).map(Recorded::without_uniforms);
                match param {
                    None => *fixed = recorded,
                    Some(param) => {
                        violations.require(recorded.is_none() || fixed.is_none() || recorded == *fixed, || {
                            let (name, value) = (&kind.params()[param].name, &node.values()[param]);
                            format!("`{name}` at {value} changes more than uniforms: declare `replans()`")
                        })
                    }
                }
            }
        }
    }
    if !uses.is_recorded {
        let why = match NodeInstance::new(kind.clone(), defaults).verify() {
            Err(why) => format!("its defaults are refused ({why})"),
            Ok(()) => "each output equals its fallback at the defaults".into(),
        };
        return Some(format!(
            "no pass is checked, because {why}, and so it is at each parameter's extremes: give it defaults at which \
             it runs, or test it in a pipeline"
        ));
    }
    // After a wrong recording, declarations would seem unused.
    if violations.0.is_empty() {
        uses.finish(violations);
    }
    None
}

/// Each parameter with each of its extremes, its middle and its neutral value, but for the default.
fn tried_values(kind: &NodeKind) -> impl Iterator<Item = Option<(usize, Value)>> + '_ {
    kind.params().iter().enumerate().flat_map(|(index, param)| {
        let mut values = extremes(param);
        values.extend(param.middle().into_iter().chain(param.neutral.clone()).filter(|_| !param.replan));
        values.into_iter().filter(|value| *value != param.default).map(move |value| Some((index, value)))
    })
}

fn extremes(param: &Param) -> Vec<Value> {
    match param.ty {
        Type::Choice(choices) => choices.iter().map(|choice| Value::Choice(choice.name)).collect(),
        _ => param.lowest().into_iter().chain(param.highest()).collect(),
    }
}

/// Declarations of a kind that its recordings have used.
struct Uses<'k> {
    kind: &'k NodeKind,
    params: Vec<bool>,
    inputs: Vec<bool>,
    /// The recording of each size at the defaults with everything wired.
    defaults: Vec<(Size, Recorded)>,
    is_recorded: bool,
    /// Sentences about images that passes store and nothing reads.
    unread: Violations,
}

impl<'k> Uses<'k> {
    /// Nothing is used yet, but for parameters without extremes, such as files, which cannot be tried.
    fn new(kind: &'k NodeKind) -> Self {
        let params = kind.params().iter().map(|param| extremes(param).is_empty()).collect();
        let is_fallback = |name: &str| {
            kind.outputs().iter().any(|output| matches!(&output.fallback, Fallback::Input(of) if *of == name))
        };
        let inputs = kind.inputs().iter().map(|port| is_fallback(&port.name)).collect();
        Self { kind, params, inputs, defaults: Vec::new(), is_recorded: false, unread: Violations::default() }
    }

    /// Adds a recording, with the parameter that is at an extreme in it.
    fn add(&mut self, size: Size, param: Option<usize>, recorded: Recorded) {
        self.is_recorded = true;
        unread_images(&recorded, &mut self.unread);
        for (is_used, value) in self.inputs.iter_mut().zip(&recorded.inputs) {
            *is_used |= is_used_in(&recorded, value);
        }
        for kernel in recorded.recording.passes.iter().flat_map(|pass| &pass.kernels) {
            let Ok(reflection) = kernel.shader.reflect() else { continue };
            for member in reflection.structs.iter().flat_map(|layout| &layout.members) {
                if let Some((param, _)) = self.kind.param(&member.name) {
                    self.params[param] = true;
                }
            }
        }
        let default = self.defaults.iter().find(|(of, _)| *of == size).map(|(_, default)| default);
        match (param, default) {
            (Some(param), Some(default)) => self.params[param] |= recorded != *default,
            (None, None) => self.defaults.push((size, recorded)),
            _ => {}
        }
    }

    /// The kind refuses a value of the parameter, or its fallback replaces it there.
    fn add_refused(&mut self, param: Option<usize>) {
        if let Some(param) = param {
            self.params[param] = true;
        }
    }

    /// Reports what no recording has used.
    fn finish(self, violations: &mut Violations) {
        self.unread.0.iter().for_each(|violation| violations.add(violation));
        for (index, port) in self.kind.inputs().iter().enumerate() {
            let is_used = self.inputs[index] || is_used_without_another(self.kind, index, violations);
            violations.require(is_used, || format!("no pass reads the input `{}`", port.name));
        }
        for (index, param) in self.kind.params().iter().enumerate() {
            let acts = self.params[index] || acts_under_its_conditions(self.kind, index, violations);
            violations.require(acts, || {
                format!(
                    "the parameter `{}` does nothing: no uniform has it, and no pass differs by it; if it depends on \
                     another one, declare `when`",
                    param.name
                )
            });
        }
    }
}

/// Whether something of what arrives at an input is read, or is a result itself.
fn is_used_in(recorded: &Recorded, value: &InputValue) -> bool {
    let passes: &[Pass] = &recorded.recording.passes;
    let reads = |resource: Resource| passes.iter().any(|pass| pass.reads().contains(&resource));
    if recorded.outputs.contains(value) {
        return true;
    }
    match value {
        InputValue::Image(image) => reads(Resource::Image(*image)),
        InputValue::Pyramid(levels) => levels.iter().any(|level| reads(Resource::Image(*level))),
        InputValue::Buffer(buffer) => reads(Resource::Buffer(*buffer)),
        InputValue::Block(block) => passes.iter().flat_map(Pass::args).any(|arg| arg.block() == Some(*block)),
        InputValue::Zero | InputValue::Absent => false,
    }
}

fn record(kind: &NodeKind, values: Vec<Value>, wiring: Wiring, violations: &mut Violations) -> Option<Recorded> {
    let node = NodeInstance::new(kind.clone(), values);
    let used = Use { node: &node, wiring, size: small(), dynamic: &[], is_exact: false };
    used.record(Tables::new(), violations)
}

/// Whether an input is used where one of the others is not wired.
fn is_used_without_another(kind: &NodeKind, input: usize, violations: &mut Violations) -> bool {
    (0..kind.inputs().len()).any(|other| {
        let defaults = kind.params().iter().map(|param| param.default.clone()).collect();
        let recorded = record(kind, defaults, Wiring::AllBut(other), violations);
        recorded.is_some_and(|recorded| is_used_in(&recorded, &recorded.inputs[input]))
    })
}

/// Whether the extremes of a parameter differ where its conditions hold, with all inputs or with some.
fn acts_under_its_conditions(kind: &NodeKind, param: usize, violations: &mut Violations) -> bool {
    let mut values: Vec<Value> = kind.params().iter().map(|param| param.default.clone()).collect();
    let mut wirings = vec![Wiring::All, Wiring::Required, Wiring::SmallOthers, Wiring::WideColors];
    for condition in &kind.params()[param].when {
        match condition {
            When::OneOf(name, among) => {
                kind.param(name).into_iter().for_each(|(other, _)| values[other].clone_from(&among[0]));
            }
            When::NoneOf(name, among) => {
                if let Some((index, other)) = kind.param(name) {
                    let others = std::iter::once(other.default.clone()).chain(extremes(other));
                    values[index] = others
                        .into_iter()
                        .find(|value| !among.contains(value))
                        .unwrap_or_else(|| other.default.clone());
                }
            }
            When::Wired(input, false) => {
                wirings.extend(kind.inputs().iter().position(|port| port.name == *input).map(Wiring::AllBut));
            }
            When::Wired(_, true) => {}
        }
    }
    wirings.into_iter().any(|wiring| {
        let mut first = None;
        extremes(&kind.params()[param]).into_iter().any(|value| {
            values[param] = value;
            let recorded = record(kind, values.clone(), wiring, violations);
            match (&first, recorded) {
                (None, recorded) => {
                    first = Some(recorded);
                    false
                }
                (Some(first), recorded) => *first != recorded,
            }
        })
    })
}

/// Reports images that passes make and that are neither read nor given to outputs. What tests depths need not be read
/// afterwards.
fn unread_images(recorded: &Recorded, violations: &mut Violations) {
    let Recorded { outputs, recording, input_images, .. } = recorded;
    let is_result = |image| {
        outputs.iter().any(|output| match output {
            InputValue::Image(of) => *of == image,
            InputValue::Pyramid(levels) => levels.contains(&image),
            _ => false,
        })
    };
    for pass in &recording.passes {
        for image in pass.writes().into_iter().filter_map(Resource::image) {
            let is_depth = pass.drawing().is_some_and(|drawing| drawing.is_depth(image));
            let is_own = image.0 as usize >= *input_images;
            let is_read = || recording.passes.iter().any(|pass| pass.reads().contains(&Resource::Image(image)));
            violations.require(!is_own || is_depth || is_result(image) || is_read(), || {
                let label = &recording.image(image).label;
                format!("the pass `{}` makes the image `{label}`, which nothing reads", pass.label)
            });
        }
    }
}
