//! Colorimetry of outputs as text and as JSON.

use afterimage_base::color::Colorimetry;
use afterimage_graph::node::ImageColor;
use serde_json::{Value, json};

use crate::plan::PlanOutput;

/// The colorimetry of an output. The chromaticities are those of red, green, blue and white.
pub(super) fn colorimetry(colorimetry: Colorimetry) -> Value {
    let Colorimetry { primaries, transfer, white_nits, peak_nits, adopted_white } = colorimetry;
    json!({
        "adopted_white": adopted_white.map(|white| white.to_vec().to_array()),
        "chromaticities": primaries.points().map(|point| point.to_vec().to_array()),
        "peak_nits": peak_nits.map(|nits| nits.get()),
        "primaries": primaries.name(),
        "transfer": transfer.to_string(),
        "white_nits": white_nits.map(|nits| nits.get()),
    })
}

/// The color state and the colorimetry: `Encoded: Pq, Rec2020, white at 203 cd/m2, peak at 1000 cd/m2`.
pub(super) fn described(output: &PlanOutput) -> String {
    let (state, colorimetry) = (output.state, output.colorimetry);
    if !(ImageColor { state, colorimetry }).is_picture() {
        return state.name().to_owned();
    }
    let Colorimetry { primaries, transfer, white_nits, peak_nits, adopted_white } = colorimetry;
    let space = primaries.name().unwrap_or("other primaries");
    let mut parts = vec![format!("{}: {transfer}", state.name()), space.to_owned()];
    parts.extend(white_nits.map(|nits| format!("white at {nits} cd/m2")));
    parts.extend(peak_nits.map(|nits| format!("peak at {nits} cd/m2")));
    parts.extend(adopted_white.map(|white| format!("adapted to x {} y {}", white.x, white.y)));
    parts.join(", ")
}
