//! Calls of kernel functions, and the bindings that they need.

use std::fmt::Write as _;

use afterimage_base::image::Format;
use afterimage_graph::node::{Arg, Argument, BlockId, ImageId, KernelCall, PassKind, WarpPart};
use afterimage_wgsl::{ArgType, Instance, Linker, SampleMode, ShaderError, limits};

use super::module::{Composed, Entry, PassCode, Slot, SlotKind};
use super::uniforms::uniform_struct;

/// Writes the code around the functions of a pass.
pub(super) struct FunctionWriter<'c, 'a> {
    code: &'c PassCode<'a>,
    linker: Linker<'a>,
    /// The file of each kernel in the module.
    instances: Vec<Instance>,
    slots: Vec<Slot>,
    /// The variables of host blocks: struct, block, name.
    blocks: Vec<(String, BlockId, String)>,
    declarations: String,
    body: String,
    immediate: bool,
    /// The place that functions get.
    point: &'static str,
    /// The textures of which the entry point loads the pixels for the function.
    loaded_pixels: Vec<LoadedPixel>,
    loads_all_pixels: bool,
}

/// A texture of which a function takes a pixel that the entry point loads. Pixels of host images are loaded for all
/// texels of an invocation and examined together: a branch after each load would let none overlap another.
struct LoadedPixel {
    texture: String,
    mode: SampleMode,
}

impl<'c, 'a> FunctionWriter<'c, 'a> {
    /// A writer of all kernels of the pass.
    pub(super) fn new(code: &'c PassCode<'a>, mut linker: Linker<'a>) -> Result<Self, ShaderError> {
        let kernels = code.pass.kernels.iter();
        let instances =
            kernels.map(|kernel| linker.add(kernel.shader.source(), &kernel.defines)).collect::<Result<_, _>>()?;
        Ok(Self {
            code,
            linker,
            instances,
            slots: Vec::new(),
            blocks: Vec::new(),
            declarations: String::new(),
            body: String::new(),
            immediate: false,
            point: "at",
            loaded_pixels: Vec::new(),
            loads_all_pixels: false,
        })
    }

    /// Lets the entry point load the pixels of all textures, and not only those of host images.
    pub(super) fn load_all_pixels(&mut self) {
        self.loads_all_pixels = true;
    }

