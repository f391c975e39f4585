//! A module that a device can run, and what its bindings hold.

use afterimage_base::image::{Format, ImageDesc};
use afterimage_graph::node::{BlockId, BufferId, ImageId, Pass, PassKind, Subresource};
use afterimage_wgsl::{Instance, Linked, Linker, SampleMode, Shader, ShaderError, SourceMap, validate};

/// A binding slot of a composed module.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Slot {
    /// `@binding`; all are in group 0.
    pub binding: u32,
    pub kind: SlotKind,
}

/// The kinds of binding slots.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SlotKind {
    /// The uniform with the frame's time.
    Frame,
    Block(BlockId),
    Params,
    /// The same in a storage buffer: see [`CodeOptions::on_processor`].
    StoredParams,
    /// A uniform with the size of the result in texels, and its first texel in the host's image: four floats. To ask
    /// the texture for the size takes longer.
    Extent,
    /// The linear, clamping sampler.
    Sampler,
    Texture(ImageId),
    /// A mip level of a layer of a sampled image.
    Level(Subresource),
    /// A storage image that is written.
    Storage(ImageId),
    /// A storage buffer, and whether it is written.
    Buffer(BufferId, bool),
}

/// Options that change the text of modules.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CodeOptions {
    /// Takes the frame's time from immediates.
    pub immediates: bool,
    /// Writes the result to a part of its image: the uniform [`Extent`](SlotKind::Extent) states its first texel.
    pub has_origin: bool,
    /// Reads the pass's uniform from a storage buffer, rounds half floats, and ends loops earlier. Mesa's driver for
    /// processors (22) compiles a shader with its numbers again for each dispatch if many branches depend on a uniform
    /// buffer, and keeps all of these shaders; it rounds half floats toward zero where it stores them; for loops, see
    /// [`PROCESSOR_LOOP_STEPS`](afterimage_wgsl::limits::PROCESSOR_LOOP_STEPS).
    pub on_processor: bool,
}

/// A module that a device can run.
#[derive(Clone, Debug)]
pub struct Composed {
    /// The text of the module.
    pub source: String,
    /// Maps its bytes to those of the sources.
    pub map: SourceMap,
    /// The compute entry point's name; empty for a drawing pass.
    pub compute: String,
    /// The entry points of a draw, if it has them.
    pub draw: Option<Draw>,
    /// The bindings of the compute entry point. A draw has the same but the storage image.
    pub slots: Vec<Slot>,
    /// True if it takes the frame's time from immediates.
    pub immediate: bool,
    pub workgroup: [u32; 3],
    /// True if every part of the module is unchecked: see [`Shader::unchecked`](afterimage_wgsl::Shader::unchecked).
    pub unchecked: bool,
    /// The sample mode of its taps.
    pub sample_mode: SampleMode,
    /// True if it may read workgroup memory that it has not written, which must then be zeroed.
    pub zero_workgroup_memory: bool,
}

/// The names of the entry points of a draw.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Draw {
    /// The vertex entry point: a triangle that covers the target, or that of a drawing pass.
    pub vertex: String,
    /// The fragment entry point; a drawing pass may have none.
    pub fragment: Option<String>,
}

impl Composed {
    /// Parses and validates the module, and compiles it as far as that needs no device.
    ///
    /// # Errors
    /// The first error, at the author's line.
    pub fn validate(&self) -> Result<naga::Module, ShaderError> {
        validate(&self.source, &self.map)
    }
}

/// A pass with all that its module depends on.
pub(super) struct PassCode<'a> {
    pub(super) pass: &'a Pass,
    pub(super) desc_of: &'a dyn Fn(ImageId) -> ImageDesc,
    pub(super) sample_mode_of: &'a dyn Fn(ImageId) -> SampleMode,
    pub(super) options: CodeOptions,
}

/// The part of a module that depends on the kind of pass.
pub(super) struct Entry {
    pub(super) slots: Vec<Slot>,
    pub(super) immediate: bool,
    pub(super) workgroup: [u32; 3],
    /// Names of the entry points in the generated code: compute, and perhaps vertex and fragment.
    pub(super) names: &'static [&'static str],
}

impl<'a> PassCode<'a> {
    /// The strictest sample mode of the textures of all kernels.
    pub(super) fn sample_mode(&self) -> SampleMode {
        let images = self.pass.kernels.iter().flat_map(|kernel| kernel.textures());
        images.map(|image| (self.sample_mode_of)(image)).max().unwrap_or_default()
    }

    pub(super) fn format_of(&self, image: ImageId) -> Format {
        (self.desc_of)(image).format
    }

    pub(super) fn linker(&self) -> Linker<'a> {
        Linker::new(self.sample_mode())
    }

    /// The module of generated code around the linker's files.
    pub(super) fn compose(&self, linker: Linker<'a>, code: String, entry: Entry) -> Result<Composed, ShaderError> {
        let names: Vec<_> = entry.names.iter().map(|name| (Instance::GENERATED, *name)).collect();
        let linked = linker.link(code, &names)?;
        Ok(self.composed(linked, entry))
    }

    /// The module that the linker has made.
    pub(super) fn composed(&self, linked: Linked, entry: Entry) -> Composed {
        let unchecked = self.pass.shaders().all(Shader::is_unchecked);
        let has_own_memory = matches!(self.pass.kind, PassKind::Workgroup(_) | PassKind::Compute);
        let mut names = linked.entries.into_iter();
        let compute = names.next().expect("a module has a compute entry point");
        let draw = names.next().zip(names.next()).map(|(vertex, fragment)| Draw { vertex, fragment: Some(fragment) });
        Composed {
            source: linked.text,
            map: linked.map,
            compute,
            draw,
            slots: entry.slots,
            immediate: entry.immediate,
            workgroup: entry.workgroup,
            unchecked,
            sample_mode: self.sample_mode(),
            // Code of the framework's own writes all memory before it reads it.
            zero_workgroup_memory: !unchecked && has_own_memory,
        }
    }
}
