//! Each kind on the GPU against its f64 twin.

mod arithmetic;
mod bloom;
mod color;
mod local;
mod metering;
mod probes;
mod shared;
