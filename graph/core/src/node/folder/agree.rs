//! Agreement of a `node.ron` with its shader.

use std::collections::BTreeSet;
use std::sync::Arc;

use super::declaration::{Declaration, Made};
use crate::node::contract::{is_pascal, snake, stem};
use afterimage_base::diagnostic::{Diagnostic, Diagnostics, Location, list, quote};
use afterimage_base::value::{Param, Type};
use afterimage_wgsl::{ArgType, Function, Member, Reflection, ScalarKind, Shader, StructLayout};

pub(super) fn look(declared: &Declaration, shader: &Shader, reflection: &Reflection, diagnostics: &mut Diagnostics) {
    let (file, source) = (shader.file().into(), shader.text());
    let mut pair = Pair { declared, file, source, diagnostics, used: BTreeSet::new() };
    pair.names();
    for (at, made) in declared.made.iter().enumerate() {
        pair.named_sources(at);
        if let Some(function) = pair.function(made, reflection) {
            pair.workgroup(at, function, reflection);
            function.args.iter().for_each(|(name, ty)| pair.argument(at, function, name, ty, reflection));
            pair.arguments(at, function);
        }
    }
    pair.unused();
}

/// A declaration and its shader.
pub(super) struct Pair<'a> {
    pub(super) declared: &'a Declaration,
    file: Arc<str>,
    source: &'a str,
    pub(super) diagnostics: &'a mut Diagnostics,
    /// The inputs, images and parameters that functions read.
    pub(super) used: BTreeSet<String>,
}

