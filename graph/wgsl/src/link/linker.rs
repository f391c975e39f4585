//! The linker: instances of files, what is changed in them, and the module that they become.

use afterimage_base::diagnostic::{did_you_mean, nearest, quote};
use rustc_hash::FxHashMap;

use super::contents::check_contents;
use super::edit;
use super::emit::emit;
use super::instance::{Instance, Part, Replacement};
use super::loops;
use super::names::choose_names;
use super::resolve::{Roots, check, reach};
use super::source_map::{GENERATED, SourceMap};
use crate::error::{ShaderError, position};
use crate::library::{FRAMEWORK, Library, SHARED, Source, SourceFile};
use crate::limits::Limit;
use crate::module::{Import, Module, Symbol};
use crate::sample_mode::SampleMode;

/// Files of the framework's library whose names every file knows.
const PRELUDE: [&str; 3] = ["point", "sanitize", "sampling"];

/// Puts files together into one module.
pub struct Linker<'a> {
    parts: Vec<Part<'a>>,
    prelude: Vec<Instance>,
    /// The file that counts the steps of loops, if an untrusted file has one.
    counter: Option<Instance>,
    mode: SampleMode,
}

#[derive(Clone, Debug)]
pub struct Linked {
    /// The text of the module.
    pub text: String,
    pub map: SourceMap,
    /// The names in the module of the entry points that were asked for.
    pub entries: Vec<String>,
}

/// A declaration of a linked module.
#[derive(Clone, Debug)]
pub(crate) struct Declared {
    /// The name in the module.
    pub(crate) name: String,
    /// The name in the file.
    pub(crate) original: String,
    pub(crate) instance: Instance,
    /// True if the file is one of the framework's library.
    pub(crate) is_framework: bool,
}

impl<'a> Linker<'a> {
    /// A linker of a module that samples its textures like that.
    pub fn new(mode: SampleMode) -> Self {
        let (parts, prelude) = (Vec::new(), Vec::new());
        let mut linker = Self { parts, prelude, counter: None, mode };
        let instances = PRELUDE.map(|name| linker.framework(name));
        linker.prelude = instances.to_vec();
        linker.parts.iter_mut().for_each(|part| part.prelude = instances.to_vec());
        linker
    }

    /// Adds a file and what it imports; an instance of it that is there and has the same defines is used again. The
    /// defines are boolean constants of the file, which are set to true.
    ///
    /// # Errors
    /// An import of a file that does not exist, and a bracket or comment without an end.
    pub fn add(&mut self, source: &'a Source, defines: &[&str]) -> Result<Instance, ShaderError> {
        let mut defines: Vec<String> = defines.iter().map(|name| (*name).to_owned()).collect();
        defines.sort_unstable();
        self.part(&source.file, source.library(), defines)
    }

    /// Adds a file as an instance of its own, even if another is there.
    ///
    /// # Errors
    /// As for [`add`](Self::add).
    pub fn add_copy(&mut self, source: &'a Source) -> Result<Instance, ShaderError> {
        let module = source.file.module()?;
        self.parts.push(Part::new(&source.file, module, source.library(), Vec::new()));
        self.import(Instance(self.parts.len() as u32 - 1))
    }

    /// A file of the framework's library.
    fn framework(&mut self, name: &str) -> Instance {
        let file = FRAMEWORK.file(name).unwrap_or_else(|| panic!("the framework's library has no `{name}`"));
        let part = self.part(file, None, Vec::new());
        part.unwrap_or_else(|error| panic!("the framework's library is in order: {error}"))
    }

    fn part(
        &mut self,
        file: &'a SourceFile,
        library: Option<&'a Library>,
        defines: Vec<String>,
    ) -> Result<Instance, ShaderError> {
        if let Some(known) = self.parts.iter().position(|part| part.is_of(file, library, &defines)) {
            return Ok(Instance(known as u32));
        }
        self.parts.push(Part::new(file, file.module()?, library, defines));
        self.import(Instance(self.parts.len() as u32 - 1))
    }

    /// Adds what a new instance imports, and makes the changes that its file always has.
    fn import(&mut self, instance: Instance) -> Result<Instance, ShaderError> {
        let part = &self.parts[instance.index()];
        let (module, file, library) = (part.module, part.file, part.library);
        let mut imported = FxHashMap::default();
        for import in &module.imports {
            if let Some(item) = self.item(file, library, import)? {
                imported.insert(import.name, item);
            }
        }
        let prelude = self.prelude.clone();
        let part = &mut self.parts[instance.index()];
        (part.imported, part.prelude, part.is_framework) = (imported, prelude, file.is_framework());
        self.settle(instance);
        Ok(instance)
    }

