//! Each kind on the GPU, compared with its CPU reference.

mod bloom;
mod camera;
mod color;
mod extremes;
mod gallery;
mod inactive;
mod laws;
mod lens;
mod local;
mod metering;
mod occlusion;
mod probes;
mod references;
mod resolve;
mod shadow;
mod shadow_rays;
mod surface;
mod taa;
mod table;
mod transparency;
mod volume;
mod warp;
mod wide;
