//! Modules that see rows of images. Of an image that is too large for a device, textures hold a band of rows, and a
//! dispatch makes some rows of workgroups. The module computes with the positions and sizes of the whole image all the
//! same: only where it reads, stores or measures a texture, the first row of the band is subtracted. So each number is
//! the one that a dispatch over the whole image would make.
//!
//! No kernel states how far it reads. A read beyond the rows that a texture holds is counted, and the host makes the
//! band again with more of them.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

use crate::token::{Token, TokenKind, tokens};

/// Module of a pass in bands.
pub struct BandedModule<'a> {
    /// The name of its compute entry point.
    pub entry: &'a str,
    /// Width and height of the images of which textures hold a band. Images of the same size have the same band.
    pub sizes: &'a [[u32; 2]],
    /// The bindings of storage textures that hold a band, with the place of their size.
    pub stored: &'a [(u32, usize)],
    /// Workgroups of the dispatch over the whole image.
    pub workgroups: [u32; 3],
    /// Invocations of a workgroup, down.
    pub rows: u32,
    /// The place of its first counter. There are two for each size: how many rows above the band were read, and below.
    pub first_counter: usize,
}

/// The module with two more bindings in group 1: a uniform with the first row of workgroups, zeros and, for each size,
/// the first row of the band, the rows that hold texels from the first to behind the last, and the rows of the texture,
/// all as `i32` in vectors of four; and the counters.
///
/// # Errors
/// What the text does that cannot be done in bands, as the end of a sentence about it.
pub fn banded(source: &str, module: &BandedModule<'_>) -> Result<String, String> {
    let tokens = tokens(source).map_err(|_| "has a comment without an end".to_owned())?;
    let mut rewriter = Rewriter { source, tokens: &tokens, module, edits: Vec::new() };
    let stores = rewriter.module()?;
    let mut text = String::with_capacity(source.len() + 4096);
    let mut end = 0;
    rewriter.edits.sort_by_key(|(place, ..)| *place);
    for (start, after, new) in &rewriter.edits {
        text += &source[end..*start];
        text += new;
        end = *after;
    }
    text += &source[end..];
    text += &access(module);
    text += &stores;
    Ok(text)
}

/// Built-in arguments that count workgroups.
const COUNTING: [&str; 3] = ["workgroup_id", "global_invocation_id", "num_workgroups"];

struct Rewriter<'a> {
    source: &'a str,
    tokens: &'a [Token],
    module: &'a BandedModule<'a>,
    /// Replacement of the text in a range of bytes.
    edits: Vec<(usize, usize, String)>,
}

/// A variable or an argument that may be a texture.
#[derive(Clone, Copy)]
struct Declared<'a> {
    ty: &'a str,
    binding: Option<u32>,
}

