//! Pipelines that are made to be expensive: small texts that ask for much work, and the files that they name.

mod bomb;
mod documents;
mod graphs;

pub use bomb::Bomb;

use documents::{
    conditions, cycle, extends, facts, fields, inner_inputs, inner_outputs, inputs, nested, nested_comments,
    nested_conditions, nested_facts, nested_labels, nested_names, nested_tiers, outputs, outputs_of_one, settings,
    tiers, unknown_facts, unknown_fields, unknown_kinds, unknown_names, unknown_outputs,
};
use graphs::{
    blurred_fan_in, blurs, fan_in, fan_out, ladder, live_pyramids, lives, meters, points, previous, previous_backwards,
    previous_far, pyramids, readers, stencils, tables, transforms,
};

/// Makes a bomb of a size: the number of what it has many of.
pub type MakeBomb = fn(usize) -> Bomb;

/// All bombs, by name, in the order of the stages that they load.
pub const BOMBS: &[(&str, MakeBomb)] = &[
    ("points", points),
    ("stencils", stencils),
    ("blurs", blurs),
    ("pyramids", pyramids),
    ("meters", meters),
    ("fan-out", fan_out),
    ("fan-in", fan_in),
    ("blurred-fan-in", blurred_fan_in),
    ("lives", lives),
    ("live-pyramids", live_pyramids),
    ("transforms", transforms),
    ("tables", tables),
    ("readers", readers),
    ("ladder", ladder),
    ("previous", previous),
    ("previous-backwards", previous_backwards),
    ("previous-far", previous_far),
    ("outputs", outputs),
    ("outputs-of-one", outputs_of_one),
    ("inputs", inputs),
    ("inner-inputs", inner_inputs),
    ("inner-outputs", inner_outputs),
    ("tiers", tiers),
    ("settings", settings),
    ("facts", facts),
    ("conditions", conditions),
    ("nested-conditions", nested_conditions),
    ("extends", extends),
    ("nested", nested),
    ("nested-facts", nested_facts),
    ("nested-tiers", nested_tiers),
    ("nested-comments", nested_comments),
    ("nested-names", nested_names),
    ("nested-labels", nested_labels),
    ("fields", fields),
    ("unknown-names", unknown_names),
    ("unknown-fields", unknown_fields),
    ("unknown-outputs", unknown_outputs),
    ("unknown-facts", unknown_facts),
    ("unknown-kinds", unknown_kinds),
    ("cycle", cycle),
];
