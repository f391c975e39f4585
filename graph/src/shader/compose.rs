//! Puts modules together into one that a device can run: constants that choose how textures are read, the modules with their
//! imports, bindings, and an entry point around a chain of kernel functions.

use std::fmt::Write as _;

use naga::BuiltIn;

use super::cells::compose_cells;
use super::import::{SourceMap, Text};
use super::reflect::GlobalKind;
use super::rows::compose_rows;
use super::tiles::{TILED, compose_tiling, is_tiled};
use super::{ShaderFeatures, Told, lints};
use crate::image::{Format, ImageDesc, Size};
use crate::node::{Arg, BufferId, EntryCall, ImageId, Pass, Resource, Step, Work};

/// How a module's textures are read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum SampleMode {
    /// Finite numbers, filtered by the device.
    #[default]
    Plain,
    /// Finite numbers that the device cannot filter.
    ByHand,
    /// Colours from outside: guarded, then filtered by hand.
    Guarded,
    /// Signed data from outside: guarded, then filtered by hand.
    GuardedSigned,
}

impl SampleMode {
    pub(super) fn settings(self) -> String {
        let guard = match self {
            Self::Plain | Self::ByHand => 0,
            Self::Guarded => 1,
            Self::GuardedSigned => 2,
        };
        let by_hand = self != Self::Plain;
        format!("const TEXEL_GUARD: u32 = {guard}u;\nconst TAP_BY_HAND: bool = {by_hand};")
    }

    fn guard_call(self) -> &'static str {
        match self {
            Self::Plain | Self::ByHand => "",
            Self::Guarded => "guard",
            Self::GuardedSigned => "guard_signed",
        }
    }
}

/// A mistake in a shader, at the author's file and line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ShaderError {
    /// The file.
    pub file: String,
    /// The line, from 1.
    pub line: u32,
    /// The column, from 1; 0 if unknown.
    pub column: u32,
    /// What is wrong.
    pub message: String,
}

impl ShaderError {
    pub(super) fn at(file: &str, line: u32, message: impl Into<String>) -> Self {
        Self { file: file.into(), line, column: 0, message: message.into() }
    }
}

impl std::fmt::Display for ShaderError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}:{}:{}: {}", self.file, self.line, self.column.max(1), self.message)
    }
}

impl std::error::Error for ShaderError {}

/// What a binding slot of a composed module holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Slot {
    /// `@binding`; all are in group 0.
    pub binding: u32,
    /// What it holds.
    pub kind: SlotKind,
}

/// What the entry points of kernels are told that number their invocations.
pub(super) fn told_of_lanes() -> Vec<Told> {
    [BuiltIn::WorkGroupId, BuiltIn::LocalInvocationIndex].map(Told::One).into()
}

/// The first binding that none of the slots has.
pub(super) fn free(slots: &[Slot]) -> u32 {
    slots.iter().map(|slot| slot.binding + 1).max().unwrap_or(0)
}

/// The kinds of binding slots.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SlotKind {
    /// The uniform with the frame's time.
    Frame,
    /// The pass's own uniform.
    Params,
    /// A uniform with the size of the result in texels: two floats. To ask the texture for it takes longer.
    Extent,
    /// The uniforms of all passes that run in the same dispatch, one after the other: each at a multiple of [`UNIFORM_ALIGNMENT`](super::UNIFORM_ALIGNMENT), its
    /// params, if it has any, and then the size of its result and, from byte 16 on, its workgroups: three whole numbers.
    Uniforms,
    /// The linear, clamping sampler.
    Sampler,
    /// A sampled image.
    Texture(ImageId),
    /// A storage image that is written.
    Storage(ImageId),
    /// A storage buffer, and whether it is written.
    Buffer(BufferId, bool),
}

/// A module that a device can run.
#[derive(Clone, Debug)]
pub struct Composed {
    /// The text of the module.
    pub source: String,
    /// Where its lines come from.
    pub map: SourceMap,
    /// The compute entry point's name.
    pub compute: &'static str,
    /// The fragment entry point's name, with `vertex` as its vertex entry point, if it has one.
    pub fragment: Option<&'static str>,
    /// The bindings of the compute entry point. The fragment entry point has the same but the storage image.
    pub slots: Vec<Slot>,
    /// The workgroup's size.
    pub workgroup: [u32; 3],
    /// What the compute entry point is told of an invocation.
    pub told: Vec<Told>,
    /// Whether every part of the module was unchecked: see [`Shader::unchecked`](super::Shader::unchecked).
    pub unchecked: bool,
    /// How its taps read textures.
    pub reading: SampleMode,
}