    /// Adds the file of an import, and finds the item in it; `None` if the file itself is imported.
    fn item(
        &mut self,
        file: &SourceFile,
        library: Option<&'a Library>,
        import: &Import,
    ) -> Result<Option<(Instance, Symbol)>, ShaderError> {
        let path = import.path(file.text());
        let (name, of) = path.split_last().expect("a path has a name");
        let error = |at, message| ShaderError::new(file.name(), position(file.text(), import.at(at)), message);
        let Some((holder, of_holder)) = file.find(library, of) else {
            let is_file = file.find(library, &path).is_some();
            return if is_file { Ok(None) } else { Err(error(of.len().min(1), unknown(library, &of.join("::")))) };
        };
        let instance = self.part(holder, of_holder, Vec::new())?;
        let module = self.parts[instance.index()].module;
        match module.symbol(name).filter(|symbol| module.declaration(*symbol).is_some()) {
            Some(symbol) => Ok(Some((instance, symbol))),
            None => {
                let names = module.declarations.iter().filter_map(|it| it.name).map(|name| module.name(name));
                let near = did_you_mean(name, names);
                let near = near.map(|near| format!("; {near}")).unwrap_or_default();
                Err(error(0, format!("`{}` declares no {}{near}", of.join("::"), quote(name))))
            }
        }
    }

    /// Sets what the way of sampling and the defines state. Nothing sets the overrides of an untrusted file.
    fn settle(&mut self, instance: Instance) {
        let part = &mut self.parts[instance.index()];
        if part.file.is_untrusted() {
            edit::make_overrides_constant(part);
        }
        if part.is_framework {
            for (name, value) in self.mode.constants() {
                edit::set_value(part, name, value);
            }
        }
        for define in part.defines.clone() {
            edit::set_value(part, &define, "true");
        }
    }

    /// A name for generated code: what `name` means in that file, wherever it is declared.
    pub fn name(&self, instance: Instance, name: &str) -> String {
        format!("__{}_{name}", instance.0)
    }

    /// The statement in front of each call of a kernel function in generated code: it sets the limit of the steps of
    /// its loops. `None` if no file has loops whose steps are counted.
    pub fn before_call(&mut self, steps: Limit) -> Option<String> {
        if self.counter.is_none() && loops::any(&self.parts) {
            self.counter = Some(self.framework(loops::FILE));
        }
        self.counter.map(|counter| format!("{}({});", self.name(counter, loops::BEGIN), steps.max))
    }

    /// An expression that is true if the last call of a kernel function has ended a loop early. `None` if no file has
    /// loops whose steps are counted.
    pub fn after_call(&self) -> Option<String> {
        self.counter.map(|counter| format!("{}()", self.name(counter, loops::CUT)))
    }

    /// Gives a variable another binding.
    pub fn bind(&mut self, instance: Instance, variable: &str, group: u32, binding: u32) {
        edit::bind(&mut self.parts[instance.index()], variable, group, binding);
    }

    /// Gives a storage texture another format.
    pub fn set_storage_format(&mut self, instance: Instance, variable: &str, format: &str) {
        edit::set_storage_format(&mut self.parts[instance.index()], variable, format);
    }

    /// Sets an `override` to a value, which makes it a constant.
    pub fn set_override(&mut self, instance: Instance, name: &str, value: f64) {
        edit::set_override(&mut self.parts[instance.index()], name, value);
    }

    /// Makes a uniform an immediate.
    pub fn make_immediate(&mut self, instance: Instance, variable: &str) {
        edit::make_immediate(&mut self.parts[instance.index()], variable);
    }

    /// Uses a variable of the generated code, or members of it, wherever the file uses one of its own. `members` starts
    /// with a dot or is empty.
    pub fn replace(&mut self, instance: Instance, variable: &str, by: &str, members: &str) {
        let part = &mut self.parts[instance.index()];
        if let Some(name) = part.module.symbol(variable) {
            let (by, members) = (by.to_owned(), members.to_owned());
            part.replacements.push(Replacement { name, by, members });
        }
    }

    /// The module of the generated code and of all that it and the entry points need. Generated code imports files like
    /// any other.
    ///
    /// # Errors
    /// Names that two imports declare, and names in the generated code that a file does not know.
    ///
    /// # Panics
    /// If the generated code has an open bracket or imports an item that the framework does not have.
    pub fn link(self, generated: String, entries: &[(Instance, &str)]) -> Result<Linked, ShaderError> {
        let file = generated_file(generated);
        let (mut linker, code) = self.with_generated(&file);
        let mut entries: Vec<(Instance, &str)> = entries
            .iter()
            .map(|(instance, name)| (if *instance == Instance::GENERATED { code } else { *instance }, *name))
            .collect();
        let count = entries.len();
        if let Some(counter) = linker.counter {
            loops::mark(&mut linker.parts);
            entries.push((counter, loops::STEP));
        }
        reach(&mut linker.parts, Roots { whole: code, entries: &entries });
        linker.finish(&entries[..count])
    }

