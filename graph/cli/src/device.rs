//! The device of a command, its sessions, and the cache of compiled pipelines of earlier runs.
//!
//! The cache of each graphics adapter holds the driver's pipelines. It can be deleted at any time. Errors with it do
//! not stop the program; it only starts slower.

use std::path::PathBuf;

use afterimage::offline::Session;
use afterimage_gpu::{Gpu, Opening};
use afterimage_graph::check::{Facts, Graph};
use afterimage_media::{Budget, read_bytes, rewrite};
use afterimage_plan::Options;

use crate::args::{DeviceOptions, PlanOptions};
use crate::failure::Failure;

/// Drivers only add to their caches; a larger one is not used again.
const MAX_BYTES: u64 = 64 << 20;

/// Opens the device that the command line names.
pub(crate) fn open(options: &DeviceOptions) -> Result<Gpu, Failure> {
    let max_memory = options.gpu_memory.map(|Budget(bytes)| bytes);
    let mut gpu = Gpu::open(&Opening { adapter: options.adapter.clone(), max_memory, ..Opening::default() })?;
    if options.require_gpu && gpu.is_processor() {
        return Err(Failure::machine(format!("`--require-gpu`: the only adapter is the processor, `{}`", gpu.name()))
            .hint("install a driver of a graphics card, or leave the option out"));
    }
    // On lavapipe whole pipelines are a third faster with draws.
    gpu.caps.prefer_fragment = gpu.is_processor();
    Ok(gpu)
}

/// Opens the device for a plan with these options.
pub(crate) fn open_for(device: &DeviceOptions, plan: &PlanOptions) -> Result<Gpu, Failure> {
    let mut gpu = open(device)?;
    gpu.caps.prefer_fragment |= plan.draws();
    Ok(gpu)
}

/// A session with the driver's pipelines of earlier runs.
pub(crate) fn session(gpu: &Gpu, graph: Graph, facts: Facts, options: Options) -> Session {
    Session::with_pipeline_cache(gpu, graph, facts, options, &pipelines(gpu))
}

/// Stores the driver's pipelines of a session for the next run.
pub(crate) fn keep_pipelines(session: &mut Session) {
    let bytes = session.post().executor().pipeline_cache_data().unwrap_or_default();
    keep_pipeline_data(session.gpu(), &bytes);
}

/// The folder of the cache: `$XDG_CACHE_HOME/afterimage`, or the system's folder for caches.
pub(crate) fn cache_folder() -> Option<PathBuf> {
    let from = |variable: &str| std::env::var_os(variable).map(PathBuf::from).filter(|path| path.is_absolute());
    let base =
        from("XDG_CACHE_HOME").or_else(|| from("LOCALAPPDATA")).or_else(|| Some(from("HOME")?.join(".cache")))?;
    Some(base.join("afterimage"))
}

/// The adapter and its driver; entries of another one do not apply.
fn key(gpu: &Gpu) -> String {
    let info = gpu.adapter.get_info();
    format!("{} {} {} {}", info.backend, info.name, info.driver, info.driver_info)
}

fn file_name(key: &str) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() || c == '.' { c } else { '-' };
    key.chars().map(plain).take(120).collect()
}

fn pipelines_file(gpu: &Gpu) -> Option<PathBuf> {
    Some(cache_folder()?.join(format!("{}.pipelines", file_name(&key(gpu)))))
}

/// The driver's pipelines of earlier runs; empty if there are none.
fn pipelines(gpu: &Gpu) -> Vec<u8> {
    pipelines_file(gpu).and_then(|path| read_bytes(&path, MAX_BYTES).ok()).unwrap_or_default()
}

/// Stores the driver's pipelines for the next run, if there are others than before.
pub(crate) fn keep_pipeline_data(gpu: &Gpu, bytes: &[u8]) {
    match pipelines_file(gpu) {
        Some(path) if !bytes.is_empty() && bytes != pipelines(gpu) => keep(&path, bytes),
        _ => {}
    }
}

fn keep(path: &std::path::Path, bytes: &[u8]) {
    // A pipe of that name would be written to, and wait for a reader.
    if path.exists() && !path.is_file() {
        return log::info!("`{}` is no file; the next start will be as slow as this one", path.display());
    }
    let made = path.parent().map_or(Ok(()), std::fs::create_dir_all);
    if made.is_err() || rewrite(path, bytes).is_err() {
        log::info!("`{}` cannot be written; the next start will be as slow as this one", path.display());
    }
}

#[cfg(test)]
mod tests {
    use super::file_name;

    #[test]
    fn file_names_are_plain() {
        assert_eq!(file_name("vulkan NVIDIA H200 580.1/x"), "vulkan-NVIDIA-H200-580.1-x");
    }
}
