//! Each kind on the GPU, compared with its CPU reference.

mod arithmetic;
mod bloom;
mod camera;
mod color;
mod lens;
mod local;
mod metering;
mod probes;
mod shared;
mod surface;
mod table;
mod warp;
mod wide;