    /// The module: the uniform, the bindings and that code around the kernels. `names` are those of the entry points.
    pub(super) fn finish(
        self,
        imports: &str,
        code: &str,
        workgroup: [u32; 3],
        names: &'static [&'static str],
    ) -> Result<Composed, ShaderError> {
        let round = if self.rounds_halves() { "import afterimage::math::nearest_half;\n" } else { "" };
        let text = [round, imports, self.uniform_struct().as_str(), &self.declarations, code].concat();
        let entry = Entry { slots: self.slots, immediate: self.immediate, workgroup, names };
        self.code.compose(self.linker, text, entry)
    }

    /// The linked name of an item in the file of a kernel.
    pub(super) fn name(&self, kernel: usize, name: &str) -> String {
        self.linker.name(self.instances[kernel], name)
    }

    /// A function `name` to the value of the last of these kernels, from a `Point` and the pixels that are loaded.
    pub(super) fn function(&mut self, name: &str, kernels: std::ops::Range<usize>) -> String {
        let last = kernels.end - 1;
        kernels.for_each(|index| self.call(index));
        let body = std::mem::take(&mut self.body);
        let value = if self.rounds_halves() { format!("nearest_half(kernel{last})") } else { format!("kernel{last}") };
        let pixels: String = (0..self.loaded_pixels.len()).map(|index| format!(", host{index}: vec4f")).collect();
        format!("fn {name}(at: Point{pixels}) -> vec4f {{\n{body}    return {value};\n}}\n")
    }

    /// True if a processor stores the result in half floats: see [`CodeOptions::on_processor`](super::CodeOptions).
    fn rounds_halves(&self) -> bool {
        let format = self.code.pass.results.first().map(|result| self.code.format_of(result.image));
        let is_half = matches!(format, Some(Format::R16Float | Format::Rg16Float | Format::Rgba16Float));
        self.code.options.on_processor && is_half
    }

    /// A function `name` to the value of the last of these kernels, from a `Point`, the value of the kernel before them
    /// and `more` arguments.
    pub(super) fn function_after(&mut self, name: &str, kernels: std::ops::Range<usize>, more: &str) -> String {
        let (before, last) = (kernels.start - 1, kernels.end - 1);
        kernels.for_each(|index| self.call(index));
        let body = std::mem::take(&mut self.body);
        format!("fn {name}(at: Point, kernel{before}: vec4f{more}) -> vec4f {{\n{body}    return kernel{last};\n}}\n")
    }

    /// Statements that load pixels at the places `at0` up to `at{count}`, and sanitize those of host images.
    pub(super) fn load_pixels(&self, count: u32, indent: &str) -> String {
        self.load_raw(count, indent) + &self.sanitize_pixels(count, indent)
    }

    /// Statements that declare variables for the pixels at that many places.
    pub(super) fn declare_ahead(&self, count: u32, indent: &str) -> String {
        self.of_loaded_pixels(count, &|index, place, _| format!("{indent}var ahead{index}_{place}: vec4f;\n"))
    }

    /// Statements that load the pixels at the places `next0` up to `next{count}` into these variables:
    /// what is done with others until they are taken hides the waiting.
    pub(super) fn load_ahead(&self, count: u32, indent: &str) -> String {
        self.loads(count, &format!("{indent}ahead"), "next")
    }

    /// Statements that take the pixels from these variables, as if they were loaded at `at0` and so on.
    pub(super) fn take_ahead(&self, count: u32, indent: &str) -> String {
        self.of_loaded_pixels(count, &|index, place, _| {
            format!("{indent}var host{index}_{place} = ahead{index}_{place};\n")
        })
    }

    /// Statements that load pixels at the places `at0` up to `at{count}`.
    pub(super) fn load_raw(&self, count: u32, indent: &str) -> String {
        self.loads(count, &format!("{indent}var host"), "at")
    }

    /// Loads into variables whose names begin with `variable`, at places whose names begin with `places`.
    fn loads(&self, count: u32, variable: &str, places: &str) -> String {
        self.of_loaded_pixels(count, &|index, place, texture| {
            format!("{variable}{index}_{place} = textureLoad({texture}, {places}{place}.pixel, 0);\n")
        })
    }

    /// A statement for each texture and each place.
    fn of_loaded_pixels(&self, count: u32, statement: &dyn Fn(usize, u32, &str) -> String) -> String {
        let mut statements = String::new();
        for (index, pixel) in self.loaded_pixels.iter().enumerate() {
            for place in 0..count {
                statements += &statement(index, place, &pixel.texture);
            }
        }
        statements
    }

    /// True if some of the pixels that the entry point loads are scene light of the host.
    pub(super) fn loads_light(&self) -> bool {
        self.loaded_pixels.iter().any(|pixel| pixel.mode == SampleMode::SanitizedLight)
    }

    /// Statements that try what `made` makes from pixels of the host at the places `at0` up to `at{count}`, as if they
    /// needed no limit and no light became less than 0. Where that holds, nearly everywhere, `light_lowest` is then 0.
    /// The code does not wait for the test: on an H200 at 4K, `lynx` takes 3 us less.
    pub(super) fn try_light(&self, count: u32, made: &str) -> String {
        let (largest, _) = self.limits_of_pixels(count, "");
        format!(
            "    light_is_tried = true;
    light_lowest = select(-1.0, 0.0, {largest} <= HALF_MAX_BITS);
{made}    light_is_tried = false;
"
        )
    }

    /// Statements that sanitize the pixels of host images that were loaded at the places `at0` up to `at{count}`.
    pub(super) fn sanitize_pixels(&self, count: u32, indent: &str) -> String {
        match self.limits_of_pixels(count, indent) {
            (largest, _) if largest.is_empty() => largest,
            (largest, repairs) => format!("{indent}if {largest} > HALF_MAX_BITS {{\n{repairs}{indent}}}\n"),
        }
    }

    /// The largest bits of these pixels, and statements that sanitize them.
    pub(super) fn limits_of_pixels(&self, count: u32, indent: &str) -> (String, String) {
        let (mut largest, mut repairs) = (String::new(), String::new());
        let pixels = self.loaded_pixels.iter().enumerate().filter(|(_, pixel)| pixel.mode.sanitizes());
        for (index, LoadedPixel { texture, mode }) in pixels {
            for place in 0..count {
                let pixel = format!("host{index}_{place}");
                let at = format!("at{place}.pixel");
                let bits = mode.largest_bits(&pixel);
                largest = if largest.is_empty() { bits } else { format!("max({largest}, {bits})") };
                repairs += &format!("{indent}    {pixel} = {};\n", mode.sanitized(texture, &at, &pixel));
            }
        }
        (largest, repairs)
    }

    /// A call of the [`function`](Self::function) of that name at the place `at{place}`.
    pub(super) fn call_at(&self, name: &str, place: u32) -> String {
        let pixels: String = (0..self.loaded_pixels.len()).map(|index| format!(", host{index}_{place}")).collect();
        format!("{name}(at{place}{pixels})")
    }

    /// A function `name` from a place to the value of the last kernel, in a workgroup. Beyond the border, pixels are
    /// read at the nearest place inside: `nearest` is its text.
    pub(super) fn workgroup_function(&mut self, name: &str, nearest: &str) -> String {
        self.point = "here";
        let last = self.code.pass.kernels.len() - 1;
        (0..=last).for_each(|index| self.call(index));
        let body = std::mem::take(&mut self.body);
        format!(
            "fn {name}(here: Point, invocation: Invocation) -> vec4f {{
    let at = {nearest};
{body}    return kernel{last};
}}
"
        )
    }

    /// The struct of the pass's uniform; nothing if it has none.
    fn uniform_struct(&self) -> String {
        let kernels = &self.code.pass.kernels;
        uniform_struct(self.code.pass, &|index| self.name(index, params_type(&kernels[index])))
    }

    /// The variable of a storage image.
    pub(super) fn storage(&mut self, image: ImageId, format: Format) -> String {
        let ty = format!("texture_storage_2d<{}, write>", format.wgsl());
        self.variable(SlotKind::Storage(image), "var", "result", &ty)
    }

    /// The size of the result. Its variable has the first texel behind the size if the result has an origin.
    pub(super) fn extent(&mut self) -> String {
        let (ty, size) = if self.code.options.has_origin { ("vec4f", ".xy") } else { ("vec2f", "") };
        self.variable(SlotKind::Extent, "var<uniform>", "extent", ty) + size
    }

    /// The first texel of the result in its image, if it is not at the corner.
    pub(super) fn origin(&mut self) -> Option<String> {
        let extent = self.code.options.has_origin.then(|| self.extent())?;
        Some(format!("vec2i({}.zw)", extent.trim_end_matches(".xy")))
    }

    /// The variable of the pass's uniform.
    pub(super) fn params(&mut self) -> String {
        let (kind, var) = match self.code.options.on_processor {
            true => (SlotKind::StoredParams, "var<storage, read>"),
            false => (SlotKind::Params, "var<uniform>"),
        };
        self.variable(kind, var, "params", "PassUniform")
    }

    /// The name of the variable in the slot of that kind, which is declared when it is first asked for.
    fn variable(&mut self, kind: SlotKind, var: &str, prefix: &str, ty: &str) -> String {
        let known = self.slots.iter().position(|slot| slot.kind == kind);
        let binding = known.unwrap_or(self.slots.len()) as u32;
        if known.is_none() {
            self.slots.push(Slot { binding, kind });
            let _ = writeln!(self.declarations, "@group(0) @binding({binding}) {var} {prefix}{binding}: {ty};");
        }
        format!("{prefix}{binding}")
    }

    fn frame(&mut self) -> String {
        if !self.code.options.immediates {
            return self.variable(SlotKind::Frame, "var<uniform>", "frame", "Frame");
        }
        if !std::mem::replace(&mut self.immediate, true) {
            self.declarations += "var<immediate> frame: Frame;\n";
        }
        "frame".into()
    }

    /// The variable of a host block. Structs of two files may differ in their names, and so need two variables.
    fn block(&mut self, index: usize, name: &str, block: BlockId) -> String {
        let kernel = &self.code.pass.kernels[index];
        let reflection = kernel.shader.reflect().expect("a kernel that is recorded was reflected");
        let ty = reflection.struct_of(&kernel.function, name).expect("the argument has a struct");
        let ty = self.name(index, ty);
        let known = self.blocks.iter().find(|(known, of, _)| (known, *of) == (&ty, block));
        if let Some((.., variable)) = known {
            return variable.clone();
        }
        // Mesa 22 crashes in some modules where a branch depends on the fourth uniform buffer, and those of the
        // framework's own code depend on this one.
        self.extent();
        let binding = self.slots.len() as u32;
        let variable = format!("block{binding}");
        self.slots.push(Slot { binding, kind: SlotKind::Block(block) });
        let _ = writeln!(self.declarations, "@group(0) @binding({binding}) var<uniform> {variable}: {ty};");
        self.blocks.push((ty, block, variable.clone()));
        variable
    }

    fn call(&mut self, index: usize) {
        let kernel = &self.code.pass.kernels[index];
        let types = types_of(kernel);
        let mut args = Vec::new();
        for (position, arg) in kernel.args.iter().enumerate() {
            let texture = types.get(position).map_or(TEXTURE, |(_, ty)| texture_type(ty));
            let text = self.arg(index, arg, texture);
            let is_computed = kernel.shader.is_untrusted() && matches!(arg.value, Arg::Pixel(_) | Arg::Kernel(_));
            args.push(if is_computed { computed(&text) } else { text });
        }
        let steps = match self.code.pass.kind {
            PassKind::Workgroup(_) => limits::WORKGROUP_LOOP_STEPS,
            _ if self.code.options.on_processor => limits::PROCESSOR_LOOP_STEPS,
            _ => limits::LOOP_STEPS,
        };
        if let Some(before) = self.linker.before_call(steps).filter(|_| kernel.shader.is_untrusted()) {
            let _ = writeln!(self.body, "    {before}");
        }
        let function = self.name(index, &kernel.function);
        let value = format!("{function}({})", args.join(", "));
        let value = match kernel.limited {
            Some(signedness) => SampleMode::sanitizing(signedness).limited(&value),
            None => value,
        };
        let _ = writeln!(self.body, "    let kernel{index} = {value};");
        if kernel.warp == Some(WarpPart::Place) {
            self.body += &place(index);
        }
    }

    fn arg(&mut self, index: usize, arg: &Argument, texture: &str) -> String {
        let name = &arg.name;
        match arg.value {
            Arg::Kernel(earlier) => format!("kernel{earlier}"),
            Arg::Faults(earlier) => self.faults(earlier),
            Arg::Point => self.point.into(),
            Arg::PointOf(earlier) => format!("place{earlier}"),
            Arg::Params => format!("{}.kernel{index}", self.params()),
            Arg::Frame => self.frame(),
            Arg::Invocation => "invocation".into(),
            Arg::Block(block) => self.block(index, name, block),
            Arg::Around => "around".into(),
            Arg::Sampler => self.variable(SlotKind::Sampler, "var", "linear", "sampler"),
            Arg::Texture(image) => self.texture(image, texture),
            Arg::Level(part) => self.variable(SlotKind::Level(part), "var", "image", TEXTURE),
            Arg::Pixel(image) => {
                let texture = self.texture(image, TEXTURE);
                match (self.code.sample_mode_of)(image) {
                    mode if (mode.sanitizes() || self.loads_all_pixels) && self.point == "at" => {
                        self.loaded_pixel(texture, mode)
                    }
                    mode => mode.pixel_read(&texture),
                }
            }
            Arg::Value(buffer, components) => {
                let name =
                    self.variable(SlotKind::Buffer(buffer, false), "var<storage, read>", "value", "array<vec4f>");
                format!("{name}[0].{}", &"xyzw"[..usize::from(components)])
            }
            Arg::Zero(1) => "0.0".into(),
            Arg::Zero(n) => format!("vec{n}f()"),
            Arg::Square | Arg::SquareOf(_) | Arg::Storage(_) | Arg::Buffer(..) => {
                panic!("{arg:?} is no argument of a function of one pixel")
            }
        }
    }

    /// The argument of the function that holds a pixel that the entry point loads.
    fn loaded_pixel(&mut self, texture: String, mode: SampleMode) -> String {
        let known = self.loaded_pixels.iter().position(|pixel| pixel.texture == texture);
        let index = known.unwrap_or_else(|| {
            self.loaded_pixels.push(LoadedPixel { texture, mode });
            self.loaded_pixels.len() - 1
        });
        format!("host{index}")
    }

    /// By bit tests: a compiler may assume that NaN and infinity do not occur.
    fn faults(&self, kernel: usize) -> String {
        let cut = self.linker.after_call().unwrap_or_else(|| "false".into());
        let exponent = "vec4u(0x7f800000u)";
        format!("vec2f(f32(any((bitcast<vec4u>(kernel{kernel}) & {exponent}) == {exponent})), f32({cut}))")
    }

    fn texture(&mut self, image: ImageId, ty: &str) -> String {
        self.variable(SlotKind::Texture(image), "var", "image", ty)
    }
}

