//! What the Khronos validation layer says, caught from the log.

use std::sync::Mutex;

static SAID: Mutex<Vec<String>> = Mutex::new(Vec::new());

struct Catcher;

impl log::Log for Catcher {
    fn enabled(&self, metadata: &log::Metadata<'_>) -> bool {
        metadata.target().starts_with("wgpu_hal::vulkan") && metadata.level() <= log::Level::Warn
    }

    fn log(&self, record: &log::Record<'_>) {
        if self.enabled(record.metadata()) {
            SAID.lock().unwrap_or_else(|poisoned| poisoned.into_inner()).push(record.args().to_string());
        }
    }

    fn flush(&self) {}
}

/// Begins to listen; before the device is opened.
pub fn listen() {
    static CATCHER: Catcher = Catcher;
    // Another test may have been first.
    if log::set_logger(&CATCHER).is_ok() {
        log::set_max_level(log::LevelFilter::Warn);
    }
}

/// Messages since the last call that speak of our use of the device.
///
/// Left out: a layer older than the driver does not know the driver's extensions, and says so once.
pub fn said() -> Vec<String> {
    let mut said = SAID.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
    said.drain(..).filter(|line| ["VUID-", "SYNC-HAZARD", "DrawState"].iter().any(|mark| line.contains(mark))).collect()
}

/// Whether the layer is installed: without it, silence proves nothing.
pub fn is_installed() -> bool {
    let folders = [
        "/usr/share/vulkan/explicit_layer.d",
        "/usr/local/share/vulkan/explicit_layer.d",
        "/etc/vulkan/explicit_layer.d",
    ];
    folders.iter().any(|folder| std::path::Path::new(folder).join("VkLayer_khronos_validation.json").exists())
}
