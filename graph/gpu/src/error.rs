//! What can go wrong on a device, as values.

use afterimage_graph::shader::ShaderError;

/// Why nothing was rendered.
#[derive(Debug, Clone, thiserror::Error)]
pub enum GpuError {
    /// There is no adapter, or none of the wanted name.
    #[error("no graphics adapter{}: {advice}", wanted.as_ref().map_or(String::new(), |name| format!(" called `{name}`")))]
    NoAdapter {
        /// The name that was asked for.
        wanted: Option<String>,
        /// What to do.
        advice: String,
    },
    /// The adapter gave no device.
    #[error("the adapter `{adapter}` gave no device: {why}")]
    NoDevice {
        /// The adapter.
        adapter: String,
        /// The driver's reason.
        why: String,
    },
    /// The device has not enough memory.
    #[error("out of graphics memory while making {what}")]
    OutOfMemory {
        /// What did not fit.
        what: String,
    },
    /// The device is gone.
    #[error("the graphics device was lost: {why}")]
    DeviceLost {
        /// The driver's reason.
        why: String,
    },
    /// An image of the host is larger than the device allows.
    #[error("the image is {width}x{height}, but `{adapter}` takes at most {limit} pixels a side")]
    TooLarge {
        /// Pixels of a row.
        width: u32,
        /// Rows.
        height: u32,
        /// The adapter.
        adapter: String,
        /// The largest side.
        limit: u32,
    },
    /// A format that the device lacks.
    #[error("this device has no format for {what}")]
    Format {
        /// The image.
        what: String,
    },
    /// A shader that does not compile.
    #[error("{0}")]
    Shader(ShaderError),
    /// The device refused something that plans promise to be right.
    #[error("the device refused {what}: {why}")]
    Refused {
        /// What was refused.
        what: String,
        /// Its reason.
        why: String,
    },
    /// The host did not give an image for an input.
    #[error("no image was given for input `{0}`")]
    MissingInput(String),
    /// The host's image for a port has another size or format than the plan was made for.
    #[error("the image given for `{port}` is {given}, but the plan was made for {planned}")]
    WrongImage {
        /// The port.
        port: String,
        /// What was given.
        given: String,
        /// What was planned.
        planned: String,
    },
    /// The host's image for a port has the planned size and format, and still cannot be used.
    #[error("the image given for `{port}` cannot be used: {why}")]
    UnfitImage {
        /// The port.
        port: String,
        /// What it lacks.
        why: String,
    },
    /// The host gave an image for an output that the plan does not have.
    #[error("the plan has no output `{name}`; it has {known}")]
    UnknownOutput {
        /// The name that was given.
        name: String,
        /// Those that there are.
        known: String,
    },
    /// No plan is loaded.
    #[error("no plan is loaded")]
    NoPlan,
}

impl GpuError {
    /// The device is lost, for the reason that wgpu gives.
    pub(crate) fn lost(why: &dyn std::fmt::Display) -> Self {
        Self::DeviceLost { why: why.to_string() }
    }
}
