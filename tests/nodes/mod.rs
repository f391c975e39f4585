//! Each kind on the GPU, compared with its CPU reference.

mod arithmetic;
mod bloom;
mod color;
mod local;
mod metering;
mod probes;
mod shared;
mod table;
mod wide;
