//! What the program remembers of each graphics adapter between two runs: the driver's pipelines, and what a calibration measured.
//!
//! Everything here can be deleted at any time. Nothing that goes wrong with it stops the program: it only starts slower.

use std::collections::BTreeMap;
use std::path::PathBuf;

use afterimage_gpu::{Executor, Gpu};
use serde::{Deserialize, Serialize};

use afterimage_media::write_atomic;

/// Drivers only ever add to their caches; beyond this one it is better to start anew.
const MOST_BYTES: usize = 64 << 20;

/// What one calibration has measured: milliseconds of a point pass at one size, by the format that it writes.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Calibration {
    /// By the format's name: dispatched, and drawn.
    pub(crate) formats: BTreeMap<String, Pair>,
    /// Half floats in the sums of a pyramid, where the adapter has them.
    #[serde(default)]
    pub(crate) half: Option<Gain>,
    /// Subgroups in the reductions of a meter, where the adapter has them.
    #[serde(default)]
    pub(crate) subgroups: Option<Gain>,
}

/// The same work without a switch and with it, in milliseconds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Gain {
    pub(crate) without_ms: f64,
    pub(crate) with_ms: f64,
}

impl Gain {
    /// Whether it is faster with it, and by more than the noise of a measurement.
    pub(crate) fn pays(self) -> bool {
        self.with_ms < NOISE * self.without_ms
    }
}

/// What is not below this share of another time may be equal to it.
const NOISE: f64 = 0.95;

/// The same work in both ways, in milliseconds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Pair {
    pub(crate) compute_ms: f64,
    pub(crate) fragment_ms: f64,
}

impl Calibration {
    /// Whether drawing is faster over all formats, and by more than the noise of a measurement.
    pub(crate) fn prefers_fragment(&self) -> bool {
        let compute: f64 = self.formats.values().map(|pair| pair.compute_ms).sum();
        let fragment: f64 = self.formats.values().map(|pair| pair.fragment_ms).sum();
        fragment < NOISE * compute
    }
}

/// The folder of everything remembered: `$XDG_CACHE_HOME/afterimage`, or where the system keeps such things.
fn folder() -> Option<PathBuf> {
    let from = |variable: &str| std::env::var_os(variable).map(PathBuf::from).filter(|path| path.is_absolute());
    let base =
        from("XDG_CACHE_HOME").or_else(|| from("LOCALAPPDATA")).or_else(|| Some(from("HOME")?.join(".cache")))?;
    Some(base.join("afterimage"))
}

/// The adapter and its driver: what was measured or compiled for another tells nothing.
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

/// Keeps the driver's pipelines for the next run, if there are others than `known`.
pub(crate) fn keep_pipelines(gpu: &Gpu, executor: &Executor, known: &[u8]) {
    let Some(path) = pipelines_file(gpu) else { return };
    let Some(bytes) = executor.pipeline_cache_data().filter(|bytes| bytes != known) else { return };
    keep(&path, &bytes);
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

/// What a calibration of this adapter has found.
pub(crate) fn calibration(gpu: &Gpu) -> Option<Calibration> {
    calibrations()?.1.remove(&key(gpu))
}

/// Keeps what a calibration has found; the file, if it could be written.
pub(crate) fn keep_calibration(gpu: &Gpu, calibration: &Calibration) -> Option<PathBuf> {
    let (path, mut all) = calibrations()?;
    all.insert(key(gpu), calibration.clone());
    keep(&path, &serde_json::to_vec_pretty(&all).expect("names and numbers are JSON"));
    path.is_file().then_some(path)
}

#[cfg(test)]
mod tests {
    use super::{Calibration, Gain, Pair, file_name};

    #[test]
    fn file_names_are_plain() {
        assert_eq!(file_name("vulkan NVIDIA H200 580.1/x"), "vulkan-NVIDIA-H200-580.1-x");
    }

    #[test]
    fn drawing_must_win_by_more_than_noise() {
        let of = |compute_ms, fragment_ms| Calibration {
            formats: [("f".into(), Pair { compute_ms, fragment_ms })].into(),
            ..Calibration::default()
        };
        assert!(of(1.0, 0.9).prefers_fragment());
        assert!(!of(1.0, 0.97).prefers_fragment());
        assert!(!of(1.0, 20.0).prefers_fragment());
        assert!(!Calibration::default().prefers_fragment());
    }

    #[test]
    fn so_must_a_switch() {
        let gain = |with_ms| Gain { without_ms: 1.0, with_ms };
        assert_eq!([0.5, 0.94, 0.96, 1.1].map(|with_ms| gain(with_ms).pays()), [true, true, false, false]);
    }

    #[test]
    fn calibrations_of_earlier_versions_are_read() {
        let known =
            serde_json::from_str::<Calibration>(r#"{"formats": {}}"#).expect("what is missing was not measured");
        assert_eq!(known, Calibration::default());
    }
}
