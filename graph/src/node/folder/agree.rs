//! Agreement of a `node.ron` with its shader.

use std::collections::BTreeSet;
use std::sync::Arc;

use super::declaration::{Declaration, DeclaredOutput};
use crate::node::PortType;
use crate::node::contract::{is_pascal, snake, stem};
use afterimage_base::diagnostic::{Diagnostic, Diagnostics, Location, did_you_mean, list, quote};
use afterimage_base::value::{Param, Type};
use afterimage_wgsl::{ArgType, Function, Member, Reflection, ScalarKind, Shader, StructLayout};

pub(super) fn look(declared: &Declaration, shader: &Shader, reflection: &Reflection, diagnostics: &mut Diagnostics) {
    let mut pair = Pair { declared, file: shader.file().into(), source: shader.text(), diagnostics };
    pair.names();
    let mut used = BTreeSet::new();
    for output in &declared.outputs {
        if let Some(function) = pair.function(output, reflection) {
            for (name, ty) in &function.args {
                pair.argument(function, name, ty, reflection, &mut used);
            }
        }
    }
    pair.unused(&used);
}

struct Pair<'a> {
    declared: &'a Declaration,
    file: Arc<str>,
    source: &'a str,
    diagnostics: &'a mut Diagnostics,
}

impl Pair<'_> {
    /// The location of a word in the shader, searched after another one.
    fn word(&self, word: &str, after: &str) -> Location {
        let from = self.source.find(after).unwrap_or(0);
        let is_word = |c: Option<char>| c.is_some_and(|c| c.is_alphanumeric() || c == '_');
        let found = self.source[from..].match_indices(word).map(|(at, _)| from + at).find(|at| {
            !is_word(self.source[..*at].chars().next_back()) && !is_word(self.source[at + word.len()..].chars().next())
        });
        let start = found.unwrap_or(from);
        Location::new(&self.file, start..(start + word.len()).min(self.source.len()))
    }

    /// The file is named after the kind.
    fn names(&mut self) {
        let name = &self.declared.name;
        let (file, wanted) = (stem(&self.file).to_owned(), snake(&name.value));
        if !is_pascal(&name.value) {
            let message = format!("{} is no name of a kind", quote(&name.value));
            let help = "it begins with a capital letter and holds letters and digits only, as `ToneMap` does";
            return self.diagnostics.push(Diagnostic::error("bad-name", message).at(&name.location, "").help(help));
        }
        if file != wanted {
            let message = format!("the shader of {} is called `{file}.wgsl`", quote(&name.value));
            let diagnostic = Diagnostic::error("file-name", message).at(&name.location, "");
            self.diagnostics.push(diagnostic.help(format!("rename it to `{wanted}.wgsl`")));
        }
    }

    fn function<'r>(&mut self, output: &DeclaredOutput, reflection: &'r Reflection) -> Option<&'r Function> {
        let name = &output.function;
        let found = reflection.function(&name.value);
        if found.is_none() {
            let own = || reflection.functions.iter().map(|function| function.name.as_str());
            let help = match own().next() {
                None => format!("write `fn {}(source: vec4f) -> vec4f`", name.value),
                Some(_) => format!("it has {}", list(own(), 8)),
            };
            let message = format!("the shader has no function {} that gives a `vec4f`", quote(&name.value));
            let diagnostic = Diagnostic::error("no-function", message).at(&name.location, "").help(help);
            let diagnostic = diagnostic.maybe_help(did_you_mean(&name.value, own()));
            self.diagnostics.push(diagnostic);
        }
        found
    }

    fn argument(
        &mut self,
        function: &Function,
        name: &str,
        ty: &ArgType,
        reflection: &Reflection,
        used: &mut BTreeSet<String>,
    ) {
        match ty {
            ArgType::Struct(layout) if name == "params" => match reflection.layout(layout) {
                Some(layout) => layout.members.iter().for_each(|member| self.member(layout, member, used)),
                None => self.not_numbers(layout),
            },
            ArgType::Point if name == "at" => {}
            ArgType::Frame if name == "frame" => {}
            ArgType::Sampler => self.sampler(function, name),
            _ => self.port(function, name, ty, used),
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

    fn port(&mut self, function: &Function, name: &str, ty: &ArgType, used: &mut BTreeSet<String>) {
        let location = self.word(name, &format!("fn {}", function.name));
        let Some((port, declared)) = self.declared.inputs.iter().find(|(port, _)| port.name == name) else {
            let names = || self.declared.inputs.iter().map(|(port, _)| &*port.name).chain(["at", "frame", "params"]);
            let message = format!("the argument {} is no input of the node", quote(name));
            let help = format!("arguments are {}", list(names(), 12));
            let diagnostic = Diagnostic::error("shader-argument", message).at(&location, "").help(help);
            return self.diagnostics.push(diagnostic.maybe_help(did_you_mean(name, names())));
        };
        used.insert(name.to_owned());
        let (fits, wanted) = match port.ty {
            PortType::Volume => (*ty == ArgType::Volume, "`texture_3d<f32>`"),
            PortType::Value => (matches!(ty, ArgType::Floats(1..=4)), "`f32`, `vec2f`, `vec3f` or `vec4f`"),
            _ => (matches!(ty, ArgType::Floats(4) | ArgType::Texture), "`vec4f` or `texture_2d<f32>`"),
        };
        if !fits {
            let message = format!("the argument {} is a {} and needs the type {wanted}", quote(name), port.ty.name());
            let diagnostic = Diagnostic::error("shader-argument", message).at(&location, "the shader takes it here");
            self.diagnostics.push(diagnostic.also(declared, "the node declares it here"));
        }
    }

    fn member(&mut self, layout: &StructLayout, member: &Member, used: &mut BTreeSet<String>) {
        let location = self.word(&member.name, &format!("struct {}", layout.name));
        let Some((param, declared)) = self.declared.params.iter().find(|(param, _)| param.name == member.name) else {
            let names = || self.declared.params.iter().map(|(param, _)| &*param.name);
            let message = format!("{} of {} is no parameter of the node", quote(&member.name), quote(&layout.name));
            let diagnostic =
                Diagnostic::error("shader-params", message).at(&location, "").help("declare it under `parameters`");
            return self.diagnostics.push(diagnostic.maybe_help(did_you_mean(&member.name, names())));
        };
        used.insert(member.name.clone());
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

    fn unused(&mut self, used: &BTreeSet<String>) {
        if self.diagnostics.has_errors() {
            return;
        }
        let inputs = self.declared.inputs.iter().map(|(port, location)| ("input", &*port.name, location));
        let params = self.declared.params.iter().map(|(param, location)| ("parameter", &*param.name, location));
        for (what, name, location) in inputs.chain(params).filter(|(_, name, _)| !used.contains(*name)) {
            let message = format!("the shader does not read the {what} {}", quote(name));
            let help = match what {
                "input" => "take it as an argument of the function, or leave it out",
                _ => "add it to the struct of the argument `params`, or leave it out",
            };
            self.diagnostics.push(Diagnostic::error("unread", message).at(location, "").help(help));
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
