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
