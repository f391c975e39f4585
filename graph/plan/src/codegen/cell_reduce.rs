//! The entry point of kernels that reduce one image by cells: each pixel is loaded once and given to all of them.

use afterimage_graph::node::{ByCells, CellReduce, KernelCall};
use afterimage_wgsl::{GlobalKind, Instance, Linker, ShaderError};

use super::compute::bind;
use super::module::{Composed, Entry, PassCode, Slot, SlotKind};
use super::uniforms::uniform_struct;

/// Kernels in their form by cells, with their entry point.
pub(super) fn compose_cell_reduce(code: &PassCode<'_>, reduce: &CellReduce) -> Result<Composed, ShaderError> {
    let mut linker = code.linker();
    let mut slots: Vec<Slot> = Vec::new();
    let mut readers = Vec::new();
    for (number, kernel) in code.pass.kernels.iter().enumerate() {
        readers.push(Reader::new(code, number, kernel, &mut linker, &mut slots)?);
    }
    let mut text = String::from("#import cells\n#import stride\n");
    let uses = |found: &dyn Fn(&GlobalKind) -> bool| readers.iter().any(|reader| reader.uniform(found).is_some());
    let immediate = uses(&is_frame) && code.options.immediates;
    if immediate {
        text += "var<immediate> cells_frame: Frame;\n";
    } else if uses(&is_frame) {
        let binding = add(&mut slots, SlotKind::Frame);
        text += &format!("@group(0) @binding({binding}) var<uniform> cells_frame: Frame;\n");
    }
    let structs = uniform_struct(code.pass, &|index| readers[index].params_type(&linker));
    if !structs.is_empty() {
        let binding = add(&mut slots, SlotKind::Params);
        text += &structs;
        text += &format!("@group(0) @binding({binding}) var<uniform> cells_params: PassUniform;\n");
    }
    text += &entry_point(reduce, &readers, &linker);
    let entry = Entry { slots, immediate, workgroup: [reduce.workgroup(), 1, 1], names: &["compute"] };
    code.compose(linker, text, entry)
}

fn is_frame(kind: &GlobalKind) -> bool {
    *kind == GlobalKind::Frame
}

fn is_params(kind: &GlobalKind) -> bool {
    matches!(kind, GlobalKind::Uniform(_))
}

/// Adds a slot; its binding.
fn add(slots: &mut Vec<Slot>, kind: SlotKind) -> u32 {
    let binding = slots.iter().map(|slot| slot.binding + 1).max().unwrap_or(0);
    slots.push(Slot { binding, kind });
    binding
}

/// A kernel in the module.
struct Reader<'a> {
    number: usize,
    kernel: &'a KernelCall,
    form: &'a ByCells,
    instance: Instance,
}

impl<'a> Reader<'a> {
    /// Adds the kernel's file with bindings that no other kernel has. All kernels share the frame's uniform, and each
    /// has a part of the pass's.
    fn new(
        code: &PassCode<'a>,
        number: usize,
        kernel: &'a KernelCall,
        linker: &mut Linker<'a>,
        slots: &mut Vec<Slot>,
    ) -> Result<Self, ShaderError> {
        let instance = linker.add_copy(kernel.shader.source())?;
        let form = kernel.by_cells.as_ref().expect("a kernel of a reduction has its form by cells");
        let globals = &kernel.shader.reflect()?.globals;
        for slot in bind(code, kernel, linker, instance)? {
            let global = globals.iter().find(|global| global.binding == slot.binding).expect("a slot has its variable");
            match slot.kind {
                SlotKind::Params => linker.replace(instance, &global.name, "cells_params", &format!(".kernel{number}")),
                SlotKind::Frame => linker.replace(instance, &global.name, "cells_frame", ""),
                kind => {
                    let binding = add(slots, kind);
                    linker.bind(instance, &global.name, 0, binding);
                }
            }
        }
        Ok(Self { number, kernel, form, instance })
    }

