//! Rules for drawing passes that hold on every device.

use super::{Recording, shape};
use crate::node::drawing::{ColorAttachment, Drawing, Subresource};
use crate::node::geometry::{DrawRange, Draws, Geometry, IndirectDraws, Topology};
use crate::node::kernel::{Arg, KernelCall};
use crate::node::pass::Pass;
use crate::node::resource::{BufferId, BufferLife, ImageId, Origin, Resource};
use afterimage_base::image::{Format, ImageDesc};
use afterimage_wgsl::{EntryPoint, EntryStage, Located, NumberKind, Reflection};

/// Samples that every device draws.
const SAMPLES: [u32; 2] = [1, 4];
/// Attachments for color that every device has, and their bytes for a sample.
const MAX_COLORS: usize = 8;
const MAX_COLOR_BYTES: u64 = 32;
/// Buffers of vertices that every device has.
const MAX_VERTEX_BUFFERS: usize = 8;

/// Refuses a drawing pass that no device, or not every device, can run after the passes before it.
///
/// # Panics
/// With everything that is wrong.
pub(super) fn check(pass: &Pass, recording: &Recording) {
    let drawing = pass.drawing().expect("it is a drawing pass");
    let mut rules = Rules { recording, drawing, faults: Vec::new() };
    rules.attachments();
    rules.contents_before();
    rules.apart(pass);
    if let (Some(geometry), [kernel]) = (drawing.geometry(), pass.kernels.as_slice()) {
        rules.geometry(geometry);
        rules.entries(geometry, kernel);
    }
    let faults = rules.faults;
    assert!(faults.is_empty(), "the drawing pass `{}` {}", pass.label, faults.join(", and "));
}

struct Rules<'a> {
    recording: &'a Recording,
    drawing: &'a Drawing,
    faults: Vec<String>,
}

