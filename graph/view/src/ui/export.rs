//! Export of the picture, of an image's numbers, and of the pipeline.

use afterimage_gpu::{Texels, wgpu};
use afterimage_graph::color::{Chromaticities, Colorimetry};
use afterimage_graph::image::Format;
use afterimage_media::{Encoding, Picture, Pixels, Samples, encode};
use egui::Ui;

use super::picture::{PictureView, Subject};
use crate::model::Model;
use crate::render::device::{image, onto};
use crate::render::{ImageCopy, Painter};

/// The format that a picture is drawn in.
const DRAWN: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

/// A file for the user.
pub struct Exported {
    /// Its name, with the extension.
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

/// The user's choice in the menu of exports.
pub(super) enum ExportChoice {
    Image(ExportKind),
    Pipeline,
}

/// Makes files of images within a few frames.
#[derive(Default)]
pub(super) struct Exporter {
    pub(super) requested: Option<ExportKind>,
    pending: Option<PendingExport>,
    pub(super) finished: Option<Exported>,
}

/// A file whose image is being copied.
struct PendingExport {
    kind: ExportKind,
    copy: ImageCopy,
    name: String,
    color: Option<Colorimetry>,
}

impl Exporter {
    /// Records the copy of the requested image.
    pub(super) fn record(&mut self, encoder: &mut wgpu::CommandEncoder, model: &Model, view: &PictureView) {
        let Some(kind) = self.requested else { return };
        let Some(subject) = Subject::of(model) else { return };
        self.requested = None;
        let (texture, slice) = match kind {
            ExportKind::Picture => (draw_picture(encoder, model, view, &subject), 0),
            ExportKind::Numbers => (subject.image.clone(), subject.slice),
        };
        let copy = ImageCopy::record(&model.gpu().device, encoder, &texture, slice);
        let (name, color) = (name(model, kind), colorimetry(model, &subject));
        self.pending = copy.map(|copy| PendingExport { kind, copy, name, color });
    }

    /// True while an image is being copied.
    pub(super) fn is_pending(&self) -> bool {
        self.pending.is_some()
    }

    /// Takes an image that has arrived.
    ///
    /// # Errors
    /// It cannot be encoded.
    pub(super) fn finish(&mut self) -> Result<(), String> {
        let Some(pending) = &mut self.pending else { return Ok(()) };
        pending.copy.request();
        let Some(texels) = pending.copy.texels() else { return Ok(()) };
        let encoded = pending.encode(&texels);
        let Some(PendingExport { name, .. }) = self.pending.take() else { return Ok(()) };
        self.finished = Some(Exported { name, bytes: encoded? });
        Ok(())
    }
}

impl PendingExport {
    /// The bytes of the file.
    fn encode(&self, texels: &Texels) -> Result<Vec<u8>, String> {
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

pub(super) fn menu(ui: &mut Ui, has_image: bool) -> Option<ExportChoice> {
    let mut choice = None;
    ui.menu_button("Export", |ui| {
        let items = [
            ("Picture as PNG", "Ctrl+E: what is seen, at the size of the image", ExportKind::Picture),
            ("Numbers as EXR", "The image that is shown, with its numbers as they are", ExportKind::Numbers),
        ];
        for (name, what, kind) in items {
            if ui.add_enabled(has_image, egui::Button::new(name)).on_hover_text(what).clicked() {
                choice = Some(ExportChoice::Image(kind));
                ui.close();
            }
        }
        if ui.button("Pipeline as .ron").on_hover_text("The text with the changed values in it").clicked() {
            choice = Some(ExportChoice::Pipeline);
            ui.close();
        }
    });
    choice
}

/// Draws the picture as it is seen into an image of its size.
fn draw_picture(
    encoder: &mut wgpu::CommandEncoder,
    model: &Model,
    view: &PictureView,
    subject: &Subject,
) -> wgpu::Texture {
    let (size, parts) = view.whole(model, subject);
    let gpu = model.gpu();
    let usages = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC;
    let target = image(&gpu.device, "exported picture", size, DRAWN, usages);
    let view = target.create_view(&Default::default());
    let painter = Painter::new(gpu, DRAWN);
    let mut pass = onto(encoder, "exported picture", &view);
    for (shown, [left, width]) in &parts {
        pass.set_scissor_rect(*left, 0, *width, size[1]);
        painter.drawn(shown).draw(&mut pass);
    }
    drop(pass);
    target
}

/// The name of the pipeline, and of the inspected image.
fn name(model: &Model, kind: ExportKind) -> String {
    let file = model.editor().project().name();
    let stem = file.strip_suffix(".ron").unwrap_or(&file);
    let place = model.inspected_image().map_or(String::new(), |(image, _)| format!("-{}", image.name));
    let letter = |c: char| if c.is_alphanumeric() || "-_.".contains(c) { c } else { '-' };
    let extension = if kind == ExportKind::Picture { "png" } else { "exr" };
    format!("{}.{extension}", format!("{stem}{place}").chars().map(letter).collect::<String>())
}

/// The colorimetry of the numbers; `None` for data.
fn colorimetry(model: &Model, subject: &Subject) -> Option<Colorimetry> {
    if model.inspector().wire().is_some() {
        return subject.is_linear_color().then(|| Colorimetry::linear(Chromaticities::REC709));
    }
    let shown = model.shown()?;
    let output = shown.plan()?.output(Some(&shown.output()?))?;
    (!subject.is_data()).then_some(output.colorimetry)
}
