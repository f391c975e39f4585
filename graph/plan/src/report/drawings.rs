//! Drawing passes, as JSON shows them.

use serde_json::{Value, json};

use super::names::Names;
use crate::plan::PlannedPass;
use afterimage_graph::node::{
    ColorAttachment, DepthAttachment, DrawContents, Drawing, Draws, Geometry, Load, Resource, Subresource, VertexBuffer,
};

/// What a pass draws and how; `None` for other passes.
pub(super) fn drawing(planned: &PlannedPass, names: &Names) -> Option<Value> {
    let Drawing { colors, depth, contents } = planned.pass.drawing()?;
    Some(json!({
        "colors": colors.iter().map(|color| color_view(color, names)).collect::<Value>(),
        "depth": depth.map(|depth| depth_view(&depth, names)),
        "draws": match contents {
            DrawContents::Nothing => json!("nothing"),
            DrawContents::Host => json!("host"),
            DrawContents::Geometry(geometry) => geometry_view(geometry, names),
        },
        "stores": planned.stores,
    }))
}

fn part(part: Subresource, names: &Names) -> Value {
    json!({ "image": names.image(part.image), "layer": part.layer, "level": part.level })
}

fn color_view(color: &ColorAttachment, names: &Names) -> Value {
    let load = match color.load {
        Load::Clear(color) => json!(color),
        Load::Keep => json!("keep"),
    };
    json!({
        "blend": format!("{:?}", color.blend),
        "load": load,
        "target": part(color.target, names),
        "writes": color.writes.0,
    })
}

fn depth_view(depth: &DepthAttachment, names: &Names) -> Value {
    let load = match depth.test.load {
        Load::Clear(depth) => json!(depth),
        Load::Keep => json!("keep"),
    };
    json!({
        "compare": format!("{:?}", depth.test.compare),
        "load": load,
        "target": part(depth.target, names),
        "write": depth.test.write,
    })
}

fn geometry_view(geometry: &Geometry, names: &Names) -> Value {
    let buffer = |buffer| names.of(Resource::Buffer(buffer));
    let vertices = |vertices: &VertexBuffer| {
        json!({
            "buffer": buffer(vertices.buffer),
            "formats": format!("{:?}", vertices.formats),
            "per_instance": vertices.per_instance,
        })
    };
    let ranges = match &geometry.draws {
        Draws::Ranges(ranges) => json!(ranges.iter().map(|range| format!("{range:?}")).collect::<Vec<_>>()),
        Draws::Indirect(indirect) => {
            json!({ "buffer": buffer(indirect.buffer), "offset": indirect.offset, "ranges": indirect.ranges })
        }
    };
    json!({
        "fragment": geometry.fragment.as_deref(),
        "indices": geometry.indices.map(buffer),
        "ranges": ranges,
        "raster": format!("{:?}", geometry.raster),
        "vertices": geometry.vertices.iter().map(vertices).collect::<Value>(),
    })
}
