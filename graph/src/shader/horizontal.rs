//! Horizontal fusion: modules that know nothing of each other side by side in one, whose workgroups are shared out among them.
//!
//! Each module keeps its own bindings, and its names get its number; files of the library, which have neither, stand there once. Which module
//! a workgroup works for depends on its number alone, so that all of its invocations meet the same barriers.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use naga::BuiltIn;

use super::Told;
use super::compose::{Composed, Slot, SlotKind, free, told_of_lanes};
use super::import::{Text, bound_from, change_words, declared, is_generated, is_library};

/// What a uniform begins at a multiple of, everywhere.
pub const UNIFORM_ALIGNMENT: u32 = 256;

/// A module and what it is to work for.
pub struct Beside<'a> {
    /// The module: a pass as it would run alone, without the time of the frame and without subgroups.
    pub composed: &'a Composed,
    /// Its override constants.
    pub constants: &'a [(&'static str, f64)],
}

impl Beside<'_> {
    /// How many of its workgroups one of so many invocations works off.
    pub fn packed(&self, lanes: u32) -> u32 {
        lanes / self.lanes()
    }

    fn lanes(&self) -> u32 {
        self.composed.workgroup.iter().product()
    }
}

/// Whether an entry point that is told this can stand beside others.
pub(crate) fn can_tell(told: &Told) -> bool {
    let is_known = |builtin: &BuiltIn| said(*builtin, [1; 3]).is_some();
    match told {
        Told::One(builtin) => is_known(builtin),
        Told::Struct(_, members) => members.iter().all(is_known),
    }
}

/// A built-in value of a module with such workgroups, in terms of the function that calls its entry point.
fn said(builtin: BuiltIn, [wide, high, deep]: [u32; 3]) -> Option<String> {
    match builtin {
        BuiltIn::WorkGroupId => Some("group".into()),
        BuiltIn::NumWorkGroups => Some("groups".into()),
        BuiltIn::LocalInvocationId => Some("local".into()),
        BuiltIn::LocalInvocationIndex => Some("lane".into()),
        BuiltIn::GlobalInvocationId => Some(format!("group * vec3u({wide}u, {high}u, {deep}u) + local")),
        _ => None,
    }
}

/// Modules of one features as one; those with taps read textures in one way. By turns, the workgroups of all modules go over an image that several of
/// them read at the same time. Where the invocations of a module wait for each other it must have the largest workgroup of all; the sizes of all
/// others divide it, and a workgroup does the work of several of theirs.
pub fn compose_beside(modules: &[Beside<'_>], by_turns: bool) -> Composed {
    let reading = modules.iter().map(|module| module.composed.reading).max().unwrap_or_default();
    let lanes = modules.iter().map(Beside::lanes).max().unwrap_or(1);
    let mut slots = Vec::new();
    let mut parts = Vec::new();
    for (number, module) in modules.iter().enumerate() {
        let part = Part::new(number, free(&slots), module);
        slots.extend(part.slots());
        parts.push(part);
    }
    let uniform = free(&slots);
    slots.push(Slot { binding: uniform, kind: SlotKind::Uniforms });
    let mut text = Text::default();
    // How to read textures is said where every module begins, and matters to those with taps. Files of the library are the same in all.
    let strictest = parts.iter().find(|part| part.module.composed.reading == reading);
    for line in strictest.into_iter().flat_map(Part::lines).filter(|line| line.is_common && is_generated(line.file)) {
        text.line(line.text, line.file, line.number);
    }
    let mut included = BTreeSet::new();
    for line in parts.iter().flat_map(Part::lines).filter(|line| is_library(line.file)) {
        if included.insert((line.file, line.number)) {
            text.line(line.text, line.file, line.number);
        }
    }
    for part in &parts {
        part.write(&mut text);
    }
    let mut entry = uniforms(&parts);
    let _ = writeln!(entry, "@group(0) @binding({uniform}) var<uniform> beside: Beside;");
    for part in &parts {
        entry += &part.caller(lanes);
    }
    entry += &dispatcher(&parts, lanes, by_turns);
    text.generated(&entry);
    Composed {
        source: text.text,
        map: text.map,
        compute: "compute",
        fragment: None,
        slots,
        workgroup: [lanes, 1, 1],
        told: told_of_lanes(),
        unchecked: modules.iter().all(|module| module.composed.unchecked),
        reading,
    }
}

/// A module on its way into the joined one.
struct Part<'a> {
    number: usize,
    /// The number of its first binding.
    first: u32,
    module: &'a Beside<'a>,
    names: BTreeSet<&'a str>,
    /// Its uniforms: what they hold, their names and their types.
    uniforms: Vec<(SlotKind, &'a str, &'a str)>,
}

