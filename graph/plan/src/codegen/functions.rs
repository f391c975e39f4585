//! The entry points of a chain of kernel functions, each of which may use the values of those before.

use std::fmt::Write as _;

use super::module::{Composed, Slot, SlotKind};
use super::uniforms::uniform_struct;
use afterimage_base::Shared;
use afterimage_base::image::{Format, ImageDesc, Size};
use afterimage_graph::node::{Arg, Argument, ImageId, KernelCall, Pass};
use afterimage_wgsl::{ArgType, SampleMode, Shader, ShaderError, ShaderFeatures, TILED, Text};

const FULL_SCREEN_TRIANGLE: &str = "
@vertex
fn vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    let uv = vec2f(f32(2u * (index & 1u)), f32(index & 2u));
    return vec4f(2.0 * uv.x - 1.0, 1.0 - 2.0 * uv.y, 0.0, 1.0);
}";

/// A chain of kernel functions with its entry points; `desc` describes the result.
///
/// The strictest sample mode of a pass's textures holds for all of its taps.
pub(super) fn compose_functions(
    pass: &Pass,
    (result, desc): (ImageId, ImageDesc),
    sample_mode_of: &dyn Fn(ImageId) -> SampleMode,
    features: ShaderFeatures,
) -> Result<Composed, ShaderError> {
    let kernels = &pass.kernels;
    let mut writer = KernelWriter::new(sample_mode_of);
    let reading = writer.strictest(kernels);
    writer.kernels(0, kernels, 0);
    let function = writer.take_function("run", kernels.len() - 1);
    let storage = writer.storage(result, desc.format);
    let extent = writer.extent();
    let rows = rows_of(desc.size);
    let mut text = Text::promising(promises(kernels)).reading(reading, features)?;
    for kernel in kernels {
        text.module(&kernel.shader)?;
    }
    text.generated(&uniform_struct(pass, &|at| params_struct(&kernels[at])));
    text.generated(writer.declarations());
    text.generated(&function);
    text.generated(&entry_points(&storage, &extent, rows));
    Ok(Composed {
        source: text.text,
        map: text.map,
        compute: Shared::of("compute"),
        fragment: Some("fragment"),
        slots: writer.into_slots(),
        workgroup: [WIDTH, HEIGHT, 1],
        unchecked: pass.shaders().all(Shader::is_unchecked),
        reading,
        zero_workgroup_memory: false,
    })
}

/// Invocations of a workgroup, across and down. On an H200 half as many take 2 per cent less time than 16x16, because more
/// of their waiting overlaps.
const WIDTH: u32 = 16;
const HEIGHT: u32 = 8;

/// Texels of a result of that size that a workgroup makes, across and down.
pub(super) fn functions_cover(size: Size) -> [u32; 2] {
    [WIDTH, HEIGHT * rows_of(size)]
}

/// Texels that an invocation makes, one below the other. Several in flight hide each other's latency (at 4K an H200 takes a
/// third less time for four than for one), but a small image needs all of its texels to occupy the device.
fn rows_of(size: Size) -> u32 {
    match size.texels() {
        0..0x4_0000 => 1,
        0x4_0000..0x10_0000 => 2,
        _ => 4,
    }
}

fn entry_points(result: &str, extent: &str, rows: u32) -> String {
    let every = |line: &dyn Fn(u32) -> String| (0..rows).map(line).collect::<String>();
    // From the bottom up, because what the pass before has read last is still in the cache. Texels above the first row are
    // made like the first row, and not stored: with a branch around each, none would overlap another.
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
pub(super) struct KernelWriter<'a> {
    slots: Vec<Slot>,
    declarations: String,
    body: String,
    sample_mode_of: &'a dyn Fn(ImageId) -> SampleMode,
}

impl<'a> KernelWriter<'a> {
    pub(super) fn new(sample_mode_of: &'a dyn Fn(ImageId) -> SampleMode) -> Self {
        Self { slots: Vec::new(), declarations: String::new(), body: String::new(), sample_mode_of }
    }

    pub(super) fn declarations(&self) -> &str {
        &self.declarations
    }

