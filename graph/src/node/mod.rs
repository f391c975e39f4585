//! What a node is: its parameters, its ports, and the passes it records.

mod contract;
mod folder;
mod kind;
mod params;
mod pass;
mod ports;
mod recorder;
mod registry;

pub use contract::{contract, for_each_recording};
pub use folder::folder_kind;
pub use kind::{Arrivals, Kind, Node, NodeKind};
pub use params::Params;
pub use pass::{
    Arg, Binding, BufferId, BufferLife, ByCells, ByRows, Cells, CellsReader, EntryCall, ImageId, Origin, Pass,
    Resource, Rows, Step, TileStage, Tiling, VirtualBuffer, VirtualImage, Work,
};
pub use ports::{Fallback, Input, Output, OutputState, PortType, Signature};
pub use recorder::{Arrival, ComputePass, FunctionPass, Recorder, RecorderContext, Recording};
pub use registry::{DuplicateKind, Registry};
