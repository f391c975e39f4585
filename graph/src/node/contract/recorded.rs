//! What a kind records, and whether the passes are fit for a device.

use std::collections::BTreeSet;
use std::panic::{AssertUnwindSafe, catch_unwind};

use super::Complaints;
use super::names::{belongs, items, pascal, snake, stem};
use crate::image::{Format, ImageDesc, Size};
use crate::node::{
    Arg, Arrival, Arrivals, BufferLife, Cells, CellsReader, ImageId, NodeKind, Origin, Pass, PortType, Recorder,
    RecorderContext, Recording, Resource, Rows, VirtualBuffer, VirtualImage, Work,
};
use crate::plan::Caps;
use crate::plan::passes::copy_step;
use crate::shader::{
    Beside, CELLS_LANES, Composed, ShaderFeatures, ROW_LANES, SampleMode, Shader, ShaderError, SlotKind, can_tell,
    compose_beside, compose_pass,
};
use crate::value::{Param, Type, Value};

/// One way of using a kind.
struct Use<'a> {
    values: &'a [Value],
    size: Size,
    is_fully_wired: bool,
    is_exact: bool,
    is_default: bool,
}

/// What one recording came to.
#[derive(PartialEq)]
struct Recorded {
    outputs: Vec<Arrival>,
    recording: Recording,
    given: usize,
}

pub(super) fn look(kind: NodeKind, complaints: &mut Complaints) {
    let mut known = Known::default();
    for (index, values) in variants(kind).into_iter().enumerate() {
        // The defaults are used in every way; each extreme with everything wired, which is where it can do most.
        let ways: &[(bool, bool)] =
            if index == 0 { &[(true, false), (false, false), (true, true)] } else { &[(true, false)] };
        for size in [Size::new(64, 36), Size::new(1, 1)] {
            for (is_fully_wired, is_exact) in ways.iter().copied() {
                let way = Use { values: &values, size, is_fully_wired, is_exact, is_default: index == 0 };
                if is_recorded(kind, &way) {
                    one(kind, &way, &mut known, complaints);
                }
            }
        }
    }
}

/// What has been looked at before, so that it is looked at once.
#[derive(Default)]
struct Known {
    shapes: BTreeSet<String>,
    modules: BTreeSet<String>,
}

/// Values that the kind refuses, such as a file that is not there, and those at which something stands in for it never reach a recorder.
fn is_recorded(kind: NodeKind, way: &Use<'_>) -> bool {
    let absent = kind.inputs().iter().filter(|port| port.optional && !way.is_fully_wired).map(|port| port.name);
    let arrivals = Arrivals::new(Vec::new(), absent.collect());
    kind.verify(way.values).is_ok() && kind.identity(way.values, &arrivals).is_none()
}

fn one(kind: NodeKind, way: &Use<'_>, known: &mut Known, complaints: &mut Complaints) {
    let Some(first) = record(kind, way, complaints) else { return };
    // A recording may bake a table, so it is made twice only at the defaults.
    let again = way.is_default.then(|| record(kind, way, complaints)).flatten();
    complaints.require(again.is_none_or(|again| first == again), || "two recordings at equal values differ".into());
    for (port, given) in kind.outputs().iter().zip(&first.outputs) {
        let fits = matches!(
            (port.ty, given),
            (PortType::Image | PortType::Volume, Arrival::Image(_) | Arrival::Zero)
                | (PortType::Pyramid, Arrival::Pyramid(_) | Arrival::Zero)
                | (PortType::Table | PortType::Value, Arrival::Buffer(_))
        );
        complaints
            .require(fits, || format!("the output `{}` is wanted and not given as a {}", port.name, port.ty.name()));
    }
    for pass in &first.recording.passes {
        writes_its_own(pass, &first, complaints);
        if known.shapes.insert(shape(pass, &first.recording)) {
            module(pass, &first.recording, &mut known.modules, complaints);
        }
    }
}

/// Every parameter at its extremes, one at a time, the defaults first.
fn variants(kind: NodeKind) -> Vec<Vec<Value>> {
    let defaults: Vec<Value> = kind.params().iter().map(|param| param.default.clone()).collect();
    let mut all = vec![defaults.clone()];
    for (index, param) in kind.params().iter().enumerate() {
        for value in extremes(param).into_iter().filter(|value| *value != param.default) {
            let mut values = defaults.clone();
            values[index] = value;
            all.push(values);
        }
    }
    all
}

