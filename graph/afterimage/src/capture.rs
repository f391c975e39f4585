//! A frame in a folder, for the report of a bug: the program renders it.

use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

use afterimage_gpu::{Frame, Gpu, download, wgpu};
use afterimage_graph::check::{Fact, GraphInput};
use afterimage_graph::image::{ColorState, Format};
use afterimage_graph::node::{BlockData, CAMERA};
use afterimage_media::{Encoding, FileError, Picture, Pixels, write_atomic, write_image};

use crate::error::Error;
use crate::post::Post;

/// The script in the folder, and the folder in it for the pipeline's files.
const SCRIPT: &str = "render.sh";
const PIPELINE: &str = "pipeline";

/// Writes the files of a frame and the words of the command that renders it.
struct Capture<'a> {
    folder: &'a Path,
    words: Vec<String>,
}

impl Post {
    /// Writes what a frame is made of into a folder, for the report of a bug: the pipeline and the files that it names,
    /// its tier, the values and facts that the host has set, images and cameras, and a script `render.sh` in which
    /// `afterimage render` renders all of it, bit for bit as the host does on that device. Reads the images back, and
    /// waits for the device.
    ///
    /// The program renders a first frame, with the noise of the last one that was recorded: what earlier ones have left
    /// is not written, nor are options, the [size](Self::set_size) in which the pipeline works, and
    /// node kinds in Rust. Of an image, the first level and layer are written.
    ///
    /// # Errors
    /// The host has given a graph without files; an image cannot be read back, because its texture lacks `COPY_SRC`,
    /// has several samples or slices or a format that cannot be copied, such as `Depth24Plus`; a block is no camera; a
    /// file cannot be written.
    pub fn capture(&self, gpu: &Gpu, frame: &Frame<'_>, folder: &Path) -> Result<(), Error> {
        let mut capture = Capture { folder, words: Vec::new() };
        capture.write_pipeline(self)?;
        for input in &self.graph().inputs {
            if let Some((_, block)) = frame.blocks.iter().find(|(name, _)| *name == input.name) {
                capture.write_camera(input, block)?;
            } else if let Some((_, view)) = frame.inputs.iter().find(|(name, _)| *name == input.name) {
                capture.write_image(gpu, frame, input, view.texture())?;
            }
        }
        if let (true, Some((_, view))) = (frame.inputs.is_empty(), frame.outputs.first()) {
            let texture = view.texture();
            capture.word("--size", format!("{}x{}", texture.width(), texture.height()));
        }
        for output in &self.graph().outputs {
            let ending = if output.state == ColorState::Encoded { "png" } else { "exr" };
            capture.word("--output", format!("{}={}.{ending}", output.name, file_name(&output.name)));
        }
        capture.word("--captured", self.noise_number().to_string());
        let words: String = capture.words.iter().map(|word| format!(" {}", quoted(word))).collect();
        let script = format!(
            "#!/bin/sh\n# A frame of Afterimage {}.\ncd \"$(dirname \"$0\")\" || exit\n\
             exec \"${{AFTERIMAGE:-afterimage}}\" render{words} \"$@\"\n",
            env!("CARGO_PKG_VERSION")
        );
        capture.write(Path::new(SCRIPT), script.as_bytes())
    }
}