    /// The module of everything that a file declares, with its declarations. Untrusted files of it may share memory of
    /// a workgroup only if that is stated.
    pub(crate) fn link_whole(
        self,
        instance: Instance,
        has_workgroups: bool,
    ) -> Result<(Linked, Vec<Declared>), ShaderError> {
        let file = generated_file(String::new());
        let (mut linker, _) = self.with_generated(&file);
        reach(&mut linker.parts, Roots { whole: instance, entries: &[] });
        check(&linker.parts)?;
        check_contents(&linker.parts, has_workgroups)?;
        choose_names(&mut linker.parts);
        let declared = linker.declared();
        let (text, map) = emit(&linker.parts, "");
        Ok((Linked { text, map, entries: Vec::new() }, declared))
    }

    fn finish(mut self, entries: &[(Instance, &str)]) -> Result<Linked, ShaderError> {
        check(&self.parts)?;
        choose_names(&mut self.parts);
        let loop_start = self.counter.map(|counter| loops::start(&self.parts, counter)).unwrap_or_default();
        let (text, map) = emit(&self.parts, &loop_start);
        let final_name = |(instance, name): &(Instance, &str)| {
            let part = &self.parts[instance.index()];
            part.module.symbol(name).map_or_else(|| (*name).to_owned(), |symbol| part.final_name(symbol).to_owned())
        };
        Ok(Linked { text, map, entries: entries.iter().map(final_name).collect() })
    }

    fn declared(&self) -> Vec<Declared> {
        let of_part = |(index, part): (usize, &Part<'_>)| {
            let reached = part.module.declarations.iter().zip(&part.reached).filter(|(_, reached)| **reached);
            let names = reached.filter_map(|(declaration, _)| declaration.name);
            let declared = names.map(|symbol| Declared {
                name: part.final_name(symbol).to_owned(),
                original: part.module.name(symbol).to_owned(),
                instance: Instance(index as u32),
                is_framework: part.is_framework,
            });
            declared.collect::<Vec<_>>()
        };
        self.parts.iter().enumerate().flat_map(of_part).collect()
    }

    /// The linker with the generated code as the last instance.
    fn with_generated<'b>(self, file: &'b SourceFile) -> (Linker<'b>, Instance)
    where
        'a: 'b,
    {
        let mut linker: Linker<'b> = self;
        let module = parsed(file);
        // The last part refers to others by their numbers, so nothing may come behind it.
        for import in &module.imports {
            let item = linker.item(file, None, import);
            item.unwrap_or_else(|error| panic!("generated code imports what there is: {error}"));
        }
        linker.parts.push(Part::new(file, module, None, Vec::new()));
        let code = Instance(linker.parts.len() as u32 - 1);
        let imported = linker.import(code);
        imported.unwrap_or_else(|error| panic!("generated code imports what there is: {error}"));
        (linker, code)
    }
}

/// Message of a path that is none of a file.
fn unknown(library: Option<&Library>, path: &str) -> String {
    let known: Vec<String> = library.into_iter().flat_map(Library::paths).chain(FRAMEWORK.paths()).collect();
    let stem = |path: &str| path.rsplit("::").next().unwrap_or_default().to_owned();
    let stems: Vec<String> = known.iter().map(|path| stem(path)).collect();
    let near = nearest(&stem(path), stems.iter().map(String::as_str));
    let near = near.and_then(|near| known.iter().find(|path| stem(path) == near));
    let near = near.map(|near| format!("did you mean {}?", quote(near)));
    let near = near.unwrap_or_else(|| format!("there are `{}`", known.join("`, `")));
    match path {
        "" => {
            format!("an import names a file and what it declares, as in `import afterimage::color::luminance;`; {near}")
        }
        path if path.starts_with(SHARED) && !known.iter().any(|known| known.starts_with(SHARED)) => format!(
            "no shared file is called {}: the folder `lib` next to kinds is read where `--nodes` names the folder of \
             both, or with `--allow`",
            quote(path)
        ),
        path => format!("no shared file is called {}; {near}", quote(path)),
    }
}

fn generated_file(text: String) -> SourceFile {
    SourceFile::new(GENERATED.into(), text.into())
}

fn parsed(file: &SourceFile) -> &Module {
    file.module().unwrap_or_else(|error| panic!("generated code is in order: {error}"))
}

#[cfg(test)]
mod tests {
    use super::Linker;
    use crate::{SampleMode, validate};

    #[test]
    fn the_library_is_valid_in_every_way_of_sampling() {
        for mode in [
            SampleMode::Plain,
            SampleMode::ByHand,
            SampleMode::Sanitized,
            SampleMode::SanitizedLight,
            SampleMode::SanitizedSigned,
        ] {
            for (name, _) in afterimage_shaders::LIBRARY {
                let mut linker = Linker::new(mode);
                let library = linker.framework(name);
                let (linked, _) = linker.link_whole(library, false).unwrap_or_else(|error| panic!("{name}: {error}"));
                validate(&linked.text, &linked.map).unwrap_or_else(|error| panic!("{name}: {error}"));
            }
        }
    }
}
