//! The entry point of kernels that reduce one image by cells: each pixel is loaded once for all of them.
//!
//! The modules become one, in which every name of theirs gets the kernel's number, and every binding a number of its own.

use std::collections::BTreeSet;

use super::compute::{Bound, set_storage_format};
use super::module::{Composed, Slot, SlotKind, free};
use super::uniforms::uniform_struct;
use afterimage_base::Shared;
use afterimage_base::image::Format;
use afterimage_graph::node::{ByCells, CellReduce, ImageId, KernelCall, Pass};
use afterimage_wgsl::{
    GlobalKind, Reflection, SampleMode, Shader, ShaderError, ShaderFeatures, Text, bound_from, change_words, declared,
};

/// Kernels in their form by cells, with their entry point.
pub(super) fn compose_cell_reduce(
    pass: &Pass,
    cells: &CellReduce,
    format_of: &dyn Fn(ImageId) -> Format,
    sample_mode_of: &dyn Fn(ImageId) -> SampleMode,
    features: ShaderFeatures,
) -> Result<Composed, ShaderError> {
    let mut slots: Vec<Slot> = Vec::new();
    let mut parts = Vec::new();
    for (number, kernel) in pass.kernels.iter().enumerate() {
        let part = Part::new(number, free(&slots), kernel, format_of, sample_mode_of)?;
        slots.extend(part.slots());
        parts.push(part);
    }
    let reading = parts.iter().map(|part| part.bound.reading).max().unwrap_or_default();
    let mut text = Text::default().reading(reading, features)?;
    for file in ["cells", "stride"] {
        text.library(file).expect("the library has this file")?;
    }
    for part in &parts {
        text.changed_module(&part.kernel.shader, &|line| part.line(line))?;
    }
    if parts.iter().any(|part| part.frame().is_some()) {
        let binding = add(&mut slots, SlotKind::Frame);
        text.generated(&format!("@group(0) @binding({binding}) var<uniform> cells_frame: Frame;"));
    }
    let structs = uniform_struct(pass, &|at| parts[at].params_type());
    if !structs.is_empty() {
        let binding = add(&mut slots, SlotKind::Params);
        text.generated(&structs);
        text.generated(&format!("@group(0) @binding({binding}) var<uniform> cells_params: PassUniform;"));
    }
    text.generated(&entry(cells, &parts));
    Ok(Composed {
        source: text.text,
        map: text.map,
        compute: Shared::of("compute"),
        fragment: None,
        slots,
        workgroup: [cells.workgroup(), 1, 1],
        unchecked: pass.shaders().all(Shader::is_unchecked),
        reading,
        zero_workgroup_memory: !pass.shaders().all(Shader::is_unchecked),
    })
}

/// Another slot, by its binding.
fn add(slots: &mut Vec<Slot>, kind: SlotKind) -> u32 {
    let binding = free(slots);
    slots.push(Slot { binding, kind });
    binding
}

/// The module of a kernel as a part of the joined one.
struct Part<'a> {
    number: usize,
    kernel: &'a KernelCall,
    by: ByCells,
    reflection: &'a Reflection,
    bound: Bound,
    /// The number of its first binding.
    first: u32,
    names: BTreeSet<&'a str>,
}

impl<'a> Part<'a> {
    fn new(
        number: usize,
        first: u32,
        kernel: &'a KernelCall,
        format_of: &dyn Fn(ImageId) -> Format,
        sample_mode_of: &dyn Fn(ImageId) -> SampleMode,
    ) -> Result<Self, ShaderError> {
        let shader = &kernel.shader;
        let by = kernel.by_cells.expect("a kernel of a reduction has a form by cells");
        let reflection = shader.reflect()?;
        let bound = Bound::new(kernel, format_of, sample_mode_of)?;
        let globals = reflection.globals.iter().map(|global| global.name.as_str());
        let names = declared(shader.source()).chain(globals).collect();
        Ok(Self { number, kernel, by, reflection, bound, first, names })
    }

    /// Its slots but those of its uniforms: all kernels share the frame's and have parts of the pass's.
    fn slots(&self) -> impl Iterator<Item = Slot> {
        let own = self.bound.slots.iter().filter(|slot| !matches!(slot.kind, SlotKind::Params | SlotKind::Frame));
        own.map(|slot| Slot { binding: self.first + slot.binding, kind: slot.kind })
    }

    /// The names of its uniforms and of their types.
    fn uniforms(&self) -> impl Iterator<Item = (&'a str, &'a str)> {
        self.reflection.globals.iter().filter_map(|global| match &global.kind {
            GlobalKind::Uniform(ty) => Some((global.name.as_str(), ty.as_str())),
            _ => None,
        })
    }

