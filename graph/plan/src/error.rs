//! Errors of the planner.

use crate::limits::{MAX_COMPUTED, MAX_OPERATIONS, MAX_PASSES};
use afterimage_base::image::{Format, Size};
use afterimage_wgsl::ShaderError;

/// The reason that a graph cannot be planned for a request.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PlanError {
    /// The host does not give an image that the pipeline needs.
    #[error("the pipeline needs an image for its input `{0}`")]
    MissingInput(String),
    /// The host gives an image of one sample in each pixel where the pipeline states a multisampled one, or the other
    /// way round.
    #[error("{}", samples(.input, *.given))]
    WrongSamples {
        input: String,
        /// Samples in each pixel of the image.
        given: u32,
    },
    /// The host states a rectangle or a factor of a multisampled image.
    #[error("rectangles and factors are not supported for the multisampled input `{0}`")]
    PartOfSamples(String),
    /// The host gives an image where the pipeline states a volume, or the other way round.
    #[error("{}", dimension(.input, *.given))]
    WrongDimension {
        input: String,
        /// True if a volume is given.
        given: bool,
    },
    /// The host states a rectangle or a factor of a volume.
    #[error("rectangles and factors are not supported for the volume input `{0}`")]
    PartOfVolume(String),
    /// Shaders of the kinds of nodes cannot be linked, are not valid, or do not fit their kinds.
    #[error("{}", shaders(.0))]
    Shaders(Vec<NodeShaderError>),
    /// A function takes a pixel of an image that has another size than its result.
    #[error(
        "node `{node}` takes `{argument}` as a pixel, but `{image}` is {size} and the result {result}: give it an \
         image of that size, or take a texture in the shader `{shader}` and read it with `tap`"
    )]
    MisfitPixel {
        node: Box<str>,
        /// The argument of the function.
        argument: Box<str>,
        /// The image, as `node.port`.
        image: Box<str>,
        size: Size,
        /// The size of the result.
        result: Size,
        /// The file of the function.
        shader: Box<str>,
    },
    /// An image is larger than the device allows.
    #[error("image `{label}` is {size}, but this device allows at most {limit} texels a side")]
    TooLarge {
        /// The image, as `node.port`.
        label: String,
        size: Size,
        limit: u32,
    },
    /// The images of a frame, those of the host included, have more bytes than [`Caps`] allow.
    ///
    /// [`Caps`]: afterimage_base::caps::Caps
    #[error("the images of a frame take {}, but may take at most {}", bytes_text(*.bytes), bytes_text(*.limit))]
    TooMuchMemory { bytes: u64, limit: u64 },
    /// The picture must be made in bands, and the rows of the smallest ones have more bytes on their way from and to
    /// files than [`BandLimits`](crate::BandLimits) allow.
    #[error(
        "the rows of a band take {} on their way from and to files, but may take at most {}", bytes_text(*.bytes),
        bytes_text(*.limit)
    )]
    TooMuchHostMemory { bytes: u64, limit: u64 },
    /// The picture must be made in bands, and a pass cannot be.
    #[error("the picture is larger than the device, and node `{node}` cannot be made band by band: {why}")]
    NoBands {
        /// The nodes of the pass.
        node: String,
        why: String,
    },
    /// A pass binds more uniform buffers than the device allows.
    #[error("pass `{label}` has {count} uniform buffers, but this device allows at most {limit}")]
    TooManyUniformBuffers {
        label: String,
        /// Its uniform buffers, with one for its size if the framework writes its entry point.
        count: usize,
        /// The most that are allowed.
        limit: u32,
    },
    /// A pass blends into an image of a format that the device cannot blend, as many cannot blend 32-bit floats.
    #[error(
        "pass `{pass}` blends into `{image}`, but this device cannot blend into its format `{}`; every device blends \
         into `Rgba16Float`",
        .format.name()
    )]
    NotBlendable {
        pass: String,
        /// The image, as `node.port`.
        image: String,
        /// Its format; for a reference, whose intermediates have 32 bits, the wider one.
        format: Format,
    },
    /// An output comes from a node that is off and has no fallback.
    #[error("output `{0}` comes from a node that is off and has no fallback")]
    NothingToShow(String),
    /// The sizes of images that depend on the previous frame do not settle.
    #[error("the size of `{0}@previous` grows from frame to frame")]
    UnstableHistory(String),
    /// The nodes up to this one record more passes than a plan may have.
    #[error("the nodes up to `{0}` have more than {MAX_PASSES} passes; a pyramid has several for each of its levels")]
    TooManyPasses(String),
    /// The nodes up to this one compute more tables than a plan may have.
    #[error("the nodes up to `{0}` compute more than {MAX_COMPUTED} tables")]
    TooManyTables(String),
    /// The shaders of the plan's passes have more operations than a driver compiles in a reasonable time.
    #[error(
        "the shaders of the plan have {0} operations, more than {MAX_OPERATIONS}: to compile them takes a driver \
         minutes"
    )]
    TooManyOperations(usize),
    /// The tables that the nodes up to this one compute, or all of them, have more bytes than those of a plan may have.
    #[error("the tables of the nodes up to `{node}` have {bytes} bytes, more than {limit}")]
    TooLargeTables {
        node: String,
        /// The bytes of the tables.
        bytes: u64,
        /// The most that is allowed.
        limit: u64,
    },
}

/// An error in a shader of a node's kind.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NodeShaderError {
    /// The first node of the kind.
    pub node: String,
    /// The error, at the author's file and line.
    pub error: ShaderError,
}

impl PlanError {
    /// Returns whether the system had no thread for parsing shaders; the pipeline may be valid.
    pub fn is_of_system(&self) -> bool {
        matches!(self, Self::Shaders(errors) if errors.iter().any(|one| one.error.is_of_system))
    }
}

fn shaders(errors: &[NodeShaderError]) -> String {
    if let Some(NodeShaderError { error, .. }) = errors.iter().find(|one| one.error.is_of_system) {
        return error.message.clone();
    }
    let lines =
        errors.iter().map(|NodeShaderError { node, error }| format!("the shader of node `{node}` is wrong: {error}"));
    lines.collect::<Vec<_>>().join("\n")
}

fn dimension(input: &str, given: bool) -> String {
    match given {
        false => format!("input `{input}` is a volume, but its image is none: a host gives a 3-D texture"),
        true => format!(
            "input `{input}` is an image, but a volume is given: declare the input as `volume: true`, and wire it to a \
             `VolumetricComposite`"
        ),
    }
}

fn samples(input: &str, given: u32) -> String {
    match given {
        1 => format!(
            "input `{input}` is multisampled, but its image has one sample in each pixel, as images of files have: a \
             host gives the image that it draws to"
        ),
        _ => format!(
            "input `{input}` is not multisampled, but its image has {given} samples in each pixel: declare the input \
             as `multisampled: true`, and wire it to a `Resolve`"
        ),
    }
}

fn bytes_text(bytes: u64) -> String {
    match bytes >> 30 {
        0 => format!("{:.1} MiB", bytes as f64 / f64::from(1 << 20)),
        _ => format!("{:.1} GiB", bytes as f64 / f64::from(1 << 30)),
    }
}