fn extremes(param: &Param) -> Vec<Value> {
    let (low, high) = param.domain.unwrap_or_default();
    match (param.ty, param.domain) {
        (Type::Bool, _) => vec![Value::Bool(false), Value::Bool(true)],
        (Type::Choice(choices), _) => choices.iter().map(|choice| Value::Choice(choice.name)).collect(),
        (Type::Int, Some(_)) => vec![Value::Int(low as i64), Value::Int(high as i64)],
        (Type::Float, Some(_)) => vec![Value::Float(low), Value::Float(high)],
        (Type::Vector(n), Some(_)) => {
            [low, high].map(|x| Value::Vector(std::array::from_fn(|i| if i < n { x } else { 0.0 }), n)).into()
        }
        _ => Vec::new(),
    }
}

fn record(kind: NodeKind, way: &Use<'_>, complaints: &mut Complaints) -> Option<Recorded> {
    let attempt = catch_unwind(AssertUnwindSafe(|| recorded(kind, way)));
    attempt.map_err(|panic| complaints.add(format!("recording fails: {}", reason(&*panic)))).ok()
}

fn reason(panic: &(dyn std::any::Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str).or_else(|| panic.downcast_ref::<&str>().copied());
    text.unwrap_or("it panics").to_owned()
}

fn recorded(kind: NodeKind, way: &Use<'_>) -> Recorded {
    let mut recording = Recording::default();
    let arrivals: Vec<Arrival> = kind
        .inputs()
        .iter()
        .map(|port| match port.optional && !way.is_fully_wired {
            true => Arrival::Absent,
            false => arrival(port.ty, port.name, way.size, &mut recording),
        })
        .collect();
    let given = recording.images.len();
    let wanted = vec![true; kind.outputs().len()];
    let caps = Caps::default();
    let context = RecorderContext {
        node: "node",
        kind,
        values: way.values,
        arrivals: &arrivals,
        format: None,
        frame_size: way.size,
        caps: &caps,
        exact: way.is_exact,
        wanted: &wanted,
    };
    let mut recorder = Recorder::new(context, &mut recording);
    kind.record(way.values, &mut recorder);
    let outputs = recorder.finish();
    Recorded { outputs, recording, given }
}

/// Something plausible at an input.
fn arrival(ty: PortType, name: &str, size: Size, recording: &mut Recording) -> Arrival {
    let mut image = |desc: ImageDesc| {
        let origin = Origin::Input(name.to_owned());
        recording.add_image(VirtualImage { label: name.to_owned(), desc, origin, finite: false, signed: false })
    };
    match ty {
        PortType::Image => Arrival::Image(image(ImageDesc::new(size))),
        PortType::Volume => Arrival::Image(image(ImageDesc::volume(Size::volume(16, 9, 8)))),
        PortType::Pyramid => {
            let levels = size.levels().clamp(1, 4);
            let sizes = std::iter::successors(Some(size.half()), |size| Some(size.half()));
            Arrival::Pyramid(sizes.take(levels as usize).map(|size| image(ImageDesc::new(size))).collect())
        }
        PortType::Table | PortType::Value => {
            let bytes = if ty == PortType::Value { 16 } else { 64 << 10 };
            let buffer = VirtualBuffer { label: name.to_owned(), bytes, life: BufferLife::Frame };
            Arrival::Buffer(recording.add_buffer(buffer))
        }
    }
}

/// A pass must not write to what it was given, nor to what is constant.
fn writes_its_own(pass: &Pass, recorded: &Recorded, complaints: &mut Complaints) {
    for resource in pass.writes() {
        if let Resource::Image(image) = resource {
            let is_foreign = (image.0 as usize) < recorded.given;
            let is_constant = matches!(recorded.recording.image(image).origin, Origin::Constant(_));
            complaints.require(!is_foreign && !is_constant, || {
                format!("the pass `{}` writes an image that is not its own", pass.label)
            });
        }
    }
}

/// All of a pass that its module depends on.
fn shape(pass: &Pass, recording: &Recording) -> String {
    let formats: Vec<Option<Format>> = pass
        .writes()
        .into_iter()
        .map(|resource| match resource {
            Resource::Image(image) => Some(recording.image(image).desc.format),
            Resource::Buffer(_) => None,
        })
        .collect();
    match &pass.work {
        Work::Steps { steps, .. } => {
            let calls: Vec<_> = steps.iter().map(|step| (step.shader, step.function, &step.args)).collect();
            format!("{calls:?} {formats:?}")
        }
        Work::Tiled(tiling) => format!("{tiling:?} {formats:?}"),
        Work::Rows(rows) => format!("{rows:?} {formats:?}"),
        Work::Cells(cells) => format!("{cells:?} {formats:?}"),
        Work::Entry(call) => format!("{:?} {} {:?} {formats:?}", call.shader, call.entry, call.bindings),
    }
}