impl<'a> Rewriter<'a> {
    fn text(&self, index: usize) -> &'a str {
        self.tokens.get(index).map_or("", |token| token.of(self.source))
    }

    /// The token behind the bracket that closes the one at `index`.
    fn behind(&self, index: usize) -> usize {
        let mut depth = 0_u32;
        for at in index..self.tokens.len() {
            match self.text(at) {
                "(" | "{" | "[" => depth += 1,
                ")" | "}" | "]" => depth -= 1,
                _ => {}
            }
            if depth == 0 {
                return at + 1;
            }
        }
        self.tokens.len()
    }

    /// Rewrites the functions; the text of those that store.
    fn module(&mut self) -> Result<String, String> {
        let mut globals = BTreeMap::new();
        let mut counting = BTreeSet::new();
        let (mut at, mut binding) = (0, None);
        let mut functions = Vec::new();
        while at < self.tokens.len() {
            match self.text(at) {
                "@" if self.text(at + 1) == "binding" => {
                    binding = self.text(at + 3).trim_end_matches('u').parse().ok();
                    at += 1;
                }
                "var" => {
                    let name = (at..).find(|at| self.text(at + 1) == ":" || *at > self.tokens.len()).unwrap_or(at);
                    globals.insert(self.text(name), Declared { ty: self.text(name + 2), binding: binding.take() });
                    at = name + 1;
                }
                "struct" => {
                    let end = self.behind(at + 2);
                    if (at..end).any(|at| COUNTING.contains(&self.text(at))) {
                        counting.insert(self.text(at + 1));
                    }
                    at = end;
                }
                "fn" => {
                    let body = self.behind(at + 2);
                    let body = (body..).find(|at| self.text(*at) == "{" || *at > self.tokens.len()).unwrap_or(body);
                    functions.push((at, body));
                    at = self.behind(body);
                }
                _ => at += 1,
            }
        }
        for (start, body) in functions {
            self.function(start, body, &globals, &counting)?;
        }
        let of_binding = |(name, declared): (&&str, &Declared<'_>)| Some((declared.binding?, (*name).to_owned()));
        let names: BTreeMap<u32, String> = globals.iter().filter_map(of_binding).collect();
        Ok(self.module.stored.iter().map(|(binding, size)| store(*binding, *size, &names[binding])).collect())
    }

    fn function(
        &mut self,
        start: usize,
        body: usize,
        globals: &BTreeMap<&str, Declared<'a>>,
        counting: &BTreeSet<&str>,
    ) -> Result<(), String> {
        let is_entry = self.text(start + 1) == self.module.entry;
        let mut arguments = BTreeMap::new();
        let mut builtin = None;
        let mut first = String::new();
        for at in start + 3..self.behind(start + 2) {
            if self.text(at) == "builtin" {
                builtin = Some(self.text(at + 2));
            } else if self.text(at + 1) == ":" && self.tokens[at].kind == TokenKind::Name {
                let (name, ty) = (self.text(at), self.text(at + 2));
                arguments.insert(name, Declared { ty, binding: None });
                if is_entry && counting.contains(ty) {
                    return Err(format!("takes the number of a workgroup in the struct `{ty}`"));
                }
                if let Some(text) = builtin.take().filter(|_| is_entry).and_then(|builtin| self.global(name, builtin)) {
                    let token = self.tokens[at];
                    self.edits.push((token.start as usize, token.end as usize, format!("{name}_in_band")));
                    first += &text;
                }
            }
        }
        let open = self.tokens[body].end as usize;
        self.edits.push((open, open, first));
        for at in body..self.behind(body) {
            if self.text(at).starts_with("texture") && self.text(at + 1) == "(" {
                // A gathering function names its component first.
                let is_number = self.tokens.get(at + 2).is_some_and(|token| token.kind == TokenKind::Number);
                let name = self.text(if is_number { at + 4 } else { at + 2 });
                if let Some(declared) = arguments.get(name).or_else(|| globals.get(name)) {
                    self.call(at, *declared)?;
                }
            }
        }
        Ok(())
    }

    /// The statement that makes an argument of the entry point what it would be in the whole dispatch.
    fn global(&self, name: &str, builtin: &str) -> Option<String> {
        let [x, y, z] = self.module.workgroups;
        Some(match builtin {
            "workgroup_id" => format!(" let {name} = {name}_in_band + vec3u(0u, u32(bands.base.x), 0u);"),
            "global_invocation_id" => {
                let rows = self.module.rows;
                format!(" let {name} = {name}_in_band + vec3u(0u, {rows}u * u32(bands.base.x), 0u);")
            }
            "num_workgroups" => format!(" let {name} = vec3u({x}u, {y}u, {z}u);"),
            _ => return None,
        })
    }

    /// Rewrites the call of a built-in function whose first argument is that texture.
    fn call(&mut self, at: usize, declared: Declared<'_>) -> Result<(), String> {
        let (function, after) = (self.text(at), at + 3);
        let size = self.module.stored.iter().find(|(binding, _)| Some(*binding) == declared.binding);
        match (declared.ty, size, function) {
            ("texture_2d", _, "textureLoad") => {
                self.replace(at, at, "bands_load".to_owned());
                self.as_place(after);
            }
            ("texture_2d", _, "textureSampleLevel") => self.replace(at, at, "bands_sample".to_owned()),
            ("texture_2d", _, "textureDimensions") if self.text(after) == ")" => {
                self.replace(at, at, "bands_size".to_owned());
            }
            ("texture_storage_2d", Some((binding, _)), "textureStore") => {
                self.replace(at, after, format!("bands_store{binding}("));
                self.as_place(after);
            }
            ("texture_storage_2d", Some((_, size)), "textureDimensions") => {
                self.replace(at, after, size_of(self.module.sizes[*size]));
            }
            ("texture_2d", ..) | ("texture_storage_2d", Some(_), _) => return Err(format!("calls `{function}`")),
            _ => {}
        }
        Ok(())
    }

    /// Puts a text in the place of these tokens.
    fn replace(&mut self, first: usize, last: usize, text: String) {
        self.edits.push((self.tokens[first].start as usize, self.tokens[last].end as usize, text));
    }

    /// Makes the argument behind the comma at `comma` a `vec2i`.
    fn as_place(&mut self, comma: usize) {
        let start = self.tokens[comma].end as usize;
        let mut at = comma + 1;
        while !matches!(self.text(at), "," | ")" | "") {
            at = if matches!(self.text(at), "(" | "[") { self.behind(at) } else { at + 1 };
        }
        let end = self.tokens[at.min(self.tokens.len() - 1)].start as usize;
        self.edits.push((start, start, " vec2i(".to_owned()));
        self.edits.push((end, end, ")".to_owned()));
    }
}

