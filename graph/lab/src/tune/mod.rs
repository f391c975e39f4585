//! The choice of quality switches with the smallest error within a time, or the shortest time within an error.

mod measurer;
mod search;
mod space;
mod state;
mod steps;
mod target;
mod tiers;
mod tuner;

use std::path::Path;

use afterimage_gpu::Gpu;
use afterimage_graph::node::Registry;

pub use crate::measure::node_change::changes;
pub use measurer::TunePipeline;
pub use target::{MARGIN, Measured, TuneTarget, claimed_flip, claimed_jod, claimed_p999};
pub use tiers::{Goal, Tier};

use measurer::ChoiceMeasurer;
use state::SearchState;
use steps::Steps;
use tuner::Tuner;

use crate::measure::MeasureOptions;
use crate::{LabError, Progress};

/// A search for several goals times each choice with the samples divided by this.
const ROUGHLY: u32 = 3;

/// The result of a search.
#[derive(Clone, Debug)]
pub struct Tuned {
    /// The most accurate first.
    pub tiers: Vec<Tier>,
    /// Goals that gave no tier, with the reasons, for a user.
    pub left_out: Vec<String>,
    /// The cost of each format of a wire alone, a sentence each.
    pub wires: Vec<String>,
    /// The number of choices with measured figures.
    pub choices: usize,
}

/// Searches the choices of a pipeline's quality switches for each goal: a greedy descent from the most accurate choice,
/// each step of which is measured. All goals share all figures. `state` is a file of figures: a search that was
/// interrupted continues from it.
///
/// The search sees every other image, and some charts. What it finds is measured on the others, too, and searched again
/// within less if its errors are beyond the goal there. Errors are claimed a tenth above the worst.
///
/// Of several goals, the most accurate first, those are left out that no choice meets, whose tier another beats in time
/// and error, or whose tier is not a quarter cheaper than the one before.
///
/// # Errors
/// No choice meets the only goal; and everything that a measurement reports.
pub fn tune(
    gpu: &Gpu,
    registry: &Registry,
    pipeline: &TunePipeline,
    options: &MeasureOptions,
    goals: &[Goal],
    state: Option<&Path>,
    progress: &dyn Progress,
) -> Result<Tuned, LabError> {
    let mut steps = Steps::new(progress, goals.len() as u64);
    steps.add(tiers::last_steps(goals.len()));
    let mut measurer = ChoiceMeasurer::prepare(gpu, registry, pipeline, options, &mut steps)?;
    if goals.len() > 1 {
        // The tiers that are found are timed by turns.
        measurer.samples = measurer.samples.div_ceil(ROUGHLY);
    }
    let state = SearchState::open(state, measurer.identity(pipeline)?)?;
    let mut tuner = Tuner::new(measurer, state, steps);
    let (tiers, left_out) = tiers::tiers(&mut tuner, goals)?;
    tuner.steps.finish();
    Ok(Tuned { tiers, left_out, wires: tuner.wires(), choices: tuner.state.len() })
}
