//! Export: what is seen becomes a file.

use afterimage_gpu::{Texels, wgpu};
use afterimage_graph::color::{Chromaticities, Colorimetry};
use afterimage_graph::image::Format;
use afterimage_media::{EncodedPixels, ExrOptions, Picture, Pixels, PngOptions, encode_exr, encode_png};
use egui::{Context, Ui};

use super::Viewer;
use super::picture::Subject;
use crate::model::Model;
use crate::render::device::{image, onto};
use crate::render::{Copied, Painter};

/// A file for the user.
pub struct Exported {
    /// Its name, with the ending.
    pub name: String,
    /// Its content.
    pub bytes: Vec<u8>,
}

/// What a file holds.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum ExportKind {
    /// The picture as an SDR screen shows it, at the size of the image, with comparisons and false colour: PNG.
    Picture,
    /// The numbers of the image that is shown, as they are: EXR.
    Numbers,
}

/// What is exported.
#[derive(Default)]
pub(super) struct Exporter {
    wanted: Option<ExportKind>,
    under_way: Option<UnderWay>,
    pub(super) finished: Option<Exported>,
}

struct UnderWay {
    kind: ExportKind,
    copied: Copied,
    name: String,
    colour: Option<Colorimetry>,
}

/// The format that a picture is drawn in.
const DRAWN: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

impl Viewer {
    /// Makes a file of what is seen in one of the next frames: see [`take_export`](Self::take_export).
    pub fn export(&mut self, kind: ExportKind) {
        self.exporter.wanted = Some(kind);
    }

    /// A file that is finished, for the shell to store.
    pub fn take_export(&mut self) -> Option<Exported> {
        self.exporter.finished.take()
    }

    pub(super) fn export_menu(&mut self, ui: &mut Ui) {
        let can = Subject::of(&self.model).is_some();
        ui.add_enabled_ui(can, |ui| self.export_items(ui));
    }

    fn export_items(&mut self, ui: &mut Ui) {
        ui.menu_button("Export", |ui| {
            let items = [
                ("Picture as PNG", "Ctrl+E: what is seen, at the size of the image", ExportKind::Picture),
                ("Numbers as EXR", "The image that is shown, with its numbers as they are", ExportKind::Numbers),
            ];
            for (name, what, kind) in items {
                if ui.button(name).on_hover_text(what).clicked() {
                    self.export(kind);
                    ui.close();
                }
            }
        });
    }

    /// Records the copy of what is wanted.
    pub(super) fn record_export(&mut self, encoder: &mut wgpu::CommandEncoder) {
        let Some(subject) = Subject::of(&self.model) else { return };
        let Some(kind) = self.exporter.wanted.take() else { return };
        let (texture, slice) = match kind {
            ExportKind::Picture => (self.draw_picture(encoder, &subject), 0),
            ExportKind::Numbers => (subject.image.clone(), subject.slice),
        };
        let (name, colour) = (name(&self.model, kind), colorimetry(&self.model, &subject));
        let copied = Copied::record(&self.model.gpu().device, encoder, &texture, slice);
        self.exporter.under_way = copied.map(|copied| UnderWay { kind, copied, name, colour });
    }

    /// The picture as it is seen, on an image of its size.
    fn draw_picture(&self, encoder: &mut wgpu::CommandEncoder, subject: &Subject) -> wgpu::Texture {
        let (size, parts) = self.picture.whole(&self.model, subject);
        let gpu = self.model.gpu();
        let usages = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC;
        let target = image(&gpu.device, "exported picture", size, (DRAWN, usages));
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

    /// Takes what has arrived.
    pub(super) fn finish_export(&mut self, ctx: &Context) {
        let Some(under_way) = &mut self.exporter.under_way else { return };
        under_way.copied.ask();
        let Some(texels) = under_way.copied.texels() else { return ctx.request_repaint() };
        let encoded = under_way.encode(&texels);
        let Some(UnderWay { name, .. }) = self.exporter.under_way.take() else { return };
        match encoded {
            Ok(bytes) => self.exporter.finished = Some(Exported { name, bytes }),
            Err(why) => self.tell(ctx, format!("Nothing is exported: {why}")),
        }
    }
}

impl UnderWay {
    fn encode(&self, texels: &Texels) -> Result<Vec<u8>, String> {
        let size = (texels.desc.size.width, texels.desc.size.height);
        let encoded = match self.kind {
            ExportKind::Picture => {
                let options = PngOptions { dither: None, ..PngOptions::default() };
                encode_png(size, EncodedPixels::Byte(&texels.bytes), &options)
            }
            ExportKind::Numbers => {
                let pixels = Pixels::Float(texels.to_floats().as_flattened().to_vec());
                let halves = [Format::Rgba16Float, Format::Rg16Float, Format::R16Float];
                let float = !halves.contains(&texels.desc.format);
                let options = ExrOptions { float, colour: self.colour, ..ExrOptions::default() };
                encode_exr(&Picture::new(size.0, size.1, pixels), &options)
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

/// What colours the numbers are; `None` for data.
fn colorimetry(model: &Model, subject: &Subject) -> Option<Colorimetry> {
    if model.tap().is_some() {
        return subject.is_light().then(|| Colorimetry::linear(Chromaticities::REC709));
    }
    let shown = model.shown()?;
    let output = shown.plan()?.output(Some(&shown.output()?))?;
    (!subject.is_data()).then_some(output.colorimetry)
}
