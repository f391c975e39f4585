//! The panel of scopes: histogram, waveform, vectorscope.

use afterimage_gpu::wgpu;
use afterimage_graph::color::rec709_luminance;
use egui::{Color32, ColorImage, Pos2, Rect, RichText, Sense, Stroke, TextureOptions, Ui, Vec2};

use super::picture::Subject;
use super::theme::{DIM, FIELD};
use crate::render::{GRID, Grid, Painter};
use crate::scopes::{COLUMNS, ROWS, STOPS, Scopes};

pub(super) struct ScopePanel {
    grid: Grid,
    scopes: Option<(Scopes, bool)>,
    waveform: Option<egui::TextureHandle>,
    vectors: Option<egui::TextureHandle>,
}

const WHOLE: Rect = Rect { min: Pos2::ZERO, max: Pos2 { x: 1.0, y: 1.0 } };

const CHANNELS: [Color32; 3] =
    [Color32::from_rgb(0xe0, 0x5a, 0x50), Color32::from_rgb(0x66, 0xc0, 0x5c), Color32::from_rgb(0x5c, 0x8c, 0xf0)];

impl ScopePanel {
    pub(super) fn new(device: &wgpu::Device) -> Self {
        Self { grid: Grid::new(device), scopes: None, waveform: None, vectors: None }
    }

    pub(super) fn rebuild(&mut self, device: &wgpu::Device) {
        self.grid = Grid::new(device);
    }

    /// Samples an image. Returns false while an earlier sample has not arrived yet.
    pub(super) fn record(
        &mut self,
        device: &wgpu::Device,
        painter: &Painter,
        encoder: &mut wgpu::CommandEncoder,
        subject: &Subject,
    ) -> bool {
        self.grid.record(device, painter, encoder, &subject.image, subject.slice)
    }

    /// Requests what was sampled; call it after the commands are submitted.
    pub(super) fn request(&mut self) {
        self.grid.request();
    }

    /// Updates the scopes from a sample that has arrived. `is_linear` tells linear color from codes.
    pub(super) fn take(&mut self, ctx: &egui::Context, is_linear: bool) {
        let Some(pixels) = self.grid.take() else { return };
        let scopes = Scopes::of(&pixels, GRID[0] as usize, is_linear);
        let waveform = image(&scopes.waveform, [COLUMNS, ROWS], 0.35);
        put(ctx, &mut self.waveform, "waveform", waveform);
        let vectors = image(&scopes.vectors, [ROWS, ROWS], 0.2);
        put(ctx, &mut self.vectors, "vectorscope", vectors);
        self.scopes = Some((scopes, is_linear));
    }

    /// Shows nothing of the picture before.
    pub(super) fn forget(&mut self) {
        self.scopes = None;
    }

    /// The number of pixels with NaN or infinities in what is shown.
    pub(super) fn faults(&self) -> u64 {
        self.scopes.as_ref().map_or(0, |(scopes, _)| scopes.faults)
    }

    /// The least and the largest number of what is shown.
    pub(super) fn range(&self) -> Option<(f32, f32)> {
        self.scopes.as_ref().map(|(scopes, _)| scopes.range)
    }

    pub(super) fn show(&self, ui: &mut Ui) {
        let Some((scopes, is_linear)) = &self.scopes else {
            ui.label(RichText::new("The scopes wait for a picture.").color(DIM));
            return;
        };
        let unit = if *is_linear { "Histogram, stops from middle gray" } else { "Histogram, codes" };
        ui.label(RichText::new(unit).color(DIM).small());
        histogram(ui, scopes, *is_linear);
        let [white, black] = scopes.clipped.map(|part| part * 100.0);
        let (low, high) = scopes.range;
        let text = format!("{low:.3} to {high:.3}, clipped {white:.1} %, black {black:.1} %");
        ui.add(egui::Label::new(RichText::new(text).small()).truncate());
        ui.label(RichText::new("Waveform").color(DIM).small());
        let width = ui.available_width();
        show_image(ui, self.waveform.as_ref(), Vec2::new(width, width * 0.42));
        ui.label(RichText::new("Vectorscope").color(DIM).small());
        let side = width.min(150.0);
        let rect = show_image(ui, self.vectors.as_ref(), Vec2::splat(side));
        targets(ui, rect);
    }
}

