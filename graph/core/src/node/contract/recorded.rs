//! One recording of a kind, and whether the passes are fit for a device.

use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use super::limits;
use super::names::{pascal, snake, stem};
use super::parts;
use super::violations::Violations;
use crate::node::{
    Arg, BlockId, BufferLife, ImageColor, Input, InputValue, InputValues, KernelCall, NodeColors, NodeInstance,
    NodeKind, Origin, OutputUse, Pass, PortType, Recorder, RecorderContext, Recording, Resource, VirtualBuffer,
    VirtualImage,
};
use afterimage_base::caps::Caps;
use afterimage_base::color::{Chromaticities, Colorimetry};
use afterimage_base::image::{ColorState, ImageDesc, Signedness, Size};
use afterimage_base::value::{Param, Type, Value};
use afterimage_wgsl::{Shader, ShaderError};

/// One way of using a kind.
pub(super) struct Use<'a> {
    pub(super) node: &'a NodeInstance,
    pub(super) dynamic: &'a [usize],
    pub(super) size: Size,
    pub(super) around: Around,
    pub(super) is_exact: bool,
    pub(super) is_default: bool,
}

/// What arrives at the inputs.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Around {
    /// Something at each, as large as the frame and of unknown primaries.
    Everything,
    /// Nothing at the optional ones.
    Required,
    /// Something at each but this optional one.
    AllBut(usize),
    /// Something at each, and all images but the first are half as large.
    SmallOthers,
    /// Something at each, with the primaries of Rec.2020.
    WideColors,
}

impl Around {
    fn wires(self, index: usize, port: &Input) -> bool {
        let is_left_out = self == Self::Required || self == Self::AllBut(index);
        !(port.optional && is_left_out)
    }
}

/// What one recording came to.
#[derive(PartialEq)]
pub(super) struct Recorded {
    pub(super) inputs: Vec<InputValue>,
    pub(super) outputs: Vec<InputValue>,
    pub(super) recording: Recording,
    /// How many of the images arrived at the inputs: the first ones.
    pub(super) given: usize,
}

/// Values of the parameters: the defaults, but for one.
pub(super) struct Variant {
    /// The parameter that is at an extreme; `None` for the defaults.
    pub(super) param: Option<usize>,
    pub(super) values: Vec<Value>,
}

/// A parameter that needs no new plan changes uniforms only: the host may set it while a plan runs.
pub(super) fn live(kind: &NodeKind, violations: &mut Violations) {
    let defaults = defaults(kind);
    let all: Vec<usize> = (0..kind.params().len()).filter(|index| !kind.params()[*index].replan).collect();
    if all.is_empty() {
        return;
    }
    for around in [Around::Everything, Around::Required] {
        let without_uniforms = |values: Vec<Value>, violations: &mut Violations| {
            let node = NodeInstance::new(kind.clone(), values);
            let (dynamic, size) = (all.as_slice(), Size::new(64, 36));
            let way = Use { node: &node, dynamic, size, around, is_exact: false, is_default: false };
            let recorded = node.verify().is_ok().then(|| record(&way, Tables::new(), violations)).flatten();
            recorded.map(Recorded::without_uniforms)
        };
        let Some(first) = without_uniforms(defaults.clone(), violations) else { return };
        for (index, param) in all.iter().map(|index| (*index, &kind.params()[*index])) {
            let probes = [param.lowest(), param.highest(), param.middle(), param.neutral.clone()];
            for value in probes.into_iter().flatten() {
                let mut values = defaults.clone();
                values[index] = value.clone();
                let other = without_uniforms(values, violations);
                violations.require(other.is_none_or(|other| other == first), || {
                    format!("`{}` at {value} changes more than uniforms: declare `replans()`", param.name)
                });
            }
        }
    }
}

/// Values that the kind refuses, such as a missing file, and those at which a fallback replaces it are not recorded.
pub(super) fn records(way: &Use<'_>) -> bool {
    let inputs = way.node.kind().inputs();
    let absent = inputs.iter().enumerate().filter(|(index, port)| !way.around.wires(*index, port));
    let inputs = InputValues::new(Vec::new(), absent.map(|(_, port)| port.name.clone()).collect());
    let is_replaced = way.node.kind().outputs().iter().all(|port| way.node.identity_of(&port.name, &inputs));
    way.node.verify().is_ok() && !is_replaced
}

/// Tables that a recording has computed.
pub(super) type Tables = BTreeMap<String, Arc<[u8]>>;

