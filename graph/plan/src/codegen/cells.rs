//! The entry point of kernels that sum up one image by cells: each pixel is loaded once and shown to all of them.
//!
//! The modules stand side by side in one, so that every name of theirs gets the reader's number, and every binding a number of its own.

use afterimage_base::Shared;
use std::collections::BTreeSet;

use super::compose::{Bound, Composed, Slot, SlotKind, free, set_storage_format};
use afterimage_base::image::Format;
use afterimage_graph::node::{Cells, CellsReader, ImageId};
use afterimage_wgsl::{
    GlobalKind, Reflection, SampleMode, ShaderError, ShaderFeatures, Text, bound_from, change_words, declared,
};

/// The most invocations of a workgroup.
pub const CELLS_LANES: u32 = 256;

/// Kernels in their form by cells, with their entry point.
pub(crate) fn compose_cells(
    cells: &Cells,
    format_of: &dyn Fn(ImageId) -> Format,
    sample_mode_of: &dyn Fn(ImageId) -> SampleMode,
    features: ShaderFeatures,
) -> Result<Composed, ShaderError> {
    let mut slots: Vec<Slot> = Vec::new();
    let mut parts = Vec::new();
    for (number, reader) in cells.readers.iter().enumerate() {
        let part = Part::new(number, free(&slots), reader, format_of, sample_mode_of)?;
        slots.extend(part.slots());
        parts.push(part);
    }
    let reading = parts.iter().map(|part| part.bound.reading).max().unwrap_or_default();
    let mut text = Text::default().reading(reading, features)?;
    for file in ["cells", "stride"] {
        text.library(file).expect("the library has this file")?;
    }
    for part in &parts {
        text.changed_module(&part.reader.call.shader, &|line| part.line(line))?;
    }
    if parts.iter().any(|part| part.frame().is_some()) {
        let binding = add(&mut slots, SlotKind::Frame);
        text.generated(&format!("@group(0) @binding({binding}) var<uniform> cells_frame: Frame;"));
    }
    if let Some(structs) = uniform(&parts) {
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
        unchecked: cells.readers.iter().all(|reader| reader.call.shader.is_unchecked()),
        reading,
    })
}

/// Another slot, by its binding.
fn add(slots: &mut Vec<Slot>, kind: SlotKind) -> u32 {
    let binding = free(slots);
    slots.push(Slot { binding, kind });
    binding
}

/// A reader's module on its way into the joined one.
struct Part<'a> {
    number: usize,
    reader: &'a CellsReader,
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
        reader: &'a CellsReader,
        format_of: &dyn Fn(ImageId) -> Format,
        sample_mode_of: &dyn Fn(ImageId) -> SampleMode,
    ) -> Result<Self, ShaderError> {
        let shader = &reader.call.shader;
        let reflection = shader.reflect()?;
        let bound = Bound::new(&reader.call, format_of, sample_mode_of)?;
        let globals = reflection.globals.iter().map(|global| global.name.as_str());
        let names = declared(shader.source()).chain(globals).collect();
        Ok(Self { number, reader, reflection, bound, first, names })
    }

    /// Its slots but those of its uniforms: all readers share the frame's and have parts of the pass's.
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
                return Some(format!("cells_params.reader{}", self.number));
            }
            if frame == Some(word) {
                return Some("cells_frame".into());
            }
            self.names.contains(word).then(|| self.named(word))
        })
    }
}

/// The struct of the pass's uniform, if any reader has one.
fn uniform(parts: &[Part<'_>]) -> Option<String> {
    let member = |part: &Part<'_>| {
        let (_, ty) = part.params()?;
        Some(format!("    @align(16) reader{}: {},\n", part.number, part.named(ty)))
    };
    let members: String = parts.iter().filter_map(member).collect();
    (!members.is_empty()).then(|| format!("struct PassUniform {{\n{members}}}"))
}

fn entry(cells: &Cells, parts: &[Part<'_>]) -> String {
    let Cells { finest, coarsest, lanes: [across, down], step, .. } = *cells;
    let inner = [finest[0] / coarsest[0], finest[1] / coarsest[1]];
    let source = parts[0].named(parts[0].reader.by.source);
    let every = |line: &dyn Fn(&Part<'_>) -> String| parts.iter().map(line).collect::<String>();
    let begins = every(&|part| begin(part, cells, inner));
    let finishes = every(&|part| {
        let (number, finish) = (part.number, part.named(&format!("{}_finish", part.reader.by.form)));
        format!("    {finish}(&state{number}, cell{number});\n")
    });
    let visits = every(&|part| {
        let (number, visit) = (part.number, part.named(&format!("{}_visit", part.reader.by.form)));
        format!("            {visit}(&state{number}, cell{number}, seen);\n")
    });
    // A picture of which every pixel is looked at needs no clamp.
    let picked = match step {
        1 => "vec2i(pixel)".to_owned(),
        _ => format!("stride_pixel(pixel, whole, {step}u)"),
    };
    // To load several pixels before the first is looked at made it slower on an H200: the other invocations hide the waiting.
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

/// A reader's cell and state, from the cell of the finest lattice and the lane in it.
fn begin(part: &Part<'_>, cells: &Cells, inner: [u32; 2]) -> String {
    let (number, by) = (part.number, part.reader.by);
    let [wide, high] = [0, 1].map(|axis| cells.finest[axis] / by.cells[axis]);
    let own = cells.lanes[0] * cells.lanes[1];
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
