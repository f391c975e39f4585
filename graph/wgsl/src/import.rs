//! `#import name`: the only directive. Brings in a file of `shaders/lib` once, and keeps the map of lines.

use std::collections::BTreeSet;

use afterimage_base::Shared;

use crate::{SampleMode, Shader, ShaderError, ShaderFeatures};

/// The shared files, by name.
use afterimage_shaders::LIBRARY;

/// The file that generated lines belong to.
const GENERATED: &str = "(generated)";

/// Which line of which file each line of a composed module came from.
#[derive(Clone, Debug, Default)]
pub struct SourceMap {
    lines: Vec<(Shared<str>, u32)>,
}

impl SourceMap {
    /// The file and the line, counted from 1, that line `line` (from 1) of the composed text came from.
    pub fn locate(&self, line: u32) -> (&str, u32) {
        let index = (line as usize).saturating_sub(1);
        self.lines.get(index).map_or((GENERATED, line), |(file, line)| (file, *line))
    }
}

/// What the names of a file written for tiles end in.
pub const TILED: &str = "_tiled";

/// Text under construction, with its map.
#[derive(Default)]
pub struct Text {
    /// The text so far.
    pub text: String,
    /// Where its lines come from.
    pub map: SourceMap,
    included: Vec<Shared<str>>,
    features: ShaderFeatures,
    tiled: Vec<Shared<str>>,
    promised: Vec<&'static str>,
}

impl Text {
    /// A text in which the promises hold that all steps of a module make: one that does not needs the general code.
    pub fn promising<'s>(steps: impl IntoIterator<Item = (&'s Shader, &'s [&'static str])>) -> Self {
        let mut common: Vec<(&str, BTreeSet<&'static str>)> = Vec::new();
        for (shader, promises) in steps {
            let made: BTreeSet<&'static str> = promises.iter().copied().collect();
            match common.iter_mut().find(|(file, _)| *file == shader.file()) {
                Some((_, known)) => known.retain(|promise| made.contains(promise)),
                None => common.push((shader.file(), made)),
            }
        }
        Self { promised: common.into_iter().flat_map(|(_, promises)| promises).collect(), ..Self::default() }
    }

    /// Begins with what every module has: what its numbers are, how it reads textures, and the shared files that do.
    pub fn reading(mut self, reading: SampleMode, features: ShaderFeatures) -> Result<Self, ShaderError> {
        self.features = features;
        self.generated(&features.settings());
        self.generated(&reading.settings());
        for name in ["point", "sanitize", "sampling"] {
            self.library(name).expect("the library has this file")?;
        }
        Ok(self)
    }

    /// Adds lines of the framework's own.
    pub fn generated(&mut self, lines: &str) {
        for (index, line) in lines.lines().enumerate() {
            self.line(line, &GENERATED.into(), index as u32 + 1);
        }
    }

    /// Adds a line of a file.
    pub fn line(&mut self, line: &str, file: &Shared<str>, number: u32) {
        let kept = self.promised.iter().any(|name| is_promise(line, name));
        self.text.push_str(&if kept { line.replacen("false", "true", 1) } else { line.to_owned() });
        self.text.push('\n');
        self.map.lines.push((file.clone(), number));
    }

    /// Adds a module and, before it, what it imports; each file once.
    pub fn module(&mut self, shader: &Shader) -> Result<(), ShaderError> {
        self.file(&shader.file_handle(), shader.source())
    }

    /// Adds a file of the library, unless it is there.
    pub fn library(&mut self, name: &str) -> Option<Result<(), ShaderError>> {
        let name = self.features.stands_for(name);
        let (file, source) = LIBRARY.iter().find(|(known, _)| *known == name)?;
        Some(self.file(&Shared::of(*file), source))
    }

    /// Adds a module and those of its imports that take textures a second time, with textures as numbers of tiles.
    pub fn tiled_module(&mut self, shader: &Shader) -> Result<(), ShaderError> {
        let mut files = Vec::new();
        collect_tiled(shader.file_handle(), shader.source(), &mut files);
        let names: Vec<&str> = files.iter().flat_map(|(_, source)| declared(source)).collect();
        for (file, source) in files {
            if self.tiled.contains(&file) {
                continue;
            }
            self.tiled.push(file.clone());
            for (number, line) in source.lines().enumerate() {
                let number = number as u32 + 1;
                match line.trim().strip_prefix("#import ") {
                    Some(name) if !takes_textures(name.trim()) => {
                        let known = self.library(name.trim());
                        known.unwrap_or_else(|| {
                            Err(ShaderError::at(&file, number, format!("no shared file is called `{name}`")))
                        })?;
                    }
                    Some(_) => {}
                    None => self.line(&tiled_line(line, &names), &file, number),
                }
            }
        }
        Ok(())
    }

    /// Adds a module, each line as `change` makes it, and before it what it imports.
    pub fn changed_module(&mut self, shader: &Shader, change: &dyn Fn(&str) -> String) -> Result<(), ShaderError> {
        self.imports(shader.file(), shader.source())?;
        for (number, line) in shader.source().lines().enumerate() {
            let line = if line.trim().starts_with("#import ") { String::new() } else { change(line) };
            self.line(&line, &shader.file_handle(), number as u32 + 1);
        }
        Ok(())
    }

    fn file(&mut self, file: &Shared<str>, source: &str) -> Result<(), ShaderError> {
        if self.included.contains(file) {
            return Ok(());
        }
        self.included.push(file.clone());
        self.imports(file, source)?;
        for (number, line) in source.lines().enumerate() {
            let directive = line.trim().starts_with("#import ");
            self.line(if directive { "" } else { line }, file, number as u32 + 1);
        }
        Ok(())
    }

    /// Adds what a file imports.
    fn imports(&mut self, file: &str, source: &str) -> Result<(), ShaderError> {
        for (number, line) in source.lines().enumerate() {
            let number = number as u32 + 1;
            let Some(name) = line.trim().strip_prefix("#import ") else { continue };
            let known = || LIBRARY.iter().map(|(known, _)| *known).collect::<Vec<_>>().join("`, `");
            self.library(name.trim()).unwrap_or_else(|| {
                Err(ShaderError::at(
                    file,
                    number,
                    format!("no shared file is called `{name}`; there are `{}`", known()),
                ))
            })?;
        }
        Ok(())
    }
}

