//! A frame of a host as files, and the command with which the program renders it again.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use afterimage_gpu::wgpu::{Device, Queue, TextureView};
use afterimage_gpu::{Frame, Post, Rectangle, Texels, download};
use afterimage_graph::image::{ColorState, Format};
use afterimage_graph::node::{BlockData, CAMERA};
use afterimage_media::{ExrOptions, Picture, Pixels, write_atomic, write_exr};
use half::f16;
use serde_json::json;

use crate::LabError;

/// What a dump cannot know from the frame.
#[derive(Clone, Copy, Debug)]
pub struct Dump<'a> {
    /// The file of the pipeline.
    pub pipeline: &'a Path,
    /// The tier that runs.
    pub tier: Option<&'a str>,
    /// The folder for the files; it is made if it is not there.
    pub folder: &'a Path,
}

impl Dump<'_> {
    /// Writes the images of a frame as EXR, its cameras as JSON, the plan that renders, and the command for a shell
    /// that renders it again into `out.png` (`out.exr` for light), in `command.txt`; returns the command. Rectangles
    /// and factors are applied to the images. Waits for the device.
    ///
    /// The program renders a first frame, with the number 0 and empty histories. A `Dither` is done by the writer.
    ///
    /// # Errors
    /// An input whose texture has no `COPY_SRC` or none of the formats of images, a block that is no camera, a file
    /// that cannot be written.
    pub fn write(&self, post: &Post, device: &Device, queue: &Queue, frame: &Frame<'_>) -> Result<String, LabError> {
        std::fs::create_dir_all(self.folder)
            .map_err(|error| LabError::Machine(format!("cannot make {}: {error}", self.folder.display())))?;
        let mut command = format!("afterimage render {}", quoted(&self.pipeline.display().to_string()));
        for input in &post.graph().inputs {
            let file = match given(frame.blocks, &input.name) {
                Some(block) => self.camera(&input.name, block)?,
                None => match given(frame.inputs, &input.name) {
                    Some(view) => self.image(&input.name, device, queue, view, frame)?,
                    None => continue,
                },
            };
            let _ = write!(command, " --input {}", quoted(&format!("{}={}", input.name, file.display())));
        }
        if let Some(tier) = self.tier {
            let _ = write!(command, " --tier {}", quoted(tier));
        }
        for (name, value) in post.set_values() {
            let _ = write!(command, " --set {}", quoted(&format!("{name}={value}")));
        }
        let used = post.graph().facts();
        for (name, fact) in post.facts().iter().filter(|(name, _)| used.iter().any(|(known, _)| known == name)) {
            let _ = write!(command, " --fact {}", quoted(&format!("{name}={fact}")));
        }
        if let Some(plan) = post.plan() {
            let is_encoded = plan.outputs.first().is_some_and(|output| output.state == ColorState::Encoded);
            let out = self.folder.join(if is_encoded { "out.png" } else { "out.exr" });
            let _ = write!(command, " -o {}", quoted(&out.display().to_string()));
            write_atomic(&self.folder.join("plan.json"), plan.to_json().as_bytes())?;
        }
        write_atomic(&self.folder.join("command.txt"), format!("{command}\n").as_bytes())?;
        Ok(command)
    }

    fn image(
        &self,
        input: &str,
        device: &Device,
        queue: &Queue,
        view: &TextureView,
        frame: &Frame<'_>,
    ) -> Result<PathBuf, LabError> {
        let texture = view.texture();
        if !texture.usage().contains(afterimage_gpu::wgpu::TextureUsages::COPY_SRC) {
            let wrong = LabError::request(format!("the texture of the input `{input}` cannot be read back"));
            return Err(wrong.hint("make it with the usage `COPY_SRC`"));
        }
        let texels = download(device, queue, texture)?;
        let size = texels.desc.size;
        let rectangle = given(frame.rectangles, input).unwrap_or(Rectangle::whole(size));
        let factor = frame.factors.iter().find(|(name, _)| *name == input).map_or(1.0, |(_, factor)| *factor);
        let picture = picture(&texels, rectangle, factor);
        let file = self.folder.join(format!("{}.exr", input.replace(['/', '\\'], "-")));
        let float = matches!(picture.pixels, Pixels::Float(_));
        write_exr(&file, &picture, &ExrOptions { float, ..ExrOptions::default() })?;
        Ok(file)
    }

    fn camera(&self, input: &str, block: &BlockData) -> Result<PathBuf, LabError> {
        if *block.block() != CAMERA {
            return Err(LabError::request(format!("the input `{input}` is a {}, and no camera", block.block().name)));
        }
        let rows = |name: &str| {
            let columns = block.get(name).expect("a camera has this member");
            (0..4).map(|row| (0..4).map(|column| columns[4 * column + row]).collect()).collect::<Vec<Vec<f32>>>()
        };
        let pair = |name: &str| block.get(name).expect("a camera has this member");
        let camera = json!({
            "view": rows("view"), "projection": rows("projection"), "jitter": pair("jitter"),
            "previous_view": rows("previous_view"), "previous_projection": rows("previous_projection"),
            "previous_jitter": pair("previous_jitter"),
        });
        let file = self.folder.join(format!("{}.json", input.replace(['/', '\\'], "-")));
        write_atomic(&file, camera.to_string().as_bytes())?;
        Ok(file)
    }
}

/// The texels of a rectangle times a factor. Half floats stay half floats without one.
fn picture(texels: &Texels, rectangle: Rectangle, factor: f32) -> Picture {
    let all = texels.to_floats();
    let row = |y: u32| {
        let first = (y * texels.desc.size.width + rectangle.x) as usize;
        &all[first..first + rectangle.width as usize]
    };
    let scaled = |[r, g, b, a]: [f32; 4]| [r * factor, g * factor, b * factor, a];
    let rows = (rectangle.y..rectangle.y + rectangle.height).flat_map(row);
    let numbers: Vec<f32> = rows.flat_map(|texel| scaled(*texel)).collect();
    let pixels = match texels.desc.format {
        Format::Rgba16Float if factor == 1.0 => Pixels::Half(numbers.into_iter().map(f16::from_f32).collect()),
        _ => Pixels::Float(numbers),
    };
    Picture::new(rectangle.width, rectangle.height, pixels)
}

/// The entry of that name.
fn given<T: Copy>(entries: &[(&str, T)], name: &str) -> Option<T> {
    entries.iter().find(|(known, _)| *known == name).map(|(_, entry)| *entry)
}

/// A word of a shell.
fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "/._-=+:,".contains(c);
    if word.chars().all(is_plain) { word.to_owned() } else { format!("'{}'", word.replace('\'', r"'\''")) }
}
