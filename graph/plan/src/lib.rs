//! Graph to plan: passes, their order, the barriers between them, the memory of their images, and their shader code.
//!
//! [`plan()`] is the list of the stages, in a file or a folder each:
//!
//! | stage | what it does |
//! |---|---|
//! | `specialize` | decides which nodes run; puts fallbacks in the place of the others |
//! | `record` | lets every node record its passes; sizes images that depend on earlier frames |
//! | `cull` | removes passes whose results nothing reads |
//! | `cache_results` | gives results of nodes that run in some frames memory of their own |
//! | `sanitize` | puts copies in front of shaders that read host images directly |
//! | `bake` | replaces runs of point functions by baked LUTs |
//! | `fusion` | joins passes: point functions, warps, halvings by rows |
//! | `formats` | chooses dispatch or draw, formats and sample modes |
//! | `refresh` | decides in which frames each pass runs |
//! | `schedule` | orders the passes, and groups them into batches without barriers inside |
//! | `memory` | finds lifetimes, offsets in the heap and slots of the pool |
//! | `barriers` | states the transitions and aliasing barriers before each batch |
//! | `codegen` | lays out uniforms, counts workgroups, and writes the shader of a pass when asked |
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
pub use bands::{Band, BandLimits, BandPass, BandedSize, Banding, HostLimits, InputRows, Parts, Reach, Sweep};
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
pub use request::{GivenImage, HostInputs, Part, PlanRequest, Requirement};
pub use verify::{Fault, verify, verify_placed};