pub(super) fn one(
    way: &Use<'_>,
    computed: &mut Tables,
    violations: &mut Violations,
    seen: &mut dyn FnMut(&Recording),
) -> Option<Recorded> {
    let is_first = computed.is_empty();
    let first = record(way, std::mem::take(computed), violations)?;
    computed.clone_from(&first.recording.computed);
    // A recording may bake a table, which no size changes, so it is made twice only at the defaults and for one size.
    let again = (way.is_default && is_first).then(|| record(way, Tables::new(), violations)).flatten();
    violations.require(again.is_none_or(|again| first == again), || "two recordings at equal values differ".into());
    for (port, given) in way.node.kind().outputs().iter().zip(&first.outputs) {
        let fits = matches!(
            (port.ty, given),
            (PortType::Image | PortType::Volume, InputValue::Image(_) | InputValue::Zero)
                | (PortType::Multisampled, InputValue::Image(_))
                | (PortType::Pyramid, InputValue::Pyramid(_) | InputValue::Zero)
                | (PortType::Table | PortType::Value, InputValue::Buffer(_))
        );
        violations
            .require(fits, || format!("the output `{}` is used and not given as a {}", port.name, port.ty.name()));
    }
    limits::look(&first.recording, way.size, violations);
    parts::look(&first.recording, violations);
    for pass in &first.recording.passes {
        writes_its_own(pass, &first, violations);
        pixels(pass, &first.recording, violations);
        pass.shaders().for_each(|shader| file_name(shader, violations));
        pass.kernels.iter().for_each(|kernel| blocks(kernel, way.node.kind(), violations));
        pass.kernels.iter().for_each(|kernel| samples(kernel, &first.recording, violations));
    }
    seen(&first.recording);
    Some(first)
}

impl Recorded {
    fn without_uniforms(mut self) -> Self {
        let kernels = self.recording.passes.iter_mut().flat_map(|pass| &mut pass.kernels);
        kernels.for_each(|kernel| kernel.uniform.fill(0));
        self
    }
}

pub(super) fn defaults(kind: &NodeKind) -> Vec<Value> {
    kind.params().iter().map(|param| param.default.clone()).collect()
}

/// The defaults, and every parameter at its extremes, one at a time.
pub(super) fn variants(kind: &NodeKind) -> Vec<Variant> {
    let defaults = defaults(kind);
    let mut all = vec![Variant { param: None, values: defaults.clone() }];
    for (index, param) in kind.params().iter().enumerate() {
        for value in extremes(param).into_iter().filter(|value| *value != param.default) {
            let mut values = defaults.clone();
            values[index] = value;
            all.push(Variant { param: Some(index), values });
        }
    }
    all
}

pub(super) fn extremes(param: &Param) -> Vec<Value> {
    match param.ty {
        Type::Choice(choices) => choices.iter().map(|choice| Value::Choice(choice.name)).collect(),
        _ => param.lowest().into_iter().chain(param.highest()).collect(),
    }
}

pub(super) fn record(way: &Use<'_>, computed: Tables, violations: &mut Violations) -> Option<Recorded> {
    let attempt = catch_unwind(AssertUnwindSafe(|| recorded(way, computed)));
    match attempt {
        Ok(Ok(recorded)) => return Some(recorded),
        Ok(Err(errors)) => errors.iter().for_each(|error| violations.add(format!("recording fails: {error}"))),
        Err(panic) => violations.add(format!("recording fails: {}", reason(&*panic))),
    }
    None
}

fn reason(panic: &(dyn std::any::Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str).or_else(|| panic.downcast_ref::<&str>().copied());
    text.unwrap_or("it panics").to_owned()
}

fn recorded(way: &Use<'_>, computed: Tables) -> Result<Recorded, Vec<ShaderError>> {
    let kind = way.node.kind();
    let mut recording = Recording { computed, ..Recording::default() };
    let inputs: Vec<InputValue> = kind
        .inputs()
        .iter()
        .enumerate()
        .map(|(index, port)| {
            let is_first = kind.inputs()[..index].iter().all(|before| before.ty != PortType::Image);
            let size = if way.around == Around::SmallOthers && !is_first { way.size.half() } else { way.size };
            match way.around.wires(index, port) {
                true => arrival(port.ty, &port.name, size, &mut recording),
                false => InputValue::Absent,
            }
        })
        .collect();
    let wide = |port: &Input| {
        let state = port.states.first().copied().unwrap_or(ColorState::Scene);
        Some(ImageColor { state, colorimetry: Colorimetry::linear(Chromaticities::REC2020) })
    };
    let colors: Vec<Option<ImageColor>> = match way.around {
        Around::WideColors => kind.inputs().iter().map(wide).collect(),
        _ => Vec::new(),
    };
    let given = recording.images.len();
    let used_outputs = vec![OutputUse::Whole; kind.outputs().len()];
    let caps = Caps::default();
    let context = RecorderContext {
        node: "node",
        kind: kind.signature(),
        parameters: way.node.uniform_values(),
        dynamic: way.dynamic,
        inputs: &inputs,
        format: None,
        frame_size: way.size,
        caps: &caps,
        exact: way.is_exact,
        used_outputs: &used_outputs,
        colors: NodeColors { inputs: &colors, outputs: &[] },
    };
    let mut recorder = Recorder::new(context, &mut recording);
    way.node.record(&mut recorder);
    let (outputs, errors) = recorder.finish();
    if errors.is_empty() { Ok(Recorded { inputs, outputs, recording, given }) } else { Err(errors) }
}