/// The type of a texture of one plane.
const TEXTURE: &str = "texture_2d<f32>";

/// The type in WGSL of a texture that an argument takes.
fn texture_type(ty: &ArgType) -> &'static str {
    match ty {
        ArgType::Volume => "texture_3d<f32>",
        ArgType::Multisampled => "texture_multisampled_2d<f32>",
        _ => TEXTURE,
    }
}

/// A finite pixel, as the result of an operation that changes no number and that no compiler removes.
///
/// What sanitizes a pixel has branches. llvmpipe keeps a value that branches have made in memory, and its time to
/// compile grows with the square of the places that read it: minutes for a thousand lines of `sum += source`, and less
/// than a second for the same lines with the result of an operation.
fn computed(pixel: &str) -> String {
    format!("min({pixel}, vec4f(3.4028234e38))")
}

/// The place that a kernel has computed. Beyond the border it is moved to the middle of the last texel, where a tap
/// would read the same.
fn place(index: usize) -> String {
    format!(
        "    let uv{index} = clamp(kernel{index}.xy, 0.5 / at.size, 1.0 - 0.5 / at.size);
    let place{index} = Point(vec2i(uv{index} * at.size), uv{index}, at.size);
"
    )
}

/// Names and types of the arguments of a kernel.
fn types_of(kernel: &KernelCall) -> &[(String, ArgType)] {
    let reflection = kernel.shader.reflect().ok();
    reflection.and_then(|known| known.function(&kernel.function)).map_or(&[], |function| &function.args)
}

/// The type of a kernel's uniform.
fn params_type(kernel: &KernelCall) -> &str {
    let params = types_of(kernel).iter().find(|(name, _)| name == "params");
    match params {
        Some((_, ArgType::Struct(ty))) => ty,
        _ => panic!("a kernel with a uniform has an argument called `params`, which is a struct"),
    }
}