/// What every device understands.
const PLAIN: ShaderFeatures = ShaderFeatures { half: false, subgroups: false };
/// What few do not.
const RICH: ShaderFeatures = ShaderFeatures { half: true, subgroups: true };
/// Every way in which a module may be composed.
const WAYS: [(SampleMode, ShaderFeatures); 5] = [
    (SampleMode::Plain, PLAIN),
    (SampleMode::ByHand, PLAIN),
    (SampleMode::Guarded, PLAIN),
    (SampleMode::GuardedSigned, PLAIN),
    (SampleMode::Plain, RICH),
];

/// The pass as a module, for every way in which its textures may be read and its numbers may be made.
fn module(pass: &Pass, recording: &Recording, modules: &mut BTreeSet<String>, complaints: &mut Complaints) {
    let desc_of = |image: ImageId| recording.image(image).desc;
    for (reading, features) in WAYS {
        let composed = compose_pass(pass, &desc_of, &|_| reading, features);
        match composed {
            Ok(composed) if modules.insert(composed.source.clone()) => {
                let valid = composed.validate().and_then(|_| beside_itself(pass, &composed, features));
                if let Err(error) = valid {
                    complaints.add(format!("the pass `{}` is no valid module: {error}", pass.label));
                }
            }
            Ok(_) => {}
            Err(error) => complaints.add(format!("the pass `{}` is no module: {error}", pass.label)),
        }
    }
    by_rows(pass).into_iter().chain(by_cells(pass)).for_each(|pass| module(&pass, recording, modules, complaints));
    pass.shaders().into_iter().for_each(|shader| item_names(shader, complaints));
}

/// Whether the module can stand beside another like it, if the planner may ever want that: names that the framework does not tell apart clash.
fn beside_itself(pass: &Pass, composed: &Composed, features: ShaderFeatures) -> Result<(), ShaderError> {
    let knows_time = composed.slots.iter().any(|slot| slot.kind == SlotKind::Frame);
    let is_told = composed.told.iter().all(can_tell);
    if !composed.unchecked || knows_time || !is_told || features.subgroups || matches!(pass.work, Work::Tiled(_)) {
        return Ok(());
    }
    let twice = [(); 2].map(|()| Beside { composed, constants: pass.constants() });
    [false, true].iter().try_for_each(|by_turns| compose_beside(&twice, *by_turns).validate().map(|_| ()))
}

/// The pass in its form by rows, if it has one.
fn by_rows(pass: &Pass) -> Option<Pass> {
    let Work::Steps { steps, result } = &pass.work else { return None };
    let [step] = steps.as_slice() else { return None };
    let source = step.args.iter().find_map(|arg| match arg {
        Arg::Texture(image) => Some(*image),
        _ => None,
    })?;
    let source = vec![copy_step(&step.node, source)];
    let work = Work::Rows(Rows { source, by: step.by_rows?, result: *result, rows: 1, lanes: ROW_LANES });
    Some(Pass { work, ..pass.clone() })
}

/// The pass in its form by cells, twice, so that names which the framework does not tell apart clash.
fn by_cells(pass: &Pass) -> Option<Pass> {
    let Work::Entry(call) = &pass.work else { return None };
    let by = call.by_cells?;
    let source = call.bindings.iter().find_map(|binding| match binding.resource {
        Resource::Image(image) if binding.name == by.source => Some(image),
        _ => None,
    })?;
    let reader = CellsReader { node: pass.nodes[0].clone(), call: call.clone(), by };
    let readers = vec![reader.clone(), reader];
    let lanes = [CELLS_LANES, 1];
    let work = Work::Cells(Cells { source, readers, coarsest: by.cells, finest: by.cells, lanes, step: by.step });
    Some(Pass { work, ..pass.clone() })
}

/// The items of a file begin with its name, so that files can stand side by side in one module; and the file is called after a kind.
fn item_names(shader: &Shader, complaints: &mut Complaints) {
    let stem = stem(shader.file());
    let kind = pascal(stem);
    let file = shader.file();
    complaints.require(snake(&kind) == stem, || format!("the file `{file}` is not called after a kind, in snake_case"));
    for item in items(shader.source()) {
        complaints.require(belongs(&item, stem), || {
            format!("`{item}` in `{file}` does not begin with `{stem}`, `{kind}` or `{}`", stem.to_uppercase())
        });
    }
}
