//! Export: what is seen becomes a file.

use afterimage_gpu::wgpu;
use egui::{Context, Ui};

use super::Viewer;
use super::exporter::{ExportKind, Exported, PendingExport};
use super::picture::Subject;
use crate::render::device::{image, onto};
use crate::render::{Copied, Painter};

/// The format that a picture is drawn in.
const DRAWN: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

impl Viewer {
    /// Makes a file of what is seen in one of the next frames: see [`take_export`](Self::take_export).
    pub fn export(&mut self, kind: ExportKind) {
        self.exporter.requested = Some(kind);
    }

    /// Makes a file of the text with the changed values in it: see [`take_export`](Self::take_export).
    pub fn export_pipeline(&mut self) {
        self.text.apply(&mut self.model);
        let (name, bytes) = (self.model.project().name(), self.model.text_with_changes().into_bytes());
        self.exporter.finished = Some(Exported { name, bytes });
    }

    /// A file that is finished, for the shell to store.
    pub fn take_export(&mut self) -> Option<Exported> {
        self.exporter.finished.take()
    }

    pub(super) fn export_menu(&mut self, ui: &mut Ui) {
        let has_image = Subject::of(&self.model).is_some();
        ui.menu_button("Export", |ui| {
            let items = [
                ("Picture as PNG", "Ctrl+E: what is seen, at the size of the image", ExportKind::Picture),
                ("Numbers as EXR", "The image that is shown, with its numbers as they are", ExportKind::Numbers),
            ];
            for (name, what, kind) in items {
                if ui.add_enabled(has_image, egui::Button::new(name)).on_hover_text(what).clicked() {
                    self.export(kind);
                    ui.close();
                }
            }
            if ui.button("Pipeline as .ron").on_hover_text("The text with the changed values in it").clicked() {
                self.export_pipeline();
                ui.close();
            }
        });
    }

    /// Records the copy of the requested image.
    pub(super) fn record_export(&mut self, encoder: &mut wgpu::CommandEncoder) {
        let Some(kind) = self.exporter.requested else { return };
        let Some(subject) = Subject::of(&self.model) else { return };
        self.exporter.requested = None;
        let (texture, slice) = match kind {
            ExportKind::Picture => (self.draw_picture(encoder, &subject), 0),
            ExportKind::Numbers => (subject.image.clone(), subject.slice),
        };
        let copied = Copied::record(&self.model.gpu().device, encoder, &texture, slice);
        self.exporter.pending = copied.map(|copied| PendingExport::new(&self.model, &subject, kind, copied));
    }

    /// The picture as it is seen, on an image of its size.
    fn draw_picture(&self, encoder: &mut wgpu::CommandEncoder, subject: &Subject) -> wgpu::Texture {
        let (size, parts) = self.picture.whole(&self.model, subject);
        let gpu = self.model.gpu();
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

    /// Takes what has arrived.
    pub(super) fn finish_export(&mut self, ctx: &Context) {
        let Some(pending) = &mut self.exporter.pending else { return };
        pending.copied.request();
        let Some(texels) = pending.copied.texels() else { return ctx.request_repaint() };
        let encoded = pending.encode(&texels);
        let Some(PendingExport { name, .. }) = self.exporter.pending.take() else { return };
        match encoded {
            Ok(bytes) => self.exporter.finished = Some(Exported { name, bytes }),
            Err(why) => self.tell(ctx, format!("Nothing is exported: {why}")),
        }
    }
}