/// Something plausible at an input.
pub(in crate::node) fn arrival(ty: PortType, name: &str, size: Size, recording: &mut Recording) -> InputValue {
    let mut image = |desc: ImageDesc| {
        let origin = Origin::Input(name.to_owned());
        recording.add_image(VirtualImage {
            label: name.to_owned(),
            desc,
            origin,
            finite: false,
            signedness: Signedness::Unsigned,
        })
    };
    match ty {
        PortType::Image => InputValue::Image(image(ImageDesc::new(size))),
        PortType::Multisampled => InputValue::Image(image(ImageDesc::new(size).multisampled(4))),
        PortType::Volume => InputValue::Image(image(ImageDesc::volume(Size::volume(16, 9, 8)))),
        PortType::Pyramid => {
            let levels = size.levels().clamp(1, 4);
            let sizes = std::iter::successors(Some(size.half()), |size| Some(size.half()));
            InputValue::Pyramid(sizes.take(levels as usize).map(|size| image(ImageDesc::new(size))).collect())
        }
        PortType::Table | PortType::Value => {
            let bytes = if ty == PortType::Value { 16 } else { 64 << 10 };
            let buffer = VirtualBuffer { label: name.to_owned(), bytes, life: BufferLife::Frame };
            InputValue::Buffer(recording.add_buffer(buffer))
        }
        PortType::Block => InputValue::Block(BlockId(0)),
    }
}

/// The structs of host blocks have the members that the kind's ports declare.
fn blocks(kernel: &KernelCall, kind: &NodeKind, violations: &mut Violations) {
    let Ok(reflection) = kernel.shader.reflect() else { return };
    for arg in kernel.args.iter().filter(|arg| matches!(arg.value, Arg::Block(_))) {
        let layout = reflection.struct_of(&kernel.function, &arg.name).and_then(|ty| reflection.layout(ty));
        let declared = kind.input(&arg.name).and_then(|port| port.block);
        let fits = layout.zip(declared).is_some_and(|(layout, declared)| declared.fits(layout));
        violations.require(fits, || {
            format!("the struct of `{}` in `{}` has not the members of its host block", arg.name, kernel.function)
        });
    }
}

/// Samples are sanitized where the library reads them, and nowhere else.
fn samples(kernel: &KernelCall, recording: &Recording, violations: &mut Violations) {
    let has_samples = kernel.textures().any(|image| recording.image(image).desc.samples > 1);
    let is_direct = kernel.shader.reads_textures_itself(&kernel.function);
    violations.require(!(has_samples && is_direct), || {
        format!("`{}` reads samples directly: `texel_sample` of the library sanitizes them", kernel.function)
    });
}

/// A pixel is read at the place of the result, so its image has the size of the result.
fn pixels(pass: &Pass, recording: &Recording, violations: &mut Violations) {
    for misfit in recording.misfit_pixels(pass) {
        violations.add(format!(
            "`{}` takes the pixel `{}` of `{}`, which has another size than its result: take a texture, and read it \
             with `tap`",
            misfit.kernel.function,
            misfit.argument,
            recording.image(misfit.image).label
        ));
    }
}

/// A pass must not write to what it was given, nor to what is constant.
fn writes_its_own(pass: &Pass, recorded: &Recorded, violations: &mut Violations) {
    for resource in pass.writes() {
        if let Resource::Image(image) = resource {
            let is_foreign = (image.0 as usize) < recorded.given;
            let is_constant = matches!(recorded.recording.image(image).origin, Origin::Constant(_));
            violations.require(!is_foreign && !is_constant, || {
                format!("the pass `{}` writes an image that is not its own", pass.label)
            });
        }
    }
}

/// The file is named after a kind.
fn file_name(shader: &Shader, violations: &mut Violations) {
    let file = shader.file();
    let stem = stem(file);
    violations.require(snake(&pascal(stem)) == stem, || {
        format!("the file `{file}` is not called after a kind, in snake_case")
    });
}
