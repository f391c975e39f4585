//! Resources of the bindings of an entry point.

use super::details::{Bindings, Bound};
use super::{InputValue, Recorder};
use crate::node::kernel::{Arg, Argument, KernelCall};
use crate::node::resource::Resource;
use afterimage_base::Shared;
use afterimage_wgsl::{Global, GlobalKind, Shader};

impl Bindings {
    /// The arguments of a module's entry point, by their names.
    pub(super) fn arguments<'s>(
        &'s self,
        recorder: &'s Recorder<'_>,
        shader: &'s Shader,
        entry: &'s str,
    ) -> impl Iterator<Item = (&'s str, Arg)> {
        let globals = recorder.shaders.reflection(shader).globals.iter();
        globals.filter_map(move |global| Some((global.name.as_str(), self.argument(recorder, entry, global)?)))
    }

    fn argument(&self, recorder: &Recorder<'_>, entry: &str, global: &Global) -> Option<Arg> {
        if let Some(block) = block(recorder, &global.name) {
            return Some(block);
        }
        if let GlobalKind::Uniform(_) = global.kind {
            return None;
        }
        let bound = self.resolve(recorder, &global.name)?;
        require_texture(recorder, entry, &global.name, bound);
        Some(argument(&global.kind, bound))
    }

    /// The call of a module's entry point.
    pub(super) fn call(&self, recorder: &Recorder<'_>, shader: Shared<Shader>, entry: Shared<str>) -> KernelCall {
        let args = self
            .arguments(recorder, &shader, &entry)
            .map(|(name, value)| Argument { name: name.to_owned(), value })
            .collect();
        let uniform = recorder.uniform(&shader, params(recorder, &shader), &self.computed);
        KernelCall { args, uniform, ..KernelCall::function(recorder.context.node, shader, entry, &[]) }
    }

    fn resolve(&self, recorder: &Recorder<'_>, name: &str) -> Option<Bound> {
        let bound = self.bound.iter().find(|(variable, _)| *variable == name).map(|(_, bound)| *bound);
        bound.or_else(|| {
            let index = recorder.context.kind.inputs.iter().position(|input| input.name == name)?;
            match &recorder.context.inputs[index] {
                InputValue::Image(image) => Some(Bound::Resource(Resource::Image(*image))),
                InputValue::Buffer(buffer) => Some(Bound::Resource(Resource::Buffer(*buffer))),
                _ => None,
            }
        })
    }
}

/// The struct of the uniform of a module's entry points, if it has one.
pub(super) fn params<'s>(recorder: &Recorder<'_>, shader: &'s Shader) -> Option<&'s str> {
    let globals = recorder.shaders.reflection(shader).globals.iter();
    let of_node = globals.filter(|global| block(recorder, &global.name).is_none());
    of_node
        .filter_map(|global| match &global.kind {
            GlobalKind::Uniform(ty) => Some(ty.as_str()),
            _ => None,
        })
        .next_back()
}

/// The host block at the input of that name.
fn block(recorder: &Recorder<'_>, name: &str) -> Option<Arg> {
    let index = recorder.context.kind.inputs.iter().position(|input| input.name == name)?;
    match recorder.context.inputs[index] {
        InputValue::Block(block) => Some(Arg::Block(block)),
        _ => None,
    }
}

/// Entry points take no samples and no arrays.
fn require_texture(recorder: &Recorder<'_>, entry: &str, name: &str, bound: Bound) {
    let image = match bound {
        Bound::Resource(resource) => resource.image(),
        Bound::Level(part) => Some(part.image),
    };
    let Some(desc) = image.map(|image| recorder.desc(image)) else { return };
    let samples = desc.samples;
    assert!(samples == 1, "`{name}` of `{entry}` has {samples} samples: functions alone read these");
    match bound {
        Bound::Level(part) => recorder.resources.require_part(part, entry),
        Bound::Resource(_) => {
            assert!(desc.layers == 1, "`{name}` of `{entry}` has {} layers: bind one with `level`", desc.layers);
        }
    }
}

fn argument(kind: &GlobalKind, bound: Bound) -> Arg {
    match (bound, kind) {
        (Bound::Resource(Resource::Image(image)), GlobalKind::StorageTexture(_)) => Arg::Storage(image),
        (Bound::Resource(Resource::Image(image)), _) => Arg::Texture(image),
        (Bound::Resource(Resource::Buffer(buffer)), kind) => {
            Arg::Buffer(buffer, matches!(kind, GlobalKind::Buffer(true)))
        }
        (Bound::Level(part), _) => Arg::Level(part),
    }
}