impl Composed {
    /// Parses and validates the module; the first mistake, at the author's line, otherwise.
    pub fn validate(&self) -> Result<naga::Module, ShaderError> {
        validate(&self.source, &self.map)
    }
}

pub(super) fn validated(text: &Text) -> Result<naga::Module, ShaderError> {
    validate(&text.text, &text.map)
}

fn validate(source: &str, map: &SourceMap) -> Result<naga::Module, ShaderError> {
    let module = naga::front::wgsl::parse_str(source).map_err(|error| {
        let place = error.location(source);
        place_error(map, place.map(|p| (p.line_number, p.line_position)), error.message().to_owned())
    })?;
    let capabilities = naga::valid::Capabilities::all();
    let flags = naga::valid::ValidationFlags::all();
    if let Some((span, why)) = lints::first(&module) {
        let place = span.location(source);
        return Err(place_error(map, Some((place.line_number, place.line_position)), why.into()));
    }
    naga::valid::Validator::new(flags, capabilities).validate(&module).map_err(|error| {
        // Of all the places that the error goes through, the narrowest says most.
        let spans =
            error.spans().map(|(span, _)| *span).filter(|span| span.to_range().is_some_and(|range| !range.is_empty()));
        let narrowest = spans.min_by_key(|span| span.to_range().map_or(usize::MAX, |range| range.len()));
        let place = narrowest.map(|span| span.location(source)).or_else(|| error.location(source));
        place_error(map, place.map(|p| (p.line_number, p.line_position)), root_cause(error.as_inner()))
    })?;
    Ok(module)
}

fn root_cause(error: &dyn std::error::Error) -> String {
    let mut parts = vec![error.to_string()];
    let mut source = error.source();
    while let Some(inner) = source {
        parts.push(inner.to_string());
        source = inner.source();
    }
    // "Function [10] is invalid" and the like only lead to what is said last.
    let last = parts.len() - 1;
    let says_more = |(at, part): &(usize, String)| *at == last || !part.ends_with("is invalid");
    parts.into_iter().enumerate().filter(says_more).map(|(_, part)| part).collect::<Vec<_>>().join(": ")
}

fn place_error(map: &SourceMap, place: Option<(u32, u32)>, mut message: String) -> ShaderError {
    // naga's sentences begin with a capital letter, ours do not; names stay as they are.
    let is_sentence = message.chars().nth(1).is_some_and(|second| second.is_ascii_lowercase() || second == ' ');
    if let Some(first) = message.get_mut(..1).filter(|_| is_sentence) {
        first.make_ascii_lowercase();
    }
    let (line, column) = place.unwrap_or((0, 0));
    let (file, line) = map.locate(line);
    ShaderError { file: file.into(), line, column, message }
}

const FULL_SCREEN_TRIANGLE: &str = "
@vertex
fn vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    let uv = vec2f(f32(2u * (index & 1u)), f32(index & 2u));
    return vec4f(2.0 * uv.x - 1.0, 1.0 - 2.0 * uv.y, 0.0, 1.0);
}";

/// A chain of kernel functions with its entry points.
///
/// `desc` describes the result. `sample_modes` says how each image is read, by its id; the strictest of a pass's textures holds for all of its taps.
fn compose_steps(
    steps: &[Step],
    result: ImageId,
    desc: ImageDesc,
    sample_mode_of: &dyn Fn(ImageId) -> SampleMode,
    features: ShaderFeatures,
) -> Result<Composed, ShaderError> {
    let mut writer = StepsWriter::new(sample_mode_of);
    let reading = writer.strictest(steps);
    writer.stage(0, steps, 0);
    let function = writer.take_function("run", steps.len() - 1);
    let storage = writer.storage(result, desc.format);
    let extent = writer.extent();
    let rows = rows_of(desc.size);
    let mut text = Text::promising(steps).reading(reading, features)?;
    for step in steps {
        text.module(step.shader)?;
    }
    text.generated(&uniform_struct(steps));
    text.generated(&writer.declarations);
    text.generated(&function);
    text.generated(&entry_points(&storage, &extent, rows));
    Ok(Composed {
        source: text.text,
        map: text.map,
        compute: "compute",
        fragment: Some("fragment"),
        slots: writer.slots,
        workgroup: [WIDTH, HEIGHT, 1],
        told: [BuiltIn::WorkGroupId, BuiltIn::LocalInvocationId].map(Told::One).into(),
        unchecked: steps.iter().all(|step| step.shader.is_unchecked()),
        reading,
    })
}

