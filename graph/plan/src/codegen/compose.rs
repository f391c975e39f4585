//! Puts modules together into one that a device can run: constants that choose how textures are read, the modules with their
//! imports, bindings, and an entry point around a chain of kernel functions.

use afterimage_base::Shared;
use std::fmt::Write as _;

use super::cells::compose_cells;
use super::rows::compose_rows;
use super::tiles::{compose_tiling, is_tiled};
use afterimage_base::image::{Format, ImageDesc, Size};
use afterimage_graph::node::{Arg, BufferId, EntryCall, ImageId, Pass, Resource, Step, Work};
use afterimage_wgsl::{
    ArgType, GlobalKind, SampleMode, Shader, ShaderError, ShaderFeatures, SourceMap, TILED, Text, validate,
};

/// What a binding slot of a composed module holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Slot {
    /// `@binding`; all are in group 0.
    pub binding: u32,
    /// What it holds.
    pub kind: SlotKind,
}

/// The first binding that none of the slots has.
pub(crate) fn free(slots: &[Slot]) -> u32 {
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
    pub compute: Shared<str>,
    /// The fragment entry point's name, with `vertex` as its vertex entry point, if it has one.
    pub fragment: Option<&'static str>,
    /// The bindings of the compute entry point. The fragment entry point has the same but the storage image.
    pub slots: Vec<Slot>,
    /// The workgroup's size.
    pub workgroup: [u32; 3],
    /// Whether every part of the module was unchecked: see [`Shader::unchecked`](afterimage_wgsl::Shader::unchecked).
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
    let mut text = Text::promising(promises(steps)).reading(reading, features)?;
    for step in steps {
        text.module(&step.shader)?;
    }
    text.generated(&uniform_struct(steps));
    text.generated(&writer.declarations);
    text.generated(&function);
    text.generated(&entry_points(&storage, &extent, rows));
    Ok(Composed {
        source: text.text,
        map: text.map,
        compute: Shared::of("compute"),
        fragment: Some("fragment"),
        slots: writer.slots,
        workgroup: [WIDTH, HEIGHT, 1],
        unchecked: steps.iter().all(|step| step.shader.is_unchecked()),
        reading,
    })
}

/// Invocations of a workgroup, across and down. On an H200 half as many take 2 per cent less time than 16x16 do, because their waiting overlaps more.
const WIDTH: u32 = 16;
const HEIGHT: u32 = 8;

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
pub(crate) struct StepsWriter<'a> {
    slots: Vec<Slot>,
    declarations: String,
    body: String,
    sample_mode_of: &'a dyn Fn(ImageId) -> SampleMode,
}

impl<'a> StepsWriter<'a> {
    pub(crate) fn new(sample_mode_of: &'a dyn Fn(ImageId) -> SampleMode) -> Self {
        Self { slots: Vec::new(), declarations: String::new(), body: String::new(), sample_mode_of }
    }

    pub(crate) fn declarations(&self) -> &str {
        &self.declarations
    }

    pub(crate) fn into_slots(self) -> Vec<Slot> {
        self.slots
    }

    /// How the textures of the steps must be read.
    pub(crate) fn strictest<'s>(&self, steps: impl IntoIterator<Item = &'s Step>) -> SampleMode {
        let textures = steps.into_iter().flat_map(|s| &s.args).filter_map(|arg| match arg {
            Arg::Texture(image) => Some((self.sample_mode_of)(*image)),
            _ => None,
        });
        textures.max().unwrap_or_default()
    }

    /// The steps of a stage, the first of which is number `first` of the pass.
    pub(crate) fn stage(&mut self, stage: usize, steps: &[Step], first: usize) {
        for (index, step) in steps.iter().enumerate() {
            self.step(stage, first, first + index, step);
        }
    }

    /// The steps written since the last call, as a function that returns the value of step `last`.
    pub(crate) fn take_function(&mut self, name: &str, last: usize) -> String {
        let body = std::mem::take(&mut self.body);
        format!("fn {name}(at: Point) -> vec4f {{\n{body}    return step{last};\n}}")
    }

    /// The variable of a storage image.
    pub(crate) fn storage(&mut self, image: ImageId, format: Format) -> String {
        let declaration = format!("var NAME: texture_storage_2d<{}, write>;", format.wgsl());
        self.variable(SlotKind::Storage(image), "result", &declaration)
    }

    /// The variable of the uniform with the result's size.
    pub(crate) fn extent(&mut self) -> String {
        self.variable(SlotKind::Extent, "extent", "var<uniform> NAME: vec2f;")
    }

    /// The variable of the pass's uniform.
    pub(crate) fn params_variable(&mut self) -> String {
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
        let function = step.shader.reflect().ok().and_then(|r| r.function(&step.function));
        let is_volume = |position: usize| {
            function.is_some_and(|f| f.args.get(position).is_some_and(|(_, ty)| *ty == ArgType::Volume))
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
                format!("{}(textureLoad({texture}, at.pixel, 0))", (self.sample_mode_of)(image).sanitize_call())
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
pub(crate) fn uniform_struct(steps: &[Step]) -> String {
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
pub(crate) fn params_struct(step: &Step) -> String {
    let reflection = step.shader.reflect().expect("a recorded step has a valid shader");
    let function = reflection.function(&step.function).expect("a recorded step has a known function");
    function
        .args
        .iter()
        .find_map(|(name, ty)| match ty {
            ArgType::Struct(ty) if name == "params" && is_tiled(step) => Some(format!("{ty}{TILED}")),
            ArgType::Struct(ty) if name == "params" => Some(ty.clone()),
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
    text.module(&call.shader)?;
    let source = formats.iter().fold(text.text, |source, (name, format)| set_storage_format(&source, name, *format));
    let entry = reflection.entry(&call.entry);
    Ok(Composed {
        source,
        map: text.map,
        compute: call.entry.clone(),
        fragment: None,
        slots,
        workgroup: entry.map_or([1; 3], |entry| entry.workgroup),
        unchecked: call.shader.is_unchecked(),
        reading,
    })
}

/// What the bindings of a whole kernel hold.
pub(crate) struct Bound {
    pub(crate) slots: Vec<Slot>,
    /// The formats of the storage images, by the variables' names.
    pub(crate) formats: Vec<(String, Format)>,
    /// How the textures must be read.
    pub(crate) reading: SampleMode,
}

impl Bound {
    pub(crate) fn new(
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
pub(crate) fn set_storage_format(source: &str, name: &str, format: Format) -> String {
    let declaration = format!("var {name}: texture_storage_");
    let Some(start) = source.find(&declaration) else { return source.to_owned() };
    let Some(open) = source[start..].find('<').map(|at| start + at + 1) else { return source.to_owned() };
    let Some(comma) = source[open..].find(',').map(|at| open + at) else { return source.to_owned() };
    format!("{}{}{}", &source[..open], format.wgsl(), &source[comma..])
}

/// The modules of the steps, and the promises that each step makes of its module.
pub(crate) fn promises<'s>(
    steps: impl IntoIterator<Item = &'s Step>,
) -> impl Iterator<Item = (&'s Shader, &'s [&'static str])> {
    steps.into_iter().map(|step| (&*step.shader, step.promises.as_slice()))
}