impl Capture<'_> {
    fn word(&mut self, option: &str, value: String) {
        self.words.extend([option.to_owned(), value]);
    }

    fn write(&self, file: &Path, bytes: &[u8]) -> Result<(), Error> {
        let path = self.folder.join(file);
        let folder = path.parent().unwrap_or(self.folder);
        let made = std::fs::create_dir_all(folder).map_err(|error| FileError::writing(folder, &error));
        made.and_then(|()| write_atomic(&path, bytes)).map_err(unwritable)
    }

    /// The pipeline with its files, its tier, and what the host has set.
    fn write_pipeline(&mut self, post: &Post) -> Result<(), Error> {
        let snapshot =
            post.snapshot().ok_or_else(|| Error::Name("a graph without files is not captured".to_owned()))?;
        let files = below_one_folder(snapshot.files());
        for (index, (path, bytes)) in files.iter().enumerate() {
            // The first one is the pipeline.
            let path = Path::new(PIPELINE).join(if index == 0 { path.with_extension("ron") } else { path.clone() });
            self.write(&path, bytes)?;
            let parent = path.parent().unwrap_or(Path::new(PIPELINE)).to_string_lossy().into_owned();
            if index == 0 {
                self.words.push(path.to_string_lossy().into_owned());
                self.word("--allow", PIPELINE.to_owned());
            } else if path.file_name().is_some_and(|name| name == "node.ron") {
                self.word("--nodes", parent);
            }
        }
        if let Some(tier) = post.tier() {
            self.word("--tier", tier.to_owned());
        }
        for (name, value) in post.set_values() {
            self.word("--set", format!("{name}={value}"));
        }
        for (name, _) in post.graph().facts() {
            match post.facts().get(&name) {
                Some(Fact::Flag(flag)) => self.word("--fact", format!("{name}={flag}")),
                Some(Fact::Number(number)) => self.word("--fact", format!("{name}={number}")),
                None => {}
            }
        }
        Ok(())
    }

    fn write_camera(&mut self, input: &GraphInput, block: &BlockData) -> Result<(), Error> {
        let name = &input.name;
        if block.block().name != CAMERA.name {
            return Err(Error::Image(format!("the block for `{name}` is no camera, and the program has no other")));
        }
        let numbers = |member: &str| block.get(member).unwrap_or_default();
        let mut members = Vec::new();
        for matrix in ["view", "projection", "previous_view", "previous_projection"] {
            // The block has columns, and the file rows.
            let columns = numbers(matrix);
            let rows: Vec<Vec<f32>> =
                (0..4).map(|row| columns.iter().skip(row).step_by(4).copied().collect()).collect();
            members.push(format!("  \"{matrix}\": {rows:?}"));
        }
        members.extend(["jitter", "previous_jitter"].map(|pair| format!("  \"{pair}\": {:?}", numbers(pair))));
        let file = format!("{}.json", file_name(name));
        self.write(Path::new(&file), format!("{{\n{}\n}}\n", members.join(",\n")).as_bytes())?;
        self.word("--input", format!("{name}={file}"));
        Ok(())
    }

    fn write_image(
        &mut self,
        gpu: &Gpu,
        frame: &Frame<'_>,
        input: &GraphInput,
        texture: &wgpu::Texture,
    ) -> Result<(), Error> {
        let name = &input.name;
        let why = match texture {
            _ if !texture.usage().contains(wgpu::TextureUsages::COPY_SRC) => Some("its texture lacks `COPY_SRC`"),
            _ if texture.sample_count() > 1 => Some("it has several samples in each pixel"),
            _ if texture.depth_or_array_layers() > 1 => Some("it has several slices"),
            _ => None,
        };
        if let Some(why) = why {
            return Err(Error::Image(format!("the image for `{name}` cannot be read back: {why}")));
        }
        let texels = download(&gpu.device, &gpu.queue, texture)?;
        let width = texels.desc.size.width as usize;
        let (mut size, mut floats) = ((texels.desc.size.width, texels.desc.size.height), texels.to_floats());
        if let Some(part) = frame.rectangle(name) {
            let (left, top) = (part.x as usize, part.y as usize);
            let rows = floats.chunks_exact(width).skip(top).take(part.height as usize);
            floats = rows.flat_map(|row| &row[left..left + part.width as usize]).copied().collect();
            size = (part.width, part.height);
        }
        let factor = frame.factors.iter().find(|(named, _)| named == name).map(|(_, factor)| *factor);
        if let Some(factor) = factor {
            floats.iter_mut().for_each(|[color @ .., _]| color.iter_mut().for_each(|number| *number *= factor));
        }
        let is_half = texels.desc.format == Format::Rgba16Float && factor.is_none();
        let pixels = match is_half {
            true => Pixels::Half(floats.as_flattened().iter().map(|number| half::f16::from_f32(*number)).collect()),
            false => Pixels::Float(floats.into_flattened()),
        };
        let file = format!("{}.exr", file_name(name));
        let options = Encoding { bits: if is_half { 16 } else { 32 }, ..Encoding::EXR };
        write_image(&self.folder.join(&file), &Picture::new(size.0, size.1, pixels), &options).map_err(unwritable)?;
        self.word("--input", format!("{name}={file}"));
        Ok(())
    }
}

fn unwritable(error: FileError) -> Error {
    Error::Unreadable(error.to_string())
}

/// A name of the pipeline as that of a file.
fn file_name(name: &str) -> String {
    name.replace(|c: char| !c.is_ascii_alphanumeric() && c != '-', "_")
}

/// A word for a shell.
fn quoted(word: &str) -> String {
    format!("'{}'", word.replace('\'', r"'\''"))
}

/// The files by their paths in the folder that is common to all.
fn below_one_folder(files: Vec<(PathBuf, Arc<[u8]>)>) -> Vec<(PathBuf, Arc<[u8]>)> {
    let files: Vec<_> = files.into_iter().map(|(path, bytes)| (without_dots(&path), bytes)).collect();
    let mut common = files.first().and_then(|(path, _)| path.parent()).unwrap_or(Path::new("")).to_owned();
    while !files.iter().all(|(path, _)| path.starts_with(&common)) && common.pop() {}
    let relative = |path: &Path| path.strip_prefix(&common).unwrap_or(path).to_owned();
    files.iter().map(|(path, bytes)| (relative(path), bytes.clone())).collect()
}

/// An absolute path without `.` and `..`.
fn without_dots(path: &Path) -> PathBuf {
    let mut plain = PathBuf::new();
    for part in std::path::absolute(path).unwrap_or(path.to_owned()).components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir => _ = plain.pop(),
            part => plain.push(part),
        }
    }
    plain
}
