//! An image on its way to a file.

use afterimage_gpu::Texels;
use afterimage_graph::color::{Chromaticities, Colorimetry};
use afterimage_graph::image::Format;
use afterimage_media::{Encoding, Picture, Pixels, Samples, encode};

use super::picture::Subject;
use crate::model::Model;
use crate::render::Copied;

/// A file for the user.
pub struct Exported {
    /// Its name, with the ending.
    pub name: String,
    pub bytes: Vec<u8>,
}

#[derive(Clone, Copy, PartialEq, Eq)]
pub enum ExportKind {
    /// The picture as an SDR screen shows it, at the size of the image, with comparisons and false color: PNG.
    Picture,
    /// The numbers of the image that is shown, as they are: EXR.
    Numbers,
}

#[derive(Default)]
pub(super) struct Exporter {
    pub(super) requested: Option<ExportKind>,
    pub(super) pending: Option<PendingExport>,
    pub(super) finished: Option<Exported>,
}

/// A file whose image is being copied.
pub(super) struct PendingExport {
    kind: ExportKind,
    pub(super) copied: Copied,
    pub(super) name: String,
    color: Option<Colorimetry>,
}

impl PendingExport {
    /// What a model shows, as a file of a kind.
    pub(super) fn new(model: &Model, subject: &Subject, kind: ExportKind, copied: Copied) -> Self {
        Self { kind, copied, name: name(model, kind), color: colorimetry(model, subject) }
    }

    /// The bytes of the file.
    pub(super) fn encode(&self, texels: &Texels) -> Result<Vec<u8>, String> {
        let size = (texels.desc.size.width, texels.desc.size.height);
        let encoded = match self.kind {
            ExportKind::Picture => {
                let options = Encoding { dither: None, ..Encoding::PNG };
                encode((size, Samples::Byte(&texels.bytes)), &options)
            }
            ExportKind::Numbers => {
                let pixels = Pixels::Float(texels.to_floats().as_flattened().to_vec());
                let halves = [Format::Rgba16Float, Format::Rg16Float, Format::R16Float];
                let bits = if halves.contains(&texels.desc.format) { 16 } else { 32 };
                let options = Encoding { bits, color: self.color, ..Encoding::EXR };
                encode(&Picture::new(size.0, size.1, pixels), &options)
            }
        };
        encoded.map_err(|error| error.to_string())
    }
}

/// The name of the pipeline, and of the place in the graph that is looked at.
fn name(model: &Model, kind: ExportKind) -> String {
    let file = model.project().name();
    let stem = file.strip_suffix(".ron").unwrap_or(&file);
    let place = model.tapped().map_or(String::new(), |(image, _)| format!("-{}", image.name));
    let letter = |c: char| if c.is_alphanumeric() || "-_.".contains(c) { c } else { '-' };
    let ending = if kind == ExportKind::Picture { "png" } else { "exr" };
    format!("{}.{ending}", format!("{stem}{place}").chars().map(letter).collect::<String>())
}

/// What colors the numbers are; `None` for data.
fn colorimetry(model: &Model, subject: &Subject) -> Option<Colorimetry> {
    if model.tap().is_some() {
        return subject.is_light().then(|| Colorimetry::linear(Chromaticities::REC709));
    }
    let shown = model.shown()?;
    let output = shown.plan()?.output(Some(&shown.output()?))?;
    (!subject.is_data()).then_some(output.colorimetry)
}
