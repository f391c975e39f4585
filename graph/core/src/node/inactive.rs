//! Parameters that do nothing at the present values of the others.
//!
//! A node is recorded at its present values and at others of one parameter. If nothing differs but members of uniforms
//! that the kernels do not read, the parameter has no effect.

use std::rc::Rc;

use super::contract::arrival;
use super::kernel::KernelCall;
use super::kind::InputValues;
use super::pass::Pass;
use super::ports::OutputUse;
use super::recorder::{InputValue, NodeColors, Recorder, RecorderContext, Recording};
use super::typed::NodeInstance;
use afterimage_base::Shared;
use afterimage_base::caps::Caps;
use afterimage_base::image::Size;
use afterimage_base::value::{Param, Type, Value};
use afterimage_wgsl::{Shader, UniformReads};

/// Why a parameter does nothing.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Inactive {
    /// No value changes what the node computes.
    NoEffect,
    /// The node refuses every other value: the sentence that states why.
    Refused(String),
}

/// What decides whether a parameter does something.
#[derive(Clone, Debug, PartialEq)]
pub enum Decisive {
    /// Another parameter, by its index, and values of it at which this one has an effect.
    Parameter(usize, Vec<Value>),
    /// An optional input, by its index: whether something is wired to it.
    Input(usize),
}

/// Finds the parameters of nodes that do nothing at present. It keeps what it has linked for the next question.
#[derive(Default)]
pub struct InactiveParameters {
    linked: Vec<(KernelModule, Rc<UniformReads>)>,
}

/// A node at the values that are asked about.
#[derive(Clone, Copy)]
pub struct NodeInUse<'a> {
    /// The node.
    pub instance: &'a NodeInstance,
    /// Of each input port, whether something is wired to it.
    pub wired: &'a [bool],
    /// The size of its images.
    pub size: Size,
}

/// What a linked module depends on.
#[derive(Clone, PartialEq)]
struct KernelModule {
    shader: Shared<Shader>,
    promises: Vec<&'static str>,
    constants: Vec<(&'static str, f64)>,
}

/// What a node records at its values.
struct Recorded {
    outputs: Vec<InputValue>,
    recording: Recording,
}

/// What a node records at its present values, and the bytes of each uniform that this depends on.
struct Present {
    recorded: Recorded,
    masks: Vec<Vec<bool>>,
}

/// Linked modules that are kept.
const MAX_LINKED: usize = 64;

impl InactiveParameters {
    /// For each parameter of a node, why it does nothing; `None` for those that do something. Nothing is known, and
    /// every parameter counts as active, of a node that refuses its present values or that its fallbacks replace.
    pub fn of(&mut self, node: NodeInUse<'_>) -> Vec<Option<Inactive>> {
        let params = node.instance.kind().params();
        let Some(present) = self.present(node) else { return vec![None; params.len()] };
        let mut found = Vec::new();
        for index in 0..params.len() {
            found.push(match is_active(node, &present, index) {
                Ok(true) => None,
                Ok(false) => Some(Inactive::NoEffect),
                Err(why) => Some(Inactive::Refused(why)),
            });
        }
        found
    }

    /// What decides that an inactive parameter does nothing, if it is one thing: the first other parameter, or else the
    /// first optional input, with which it has an effect.
    pub fn decisive(&mut self, node: NodeInUse<'_>, index: usize) -> Option<Decisive> {
        let params = node.instance.kind().params();
        // Choices decide more often than numbers.
        let is_number = |other: &usize| !matches!(params[*other].ty, Type::Choice(_) | Type::Bool);
        let mut others: Vec<usize> = (0..params.len()).filter(|other| *other != index).collect();
        others.sort_by_key(is_number);
        for other in others {
            let mut values = Vec::new();
            for value in candidates(&params[other], &node.instance.values()[other]) {
                let mut changed = node.instance.clone();
                changed.set(other, value.clone());
                if self.has_effect(NodeInUse { instance: &changed, ..node }, index) {
                    values.push(value);
                }
            }
            if !values.is_empty() {
                return Some(Decisive::Parameter(other, values));
            }
        }
        let inputs = node.instance.kind().inputs();
        let mut optional = (0..inputs.len()).filter(|input| inputs[*input].optional);
        let input = optional.find(|input| {
            let mut wired = node.wired.to_vec();
            wired[*input] ^= true;
            self.has_effect(NodeInUse { wired: &wired, ..node }, index)
        });
        input.map(Decisive::Input)
    }

    fn has_effect(&mut self, node: NodeInUse<'_>, index: usize) -> bool {
        self.present(node).is_some_and(|present| is_active(node, &present, index) == Ok(true))
    }

    fn present(&mut self, node: NodeInUse<'_>) -> Option<Present> {
        let mut recorded = recorded(node)?;
        let masks = recorded.recording.passes.iter().flat_map(|pass| self.masks(pass)).collect::<Vec<_>>();
        recorded.forget_unread(&masks);
        Some(Present { recorded, masks })
    }

    /// Of each kernel of a pass, the bytes of its uniform that it reads. A draw has several entry points, and may read
    /// all of them.
    fn masks(&mut self, pass: &Pass) -> Vec<Vec<bool>> {
        let mut masks = Vec::new();
        for kernel in &pass.kernels {
            let reads = if kernel.uniform.is_empty() || pass.drawing().is_some() { None } else { self.reads(kernel) };
            masks.push(match reads {
                Some(reads) => reads.mask(&kernel.function, &kernel.uniform),
                None => vec![true; kernel.uniform.len()],
            });
        }
        masks
    }