impl Pair<'_> {
    /// The location of a word in the shader, searched after other words.
    pub(super) fn word(&self, word: &str, after: &str) -> Location {
        let from = self.find(after, 0).unwrap_or(0);
        let start = self.find(word, from).unwrap_or(from);
        Location::new(&self.file, start..(start + word.len()).min(self.source.len()))
    }

    fn find(&self, words: &str, from: usize) -> Option<usize> {
        let is_word = |c: Option<char>| c.is_some_and(|c| c.is_alphanumeric() || c == '_');
        self.source[from..].match_indices(words).map(|(at, _)| from + at).find(|at| {
            let (before, behind) = (&self.source[..*at], &self.source[at + words.len()..]);
            !is_word(before.chars().next_back()) && !is_word(behind.chars().next())
        })
    }

    /// The file is named after the kind.
    fn names(&mut self) {
        let name = &self.declared.name;
        let (file, expected) = (stem(&self.file).to_owned(), snake(&name.value));
        if !is_pascal(&name.value) {
            let message = format!("{} is not a valid name of a kind", quote(&name.value));
            let help = "it begins with a capital letter and holds letters and digits only, as `ToneMap` does";
            return self.diagnostics.push(Diagnostic::error("bad-name", message).at(&name.location, "").help(help));
        }
        if file != expected {
            let message = format!("the shader of {} is called `{file}.wgsl`", quote(&name.value));
            let diagnostic = Diagnostic::error("file-name", message).at(&name.location, "");
            self.diagnostics.push(diagnostic.help(format!("rename it to `{expected}.wgsl`")));
        }
    }

    fn function<'r>(&mut self, made: &Made, reflection: &'r Reflection) -> Option<&'r Function> {
        let name = &made.function;
        let found = reflection.function(&name.value);
        if found.is_none() {
            let own = || reflection.functions.iter().map(|function| function.name.as_str());
            let help = match own().next() {
                None => format!("write `fn {}(source: vec4f) -> vec4f`", name.value),
                Some(_) => format!("it has {}", list(own(), 8)),
            };
            let message = format!("the shader has no function {} that gives a `vec4f`", quote(&name.value));
            let diagnostic = Diagnostic::error("no-function", message).at(&name.location, "").help(help);
            let diagnostic = diagnostic.did_you_mean(&name.value, own());
            self.diagnostics.push(diagnostic);
        }
        found
    }

    /// Only a function with a workgroup shares memory.
    fn workgroup(&mut self, at: usize, function: &Function, reflection: &Reflection) {
        if self.declared.made[at].shape.workgroup().is_none() && reflection.sharing.contains(&function.name) {
            self.no_workgroup(at, function, &function.name);
        }
    }

    fn no_workgroup(&mut self, at: usize, function: &Function, word: &str) {
        let made = &self.declared.made[at].name;
        let location = self.word(word, &format!("fn {}", function.name));
        let message = format!("{} shares memory of a workgroup, which it has not", quote(&function.name));
        let diagnostic = Diagnostic::error("no-workgroup", message).at(&location, "");
        let help = "declare `workgroup: (16, 16)` for the image that it makes";
        self.diagnostics.push(diagnostic.also(&made.location, "this is the image").help(help));
    }

    fn argument(&mut self, at: usize, function: &Function, name: &str, ty: &ArgType, reflection: &Reflection) {
        match ty {
            ArgType::Struct(layout) if name == "params" => match reflection.layout(layout) {
                Some(layout) => layout.members.iter().for_each(|member| self.member(layout, member)),
                None => self.not_numbers(layout),
            },
            ArgType::Struct(layout) => {
                self.port(at, function, name, ty);
                self.block(function, name, reflection.layout(layout));
            }
            ArgType::Point if name == "at" => {}
            ArgType::Frame if name == "frame" => {}
            ArgType::Invocation if name == "invocation" && self.declared.made[at].shape.workgroup().is_some() => {}
            ArgType::Invocation if name == "invocation" => self.no_workgroup(at, function, name),
            ArgType::Sampler => self.sampler(function, name),
            _ => self.port(at, function, name, ty),
        }
    }

    /// The struct of a host block is that of the framework's library, or has its members.
    fn block(&mut self, function: &Function, name: &str, layout: Option<&StructLayout>) {
        let port = self.declared.inputs.iter().find(|(port, _)| port.name == name);
        let Some(block) = port.and_then(|(port, _)| port.block) else { return };
        if !layout.is_some_and(|layout| block.fits(layout)) {
            let location = self.word(name, &format!("fn {}", function.name));
            let message = format!("the type of {} has not the members of the block {}", quote(name), quote(block.name));
            let help = format!("`import afterimage::{}::{};` declares it", block.name.to_lowercase(), block.name);
            self.diagnostics.push(Diagnostic::error("shader-argument", message).at(&location, "").help(help));
        }
    }

    /// A member of the parameters is neither a number nor a vector.
    fn not_numbers(&mut self, layout: &str) {
        let location = self.word(layout, "struct");
        let message = format!("the struct {} has a member that no parameter fits", quote(layout));
        let help = "its members are `f32`, `i32`, `u32`, `vec2f`, `vec3f` and `vec4f`";
        self.diagnostics.push(Diagnostic::error("shader-params", message).at(&location, "").help(help));
    }

    fn sampler(&mut self, function: &Function, name: &str) {
        let at = function.args.iter().position(|(arg, _)| arg == name).unwrap_or(0);
        let before = at.checked_sub(1).map(|before| &function.args[before]);
        let follows = before.is_some_and(|(texture, ty)| {
            matches!(ty, ArgType::Texture | ArgType::Volume) && name == format!("{texture}_sampler")
        });
        if !follows {
            let location = self.word(name, &format!("fn {}", function.name));
            let message = format!("the sampler {} does not follow its texture", quote(name));
            let help = "write `source: texture_2d<f32>, source_sampler: sampler`";
            self.diagnostics.push(Diagnostic::error("shader-argument", message).at(&location, "").help(help));
        }
    }

    fn member(&mut self, layout: &StructLayout, member: &Member) {
        let location = self.word(&member.name, &format!("struct {}", layout.name));
        let Some((param, declared)) = self.declared.params.iter().find(|(param, _)| param.name == member.name) else {
            let names = || self.declared.params.iter().map(|(param, _)| &*param.name);
            let message = format!("{} of {} is not a parameter of the node", quote(&member.name), quote(&layout.name));
            let diagnostic =
                Diagnostic::error("shader-params", message).at(&location, "").help("declare it under `parameters`");
            return self.diagnostics.push(diagnostic.did_you_mean(&member.name, names()));
        };
        self.used.insert(member.name.clone());
        if !holds(member, param) {
            let message = format!("{} is {} and does not fit its member", quote(&param.name), param.ty.describe());
            let diagnostic = Diagnostic::error("shader-params", message)
                .at(&location, "the shader takes it here")
                .also(declared, "the node declares it here")
                .help(
                    "`Float` goes into `f32`, `Int` into `i32`, `u32` or `f32`, `Bool` into `u32`, `Vector3` \
                       into `vec3f`",
                );
            self.diagnostics.push(diagnostic);
        }
    }
}

fn holds(member: &Member, param: &Param) -> bool {
    let width = match param.ty {
        Type::Vector(n) => n as u32,
        _ => 1,
    };
    let is_float = member.scalar == ScalarKind::Float;
    let kind = match param.ty {
        Type::Float | Type::Vector(_) => is_float,
        Type::Bool => !is_float,
        _ => true,
    };
    let is_array = member.stride > 0;
    !is_array && member.width == width && kind
}