    /// The type of its first uniform of that kind.
    fn uniform(&self, found: &dyn Fn(&GlobalKind) -> bool) -> Option<&'a GlobalKind> {
        let reflection = self.kernel.shader.reflect().ok()?;
        let own = reflection.globals.iter().filter(|global| self.kernel.arg(&global.name).is_none());
        own.map(|global| &global.kind).find(|kind| found(kind))
    }

    /// The type of its uniform.
    fn params_type(&self, linker: &Linker<'_>) -> String {
        match self.uniform(&is_params) {
            Some(GlobalKind::Uniform(ty)) => linker.name(self.instance, ty),
            _ => panic!("a kernel with numbers has a uniform for them"),
        }
    }

    /// One of its three functions.
    fn function(&self, linker: &Linker<'_>, what: &str) -> String {
        linker.name(self.instance, &format!("{}_{what}", self.form.form))
    }

    /// A call of one of the two functions that take the cell and its state.
    fn call(&self, linker: &Linker<'_>, what: &str, rest: &str) -> String {
        let number = self.number;
        format!("{}(&state{number}, cell{number}{rest})", self.function(linker, what))
    }

    /// Its cell and its state, from the cell of the finest lattice and the invocation in it.
    fn begin(&self, linker: &Linker<'_>, reduce: &CellReduce) -> String {
        let (number, inner) = (self.number, reduce.inner());
        let [wide, high] = [0, 1].map(|axis| reduce.finest[axis] / self.form.cells[axis]);
        let own = reduce.invocations[0] * reduce.invocations[1];
        format!(
            "    let cell{number} = Cell(
        place / vec2u({wide}u, {high}u),
        (inner.y % {high}u * {wide}u + inner.x % {wide}u) * {own}u + within,
        {}u,
        inner.y / {high}u * {}u + inner.x / {wide}u,
    );
    var state{number} = {}(cell{number});
",
            wide * high * own,
            inner[0] / wide,
            self.function(linker, "begin"),
        )
    }
}

fn entry_point(reduce: &CellReduce, readers: &[Reader<'_>], linker: &Linker<'_>) -> String {
    let CellReduce { finest, invocations: [across, down], stride, .. } = *reduce;
    let (source, inner) = (linker.name(readers[0].instance, readers[0].form.source), reduce.inner());
    let every = |line: &dyn Fn(&Reader<'_>) -> String| readers.iter().map(line).collect::<String>();
    let begins = every(&|reader| reader.begin(linker, reduce));
    let visits = every(&|reader| format!("            {};\n", reader.call(linker, "visit", ", seen")));
    let finishes = every(&|reader| format!("    {};\n", reader.call(linker, "finish", "")));
    let picked = match stride {
        1 => "vec2i(pixel)".to_owned(),
        _ => format!("stride_pixel(pixel, whole, {stride}u)"),
    };
    format!(
        "fn cells_texel(pixel: vec2i) -> vec4f {{ return texel_inside({source}, pixel); }}
@compute @workgroup_size({workgroup})
fn compute(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) invocation: u32) {{
    let whole = textureDimensions({source});
    let size = stride_size(whole, {stride}u);
    let lattice = vec2u({finest});
    let number = invocation / {own}u;
    let within = invocation % {own}u;
    let inner = vec2u(number % {columns}u, number / {columns}u);
    let place = group.xy * vec2u({inner}) + inner;
{WALK}{begins}    workgroupBarrier();
    for (var x = first.x + within % {across}u; x < end.x; x += {across}u) {{
        for (var y = first.y + within / {across}u; y < end.y; y += {down}u) {{
            let pixel = vec2u(x, y);
            let share = cell_share(pixel, place, size, lattice);
            let is_centered = all(pixel >= centered) && all(pixel < beyond);
            let picked = {picked};
            let seen = Seen(picked, cells_texel(picked), share.x * share.y, is_centered);
{visits}        }}
    }}
{finishes}}}",
        workgroup = reduce.workgroup(),
        own = across * down,
        columns = inner[0],
        finest = pair(finest),
        inner = pair(inner),
    )
}

/// The pixels of the invocation's cell.
const WALK: &str = "    let first = place * size / lattice;
    let end = ((place + 1u) * size + lattice - 1u) / lattice;
    let centered = cell_first(place, size, lattice);
    let beyond = cell_first(place + 1u, size, lattice);
";

fn pair([across, down]: [u32; 2]) -> String {
    format!("{across}u, {down}u")
}