/// A line of a module, and where it came from.
#[derive(Clone, Copy)]
struct Line<'a> {
    text: &'a str,
    file: &'static str,
    number: u32,
    /// Whether it means the same in all modules.
    is_common: bool,
}

impl<'a> Part<'a> {
    fn new(number: usize, first: u32, module: &'a Beside<'a>) -> Self {
        let mut part = Self { number, first, module, names: BTreeSet::new(), uniforms: Vec::new() };
        let own: Vec<Line<'a>> = part.lines().filter(|line| !line.is_common).collect();
        part.names = own.iter().flat_map(|line| declared(line.text)).collect();
        for (binding, name, ty) in own.iter().filter_map(|line| bound(line.text)) {
            part.names.insert(name);
            let kind = module.composed.slots.iter().find(|slot| slot.binding == binding).map(|slot| slot.kind);
            if let Some(kind @ (SlotKind::Params | SlotKind::Extent)) = kind {
                part.uniforms.push((kind, name, ty));
            }
        }
        part
    }

    /// Its slots but those of its uniforms, which are parts of the one of all modules.
    fn slots(&self) -> impl Iterator<Item = Slot> {
        let own = self.module.composed.slots.iter();
        let own = own.filter(|slot| !matches!(slot.kind, SlotKind::Params | SlotKind::Extent));
        own.map(|slot| Slot { binding: self.first + slot.binding, kind: slot.kind })
    }

    fn lines(&self) -> impl Iterator<Item = Line<'a>> {
        let composed = self.module.composed;
        let mut is_beginning = true;
        composed.source.lines().zip(composed.map.lines()).map(move |(text, (file, number))| {
            is_beginning &= is_generated(file);
            Line { text, file, number, is_common: is_beginning || is_library(file) }
        })
    }

    fn named(&self, name: &str) -> String {
        format!("{name}_{}", self.number)
    }

    /// Adds its own lines, as they stand beside those of others.
    fn write(&self, text: &mut Text) {
        let mut in_struct = false;
        for line in self.lines().filter(|line| !line.is_common) {
            // Entry points for draws end a module.
            if line.text == "@vertex" {
                break;
            }
            let is_member = in_struct && !line.text.starts_with('}');
            in_struct = is_member || line.text.starts_with("struct ") && !line.text.contains('}');
            let changed = match line.text.split_once(':') {
                // The names of members are nobody else's.
                Some((name, ty)) if is_member => format!("{name}:{}", self.renamed(ty)),
                _ if line.text.starts_with("@compute") || self.is_uniform(line.text) => String::new(),
                _ if line.text.starts_with("override ") => self.constant(line.text),
                _ => bound_from(&self.renamed(&without_builtins(line.text)), self.first),
            };
            text.line(&changed, line.file, line.number);
        }
    }

    fn is_uniform(&self, line: &str) -> bool {
        bound(line).is_some_and(|(_, name, _)| self.uniforms.iter().any(|(_, known, _)| *known == name))
    }

    fn renamed(&self, line: &str) -> String {
        change_words(line, |word| {
            let uniform = self.uniforms.iter().find(|(_, name, _)| *name == word);
            match uniform {
                Some((SlotKind::Params, ..)) => Some(format!("beside.params_{}", self.number)),
                Some(_) => Some(format!("beside.result_{}.size", self.number)),
                None => self.names.contains(word).then(|| self.named(word)),
            }
        })
    }

    /// An override constant with the value that holds here.
    fn constant(&self, line: &str) -> String {
        let declaration = line.split("//").next().unwrap_or(line).trim_start_matches("override ");
        let (name, rest) = declaration.split_once(':').unwrap_or((declaration, ""));
        let (ty, default) = rest.split_once('=').unwrap_or((rest.trim_end_matches([';', ' ']), ""));
        let given = self.module.constants.iter().find(|(known, _)| *known == name.trim());
        let value = match (given, ty.trim()) {
            (None, _) => default.trim().trim_end_matches(';').to_owned(),
            (Some((_, value)), "bool") => (*value != 0.0).to_string(),
            (Some((_, value)), ty) => format!("{ty}({value})"),
        };
        format!("const {}: {} = {value};", self.named(name.trim()), ty.trim())
    }

    /// A function that does what a workgroup of the module does, or what several do.
    fn caller(&self, lanes: u32) -> String {
        let composed = self.module.composed;
        let values: Vec<String> = composed.told.iter().map(|told| self.value(told)).collect();
        let [wide, high, deep] = composed.workgroup;
        let (number, own) = (self.number, wide * high * deep);
        let packed = self.module.packed(lanes);
        let mut text = format!(
            "fn beside_count_{number}() -> u32 {{
    let groups = beside.result_{number}.groups;
    return (groups.x * groups.y * groups.z + {}u) / {packed}u;
}}
fn beside_{number}(at: u32, invocation: u32) {{
    let groups = beside.result_{number}.groups;
",
            packed - 1,
        );
        let picked = match packed {
            1 => "    let number = at;\n    let lane = invocation;\n".to_owned(),
            _ => format!(
                "    let number = at * {packed}u + invocation / {own}u;
    let lane = invocation % {own}u;
    if number >= groups.x * groups.y * groups.z {{ return; }}
"
            ),
        };
        text += &picked;
        let _ = writeln!(
            text,
            "    let group = vec3u(number % groups.x, number / groups.x % groups.y, number / (groups.x * groups.y));
    let local = vec3u(lane % {wide}u, lane / {wide}u % {high}u, lane / {}u);
    {}({});
}}",
            wide * high,
            self.named(composed.compute),
            values.join(", "),
        );
        text
    }

    /// What the entry point is told, in terms of the function that calls it.
    fn value(&self, told: &Told) -> String {
        match told {
            Told::One(builtin) => self.builtin(*builtin),
            Told::Struct(name, members) => {
                let values: Vec<String> = members.iter().map(|builtin| self.builtin(*builtin)).collect();
                let name = if self.names.contains(name.as_str()) { self.named(name) } else { name.clone() };
                format!("{name}({})", values.join(", "))
            }
        }
    }

    fn builtin(&self, builtin: BuiltIn) -> String {
        said(builtin, self.module.composed.workgroup).expect("no module is joined that asks for more")
    }
}

