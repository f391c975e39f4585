//! What the bindings of an entry point hold.

use super::{Arrival, Recorder};
use crate::node::drawing::Subresource;
use crate::node::kernel::{Arg, Argument};
use crate::node::resource::Resource;
use afterimage_wgsl::{GlobalKind, Shader, UniformValue};

/// What the variables of a module hold, where that is no input of the same name, and the numbers of its uniform.
pub(super) struct Bindings<'a> {
    bound: Vec<(&'static str, Bound)>,
    /// The parameters, and after them what the node computes.
    uniform: Vec<(&'a str, UniformValue)>,
}

/// What a variable holds.
#[derive(Clone, Copy)]
pub(super) enum Bound {
    /// A whole image or buffer.
    Resource(Resource),
    /// A mip level of a layer.
    Level(Subresource),
}

impl<'a> Bindings<'a> {
    pub(super) fn new(recorder: &Recorder<'a>) -> Self {
        Self { bound: Vec::new(), uniform: recorder.parameters.clone() }
    }

    pub(super) fn bind(&mut self, variable: &'static str, bound: Bound) {
        self.bound.push((variable, bound));
    }

    pub(super) fn set(&mut self, name: &'a str, value: UniformValue) {
        self.uniform.push((name, value));
    }

    /// The arguments of a module's entry point, and the bytes of its uniform.
    pub(super) fn arguments(&self, recorder: &Recorder<'a>, shader: &Shader, entry: &str) -> (Vec<Argument>, Vec<u8>) {
        let reflection = recorder.reflection(shader);
        let mut args = Vec::new();
        let mut uniform = Ok(Vec::new());
        for global in &reflection.globals {
            if let Some(value) = block(recorder, &global.name) {
                args.push(Argument { name: global.name.clone(), value });
                continue;
            }
            match &global.kind {
                GlobalKind::Uniform(ty) => uniform = reflection.pack(ty, &self.uniform),
                kind => args.extend(self.held(recorder, &global.name).map(|held| {
                    require_texture(recorder, (entry, &global.name), held);
                    Argument { name: global.name.clone(), value: argument(kind, held) }
                })),
            }
        }
        (args, uniform.unwrap_or_else(|why| panic!("{shader:?}: {why}")))
    }

    fn held(&self, recorder: &Recorder<'_>, name: &str) -> Option<Bound> {
        let bound = self.bound.iter().find(|(variable, _)| *variable == name).map(|(_, bound)| *bound);
        bound.or_else(|| {
            let index = recorder.kind.inputs.iter().position(|input| input.name == name)?;
            match &recorder.arrivals[index] {
                Arrival::Image(image) => Some(Bound::Resource(Resource::Image(*image))),
                Arrival::Buffer(buffer) => Some(Bound::Resource(Resource::Buffer(*buffer))),
                _ => None,
            }
        })
    }
}

/// The host block at the input of that name.
fn block(recorder: &Recorder<'_>, name: &str) -> Option<Arg> {
    let index = recorder.kind.inputs.iter().position(|input| input.name == name)?;
    match recorder.arrivals[index] {
        Arrival::Block(block) => Some(Arg::Block(block)),
        _ => None,
    }
}

/// Entry points take no samples and no arrays.
fn require_texture(recorder: &Recorder<'_>, (entry, name): (&str, &str), held: Bound) {
    let image = match held {
        Bound::Resource(held) => held.image(),
        Bound::Level(part) => Some(part.image),
    };
    let Some(desc) = image.map(|image| recorder.desc(image)) else { return };
    let samples = desc.samples;
    assert!(samples == 1, "`{name}` of `{entry}` has {samples} samples: functions alone read these");
    match held {
        Bound::Level(part) => recorder.require_part(part, entry),
        Bound::Resource(_) => {
            assert!(desc.layers == 1, "`{name}` of `{entry}` has {} layers: bind one with `level`", desc.layers);
        }
    }
}

fn argument(kind: &GlobalKind, held: Bound) -> Arg {
    match (held, kind) {
        (Bound::Resource(Resource::Image(image)), GlobalKind::StorageTexture(_)) => Arg::Storage(image),
        (Bound::Resource(Resource::Image(image)), _) => Arg::Texture(image),
        (Bound::Resource(Resource::Buffer(buffer)), kind) => {
            Arg::Buffer(buffer, matches!(kind, GlobalKind::Buffer(true)))
        }
        (Bound::Level(part), _) => Arg::Level(part),
    }
}
