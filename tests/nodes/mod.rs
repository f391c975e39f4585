//! Each kind on the GPU against its f64 twin.

mod bloom;
mod local;
mod metering;
mod probes;