/// Whether a line declares that promise, as not made.
fn is_promise(line: &str, name: &str) -> bool {
    let rest = line.strip_prefix("const ").and_then(|rest| rest.strip_prefix(name));
    rest.is_some_and(|rest| rest.trim_start_matches(TILED).starts_with(": bool = false;"))
}

/// Whether a shared file, other than the one that reads textures, has functions that take them.
fn takes_textures(name: &str) -> bool {
    name != "sampling" && LIBRARY.iter().any(|(known, source)| *known == name && source.contains("texture_2d<"))
}

/// A file and its imports that take textures, what is imported first.
fn collect_tiled<'s>(file: Shared<str>, source: &'s str, files: &mut Vec<(Shared<str>, &'s str)>) {
    for name in source.lines().filter_map(|line| line.trim().strip_prefix("#import ")) {
        let known = LIBRARY.iter().find(|(known, _)| *known == name.trim() && takes_textures(known));
        if let Some((file, source)) = known
            && files.iter().all(|(other, _)| other != file)
        {
            collect_tiled(Shared::of(*file), source, files);
        }
    }
    files.push((file, source));
}

/// What a line begins with that declares a name.
const DECLARING: [&str; 7] = ["fn ", "struct ", "const ", "alias ", "override ", "var<workgroup> ", "var<private> "];

/// The names that a file declares, but its bindings.
pub fn declared(source: &str) -> impl Iterator<Item = &str> {
    source.lines().filter_map(|line| {
        let rest = DECLARING.iter().find_map(|word| line.strip_prefix(word))?;
        let end = rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len());
        Some(&rest[..end])
    })
}

/// A line with textures as numbers of tiles, and with the names of its file changed.
fn tiled_line(line: &str, names: &[&str]) -> String {
    let line = line.replace("texture_2d<f32>", "u32");
    change_words(&line, |word| match word {
        "sampler" => Some("u32".into()),
        "textureDimensions" => Some("tile_size".into()),
        "tap" | "texel" => Some(format!("tile_{word}")),
        _ => names.contains(&word).then(|| format!("{word}{}", TILED)),
    })
}

/// The line with its binding, if it has one, counted from `first`.
pub fn bound_from(line: &str, first: u32) -> String {
    let Some((before, rest)) = line.split_once("@binding(") else { return line.to_owned() };
    let Some((binding, after)) = rest.split_once(')') else { return line.to_owned() };
    match binding.trim().parse::<u32>() {
        Ok(binding) => format!("{before}@binding({}){after}", first + binding),
        Err(_) => line.to_owned(),
    }
}

/// A line without its comment, with other words for some.
pub fn change_words(line: &str, change: impl Fn(&str) -> Option<String>) -> String {
    let mut out = String::with_capacity(line.len() + 16);
    let mut rest = line.split("//").next().unwrap_or(line);
    while let Some(c) = rest.chars().next() {
        let is_word = c.is_alphabetic() || c == '_';
        // A number's suffix and a member's name are no names of the file.
        let is_fixed = c.is_ascii_digit() || c == '.';
        let start = if is_word { 0 } else { c.len_utf8() };
        let length = rest[start..].find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len() - start);
        let (text, after) = rest.split_at(if is_word || is_fixed { start + length } else { start });
        match change(text).filter(|_| is_word) {
            Some(other) => out.push_str(&other),
            None => out.push_str(text),
        }
        rest = after;
    }
    out
}
