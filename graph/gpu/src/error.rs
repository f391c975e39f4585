//! Errors of the device and of the host's images, as values.

use afterimage_base::diagnostic::{list, quote};
use afterimage_plan::Plan;
use afterimage_wgsl::ShaderError;

/// The reason why nothing was rendered.
#[derive(Debug, Clone, thiserror::Error)]
pub enum GpuError {
    /// There is no adapter, or none with the requested name.
    #[error("no graphics adapter{}: {advice}", called(wanted.as_deref()))]
    NoAdapter {
        /// The requested name.
        wanted: Option<String>,
        /// A hint.
        advice: String,
    },
    /// The adapter cannot create a device.
    #[error("the adapter `{adapter}` gave no device: {why}")]
    NoDevice {
        /// The adapter.
        adapter: String,
        /// The driver's reason.
        why: String,
    },
    /// The system has no further thread.
    #[error("the system has no further thread for this program: {why}")]
    NoThreads {
        /// The system's reason.
        why: String,
    },
    /// The device has too little memory.
    #[error("out of graphics memory while making {what}")]
    OutOfMemory {
        /// The object that did not fit.
        what: String,
    },
    /// The device was lost.
    #[error("the graphics device was lost: {why}")]
    DeviceLost {
        /// The driver's reason.
        why: String,
    },
    /// The device did not finish in time. What it was given may still run, so nothing of it can be read.
    #[error("the graphics device did not finish within the driver's time limit")]
    TimedOut,
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
    /// The device does not support a format.
    #[error("this device has no format for {what}")]
    Format {
        /// The image.
        what: String,
    },
    /// The device has no textures with this many samples in each pixel.
    #[error("this device has no {format} textures with {samples} samples in each pixel; it has them with {supported}")]
    Samples {
        /// The requested samples.
        samples: u32,
        /// The format.
        format: &'static str,
        /// The numbers of samples that it supports.
        supported: String,
    },
    /// A shader does not compile.
    #[error("{0}")]
    Shader(Box<ShaderError>),
    /// The device rejected an object that the plan declares valid.
    #[error("the device refused {what}: {why}")]
    Refused {
        /// The rejected object.
        what: String,
        /// The device's reason.
        why: String,
    },
    /// The host supplied no image for an input.
    #[error("no image was given for input `{0}`")]
    MissingInput(String),
    /// The host gave no block for an input.
    #[error("no {ty} was given for input `{port}`: set it in `Frame::blocks`")]
    MissingBlock {
        /// The input.
        port: String,
        /// The type of the block.
        ty: &'static str,
    },
    /// The host's block for an input is of another type.
    #[error("the block given for `{port}` is a {given}, but the pipeline requires a {wanted}")]
    WrongBlock {
        /// The input.
        port: String,
        /// The type of the host's block.
        given: &'static str,
        /// The type of the input.
        wanted: &'static str,
    },
    /// The host gave no draws for a node whose pass it fills.
    #[error("no draws were given for node `{0}`, which the host fills: give them to `encode_drawing`")]
    MissingDraw(String),
    /// The host's image for a port differs in size or format from the plan.
    #[error("the image given for `{port}` is {given}, but the plan was made for {planned}")]
    WrongImage {
        /// The port.
        port: String,
        /// The description of the host's image.
        given: String,
        /// The planned description.
        planned: String,
    },
    /// The host's image for a port has the planned size and format, but cannot be used.
    #[error("the image given for `{port}` cannot be used: {why}")]
    UnfitImage {
        /// The port.
        port: String,
        /// The reason.
        why: String,
    },
    /// The host supplied an image for an output that the plan does not have.
    #[error("the plan has no output `{name}`; it has {known}")]
    UnknownOutput {
        /// The unknown name.
        name: String,
        /// The outputs of the plan.
        known: String,
    },
    /// The host's task pool has dropped the task that makes a plan, so that there is none.
    #[error("the task pool of the host has dropped the task that makes the next plan")]
    TaskDropped,
    /// No plan is loaded.
    #[error("no plan is loaded")]
    NoPlan,
}

impl GpuError {
    /// The plan has no output of that name.
    #[doc(hidden)] // For the crate `afterimage`.
    pub fn unknown_output(plan: &Plan, name: &str) -> Self {
        let known = plan.outputs.iter().map(|output| output.name.as_str());
        Self::UnknownOutput { name: name.to_owned(), known: list(known, 16) }
    }

    pub(crate) fn unfit(port: &str, why: impl Into<String>) -> Self {
        Self::UnfitImage { port: port.to_owned(), why: why.into() }
    }

    /// The device is lost, for the reason that wgpu gives.
    #[doc(hidden)] // For the crate `afterimage`.
    pub fn lost(why: &dyn std::fmt::Display) -> Self {
        Self::DeviceLost { why: why.to_string() }
    }
}

fn called(name: Option<&str>) -> String {
    name.map_or(String::new(), |name| format!(" called {}", quote(name)))
}
