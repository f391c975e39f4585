//! Messages of the Khronos validation layer, from the log.

use std::sync::{Mutex, MutexGuard};

static MESSAGES: Mutex<Vec<String>> = Mutex::new(Vec::new());

struct Catcher;

impl log::Log for Catcher {
    fn enabled(&self, metadata: &log::Metadata<'_>) -> bool {
        metadata.target().starts_with("wgpu_hal::vulkan") && metadata.level() <= log::Level::Warn
    }

    fn log(&self, record: &log::Record<'_>) {
        if self.enabled(record.metadata()) {
            MESSAGES.lock().unwrap_or_else(|poisoned| poisoned.into_inner()).push(record.args().to_string());
        }
    }

    fn flush(&self) {}
}

/// Starts to collect messages. To be called before the device is opened.
pub fn listen() {
    static CATCHER: Catcher = Catcher;
    // Another test may have been first.
    if log::set_logger(&CATCHER).is_ok() {
        log::set_max_level(log::LevelFilter::Warn);
    }
}

/// Excludes other tests that read messages: they must not see the messages of a deliberate fault.
pub fn alone() -> MutexGuard<'static, ()> {
    static LISTENER: Mutex<()> = Mutex::new(());
    LISTENER.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
}

/// Messages since the last call about our use of the device.
///
/// Without one: a layer older than naga does not know the number of WGSL in a shader's debug information.
pub fn messages() -> Vec<String> {
    let mut messages = MESSAGES.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
    let ours = |line: &String| {
        let marked = ["VUID-", "SYNC-HAZARD", "DrawState"].iter().any(|mark| line.contains(mark));
        marked && !line.contains("source language")
    };
    messages.drain(..).filter(ours).collect()
}

/// True if the layer is installed: without it, no message proves nothing.
pub fn is_installed() -> bool {
    let folders = [
        "/usr/share/vulkan/explicit_layer.d",
        "/usr/local/share/vulkan/explicit_layer.d",
        "/etc/vulkan/explicit_layer.d",
    ];
    folders.iter().any(|folder| std::path::Path::new(folder).join("VkLayer_khronos_validation.json").exists())
}