fn put(ctx: &egui::Context, texture: &mut Option<egui::TextureHandle>, name: &str, image: ColorImage) {
    match texture {
        Some(texture) => texture.set(image, TextureOptions::LINEAR),
        None => *texture = Some(ctx.load_texture(name, image, TextureOptions::LINEAR)),
    }
}

/// Counts as brightness; `gamma` lifts what is rare.
fn image(counts: &[u32], size: [usize; 2], gamma: f32) -> ColorImage {
    let most = counts.iter().copied().max().unwrap_or(0).max(1) as f32;
    let shade = |count: &u32| {
        let part = (*count as f32 / most).powf(gamma);
        if *count == 0 { FIELD } else { Color32::from_gray((40.0 + 200.0 * part) as u8) }
    };
    ColorImage::new(size, counts.iter().map(shade).collect())
}

fn show_image(ui: &mut Ui, texture: Option<&egui::TextureHandle>, size: Vec2) -> Rect {
    let (rect, _) = ui.allocate_exact_size(size, Sense::hover());
    if let Some(texture) = texture {
        ui.painter().image(texture.id(), rect, WHOLE, Color32::WHITE);
    }
    rect
}

fn histogram(ui: &mut Ui, scopes: &Scopes, is_linear: bool) {
    let width = ui.available_width();
    let (rect, _) = ui.allocate_exact_size(Vec2::new(width, 74.0), Sense::hover());
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 2.0, FIELD);
    let marks: Vec<f32> =
        if is_linear { (1..5).map(|step| step as f32 / 5.0).collect() } else { vec![0.25, 0.5, 0.75] };
    for part in marks {
        let x = rect.min.x + rect.width() * part;
        painter.vline(x, rect.y_range(), Stroke::new(1.0, Color32::from_gray(0x30)));
        let stops = STOPS.0 + (STOPS.1 - STOPS.0) * part;
        let text = if is_linear { format!("{stops:+.0}") } else { format!("{:.0}", part * 255.0) };
        let at = Pos2::new(x + 2.0, rect.min.y + 1.0);
        painter.text(at, egui::Align2::LEFT_TOP, text, egui::FontId::proportional(9.0), Color32::from_gray(0x70));
    }
    // The ends hold everything beyond them, and would make the rest flat.
    let inner = scopes.histogram.iter().flat_map(|counts| &counts[1..COLUMNS - 1]);
    let most = inner.copied().max().unwrap_or(0).max(1) as f32;
    for (counts, color) in scopes.histogram.iter().zip(CHANNELS) {
        let point = |(column, count): (usize, &u32)| {
            let height = (*count as f32 / most).min(1.0).sqrt() * (rect.height() - 4.0);
            Pos2::new(rect.min.x + rect.width() * (column as f32 + 0.5) / COLUMNS as f32, rect.max.y - 1.0 - height)
        };
        painter.line(counts.iter().enumerate().map(point).collect(), Stroke::new(1.0, color));
    }
}

/// The places of the saturated primaries and their mixtures, at three quarters.
fn targets(ui: &Ui, rect: Rect) {
    let painter = ui.painter_at(rect);
    painter.circle_stroke(rect.center(), rect.width() * 0.375, Stroke::new(1.0, Color32::from_gray(0x38)));
    let colors = [[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.0, 1.0, 1.0], [0.0, 0.0, 1.0], [1.0, 0.0, 1.0]];
    for [red, green, blue] in colors {
        let luma = rec709_luminance([red, green, blue]);
        let across = Vec2::new((blue - luma) / 1.8556, -(red - luma) / 1.5748) * rect.width() * 0.75;
        let color = Color32::from_rgb((red * 220.0) as u8, (green * 220.0) as u8, (blue * 220.0) as u8);
        let square = Rect::from_center_size(rect.center() + across, Vec2::splat(6.0));
        painter.rect_stroke(square, 0.0, Stroke::new(1.0, color), egui::StrokeKind::Middle);
    }
}