/// The uniform of all modules: of each its numbers, if it has any, the size of its result and its workgroups, as the buffer of all passes has them.
///
/// One uniform and not several, because Mesa 22's lavapipe falls over branches that depend on numbers of more than one.
fn uniforms(parts: &[Part<'_>]) -> String {
    let mut text = String::from("struct BesideResult { size: vec2f, groups: vec3u }\nstruct Beside {\n");
    for part in parts {
        let params = part.uniforms.iter().find(|(kind, ..)| *kind == SlotKind::Params);
        if let Some((_, _, ty)) = params {
            let _ = writeln!(text, "    @align({UNIFORM_ALIGNMENT}) params_{}: {},", part.number, part.named(ty));
        }
        let _ = writeln!(text, "    @align({UNIFORM_ALIGNMENT}) result_{}: BesideResult,", part.number);
    }
    text + "}\n"
}

/// The number, the name and the type of the variable that a line binds.
fn bound(line: &str) -> Option<(u32, &str, &str)> {
    let (binding, rest) = line.strip_prefix("@group")?.split_once("@binding(")?.1.split_once(')')?;
    let (_, rest) = rest.split_once("var")?;
    let rest = rest.strip_prefix('<').and_then(|rest| rest.split_once('>')).map_or(rest, |(_, rest)| rest);
    let (name, ty) = rest.split_once(':')?;
    Some((binding.trim().parse().ok()?, name.trim(), ty.split(';').next().unwrap_or(ty).trim()))
}

/// The line of an entry point's head as that of a function.
fn without_builtins(line: &str) -> String {
    let mut text = String::with_capacity(line.len());
    let mut rest = line;
    while let Some((before, after)) = rest.split_once("@builtin(") {
        text += before;
        rest = after.split_once(')').map_or("", |(_, rest)| rest.trim_start());
    }
    text + rest
}

/// The entry point: the workgroups of the last module come first, or those of all by turns.
fn dispatcher(parts: &[Part<'_>], lanes: u32, by_turns: bool) -> String {
    let all = parts.len();
    let counts: String =
        parts.iter().map(|part| format!("    let count{0} = beside_count_{0}();\n", part.number)).collect();
    let sum: Vec<String> = parts.iter().map(|part| format!("count{}", part.number)).collect();
    let mut text = format!(
        "@compute @workgroup_size({lanes})
fn compute(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) invocation: u32) {{
{counts}    let at{all} = group.x;
    let all{all} = {};
",
        sum.join(" + "),
    );
    for part in parts.iter().skip(1).rev() {
        let (number, rest) = (part.number, part.number + 1);
        text += &if by_turns {
            format!(
                "    let before{number} = at{rest} * count{number} / all{rest};
    if (at{rest} + 1u) * count{number} / all{rest} > before{number} {{
        beside_{number}(before{number}, invocation);
        return;
    }}
    let at{number} = at{rest} - before{number};
    let all{number} = all{rest} - count{number};
"
            )
        } else {
            format!(
                "    if at{rest} < count{number} {{
        beside_{number}(at{rest}, invocation);
        return;
    }}
    let at{number} = at{rest} - count{number};
"
            )
        };
    }
    text + "    beside_0(at1, invocation);\n}"
}

#[cfg(test)]
mod tests {
    use super::{Beside, compose_beside};
    use crate::image::{ImageDesc, Size};
    use crate::node::{Binding, BufferId, EntryCall, Pass, Resource, Work};
    use crate::shader::{ShaderFeatures, SampleMode, Shader, compose_pass};

    /// A member called like a binding, a head of several lines, a struct of what is told, constants with and without a value, a name of the library.
    static TRICKY: Shader = Shader::new(
        "tricky.wgsl",
        "#import color
struct Tricky {
    tiles: f32, // of all: bright ones
    lo: f32,
}
override TRICKY_ON: bool = false;
override TRICKY_SHARE: f32 = 0.25;
override TRICKY_ROWS: u32 = 4u; // of a tile
struct TrickyTold {
    @builtin(local_invocation_index) index: u32,
}
@group(0) @binding(0) var<uniform> params: Tricky;
@group(0) @binding(1) var<storage, read_write> tiles: array<vec4f>;
var<workgroup> tricky_sums: array<f32, 64>;
fn tricky_light(tiles_of: vec3f) -> f32 { return luminance(tiles_of) * params.tiles; }
@compute @workgroup_size(64)
fn tricky(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    told: TrickyTold,
) {
    tricky_sums[told.index] = select(params.lo, tricky_light(tiles[0].rgb), TRICKY_ON);
    workgroupBarrier();
    if told.index < TRICKY_ROWS { tiles[group.y * groups.x + group.x].x = TRICKY_SHARE * tricky_sums[told.index]; }
}",
    );

    fn pass() -> Pass {
        let resource = Resource::Buffer(BufferId(0));
        let call = EntryCall {
            shader: &TRICKY,
            entry: "tricky",
            bindings: vec![Binding { name: "tiles".into(), resource, writes: true, reads: true }],
            constants: vec![("TRICKY_ON", 1.0), ("TRICKY_SHARE", 0.5)],
            uniform: vec![0; 8],
            groups: [3, 2, 1],
            by_cells: None,
        };
        Pass { nodes: vec!["a".into()], label: "tricky".into(), work: Work::Entry(call) }
    }

    #[test]
    fn names_members_and_constants_survive_beside_themselves() {
        let desc = |_| ImageDesc::new(Size::new(1, 1));
        let pass = pass();
        let Work::Entry(call) = &pass.work else { unreachable!("it was made so") };
        let composed = compose_pass(&pass, &desc, &|_| SampleMode::Plain, ShaderFeatures::default());
        let composed = composed.unwrap_or_else(|error| panic!("{error}"));
        let twice = [(); 2].map(|()| Beside { composed: &composed, constants: &call.constants });
        for by_turns in [false, true] {
            let joined = compose_beside(&twice, by_turns);
            joined.validate().unwrap_or_else(|error| panic!("{error}\n{}", joined.source));
            for (text, times) in [
                ("const TRICKY_ON_0: bool = true;", 1),
                ("const TRICKY_SHARE_1: f32 = f32(0.5);", 1),
                ("const TRICKY_ROWS_1: u32 = 4u;", 1),
                ("    tiles: f32,", 2),
                ("fn luminance(", 1),
                ("tricky_1(group, groups, TrickyTold_1(lane))", 1),
                ("beside.params_0.tiles", 1),
            ] {
                assert_eq!(joined.source.matches(text).count(), times, "{text}\n{}", joined.source);
            }
            assert_eq!(joined.slots.len(), 3, "two buffers and the one uniform");
            let line = joined.source.lines().position(|line| line.contains("fn tricky_light_1")).expect("it is there");
            assert_eq!(joined.map.locate(line as u32 + 1), ("tricky.wgsl", 15), "errors are told at the author's line");
        }
    }
}
