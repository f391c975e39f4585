//! A file of WGSL with all that the framework knows of it.

use std::sync::OnceLock;

use afterimage_base::Shared;
use afterimage_base::diagnostic::{Diagnostic, Diagnostics};

use crate::error::{Place, ShaderError, ShaderLabel, position};
use crate::library::{ImportedName, Library, Source, SourceFile};
use crate::limits::CompileCost;
use crate::reflect::{Reflection, reflect};
use crate::shader_cost::{RegisterPressure, ShaderCost};

/// One file of WGSL, with the library that it may import besides the framework's.
pub struct Shader {
    source: Source,
    unchecked: bool,
    reflection: OnceLock<Result<Reflection, ShaderError>>,
}

impl Shader {
    /// A file with the name that errors show.
    pub const fn new(file: &'static str, text: &'static str) -> Self {
        Self::from_source(SourceFile::new(Shared::of(file), Shared::of(text)), ImportedName::Nothing)
    }

    /// A text that the program makes while it runs.
    pub fn loaded(file: String, text: String) -> Self {
        Self::from_source(SourceFile::new(file.into(), text.into()), ImportedName::Nothing)
    }

    /// A file that is not trusted: [`limits`](crate::limits) hold for it, and its loops end.
    pub fn untrusted(file: String, text: String) -> Self {
        Self::from_source(SourceFile::untrusted(file.into(), text.into()), ImportedName::Nothing)
    }

    /// The same file, whose functions may share memory of a workgroup if it is not trusted: passes give them a
    /// workgroup.
    #[must_use]
    pub fn with_workgroups(mut self) -> Self {
        self.source.file.permit_workgroups();
        self
    }

    /// The same file, of a kind's folder, with the library of that folder.
    #[must_use]
    pub fn with_loaded_library(mut self, library: Library) -> Self {
        self.source.file.set_of_kind();
        self.source.brought = ImportedName::Owned(Box::new(library));
        self
    }

    const fn from_source(file: SourceFile, brought: ImportedName) -> Self {
        Self { source: Source { file, brought }, unchecked: false, reflection: OnceLock::new() }
    }

    /// The same file with the library of its package.
    #[must_use]
    pub const fn with_library(mut self, library: &'static Library) -> Self {
        // A constant function cannot drop what a library may own.
        std::mem::forget(std::mem::replace(&mut self.source.brought, ImportedName::Static(library)));
        self
    }

    /// A file that runs without the bounds checks of indices and loops that a driver otherwise adds to it.
    ///
    /// # Safety
    ///
    /// Whatever its inputs and parameters hold, NaN and the largest integers among them, every index into an array and
    /// every texel that is loaded must lie inside, every loop must end, and no memory of a workgroup may be read before
    /// it is written. This holds for the files that it imports too.
    #[allow(unsafe_code, reason = "the promise is the author's, and breaking it is undefined behavior on the device")]
    pub const unsafe fn unchecked(file: &'static str, text: &'static str) -> Self {
        let mut shader = Self::new(file, text);
        shader.unchecked = true;
        shader
    }

    /// Returns whether it was made by [`unchecked`](Self::unchecked).
    pub fn is_unchecked(&self) -> bool {
        self.unchecked
    }

    /// Returns whether it was made by [`untrusted`](Self::untrusted).
    pub fn is_untrusted(&self) -> bool {
        self.source.file.is_untrusted()
    }

    pub fn file(&self) -> &str {
        self.source.file.name()
    }

    /// The text of the file.
    pub fn text(&self) -> &str {
        self.source.file.text()
    }

    /// The file as the linker takes it.
    pub fn source(&self) -> &Source {
        &self.source
    }

    /// Reflection of the file, which is linked with its imports, parsed and validated once.
    ///
    /// # Errors
    /// The first error in the file or its imports.
    pub fn reflect(&self) -> Result<&Reflection, ShaderError> {
        self.reflection.get_or_init(|| reflect(&self.source)).as_ref().map_err(Clone::clone)
    }