/// Invocations of a workgroup, across and down. On an H200 half as many take 2 per cent less time than 16x16 do, because their waiting overlaps more.
const WIDTH: u32 = 16;
const HEIGHT: u32 = 8;

/// The same together.
pub(crate) const STEPS_LANES: u32 = WIDTH * HEIGHT;

/// Texels of a result of that size that a workgroup makes, across and down.
pub(crate) fn steps_cover(size: Size) -> [u32; 2] {
    [WIDTH, HEIGHT * rows_of(size)]
}

/// Texels that an invocation makes, one below the other. Several in flight hide each other's waiting (at 4K an H200 takes a third less time
/// for four than for one), but a small image needs all of its texels to occupy the device.
fn rows_of(size: Size) -> u32 {
    match size.texels() {
        0..0x4_0000 => 1,
        0x4_0000..0x10_0000 => 2,
        _ => 4,
    }
}

fn entry_points(result: &str, extent: &str, rows: u32) -> String {
    let every = |line: &dyn Fn(u32) -> String| (0..rows).map(line).collect::<String>();
    // From the bottom up, because what the pass before has read last is still in the cache. Texels above the first row are made like the
    // first row, and not stored: a branch around each would let none overlap another.
    let made = every(&|row| {
        let offset = row * HEIGHT;
        format!("    let value{row} = run(point_at(max(first - vec2i(0, {offset}), vec2i())));\n")
    });
    let stored = every(&|row| {
        let offset = row * HEIGHT;
        format!("    if first.y >= {offset} {{ textureStore({result}, first - vec2i(0, {offset}), value{row}); }}\n")
    });
    format!(
        "fn point_at(pixel: vec2i) -> Point {{
    return Point(pixel, (vec2f(pixel) + 0.5) / {extent}, {extent});
}}
@compute @workgroup_size({WIDTH}, {HEIGHT})
fn compute(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_id) local: vec3u) {{
    let away = vec2i(group.xy * vec2u({WIDTH}u, {}u) + local.xy);
    let size = vec2i({extent});
    let first = vec2i(away.x, size.y - 1 - away.y);
    if first.x >= size.x {{ return; }}
{made}{stored}}}
{FULL_SCREEN_TRIANGLE}
@fragment
fn fragment(@builtin(position) position: vec4f) -> @location(0) vec4f {{
    return run(point_at(vec2i(position.xy)));
}}",
        HEIGHT * rows
    )
}

/// Writes calls of kernel functions and the bindings that they need.
pub(super) struct StepsWriter<'a> {
    slots: Vec<Slot>,
    declarations: String,
    body: String,
    sample_mode_of: &'a dyn Fn(ImageId) -> SampleMode,
}

impl<'a> StepsWriter<'a> {
    pub(super) fn new(sample_mode_of: &'a dyn Fn(ImageId) -> SampleMode) -> Self {
        Self { slots: Vec::new(), declarations: String::new(), body: String::new(), sample_mode_of }
    }

    pub(super) fn declarations(&self) -> &str {
        &self.declarations
    }

    pub(super) fn into_slots(self) -> Vec<Slot> {
        self.slots
    }