    /// The name of its own uniform and of the uniform's type.
    fn params(&self) -> Option<(&'a str, &'a str)> {
        self.uniforms().find(|(_, ty)| *ty != "Frame")
    }

    /// The type of its own uniform in the joined module.
    fn params_type(&self) -> String {
        let (_, ty) = self.params().expect("a kernel with numbers has a uniform for them");
        self.named(ty)
    }

    /// The name of the uniform with the frame's time.
    fn frame(&self) -> Option<&'a str> {
        self.uniforms().find(|(_, ty)| *ty == "Frame").map(|(name, _)| name)
    }

    fn named(&self, name: &str) -> String {
        format!("{name}_{}", self.number)
    }

    /// A line of the module as it stands in the joined one.
    fn line(&self, line: &str) -> String {
        if line.contains("@binding(") && self.uniforms().any(|(name, _)| line.contains(&format!(" {name}:"))) {
            return String::new();
        }
        let (params, frame) = (self.params().map(|(name, _)| name), self.frame());
        let formats = self.bound.formats.iter();
        let line =
            formats.fold(bound_from(line, self.first), |line, (name, format)| set_storage_format(&line, name, *format));
        change_words(&line, |word| {
            if params == Some(word) {
                return Some(format!("cells_params.kernel{}", self.number));
            }
            if frame == Some(word) {
                return Some("cells_frame".into());
            }
            self.names.contains(word).then(|| self.named(word))
        })
    }
}

fn entry(cells: &CellReduce, parts: &[Part<'_>]) -> String {
    let CellReduce { finest, invocations: [across, down], stride: step, .. } = *cells;
    let inner = cells.inner();
    let source = parts[0].named(parts[0].by.source);
    let every = |line: &dyn Fn(&Part<'_>) -> String| parts.iter().map(line).collect::<String>();
    let begins = every(&|part| begin(part, cells, inner));
    let finishes = every(&|part| {
        let (number, finish) = (part.number, part.named(&format!("{}_finish", part.by.form)));
        format!("    {finish}(&state{number}, cell{number});\n")
    });
    let visits = every(&|part| {
        let (number, visit) = (part.number, part.named(&format!("{}_visit", part.by.form)));
        format!("            {visit}(&state{number}, cell{number}, seen);\n")
    });
    // An image of which every pixel is read needs no clamp.
    let picked = match step {
        1 => "vec2i(pixel)".to_owned(),
        _ => format!("stride_pixel(pixel, whole, {step}u)"),
    };
    // To load several pixels before the first is used made it slower on an H200: the other invocations hide the latency.
    format!(
        "fn cells_texel(pixel: vec2i) -> vec4f {{ return sanitized(textureLoad({source}, pixel, 0)); }}
@compute @workgroup_size({})
fn compute(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) invocation: u32) {{
    let whole = textureDimensions({source});
    let size = stride_size(whole, {step}u);
    let lattice = vec2u({}u, {}u);
    let number = invocation / {own}u;
    let lane = invocation % {own}u;
    let inner = vec2u(number % {}u, number / {}u);
    let place = group.xy * vec2u({}u, {}u) + inner;
    let first = place * size / lattice;
    let end = ((place + 1u) * size + lattice - 1u) / lattice;
    let centred = cell_first(place, size, lattice);
    let beyond = cell_first(place + 1u, size, lattice);
{begins}    workgroupBarrier();
    for (var x = first.x + lane % {across}u; x < end.x; x += {across}u) {{
        for (var y = first.y + lane / {across}u; y < end.y; y += {down}u) {{
            let pixel = vec2u(x, y);
            let share = cell_share(pixel, place, size, lattice);
            let is_centred = all(pixel >= centred) && all(pixel < beyond);
            let picked = {picked};
            let seen = Seen(picked, cells_texel(picked), share.x * share.y, is_centred);
{visits}        }}
    }}
{finishes}}}",
        cells.workgroup(),
        finest[0],
        finest[1],
        inner[0],
        inner[0],
        inner[0],
        inner[1],
        own = across * down,
    )
}

/// A kernel's cell and state, from the cell of the finest lattice and the invocation in it.
fn begin(part: &Part<'_>, cells: &CellReduce, inner: [u32; 2]) -> String {
    let (number, by) = (part.number, part.by);
    let [wide, high] = [0, 1].map(|axis| cells.finest[axis] / by.cells[axis]);
    let own = cells.invocations[0] * cells.invocations[1];
    format!(
        "    let cell{number} = Cell(
        place / vec2u({wide}u, {high}u),
        (inner.y % {high}u * {wide}u + inner.x % {wide}u) * {own}u + lane,
        {}u,
        inner.y / {high}u * {}u + inner.x / {wide}u,
    );
    var state{number} = {}(cell{number});
",
        wide * high * own,
        inner[0] / wide,
        part.named(&format!("{}_begin", by.form)),
    )
}
