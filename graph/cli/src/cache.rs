//! The cache of each graphics adapter between runs: the driver's pipelines, and the results of a calibration.
//!
//! The cache can be deleted at any time. Errors with it do not stop the program; it only starts slower.

use std::collections::BTreeMap;
use std::path::PathBuf;

use afterimage_gpu::{Gpu, Session};
use afterimage_lab::bench::Calibration;
use afterimage_media::write_atomic;

/// Drivers only add to their caches; a larger one is not used again.
const MOST_BYTES: usize = 64 << 20;

/// The folder of the cache: `$XDG_CACHE_HOME/afterimage`, or the system's folder for caches.
fn folder() -> Option<PathBuf> {
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
    Some(folder()?.join(format!("{}.pipelines", file_name(&key(gpu)))))
}

/// The driver's pipelines of earlier runs; empty if there are none.
pub(crate) fn pipelines(gpu: &Gpu) -> Vec<u8> {
    pipelines_file(gpu)
        .and_then(|path| std::fs::read(path).ok())
        .filter(|bytes| bytes.len() <= MOST_BYTES)
        .unwrap_or_default()
}

/// Stores the driver's pipelines of a session for the next run, if there are others than `known`.
pub(crate) fn keep_pipelines(session: &mut Session, known: &[u8]) {
    let bytes = session.executor().pipeline_cache_data().unwrap_or_default();
    keep_pipeline_data(session.gpu(), &bytes, known);
}

/// Stores the driver's pipelines for the next run, if there are others than `known`.
pub(crate) fn keep_pipeline_data(gpu: &Gpu, bytes: &[u8], known: &[u8]) {
    match pipelines_file(gpu) {
        Some(path) if !bytes.is_empty() && bytes != known => keep(&path, bytes),
        _ => {}
    }
}

fn keep(path: &std::path::Path, bytes: &[u8]) {
    let made = path.parent().map_or(Ok(()), std::fs::create_dir_all);
    if made.is_err() || write_atomic(path, bytes).is_err() {
        log::info!("`{}` cannot be written; the next start will be as slow as this one", path.display());
    }
}

fn calibrations() -> Option<(PathBuf, BTreeMap<String, Calibration>)> {
    let path = folder()?.join("calibration.json");
    let known = std::fs::read(&path).ok().and_then(|bytes| serde_json::from_slice(&bytes).ok());
    Some((path, known.unwrap_or_default()))
}

/// The calibration of this adapter.
pub(crate) fn calibration(gpu: &Gpu) -> Option<Calibration> {
    calibrations()?.1.remove(&key(gpu))
}

/// Stores a calibration; returns the file if it could be written.
pub(crate) fn keep_calibration(gpu: &Gpu, calibration: &Calibration) -> Option<PathBuf> {
    let (path, mut all) = calibrations()?;
    all.insert(key(gpu), calibration.clone());
    keep(&path, &serde_json::to_vec_pretty(&all).expect("names and numbers are JSON"));
    path.is_file().then_some(path)
}

#[cfg(test)]
mod tests {
    use super::file_name;

    #[test]
    fn file_names_are_plain() {
        assert_eq!(file_name("vulkan NVIDIA H200 580.1/x"), "vulkan-NVIDIA-H200-580.1-x");
    }
}