    /// How the textures of the steps must be read.
    pub(super) fn strictest<'s>(&self, steps: impl IntoIterator<Item = &'s Step>) -> SampleMode {
        let textures = steps.into_iter().flat_map(|s| &s.args).filter_map(|arg| match arg {
            Arg::Texture(image) => Some((self.sample_mode_of)(*image)),
            _ => None,
        });
        textures.max().unwrap_or_default()
    }

    /// The steps of a stage, the first of which is number `first` of the pass.
    pub(super) fn stage(&mut self, stage: usize, steps: &[Step], first: usize) {
        for (index, step) in steps.iter().enumerate() {
            self.step(stage, first, first + index, step);
        }
    }

    /// The steps written since the last call, as a function that returns the value of step `last`.
    pub(super) fn take_function(&mut self, name: &str, last: usize) -> String {
        let body = std::mem::take(&mut self.body);
        format!("fn {name}(at: Point) -> vec4f {{\n{body}    return step{last};\n}}")
    }

    /// The variable of a storage image.
    pub(super) fn storage(&mut self, image: ImageId, format: Format) -> String {
        let declaration = format!("var NAME: texture_storage_2d<{}, write>;", format.wgsl());
        self.variable(SlotKind::Storage(image), "result", &declaration)
    }

    /// The variable of the uniform with the result's size.
    pub(super) fn extent(&mut self) -> String {
        self.variable(SlotKind::Extent, "extent", "var<uniform> NAME: vec2f;")
    }

    /// The variable of the pass's uniform.
    pub(super) fn params_variable(&mut self) -> String {
        self.variable(SlotKind::Params, "params", "var<uniform> NAME: PassUniform;")
    }

    /// The slot that holds `kind`, made at its first mention.
    fn slot(&mut self, kind: SlotKind) -> u32 {
        if let Some(slot) = self.slots.iter().find(|slot| slot.kind == kind) {
            return slot.binding;
        }
        let binding = self.slots.len() as u32;
        self.slots.push(Slot { binding, kind });
        binding
    }

    /// The name of the variable in that slot, declared at its first mention.
    fn variable(&mut self, kind: SlotKind, prefix: &str, declaration: &str) -> String {
        let known = self.slots.len();
        let binding = self.slot(kind);
        let name = format!("{prefix}{binding}");
        if self.slots.len() > known {
            let declared = declaration.replace("NAME", &name);
            let _ = writeln!(self.declarations, "@group(0) @binding({binding}) {declared}");
        }
        name
    }

    fn step(&mut self, stage: usize, first: usize, index: usize, step: &Step) {
        let function = step.shader.reflect().ok().and_then(|r| r.function(step.function));
        let is_volume = |position: usize| {
            function.is_some_and(|f| f.args.get(position).is_some_and(|(_, ty)| *ty == super::ArgType::Volume))
        };
        let args: Vec<String> = step
            .args
            .iter()
            .enumerate()
            .map(|(position, arg)| self.arg(stage, first, index, step, *arg, is_volume(position)))
            .collect();
        let suffix = if is_tiled(step) { TILED } else { "" };
        let _ = writeln!(self.body, "    let step{index} = {}{suffix}({});", step.function, args.join(", "));
    }

    fn arg(&mut self, stage: usize, first: usize, index: usize, step: &Step, arg: Arg, volume: bool) -> String {
        match arg {
            Arg::Step(earlier) => format!("step{}", first + earlier),
            Arg::Tile => format!("{}u", stage.saturating_sub(1)),
            Arg::Sampler if is_tiled(step) => "0u".into(),
            Arg::Point => "at".into(),
            Arg::Params => self.params_variable() + &format!(".step{index}"),
            Arg::Frame => self.variable(SlotKind::Frame, "frame", "var<uniform> NAME: Frame;"),
            Arg::Sampler => self.variable(SlotKind::Sampler, "linear", "var NAME: sampler;"),
            Arg::Texture(image) => self.texture(image, volume),
            Arg::Pixel(image) => {
                let texture = self.texture(image, false);
                format!("{}(textureLoad({texture}, at.pixel, 0))", (self.sample_mode_of)(image).guard_call())
            }
            Arg::Value(buffer, components) => {
                let declaration = "var<storage, read> NAME: array<vec4f>;";
                let name = self.variable(SlotKind::Buffer(buffer, false), "value", declaration);
                format!("{name}[0].{}", &"xyzw"[..usize::from(components)])
            }
            Arg::Zero(1) => "0.0".into(),
            Arg::Zero(n) => format!("vec{n}f()"),
        }
    }

    fn texture(&mut self, image: ImageId, volume: bool) -> String {
        let declaration = if volume { "var NAME: texture_3d<f32>;" } else { "var NAME: texture_2d<f32>;" };
        self.variable(SlotKind::Texture(image), "image", declaration)
    }
}

/// The struct of a pass's uniform; nothing for steps without numbers.
pub(super) fn uniform_struct(steps: &[Step]) -> String {
    if steps.iter().all(|step| step.uniform.is_empty()) {
        return String::new();
    }
    let mut text = String::from("struct PassUniform {\n");
    for (index, step) in steps.iter().enumerate().filter(|(_, s)| !s.uniform.is_empty()) {
        let _ = writeln!(text, "    @align(16) step{index}: {},", params_struct(step));
    }
    text + "}"
}

/// The type of a step's uniform.
pub(super) fn params_struct(step: &Step) -> String {
    let reflection = step.shader.reflect().expect("a recorded step has a valid shader");
    let function = reflection.function(step.function).expect("a recorded step has a known function");
    function
        .args
        .iter()
        .find_map(|(name, ty)| match ty {
            super::ArgType::Struct(ty) if name == "params" && is_tiled(step) => Some(format!("{ty}{TILED}")),
            super::ArgType::Struct(ty) if name == "params" => Some(ty.clone()),
            _ => None,
        })
        .expect("a step with a uniform has an argument called `params`")
}

