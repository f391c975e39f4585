//! Graph to plan: passes, their order, the barriers between them, the memory of their images, and their shader code.
//!
//! [`plan()`] is the list of the stages, in a file or a folder each, which says what it does;
//! `graph/docs/ARCHITECTURE.md` has them in a table.
//!
//! No stage uses another one: each gets what the one before has made. Next to them are [`verify`], which checks a
//! finished plan and shares no code with the stages, and the report: text, JSON, SVG, hash and difference.
//!
//! A [`Plan`] is never altered. Where its images lie when the heap of the previous plan is kept is a value of its own,
//! the [`PlacedPlan`].

#![allow(missing_docs, reason = "many fields of a plan say what they hold by their names")]

mod bake;
mod bands;
mod barriers;
mod builder;
pub mod codegen;
mod contract;
mod crop;
mod cull;
mod decoding;
mod dynamic_nodes;
mod error;
mod fault_counters;
mod formats;
mod fusion;
mod heap_placement;
pub mod limits;
mod memory;
mod options;
mod plan;
mod plan_cache;
mod planner;
mod record;
mod record_context;
mod recording_limits;
mod refresh;
mod report;
mod request;
mod sanitize;
mod schedule;
mod specialize;
mod topological;
mod verify;

pub use afterimage_base::caps::Caps;
pub use bands::{Band, BandLimits, BandPass, BandedSize, Banding, Halos, HostLimits, InputRows, Parts, Sweep};
pub use contract::{contract, modules};
pub use dynamic_nodes::{DynamicNodes, NeedsPlan};
pub use error::{NodeShaderError, PlanError};
pub use fault_counters::FaultCounter;
pub use heap_placement::{HeapPlacement, PlacedPlan};
pub use options::{Alias, Options, When};
pub use plan::{
    AliasingBarrier, Baked, Batch, CachedResults, Fused, Lifetime, Memory, Metering, Plan, PlanOutput, PlannedBlock,
    PlannedImage, PlannedPass, RectangleInput, Refresh, Savings, ScheduledPass, SharedRead, Skipped, Slot, Stage,
    StateContent, StateItem, Transition, UniformBlock, Use,
};
pub use plan_cache::{PlanCache, PlanKey, Planned};
pub use planner::{plan, plan_dynamic, plan_without_tables};
pub use report::{PlanDiff, PlanHash, diff};
pub use request::{HostImageDesc, HostInputs, Part, PlanRequest, Requirement};
pub use verify::{Fault, verify, verify_placed};