    fn reads(&mut self, kernel: &KernelCall) -> Option<Rc<UniformReads>> {
        let (shader, promises) = (kernel.shader.clone(), kernel.promises.clone());
        let module = KernelModule { shader, promises, constants: kernel.constants.clone() };
        if let Some((_, reads)) = self.linked.iter().find(|(known, _)| *known == module) {
            return Some(reads.clone());
        }
        // The plan reports the errors of a shader.
        let reads = Rc::new(UniformReads::new(&kernel.shader, &kernel.promises, &kernel.constants).ok()?);
        if self.linked.len() == MAX_LINKED {
            self.linked.remove(0);
        }
        self.linked.push((module, reads.clone()));
        Some(reads)
    }
}

/// Whether another value of a parameter changes what the node computes.
///
/// # Errors
/// Why the node refuses every other value.
fn is_active(node: NodeInUse<'_>, present: &Present, index: usize) -> Result<bool, String> {
    // Any parameter may have a part in a table, and tables take too long to compute for a question.
    let has_tables = !present.recorded.recording.computed.is_empty();
    let candidates = candidates(&node.instance.kind().params()[index], &node.instance.values()[index]);
    let mut refusals = Vec::new();
    for value in &candidates {
        let mut changed = node.instance.clone();
        changed.set(index, value.clone());
        if let Err(why) = changed.verify() {
            refusals.push(why);
            continue;
        }
        let changed = NodeInUse { instance: &changed, ..node };
        // At a value at which its fallbacks replace the node, the parameter has an effect.
        let Some(mut other) = recorded(changed) else { return Ok(true) };
        other.forget_unread(&present.masks);
        if !other.is_same(&present.recorded) {
            return Ok(true);
        }
    }
    match refusals.into_iter().next_back() {
        // Texts and files have no candidates.
        _ if candidates.is_empty() => Ok(true),
        Some(why) if candidates.iter().all(|value| refuses(node, index, value)) => Err(why),
        _ => Ok(has_tables),
    }
}

fn refuses(node: NodeInUse<'_>, index: usize, value: &Value) -> bool {
    let mut changed = node.instance.clone();
    changed.set(index, value.clone());
    changed.verify().is_err()
}

/// Other values of a parameter: all choices, or the ends and the middle of its domain, its default, and one next to the
/// present value, which a node is least likely to refuse.
fn candidates(param: &Param, present: &Value) -> Vec<Value> {
    let values = match param.ty {
        Type::Choice(choices) => choices.iter().map(|choice| Value::Choice(choice.name)).collect(),
        Type::Text | Type::File => Vec::new(),
        _ => {
            let ends = [param.lowest(), param.middle(), param.highest(), next_to(param, present)];
            ends.into_iter().flatten().chain([param.default.clone()]).collect::<Vec<_>>()
        }
    };
    values.into_iter().filter(|value| value != present).collect()
}

/// A value near the present one, within the domain.
fn next_to(param: &Param, present: &Value) -> Option<Value> {
    let (low, high) = param.domain?;
    let near = |number: f64| if number + 0.01 <= high { number + 0.01 } else { (number - 0.01).max(low) };
    match present {
        Value::Float(number) => Some(Value::Float(near(*number))),
        Value::Vector(numbers, count) => {
            Some(Value::Vector(std::array::from_fn(|at| if at < *count { near(numbers[at]) } else { 0.0 }), *count))
        }
        Value::Int(number) => Some(Value::Int(if (*number as f64) < high { number + 1 } else { number - 1 })),
        _ => None,
    }
}

/// What a node records; `None` if it refuses its values, or its fallbacks replace it.
fn recorded(node: NodeInUse<'_>) -> Option<Recorded> {
    let kind = node.instance.kind();
    let ports = kind.inputs().iter().zip(node.wired);
    let absent = ports.clone().filter(|(_, wired)| !**wired).map(|(port, _)| port.name.clone()).collect();
    let values = InputValues::new(Vec::new(), absent);
    let is_replaced = kind.outputs().iter().all(|output| node.instance.identity_of(&output.name, &values));
    if is_replaced || node.instance.verify().is_err() {
        return None;
    }
    let mut recording = Recording { most_computed: Some(0), ..Recording::default() };
    let mut inputs = Vec::new();
    for (port, wired) in ports {
        inputs.push(match wired {
            true => arrival(port.ty, &port.name, node.size, &mut recording),
            false => InputValue::Absent,
        });
    }
    let context = RecorderContext {
        node: "node",
        kind: kind.signature(),
        parameters: node.instance.uniform_values(),
        dynamic: &[],
        inputs: &inputs,
        format: None,
        frame_size: node.size,
        caps: &Caps::default(),
        exact: false,
        used_outputs: &vec![OutputUse::Whole; kind.outputs().len()],
        colors: NodeColors::default(),
    };
    let mut recorder = Recorder::new(context, &mut recording);
    node.instance.record(&mut recorder);
    // The plan reports the errors of shaders.
    let (outputs, errors) = recorder.finish();
    errors.is_empty().then_some(Recorded { outputs, recording })
}

impl Recorded {
    /// Sets the bytes of uniforms to zero that no kernel reads.
    fn forget_unread(&mut self, masks: &[Vec<bool>]) {
        let kernels = self.recording.passes.iter_mut().flat_map(|pass| &mut pass.kernels);
        for (kernel, mask) in kernels.zip(masks) {
            for (byte, is_read) in kernel.uniform.iter_mut().zip(mask) {
                *byte = if *is_read { *byte } else { 0 };
            }
        }
    }

    /// Whether both compute the same, tables aside.
    fn is_same(&self, other: &Self) -> bool {
        let (a, b) = (&self.recording, &other.recording);
        self.outputs == other.outputs && a.passes == b.passes && a.images == b.images && a.buffers == b.buffers
    }
}
