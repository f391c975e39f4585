//! A drawing pass whose entry points its author has written: its overrides and bindings are set.

use afterimage_graph::node::Drawing;
use afterimage_wgsl::{SampleMode, ShaderError, SourceMap};

use super::compute::bind;
use super::module::{Composed, Draw, PassCode};

/// The module of a drawing pass; an empty one if the pass only clears, or the host draws.
pub(super) fn compose_drawing(code: &PassCode<'_>, drawing: &Drawing) -> Result<Composed, ShaderError> {
    let (Some(geometry), [kernel]) = (drawing.geometry(), code.pass.kernels.as_slice()) else {
        return Ok(without_module());
    };
    let mut linker = code.linker();
    let instance = linker.add_copy(kernel.shader.source())?;
    let (slots, immediate) = bind(code, kernel, &mut linker, instance)?;
    let entries: Vec<_> =
        std::iter::once(&kernel.function).chain(&geometry.fragment).map(|name| (instance, &**name)).collect();
    let linked = linker.link(String::new(), &entries)?;
    let mut names = linked.entries.into_iter();
    let vertex = names.next().expect("a drawing pass has a vertex entry point");
    Ok(Composed {
        source: linked.text,
        map: linked.map,
        draw: Some(Draw { vertex, fragment: names.next() }),
        slots,
        immediate,
        unchecked: kernel.shader.is_unchecked(),
        sample_mode: code.sample_mode(),
        ..without_module()
    })
}

/// The empty module of a pass that draws nothing itself.
fn without_module() -> Composed {
    Composed {
        source: String::new(),
        map: SourceMap::default(),
        compute: String::new(),
        draw: None,
        slots: Vec::new(),
        immediate: false,
        workgroup: [1; 3],
        unchecked: false,
        sample_mode: SampleMode::Plain,
        zero_workgroup_memory: false,
    }
}
