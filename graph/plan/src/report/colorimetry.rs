//! Colorimetry of outputs as text.

use afterimage_base::color::Colorimetry;
use afterimage_graph::node::ImageColor;

use crate::plan::PlanOutput;

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
