//! Nodes: their parameters, ports, and the passes that they record.

mod blend;
mod block;
mod camera;
mod camera_file;
mod color;
mod contract;
mod drawing;
mod embedded;
mod folder;
mod geometry;
mod invariants;
mod kernel;
mod kind;
mod pass;
mod ports;
mod recorder;
mod registry;
mod resource;
mod typed;
mod values;

pub use afterimage_base::bake::Bake;
pub use blend::{Blend, BlendComponent, BlendFactor, Factors, WriteMask};
pub use block::{BlockData, BlockField, FieldType, HostBlock};
pub use camera::{CAMERA, Camera, Matrix};
pub use camera_file::CameraFile;
pub use color::{ColorChange, ImageColor};
pub use contract::{contract, contract_with, kind_file_name};
pub use drawing::{ColorAttachment, Compare, DepthAttachment, DepthTest, DrawContents, Drawing, Load, Subresource};
pub use embedded::EmbeddedKind;
pub use folder::{folder_kind, folder_kind_of, folder_kind_sharing};
pub use geometry::{Cull, DrawRange, Draws, Geometry, IndirectDraws, Raster, Topology, VertexBuffer, VertexFormat};
pub use invariants::Invariants;
pub use kernel::{Arg, Argument, ByNeighbors, ByRows, KernelCall, KernelOrigin, WarpPart};
pub use kind::{InputValues, Kind, Node, NodeKind};
pub use pass::{Pass, PassKind, PassResult, RowDownsample};
pub use ports::{Fallback, Input, Output, OutputState, OutputUse, PortType, Signature};
pub use recorder::{
    AttachmentPass, ComputePass, DrawPass, FunctionPass, InputValue, MisfitPixel, NodeColors, Recorder,
    RecorderContext, Recording, Replay, WarpPass,
};
pub use registry::{Registry, RegistryError};
pub use resource::{BlockId, BufferId, BufferLife, ImageId, Origin, Resource, VirtualBuffer, VirtualImage};
pub use typed::{NodeInstance, TypedKind};
pub use values::UniformValues;