/// The size of a whole image. The uniform's zero hides from the compiler that it is a constant: it would divide by a
/// constant with another last bit than by the size of a texture.
fn size_of([width, height]: [u32; 2]) -> String {
    format!("vec2u(vec2i({width}, {height}) + bands.base.yy)")
}

/// The bindings, and the functions that read, store and measure textures.
fn access(module: &BandedModule<'_>) -> String {
    let count = module.sizes.len();
    let mut text = format!(
        "
struct Bands {{ base: vec4i, windows: array<vec4i, {count}> }}
@group(1) @binding(0) var<uniform> bands: Bands;
@group(1) @binding(1) var<storage, read_write> bands_missing: array<atomic<i32>>;
fn bands_note(counter: u32, window: vec4i, low: i32, high: i32) {{
    if low < window.y {{ atomicMax(&bands_missing[counter], window.y - low); }}
    if high >= window.z {{ atomicMax(&bands_missing[counter + 1u], high + 1 - window.z); }}
}}
"
    );
    let (mut loads, mut sizes, mut samples) = (String::new(), String::new(), String::new());
    for (index, [width, height]) in module.sizes.iter().enumerate() {
        let counter = module.first_counter + 2 * index;
        let is_own = format!("    if all(own == vec2u({width}u, u32(bands.windows[{index}].w))) {{\n");
        let last = height - 1;
        let _ = write!(
            loads,
            "{is_own}        let window = bands.windows[{index}];
        let row = clamp(p.y, 0, {last});
        bands_note({counter}u, window, row, row);
        return textureLoad(t, vec2i(p.x, clamp(row - window.x, 0, window.w - 1)), level);
    }}
"
        );
        let _ = writeln!(sizes, "{is_own}        return {};\n    }}", size_of([*width, *height]));
        // The sampler multiplies by the rows of the texture, a power of two: no bit of the place is lost. A texture of
        // all rows may have another number of them.
        let _ = write!(
            samples,
            "{is_own}        let window = bands.windows[{index}];
        let y = uv.y * {height}.0;
        let row = i32(floor(clamp(y - 0.5, -1.0, {height}.0)));
        bands_note({counter}u, window, clamp(row, 0, {last}), clamp(row + 1, 0, {last}));
        if window.w == {height} {{ return textureSampleLevel(t, s, uv, level); }}
        return textureSampleLevel(t, s, vec2f(uv.x, (y - f32(window.x)) / f32(window.w)), level);
    }}
"
        );
    }
    let own = "    let own = textureDimensions(t);\n";
    let _ = write!(
        text,
        "fn bands_load(t: texture_2d<f32>, p: vec2i, level: i32) -> vec4f {{
{own}{loads}    return textureLoad(t, p, level);
}}
fn bands_size(t: texture_2d<f32>) -> vec2u {{
{own}{sizes}    return own;
}}
fn bands_sample(t: texture_2d<f32>, s: sampler, uv: vec2f, level: f32) -> vec4f {{
{own}{samples}    return textureSampleLevel(t, s, uv, level);
}}
"
    );
    text
}

/// The function that stores into the variable of a binding.
fn store(binding: u32, size: usize, name: &str) -> String {
    format!(
        "fn bands_store{binding}(p: vec2i, value: vec4f) {{
    let window = bands.windows[{size}];
    let row = p.y - window.x;
    if row >= 0 && row < i32(textureDimensions({name}).y) {{ textureStore({name}, vec2i(p.x, row), value); }}
}}
"
    )
}