    /// Returns whether a function or an entry point of the file reads textures directly, and not through `texel` and
    /// `tap`, so that the framework cannot sanitize what it reads.
    pub fn reads_textures_itself(&self, function: &str) -> bool {
        self.reflect().is_ok_and(|reflection| reflection.direct_reads.iter().any(|name| name == function))
    }

    /// Returns whether a function or an entry point of the file filters textures, through `tap` or directly.
    pub fn filters_textures(&self, function: &str) -> bool {
        self.reflect().is_ok_and(|reflection| reflection.filtering.iter().any(|name| name == function))
    }

    /// Returns whether to compute a function again takes longer than to store its result and to read it again.
    pub fn is_heavy(&self, function: &str) -> bool {
        self.shader_cost(function).is_heavy()
    }

    /// Register pressure of a function.
    pub fn register_pressure(&self, function: &str) -> RegisterPressure {
        self.shader_cost(function).register_pressure()
    }

    /// Upper bound of the texels that a function reads through the library; `usize::MAX` if no constant states how many
    /// turns its loops have, and for an entry point.
    pub fn texel_reads(&self, function: &str) -> usize {
        let is_function = self.reflect().is_ok_and(|reflection| reflection.function(function).is_some());
        if is_function { self.shader_cost(function).reads() } else { usize::MAX }
    }

    /// Compilation cost of a function or an entry point.
    pub fn compile_cost(&self, function: &str) -> CompileCost {
        let reflection = self.reflect().ok();
        let known = reflection.and_then(|reflection| reflection.costs.iter().find(|(name, _)| name == function));
        known.map(|(_, cost)| *cost).unwrap_or_default()
    }

    fn shader_cost(&self, function: &str) -> ShaderCost {
        let reflection = self.reflect().ok();
        let known = reflection.and_then(|reflection| reflection.shader_costs.iter().find(|(name, _)| name == function));
        known.map(|(_, work)| *work).unwrap_or_default()
    }

    /// An error at the place where the file has these words, such as `fn name`; at its start, if it has not.
    pub fn error_at(&self, words: &str, message: impl Into<String>) -> ShaderError {
        let is_word = |c: char| c.is_alphanumeric() || c == '_';
        let mut found = self.text().match_indices(words).map(|(at, _)| at);
        let whole = found.find(|at| !self.text()[at + words.len()..].starts_with(is_word));
        ShaderError::new(self.file(), position(self.text(), whole.unwrap_or(0)), message)
    }

    /// Adds an error in the file, and those that were found with it, to diagnostics. Each has an excerpt if it is in
    /// this file and not in one that it imports.
    pub fn report(&self, error: &ShaderError, diagnostics: &mut Diagnostics) {
        diagnostics.add_source(self.file(), self.text());
        for error in std::iter::once(error).chain(error.others.iter()) {
            let place = Place { file: error.file.clone(), line: error.line, column: error.column };
            let remark = error.labels.iter().find(|label| label.place == place).map_or("", |label| &label.text);
            let mut diagnostic = match diagnostics.locate(&place.file, place.line, place.column) {
                Some(at) => Diagnostic::error("shader", &*error.message).at(&at, remark),
                None => Diagnostic::error("shader", error.first_line()),
            };
            for ShaderLabel { place: other, text } in error.labels.iter().filter(|label| label.place != place) {
                if let Some(there) = diagnostics.locate(&other.file, other.line, other.column) {
                    diagnostic = diagnostic.also(&there, &**text);
                }
            }
            diagnostics.push(diagnostic.maybe_help(error.help.as_deref().map(str::to_owned)));
        }
    }
}

impl PartialEq for Shader {
    fn eq(&self, other: &Self) -> bool {
        std::ptr::eq(self, other)
            || (self.file() == other.file() && self.text() == other.text() && self.source.has_library_of(&other.source))
    }
}

impl std::fmt::Debug for Shader {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Shader({})", self.file())
    }
}
