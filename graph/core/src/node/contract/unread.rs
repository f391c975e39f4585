//! What a kind declares or stores and never uses: parameters, inputs, images between passes.

use std::collections::BTreeSet;

use super::recorded::{Around, Recorded, Tables, Use, extremes, record, records, variants};
use super::violations::Violations;
use crate::node::{Fallback, InputValue, NodeInstance, NodeKind, Pass, Resource};
use afterimage_base::image::Size;
use afterimage_base::value::{Type, Value};

/// What recordings have used of what a kind declares.
pub(super) struct Uses<'k> {
    kind: &'k NodeKind,
    params: Vec<bool>,
    inputs: Vec<bool>,
    /// The first recording, at the defaults with everything wired, and its size.
    default: Option<(Size, Recorded)>,
    is_recorded: bool,
    /// Images that passes store and nothing reads: sentences.
    stored: BTreeSet<String>,
}

impl<'k> Uses<'k> {
    /// Nothing is used yet, but for parameters without extremes, such as files, which cannot be tried.
    pub(super) fn new(kind: &'k NodeKind) -> Self {
        let params = kind.params().iter().map(|param| extremes(param).is_empty()).collect();
        let is_fallback = |name: &str| {
            kind.outputs().iter().any(|output| matches!(&output.fallback, Fallback::Input(of) if *of == name))
        };
        let inputs = kind.inputs().iter().map(|port| is_fallback(&port.name)).collect();
        Self { kind, params, inputs, default: None, is_recorded: false, stored: BTreeSet::new() }
    }

    /// Adds a recording, with the parameter that is at an extreme in it.
    pub(super) fn add(&mut self, size: Size, param: Option<usize>, recorded: Recorded) {
        self.is_recorded = true;
        self.stored.extend(stored(&recorded));
        for (is_used, value) in self.inputs.iter_mut().zip(&recorded.inputs) {
            *is_used |= is_used_in(&recorded, value);
        }
        for kernel in recorded.recording.passes.iter().flat_map(|pass| &pass.kernels) {
            let Ok(reflection) = kernel.shader.reflect() else { continue };
            for layout in &reflection.structs {
                for (param, is_used) in self.kind.params().iter().zip(&mut self.params) {
                    *is_used |= layout.members.iter().any(|member| param.name == member.name);
                }
            }
        }
        match (param, &self.default) {
            (Some(param), Some((of, default))) if *of == size => self.params[param] |= recorded != *default,
            (None, None) => self.default = Some((size, recorded)),
            _ => {}
        }
    }

    /// The kind refuses this value of the parameter, or its fallback replaces it there.
    pub(super) fn add_unrecorded(&mut self, param: Option<usize>) {
        if let Some(param) = param {
            self.params[param] = true;
        }
    }

    /// Whether there was a recording.
    pub(super) fn is_recorded(&self) -> bool {
        self.is_recorded
    }

    /// Complains about what no recording has used.
    pub(super) fn finish(self, violations: &mut Violations) {
        self.stored.iter().for_each(|sentence| violations.add(sentence));
        for (index, port) in self.kind.inputs().iter().enumerate() {
            let is_used = self.inputs[index] || is_used_without_another(self.kind, index, violations);
            violations.require(is_used, || format!("no pass reads the input `{}`", port.name));
        }
        for (index, param) in self.kind.params().iter().enumerate() {
            let acts = self.params[index] || acts_with_others(self.kind, index, violations);
            violations.require(acts, || {
                format!("the parameter `{}` does nothing: no uniform has it, and no pass differs by it", param.name)
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

fn recorded(kind: &NodeKind, values: Vec<Value>, around: Around, violations: &mut Violations) -> Option<Recorded> {
    let node = NodeInstance::new(kind.clone(), values);
    let size = Size::new(64, 36);
    let way = Use { node: &node, dynamic: &[], size, around, is_exact: false, is_default: false };
    records(&way).then(|| record(&way, Tables::new(), violations)).flatten()
}

/// Whether an input is used where one of the others is not wired.
fn is_used_without_another(kind: &NodeKind, input: usize, violations: &mut Violations) -> bool {
    for other in 0..kind.inputs().len() {
        let defaults = kind.params().iter().map(|param| param.default.clone()).collect();
        let recorded = recorded(kind, defaults, Around::AllBut(other), violations);
        if recorded.is_some_and(|recorded| is_used_in(&recorded, &recorded.inputs[input])) {
            return true;
        }
    }
    false
}

/// Whether the extremes of a parameter differ where another parameter is at an extreme, or with other inputs.
fn acts_with_others(kind: &NodeKind, param: usize, violations: &mut Violations) -> bool {
    let is_switch = |param: usize| matches!(kind.params()[param].ty, Type::Bool | Type::Choice(_));
    let mut contexts = variants(kind);
    // What a parameter depends on is a switch, more often than not.
    contexts.sort_by_key(|variant| variant.param.is_some_and(|param| !is_switch(param)));
    for variant in contexts {
        for around in [Around::Everything, Around::Required, Around::SmallOthers, Around::WideColors] {
            let mut first: Option<Recorded> = None;
            for value in extremes(&kind.params()[param]) {
                let mut values = variant.values.clone();
                values[param] = value;
                let recorded = recorded(kind, values, around, violations);
                match (recorded, &first) {
                    (None, None) => {}
                    (Some(recorded), None) => first = Some(recorded),
                    (Some(recorded), Some(first)) if recorded == *first => {}
                    _ => return true,
                }
            }
        }
    }
    false
}

/// Images that passes make are read, or given to outputs. What tests depths need not be read afterwards.
fn stored(recorded: &Recorded) -> BTreeSet<String> {
    let mut unread = BTreeSet::new();
    let Recorded { outputs, recording, given, .. } = recorded;
    let is_given = |image| {
        outputs.iter().any(|output| match output {
            InputValue::Image(of) => *of == image,
            InputValue::Pyramid(levels) => levels.contains(&image),
            _ => false,
        })
    };
    for pass in &recording.passes {
        for image in pass.writes().into_iter().filter_map(Resource::image) {
            let is_depth = pass.drawing().is_some_and(|drawing| drawing.is_depth(image));
            let is_own = image.0 as usize >= *given;
            let is_read = || recording.passes.iter().any(|pass| pass.reads().contains(&Resource::Image(image)));
            if is_own && !is_depth && !is_given(image) && !is_read() {
                let label = &recording.image(image).label;
                unread.insert(format!("the pass `{}` makes the image `{label}`, which nothing reads", pass.label));
            }
        }
    }
    unread
}
