//! What a node is: its parameters, its ports, and the passes it records.

mod blend;
mod block;
mod camera;
mod color;
mod contract;
mod drawing;
mod embedded;
mod folder;
mod geometry;
mod inactive;
mod kernel;
mod kind;
mod pass;
mod ports;
mod promises;
mod recorder;
mod registry;
mod resource;
mod typed;
mod values;

pub use afterimage_base::bake::Bake;
pub use blend::{Blend, BlendComponent, BlendFactor, Factors, WriteMask};
pub use block::{BlockData, BlockField, FieldType, HostBlock};
pub use camera::{CAMERA, Camera, Matrix};
pub use color::{ColorChange, ImageColor};
pub use contract::{contract, for_each_recording, kind_file_name};
pub use drawing::{ColorAttachment, Compare, DepthAttachment, DepthTest, DrawContents, Drawing, Load, Subresource};
pub use embedded::EmbeddedKind;
pub use folder::{folder_kind, folder_kind_of, folder_kind_sharing};
pub use geometry::{Cull, DrawRange, Draws, Geometry, IndirectDraws, Raster, Topology, VertexBuffer, VertexFormat};
pub use inactive::{Decisive, Inactive, InactiveParameters, NodeInUse};
pub use kernel::{Arg, Argument, ByNeighbors, ByRows, KernelCall, KernelOrigin, WarpPart};
pub use kind::{DynNode, InputValues, Kind, NodeKind};
pub use pass::{Pass, PassKind, PassResult, RowDownsample};
pub use ports::{Fallback, Input, Output, OutputState, OutputUse, PortType, Signature};
pub use promises::Promises;
pub use recorder::{
    AttachmentPass, ComputePass, DrawPass, FunctionPass, InputValue, MisfitPixel, NodeColors, Recorder,
    RecorderContext, Recording, Replay, WarpPass,
};
pub use registry::{Registry, RegistryError};
pub use resource::{BlockId, BufferId, BufferLife, ImageId, Origin, Resource, VirtualBuffer, VirtualImage};
pub use typed::{Node, NodeInstance, Params};
pub use values::UniformValues;