impl Rules<'_> {
    fn require(&mut self, holds: bool, fault: impl FnOnce() -> String) {
        if !holds {
            self.faults.push(fault());
        }
    }

    fn label(&self, image: ImageId) -> &str {
        &self.recording.image(image).label
    }

    fn desc(&self, target: Subresource) -> ImageDesc {
        self.recording.image(target.image).desc
    }

    fn attachments(&mut self) {
        let targets: Vec<Subresource> = self.drawing.targets().collect();
        self.require(!targets.is_empty(), || "draws into nothing: add an attachment".into());
        targets.iter().for_each(|target| self.target(*target));
        for (index, target) in targets.iter().enumerate() {
            let name = self.label(target.image).to_owned();
            self.require(!targets[..index].contains(target), || format!("draws into `{name}` twice"));
        }
        for pair in targets.windows(2) {
            let [first, second] = [pair[0], pair[1]].map(|target| (self.desc(target), target));
            let names = format!("`{}` and `{}`", self.label(first.1.image), self.label(second.1.image));
            let [one, two] = [first, second].map(|(desc, target)| desc.level(target.level).size);
            self.require(one == two, || format!("draws into {names}, which have {one} and {two} texels"));
            let [one, two] = [first, second].map(|(desc, _)| desc.samples);
            self.require(one == two, || format!("draws into {names}, which have {one} and {two} samples"));
        }
        self.formats();
    }

    fn target(&mut self, target: Subresource) {
        let (image, name) = (self.recording.image(target.image), self.label(target.image).to_owned());
        let desc = image.desc;
        self.require(image.origin == Origin::Transient, || format!("draws into `{name}`, which is not its own"));
        self.require(!desc.volume, || format!("draws into the volume `{name}`"));
        let (level, layer) = (target.level, target.layer);
        self.require(level < desc.levels && layer < desc.layers, || {
            format!("draws into level {level} of layer {layer} of `{name}`: {}", shape(desc))
        });
        let most = desc.size.levels() + 1;
        self.require(desc.levels <= most, || {
            format!("draws into `{name}`, which has {} levels, but {} has at most {most}", desc.levels, desc.size)
        });
        self.require(desc.samples == 1 || (desc.levels, desc.layers) == (1, 1), || {
            format!("draws into `{name}`: {}, but an image with samples has one level and one layer", shape(desc))
        });
        self.require(SAMPLES.contains(&desc.samples), || {
            format!("draws {} samples into `{name}`: every device draws 1 or 4", desc.samples)
        });
        self.require(desc.samples == 1 || desc.format != Format::Rgba32Float, || {
            format!("draws samples of the format `Rgba32Float` into `{name}`, which no device has to have")
        });
    }

    fn formats(&mut self) {
        let colors: Vec<ColorAttachment> = self.drawing.colors.clone();
        let mut bytes = 0;
        for color in &colors {
            let (format, name) = (self.desc(color.target).format, self.label(color.target.image).to_owned());
            self.require(!format.is_depth(), || {
                format!("draws color into `{name}`, whose format `{}` holds a depth", format.name())
            });
            // A device stores bytes as more.
            bytes += if format == Format::Rgba8Unorm { 8 } else { format.bytes() };
        }
        self.require(colors.len() <= MAX_COLORS && bytes <= MAX_COLOR_BYTES, || {
            format!(
                "has {} attachments for color with {bytes} bytes a sample; the limit of a device may be {MAX_COLORS} \
                 with {MAX_COLOR_BYTES}",
                colors.len()
            )
        });
        if let Some(depth) = self.drawing.depth {
            let (format, name) = (self.desc(depth.target).format, self.label(depth.target.image).to_owned());
            self.require(format.is_depth(), || {
                format!(
                    "draws depth into `{name}`, whose format `{}` holds none: use `Depth32Float` or `Depth16Unorm`",
                    format.name()
                )
            });
        }
    }

    /// A kept attachment was drawn by a pass before.
    fn contents_before(&mut self) {
        for kept in self.drawing.kept().collect::<Vec<_>>() {
            let draws = |pass: &Pass| match pass.drawing() {
                Some(drawing) => drawing.targets().any(|target| target == kept),
                None => kept == kept.image.into() && pass.writes().contains(&Resource::Image(kept.image)),
            };
            let name = self.label(kept.image).to_owned();
            self.require(self.recording.passes.iter().any(draws), || {
                format!("keeps what `{name}` holds, but no pass before has written it: clear it")
            });
        }
    }

    /// A pass reads none of the images that it draws into, and only reads its buffers.
    fn apart(&mut self, pass: &Pass) {
        let attached = self.drawing.images();
        for read in pass.args().filter_map(Arg::read).filter_map(Resource::image) {
            let name = self.label(read).to_owned();
            self.require(!attached.contains(&read), || format!("reads `{name}` while it draws into it"));
        }
        for kernel in &pass.kernels {
            for arg in kernel.args.iter().filter(|arg| arg.value.written().is_some()) {
                self.faults.push(format!("writes the variable `{}`: only attachments are written", arg.name));
            }
        }
    }

    fn geometry(&mut self, geometry: &Geometry) {
        let buffers = geometry.vertices.len();
        self.require(buffers <= MAX_VERTEX_BUFFERS, || {
            format!("has {buffers} buffers of vertices; the limit of a device may be {MAX_VERTEX_BUFFERS}")
        });
        match &geometry.draws {
            Draws::Ranges(ranges) => {
                self.require(!ranges.is_empty(), || "draws no range: use `clear`".into());
                ranges.iter().for_each(|range| self.range(geometry, range));
            }
            Draws::Indirect(indirect) => self.indirect(geometry, indirect),
        }
        let raster = geometry.raster;
        let is_flat = (raster.bias, raster.slope_bias) == (0, 0.0);
        let has_faces = matches!(raster.topology, Topology::Triangles | Topology::TriangleStrip);
        self.require(is_flat || has_faces, || "has a depth bias, which lines and points have not".into());
        self.require(is_flat || self.drawing.depth.is_some(), || {
            "has a depth bias, but no attachment for depth".into()
        });
        self.require(raster.slope_bias.is_finite(), || "has a slope bias that is not finite".into());
    }

    fn range(&mut self, geometry: &Geometry, range: &DrawRange) {
        let DrawRange { first, count, base_vertex, first_instance, instances } = *range;
        self.require(count > 0 && instances > 0, || format!("draws {count} vertices of {instances} instances"));
        self.require(base_vertex == 0 || geometry.indices.is_some(), || {
            format!("has a base vertex of {base_vertex}, but no indices")
        });
        let end = u64::from(first) + u64::from(count);
        let vertices_end = match geometry.indices {
            None => end,
            Some(indices) => self.indexed_end(indices, range),
        };
        let instances_end = u64::from(first_instance) + u64::from(instances);
        self.require(end.max(instances_end) <= u64::from(u32::MAX), || {
            format!("draws up to the vertex {end} and the instance {instances_end}")
        });
        for vertices in &geometry.vertices {
            let used = if vertices.per_instance { instances_end } else { vertices_end };
            self.holds(vertices.buffer, used * vertices.stride());
        }
        if let Some(indices) = geometry.indices {
            self.holds(indices, 4 * end);
        }
    }

    /// One more than the largest vertex of a range of indices; 1 if they are not known now.
    fn indexed_end(&mut self, indices: BufferId, range: &DrawRange) -> u64 {
        let BufferLife::Constant(bytes) = &self.recording.buffer(indices).life else { return 1 };
        let words = bytes.chunks_exact(4).skip(range.first as usize).take(range.count as usize);
        let numbers = words.map(|word| u32::from_le_bytes(word.try_into().expect("four bytes")));
        let vertices = numbers.map(|number| i64::from(number) + i64::from(range.base_vertex));
        let (least, most) = vertices.fold((0, 0), |(least, most), vertex| (vertex.min(least), vertex.max(most)));
        self.require(least >= 0, || format!("draws the vertex {least}"));
        most.unsigned_abs() + 1
    }

    /// The ranges are known to the device alone.
    fn indirect(&mut self, geometry: &Geometry, indirect: &IndirectDraws) {
        let IndirectDraws { buffer, offset, ranges } = *indirect;
        let described = self.recording.buffer(buffer);
        let (label, is_of_frame) = (described.label.clone(), described.life == BufferLife::Frame);
        self.require(ranges > 0, || "draws no range: use `clear`".into());
        self.require(offset % 4 == 0, || {
            format!("reads ranges from byte {offset} of the buffer `{label}`, which is not a multiple of 4")
        });
        self.holds(buffer, indirect.end(geometry.indices.is_some()));
        let writes = |pass: &Pass| pass.writes().contains(&Resource::Buffer(buffer));
        self.require(!is_of_frame || self.recording.passes.iter().any(writes), || {
            format!("reads ranges of the buffer `{label}`, but no pass before has written it")
        });
        geometry.vertices.iter().for_each(|vertices| self.holds(vertices.buffer, vertices.stride()));
        geometry.indices.into_iter().for_each(|indices| self.holds(indices, 4));
    }

    fn holds(&mut self, buffer: BufferId, bytes: u64) {
        let described = self.recording.buffer(buffer);
        let (label, has) = (described.label.clone(), described.bytes);
        self.require(has >= bytes, || format!("reads {bytes} bytes of the buffer `{label}`, which has {has}"));
    }

    fn entries(&mut self, geometry: &Geometry, kernel: &KernelCall) {
        let Ok(reflection) = kernel.shader.reflect() else { return };
        let vertex = self.entry(reflection, &kernel.function, EntryStage::Vertex);
        let fragment = geometry.fragment.as_ref().and_then(|name| self.entry(reflection, name, EntryStage::Fragment));
        if let Some(vertex) = &vertex {
            let given = geometry.attributes();
            self.require(vertex.inputs == given, || {
                format!("gives `{}` {}, but it takes {}", vertex.name, list(&given), list(&vertex.inputs))
            });
        }
        let colors = self.drawing.colors.len();
        self.require(geometry.fragment.is_some() || colors == 0, || {
            "has an attachment for color, but no fragment entry point".into()
        });
        let Some(fragment) = fragment else { return };
        let expected: Vec<Located> =
            (0..colors as u32).map(|location| Located { location, number: NumberKind::Float, width: 4 }).collect();
        self.require(fragment.outputs == expected, || {
            let (gives, wants) = (list(&fragment.outputs), list(&expected));
            format!("takes {wants} for its attachments, but `{}` gives {gives}", fragment.name)
        });
        for input in &fragment.inputs {
            let fits = vertex.as_ref().is_none_or(|vertex| vertex.outputs.contains(input));
            self.require(fits, || format!("has no {input} for `{}` from `{}`", fragment.name, kernel.function));
        }
    }

    fn entry(&mut self, reflection: &Reflection, name: &str, stage: EntryStage) -> Option<EntryPoint> {
        let found = reflection.entry(name).filter(|entry| entry.stage == stage).cloned();
        self.require(found.is_some(), || {
            let word = if stage == EntryStage::Vertex { "@vertex" } else { "@fragment" };
            format!("needs `{name}`, which is not a {word} entry point of its module")
        });
        found
    }
}

/// Values with locations, for messages.
fn list(values: &[Located]) -> String {
    let words: Vec<String> = values.iter().map(|value| format!("`{value}`")).collect();
    if words.is_empty() { "nothing".into() } else { words.join(", ") }
}