/// A pass of any kind.
pub fn compose_pass(
    pass: &Pass,
    desc_of: &dyn Fn(ImageId) -> ImageDesc,
    sample_mode_of: &dyn Fn(ImageId) -> SampleMode,
    features: ShaderFeatures,
) -> Result<Composed, ShaderError> {
    let format_of = |image| desc_of(image).format;
    match &pass.work {
        Work::Steps { steps, result } => compose_steps(steps, *result, desc_of(*result), sample_mode_of, features),
        Work::Tiled(tiling) => compose_tiling(tiling, &format_of, sample_mode_of, features),
        Work::Rows(rows) => compose_rows(rows, desc_of(rows.result).format, sample_mode_of, features),
        Work::Cells(cells) => compose_cells(cells, &format_of, sample_mode_of, features),
        Work::Entry(call) => compose_entry(call, &format_of, sample_mode_of, features),
    }
}

/// A whole kernel, with the formats of its storage images set and its bindings resolved.
fn compose_entry(
    call: &EntryCall,
    format_of: &dyn Fn(ImageId) -> Format,
    sample_mode_of: &dyn Fn(ImageId) -> SampleMode,
    features: ShaderFeatures,
) -> Result<Composed, ShaderError> {
    let reflection = call.shader.reflect()?;
    let Bound { slots, formats, reading } = Bound::new(call, format_of, sample_mode_of)?;
    let mut text = Text::default().reading(reading, features)?;
    text.module(call.shader)?;
    let source = formats.iter().fold(text.text, |source, (name, format)| set_storage_format(&source, name, *format));
    let entry = reflection.entry(call.entry);
    Ok(Composed {
        source,
        map: text.map,
        compute: call.entry,
        fragment: None,
        slots,
        workgroup: entry.map_or([1; 3], |entry| entry.workgroup),
        told: entry.map_or_else(Vec::new, |entry| entry.told.clone()),
        unchecked: call.shader.is_unchecked(),
        reading,
    })
}

/// What the bindings of a whole kernel hold.
pub(super) struct Bound {
    pub(super) slots: Vec<Slot>,
    /// The formats of the storage images, by the variables' names.
    pub(super) formats: Vec<(String, Format)>,
    /// How the textures must be read.
    pub(super) reading: SampleMode,
}

impl Bound {
    pub(super) fn new(
        call: &EntryCall,
        format_of: &dyn Fn(ImageId) -> Format,
        sample_mode_of: &dyn Fn(ImageId) -> SampleMode,
    ) -> Result<Self, ShaderError> {
        let resource = |name: &str| call.bindings.iter().find(|b| b.name == name).map(|b| b.resource);
        let mut bound = Self { slots: Vec::new(), formats: Vec::new(), reading: SampleMode::default() };
        let Self { slots, formats, reading } = &mut bound;
        for global in &call.shader.reflect()?.globals {
            let kind = match (&global.kind, resource(&global.name)) {
                (GlobalKind::Uniform(ty), None) if ty == "Frame" => SlotKind::Frame,
                (GlobalKind::Uniform(_), None) => SlotKind::Params,
                (GlobalKind::Sampler, None) => SlotKind::Sampler,
                (GlobalKind::Texture(_), Some(Resource::Image(image))) => {
                    *reading = (*reading).max(sample_mode_of(image));
                    SlotKind::Texture(image)
                }
                (GlobalKind::StorageTexture(_), Some(Resource::Image(image))) => {
                    formats.push((global.name.clone(), format_of(image)));
                    SlotKind::Storage(image)
                }
                (GlobalKind::Buffer(writes), Some(Resource::Buffer(buffer))) => SlotKind::Buffer(buffer, *writes),
                // A binding that this entry point does not use.
                (_, None) => continue,
                _ => {
                    return Err(ShaderError::at(
                        call.shader.file(),
                        0,
                        format!("`{}` holds another kind of resource", global.name),
                    ));
                }
            };
            slots.push(Slot { binding: global.binding, kind });
        }
        Ok(bound)
    }
}

/// Replaces the format in `var NAME: texture_storage_2d<FORMAT, write>`, which a graph file may choose.
pub(super) fn set_storage_format(source: &str, name: &str, format: Format) -> String {
    let declaration = format!("var {name}: texture_storage_");
    let Some(start) = source.find(&declaration) else { return source.to_owned() };
    let Some(open) = source[start..].find('<').map(|at| start + at + 1) else { return source.to_owned() };
    let Some(comma) = source[open..].find(',').map(|at| open + at) else { return source.to_owned() };
    format!("{}{}{}", &source[..open], format.wgsl(), &source[comma..])
}