    pub(super) fn into_slots(self) -> Vec<Slot> {
        self.slots
    }

    /// How the textures of the kernels must be read.
    pub(super) fn strictest(&self, kernels: &[KernelCall]) -> SampleMode {
        let textures = kernels.iter().flat_map(KernelCall::textures);
        textures.map(|image| (self.sample_mode_of)(image)).max().unwrap_or_default()
    }

    /// Calls of the kernels of a stage, the first of which is number `first` of the pass.
    pub(super) fn kernels(&mut self, stage: usize, kernels: &[KernelCall], first: usize) {
        for (index, kernel) in kernels.iter().enumerate() {
            self.kernel(stage, first + index, kernel);
        }
    }

    /// The calls written since the last time, as a function that returns the value of kernel `last`.
    pub(super) fn take_function(&mut self, name: &str, last: usize) -> String {
        let body = std::mem::take(&mut self.body);
        format!("fn {name}(at: Point) -> vec4f {{\n{body}    return kernel{last};\n}}")
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

    fn kernel(&mut self, stage: usize, index: usize, kernel: &KernelCall) {
        let function = kernel.shader.reflect().ok().and_then(|r| r.function(&kernel.function));
        let is_volume = |position: usize| {
            function.is_some_and(|f| f.args.get(position).is_some_and(|(_, ty)| *ty == ArgType::Volume))
        };
        let is_tiled = is_tiled(kernel);
        let args = kernel.args.iter().enumerate();
        let args: Vec<String> = args
            .map(|(position, Argument { value, .. })| match value {
                Arg::Tile => format!("{}u", stage.saturating_sub(1)),
                Arg::Sampler if is_tiled => "0u".into(),
                Arg::Params => self.params_variable() + &format!(".kernel{index}"),
                value => self.arg(*value, is_volume(position)),
            })
            .collect();
        let suffix = if is_tiled { TILED } else { "" };
        let _ = writeln!(self.body, "    let kernel{index} = {}{suffix}({});", kernel.function, args.join(", "));
    }

    fn arg(&mut self, arg: Arg, is_volume: bool) -> String {
        match arg {
            Arg::Kernel(earlier) => format!("kernel{earlier}"),
            Arg::Point => "at".into(),
            Arg::Frame => self.variable(SlotKind::Frame, "frame", "var<uniform> NAME: Frame;"),
            Arg::Sampler => self.variable(SlotKind::Sampler, "linear", "var NAME: sampler;"),
            Arg::Texture(image) => self.texture(image, is_volume),
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
            Arg::Params | Arg::Tile | Arg::Square | Arg::Storage(_) | Arg::Buffer(..) => {
                unreachable!("{arg:?} is no argument of a kernel function by itself")
            }
        }
    }

    fn texture(&mut self, image: ImageId, volume: bool) -> String {
        let declaration = if volume { "var NAME: texture_3d<f32>;" } else { "var NAME: texture_2d<f32>;" };
        self.variable(SlotKind::Texture(image), "image", declaration)
    }
}

/// Whether a kernel reads the image before in a tiled chain.
pub(super) fn is_tiled(kernel: &KernelCall) -> bool {
    kernel.takes(Arg::Tile)
}

/// The type of a kernel's uniform.
pub(super) fn params_struct(kernel: &KernelCall) -> String {
    let reflection = kernel.shader.reflect().expect("a recorded kernel has a valid shader");
    let function = reflection.function(&kernel.function).expect("a recorded kernel has a known function");
    function
        .args
        .iter()
        .find_map(|(name, ty)| match ty {
            ArgType::Struct(ty) if name == "params" && is_tiled(kernel) => Some(format!("{ty}{TILED}")),
            ArgType::Struct(ty) if name == "params" => Some(ty.clone()),
            _ => None,
        })
        .expect("a kernel with a uniform has an argument called `params`")
}

/// The modules of the kernels, and the promises that each kernel makes of its module.
pub(super) fn promises(kernels: &[KernelCall]) -> impl Iterator<Item = (&Shader, &[&'static str])> {
    kernels.iter().map(|kernel| (&*kernel.shader, kernel.promises.as_slice()))
}
