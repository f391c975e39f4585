//! Sources of the functions of a kind: by their arguments, and by the names in its `node.ron`.

use super::agree::Pair;
use super::declaration::{COARSER, Made, Shape, Source};
use crate::node::PortType;
use afterimage_base::diagnostic::{Diagnostic, Location, Spanned, list, quote};
use afterimage_wgsl::limits::TEXTURES;
use afterimage_wgsl::{ArgType, Function};

impl Pair<'_> {
    /// Checks that each named source exists before its use, and fits.
    pub(super) fn named_sources(&mut self, at: usize) {
        let made = &self.declared.made[at];
        if let Some((of, expected)) = made.shape.of() {
            self.named_source(at, of, &[expected]);
        }
        for (_, read) in &made.reads {
            let expected: &[PortType] = match read.level {
                Some(_) => &[PortType::Pyramid],
                None => &[PortType::Image, PortType::Volume, PortType::Table],
            };
            self.named_source(at, &read.of, expected);
        }
    }

    fn named_source(&mut self, at: usize, name: &Spanned<String>, expected: &[PortType]) {
        let error = match self.declared.named(&name.value, at).map(|source| self.declared.ty(source)) {
            Some(ty) if expected.contains(&ty) => {
                self.used.insert(name.value.clone());
                return;
            }
            Some(ty) => {
                let expected = list(expected.iter().map(|ty| ty.name()), expected.len());
                let message = format!("{} is a {}, and not one of {expected}", quote(&name.value), ty.name());
                Diagnostic::error("wrong-source", message)
            }
            None => {
                let message = format!("nothing before this one is called {}", quote(&name.value));
                self.unknown(at, &name.value, message, &[])
            }
        };
        self.diagnostics.push(error.at(&name.location, ""));
    }

    /// The error of a name that means nothing at that place.
    fn unknown(&self, at: usize, name: &str, message: String, more: &[&str]) -> Diagnostic {
        let inputs = self.declared.inputs.iter().map(|(port, _)| &*port.name);
        let made = self.declared.made[..at].iter().map(|made| made.name.value.as_str());
        let names: Vec<&str> = inputs.chain(made).chain(more.iter().copied()).collect();
        let error = Diagnostic::error("shader-argument", message);
        match self.declared.made[at..].iter().find(|made| made.name.value == name) {
            Some(later) => {
                error.also(&later.name.location, "it is made here").help("a function reads what is made before")
            }
            None => {
                let error = error.help(format!("there are {}", list(names.iter().copied(), 16)));
                error.did_you_mean(name, names)
            }
        }
    }

    /// An argument that reads an input or what a function has made.
    pub(super) fn port(&mut self, at: usize, function: &Function, name: &str, ty: &ArgType) {
        let location = self.word(name, &format!("fn {}", function.name));
        let Some(source) = self.declared.source(at, name) else {
            let more: &[&str] = match self.declared.made[at].shape {
                Shape::Up { .. } => &[COARSER, "at", "frame", "params"],
                Shape::Image { workgroup: Some(_) } => &["at", "frame", "invocation", "params"],
                _ => &["at", "frame", "params"],
            };
            let name_is = format!("the argument {} is not an input of the node", quote(name));
            let error = self.unknown(at, name, format!("{name_is}, nor an image made before it"), more);
            return self.diagnostics.push(error.at(&location, ""));
        };
        self.used.insert(name.to_owned());
        let port_type = self.declared.ty(source);
        let (fits, expected) = match port_type {
            PortType::Volume => (*ty == ArgType::Volume, "`texture_3d<f32>`"),
            PortType::Value => (matches!(ty, ArgType::Floats(1..=4)), "`f32`, `vec2f`, `vec3f` or `vec4f`"),
            PortType::Table => (*ty == ArgType::Texture, "`texture_2d<f32>`, which `afterimage::table` reads"),
            PortType::Pyramid => {
                (false, "of a level: name it in `reads`, as `\"low\": Level(\"levels\", 3)`, or use `each` or `up`")
            }
            PortType::Multisampled => (false, "of a kind in Rust: folders read no samples"),
            PortType::Block => (matches!(ty, ArgType::Struct(_)), "of the struct `afterimage::camera::Camera`"),
            PortType::Image => (matches!(ty, ArgType::Floats(4) | ArgType::Texture), "`vec4f` or `texture_2d<f32>`"),
        };
        if !fits {
            let message =
                format!("the argument {} is a {} and needs the type {expected}", quote(name), port_type.name());
            let error = Diagnostic::error("shader-argument", message).at(&location, "the shader takes it here");
            let declared = self.location(at, source);
            return self.diagnostics.push(error.also(&declared, "the node declares it here"));
        }
        if port_type == PortType::Image && *ty != ArgType::Texture && self.declared.differs_in_size(at, source) {
            let message = format!("the argument {} is a pixel of an image that may have another size", quote(name));
            let help = format!("take it as `{name}: texture_2d<f32>, {name}_sampler: sampler` and read it with `tap`");
            self.diagnostics.push(Diagnostic::error("shader-argument", message).at(&location, "").help(help));
        }
    }

    /// Location of the declaration of a source.
    fn location(&self, at: usize, source: Source) -> Location {
        match source {
            Source::Input(input) => self.declared.inputs[input].1.clone(),
            Source::Made(made) => self.declared.made[made].name.location.clone(),
            Source::Level(..) | Source::AtHand | Source::Coarser => self.declared.made[at].name.location.clone(),
        }
    }

    /// Names in `reads` are arguments, and a device binds a fixed number of textures.
    pub(super) fn arguments(&mut self, at: usize, function: &Function) {
        let made = &self.declared.made[at];
        for (name, _) in &made.reads {
            if !function.args.iter().any(|(arg, _)| *arg == name.value) {
                let message = format!("{} has no argument {}", quote(&function.name), quote(&name.value));
                let help = format!("its arguments are {}", list(function.args.iter().map(|(arg, _)| arg.as_str()), 16));
                self.diagnostics.push(Diagnostic::error("shader-argument", message).at(&name.location, "").help(help));
            }
        }
        let is_texture = |ty: &ArgType| matches!(ty, ArgType::Texture | ArgType::Volume);
        if let Some(message) = TEXTURES.exceeded(function.args.iter().filter(|(_, ty)| is_texture(ty)).count()) {
            self.diagnostics.push(Diagnostic::error("limit", message).at(&made.name.location, ""));
        }
    }

    /// Reports what no function reads.
    pub(super) fn unused(&mut self) {
        if self.diagnostics.has_errors() {
            return;
        }
        let inputs = self.declared.inputs.iter().map(|(port, location)| ("input", &*port.name, location));
        let between = |made: &&Made| made.port.is_none();
        let images = self.declared.made.iter().filter(between);
        let images = images.map(|made| ("image", made.name.value.as_str(), &made.name.location));
        let params = self.declared.params.iter().map(|(param, location)| ("parameter", &*param.name, location));
        for (what, name, location) in inputs.chain(images).chain(params) {
            if self.used.contains(name) {
                continue;
            }
            let message = format!("the shader does not read the {what} {}", quote(name));
            let help = match what {
                "parameter" => "add it to the struct of the argument `params`, or leave it out",
                _ => "take it as an argument of a function, or leave it out",
            };
            self.diagnostics.push(Diagnostic::error("unread", message).at(location, "").help(help));
        }
    }
}
