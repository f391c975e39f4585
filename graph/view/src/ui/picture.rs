//! The picture: placed, moved and enlarged without rendering it again, and compared with another.

use afterimage_gpu::wgpu;
use afterimage_graph::image::{ColorState, Signedness};
use egui::{Color32, Pos2, Rect, Sense, Stroke, Ui, Vec2};

use super::missing_image::lacking;
use super::theme::{ACCENT, SURROUND};
use crate::model::{InspectedWire, Model};
use crate::render::{Drawn, Flags, Painter, Placement, Shown};

/// A way to compare two pictures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Comparison {
    /// The other begins at a line that can be moved.
    #[default]
    Wipe,
    /// The other stands to the right, at the same zoom.
    SideBySide,
    /// Their difference, enlarged eight times.
    Difference,
}

/// The most physical pixels that a texel is enlarged to, and the least.
const ZOOMS: (f32, f32) = (1.0 / 32.0, 128.0);
/// The factor of a difference.
const DIFFERENCE: f32 = 8.0;
/// From this zoom on, texels are shown as squares unless the user wants otherwise.
const SQUARES: f32 = 2.0;

/// Placement and appearance of the picture.
pub struct PictureView {
    /// Physical pixels of a texel; `None` fits the picture into the window.
    pub zoom: Option<f32>,
    /// The place in the picture that is in the middle of the window, in parts of its width and height.
    pub center: Vec2,
    /// Enlarged texels are filtered.
    pub smooth: bool,
    /// A way to compare two pictures.
    pub comparison: Comparison,
    /// The line of a wipe, in parts of the window's width.
    pub wipe: f32,
    /// Stops of exposure for the eye.
    pub stops: f32,
    /// The channel that is shown alone; 4 for all.
    pub channel: u32,
    pub false_color: bool,
    pub clipping: bool,
    /// Stripes on NaN, infinite and negative pixels.
    pub faults: bool,
    /// The peak of an HDR screen, where 1 is SDR white; `None` for other screens.
    pub headroom: Option<f32>,
    /// The picture is limited to SDR on an HDR screen, at the same white.
    pub is_sdr: bool,
    /// The place of the pointer, in parts of the picture.
    pub pointer: Option<[f32; 2]>,
    /// The place of the inspected pixel, in parts of the picture: the last place of the pointer, or the pinned one.
    pub inspected_place: Option<[f32; 2]>,
    /// The inspected pixel stays where it is.
    pub is_pinned: bool,
    /// The range of data that is shown from black to white.
    pub range: (f32, f32),
    /// Letters are commands: the picture was pressed last, and no panel.
    pub has_focus: bool,
    /// The node for which a click chooses what is gray.
    pub(super) picks: Option<String>,
    /// The place that was clicked for it, in parts of the picture.
    pub(super) picked: Option<[f32; 2]>,
    /// The difference of the compared pictures in figures.
    pub(super) figures: Option<String>,
    is_wiping: bool,
}

impl Default for PictureView {
    fn default() -> Self {
        Self {
            zoom: None,
            center: Vec2::splat(0.5),
            smooth: true,
            comparison: Comparison::default(),
            wipe: 0.5,
            stops: 0.0,
            channel: 4,
            false_color: false,
            clipping: false,
            faults: true,
            headroom: None,
            is_sdr: false,
            pointer: None,
            inspected_place: None,
            is_pinned: false,
            range: (0.0, 1.0),
            has_focus: true,
            picks: None,
            picked: None,
            figures: None,
            is_wiping: false,
        }
    }
}

/// An image that is shown, with its color state.
#[derive(Clone)]
pub struct Subject {
    pub image: wgpu::Texture,
    /// The color state of its numbers; `None` if it is unknown.
    pub state: Option<ColorState>,
    /// The slice of a volume.
    pub slice: u32,
}

impl Subject {
    /// The image that the model shows: that of the inspected wire, which may have none, or the output.
    pub fn of(model: &Model) -> Option<Self> {
        if let Some(wire) = model.inspector().wire() {
            return Some(Self::of_wire(model, wire)?.1);
        }
        let shown = model.shown()?;
        Some(Self { image: shown.picture()?.clone(), state: shown.output_state(), slice: 0 })
    }

    /// The image of a wire, and its name in the plan.
    pub(super) fn of_wire(model: &Model, wire: &InspectedWire) -> Option<(String, Self)> {
        let (image, texture) = model.wire_image(wire)?;
        let state = model.editor().checked().and_then(|checked| checked.wire_state(&wire.wire));
        Some((image.name, Self { image: texture, state, slice: wire.slice.min(image.desc.size.depth - 1) }))
    }

    /// True for linear color, which the window must encode.
    pub fn is_linear_color(&self) -> bool {
        matches!(self.state, Some(ColorState::Scene | ColorState::Exposed | ColorState::DisplayLinear))
    }

    /// True for data, which is shown by its range.
    pub fn is_data(&self) -> bool {
        self.state.is_none_or(|state| state.signedness() == Signedness::Signed)
    }
}

impl PictureView {
    /// Shows the picture in the rest of the window, with the place of the inspected pixel.
    pub fn show(&mut self, ui: &mut Ui, painter: &Painter, model: &Model, inspects_pixels: bool) {
        let (area, response) = ui.allocate_exact_size(ui.available_size(), Sense::click_and_drag());
        ui.painter().rect_filled(area, 0.0, SURROUND);
        self.has_focus |= response.contains_pointer() && ui.input(|input| input.pointer.any_pressed());
        let Some(subject) = Subject::of(model) else {
            return nothing(ui, area, model);
        };
        let other = if model.inspector().wire().is_some() { None } else { model.compared_picture() };
        let halves = self.areas(area, other.is_some());
        self.handle(ui, &response, &subject, halves[0], other.is_some());
        let images = [Some(&subject.image), if halves.len() == 2 { other } else { None }];
        let compared = if halves.len() == 2 { None } else { other };
        for (half, image) in halves.iter().zip(images.into_iter().flatten()) {
            let placement = self.placement(ui, *half, &subject, compared.is_some());
            let shown = Shown { image, other: compared, placement };
            paint(ui, *half, painter.drawn(&shown));
        }
        self.say_names(ui, model, area, other.is_some());
        self.pointer = response.hover_pos().and_then(|at| self.place_of(ui, at, &halves, &subject));
        if self.picks.is_some() {
            if self.pointer.is_some() {
                ui.set_cursor_icon(egui::CursorIcon::Crosshair);
            }
            self.picked = self.pointer.filter(|_| response.clicked());
        } else if inspects_pixels {
            self.follow_pointer(response.clicked());
            halves.iter().for_each(|half| self.mark_place(ui, *half, &subject));
        }
    }

    /// A click pins the inspected pixel, and another lets it go. Without a pin it stays where the pointer left the
    /// picture, so that a control can be turned while its values are read.
    fn follow_pointer(&mut self, is_clicked: bool) {
        let Some(place) = self.pointer else { return };
        if !self.is_pinned {
            self.inspected_place = Some(place);
        }
        self.is_pinned ^= is_clicked;
    }

    /// A cross at the inspected pixel, unless the pointer is there.
    fn mark_place(&self, ui: &Ui, area: Rect, subject: &Subject) {
        let Some(place) = self.inspected_place.filter(|_| self.is_pinned || self.pointer.is_none()) else { return };
        let (origin, extent) = self.place(ui, area, subject);
        let at = ((origin + Vec2::from(place) * extent) / ui.pixels_per_point()).to_pos2();
        let painter = ui.painter_at(area);
        for (width, color) in [(3.0, Color32::from_black_alpha(0xa0)), (1.0, Color32::WHITE)] {
            for side in [Vec2::X, Vec2::Y, -Vec2::X, -Vec2::Y] {
                painter.line_segment([at + side * 3.0, at + side * 10.0], Stroke::new(width, color));
            }
        }
    }

    /// The areas of pictures: two halves side by side, or everything.
    fn areas(&self, area: Rect, compares: bool) -> Vec<Rect> {
        if compares && self.comparison == Comparison::SideBySide {
            let (left, right) = area.split_left_right_at_fraction(0.5);
            return vec![left.with_max_x(left.max.x - 1.0), right.with_min_x(right.min.x + 1.0)];
        }
        vec![area]
    }

    /// Physical pixels of a texel.
    fn zoom_in(&self, ui: &Ui, area: Rect, subject: &Subject) -> f32 {
        let size = size_of(subject);
        let fit = (area.size() * ui.pixels_per_point() / size).min_elem();
        self.zoom.unwrap_or(fit)
    }

    fn placement(&self, ui: &Ui, area: Rect, subject: &Subject, compares: bool) -> Placement {
        let (origin, extent) = self.place(ui, area, subject);
        let line = ui.pixels_per_point() * (area.min.x + area.width() * self.wipe);
        let (zoom, peak) = (self.zoom_in(ui, area, subject), self.headroom.filter(|_| !self.is_sdr));
        let placed = Placement { wipe: line.round(), peak: peak.unwrap_or(1.0), ..self.made_visible(subject) };
        let flags = self.flags(subject, compares, zoom);
        Placement { origin: origin.into(), extent: extent.into(), flags, ..placed }
    }

    /// A small picture of an image in an area of the window, in physical pixels. Data is shown from black to white by
    /// its range.
    pub(super) fn thumbnail(&self, subject: &Subject, range: Option<(f32, f32)>, area: Rect) -> Placement {
        let (gain, bias) = gain(range.filter(|_| subject.is_data()).unwrap_or(self.range));
        let seen = self.made_visible(subject);
        let seen = if subject.is_data() { Placement { gain, bias, ..seen } } else { seen };
        let flags = self.flags(subject, false, 0.0) | Flags::SMOOTH;
        // A single channel is gray, and not red.
        let channel = if subject.image.format().components() == 1 { 0 } else { 4 };
        Placement { origin: area.min.into(), extent: area.size().into(), flags, channel, peak: 1.0, ..seen }
    }

    /// The mapping of numbers to colors, without a place.
    fn made_visible(&self, subject: &Subject) -> Placement {
        let (gain, bias) = self.gain(subject);
        let (difference, channel, slice) = (DIFFERENCE, self.channel, subject.slice);
        Placement { gain, bias, difference, channel, slice, ..bytemuck::Zeroable::zeroed() }
    }

    /// The visible picture at the size of the image, as on an SDR screen: the size of all, and each picture with its
    /// first column and its width. The line of a wipe is at the same part of the width as in the window.
    pub(super) fn whole<'m>(&self, model: &'m Model, subject: &'m Subject) -> ([u32; 2], Vec<(Shown<'m>, [u32; 2])>) {
        let other = if model.inspector().wire().is_some() { None } else { model.compared_picture() };
        let is_side_by_side = other.is_some() && self.comparison == Comparison::SideBySide;
        let compared = other.filter(|_| !is_side_by_side);
        let [width, height] = [subject.image.width(), subject.image.height()];
        let images = [Some(&subject.image), other.filter(|_| is_side_by_side)];
        let part = |(index, image): (usize, &'m wgpu::Texture)| {
            let left = index as u32 * width;
            let wipe = (width as f32 * self.wipe).round();
            let (origin, extent) = ([left as f32, 0.0], [width as f32, height as f32]);
            let flags = self.flags(subject, compared.is_some(), 1.0) & !Flags::SMOOTH;
            let placement = Placement { origin, extent, wipe, flags, peak: 1.0, ..self.made_visible(subject) };
            (Shown { image, other: compared, placement }, [left, width])
        };
        let parts: Vec<_> = images.into_iter().flatten().enumerate().map(part).collect();
        ([width * parts.len() as u32, height], parts)
    }

    /// The corner and the extent of the picture in physical pixels.
    fn place(&self, ui: &Ui, area: Rect, subject: &Subject) -> (Vec2, Vec2) {
        let extent = size_of(subject) * self.zoom_in(ui, area, subject);
        let center = if self.zoom.is_none() { Vec2::splat(0.5) } else { self.center };
        let origin = area.center().to_vec2() * ui.pixels_per_point() - center * extent;
        // Texels end at pixels of the screen where they are as large or larger.
        (Vec2::new(origin.x.round(), origin.y.round()), extent)
    }

    fn gain(&self, subject: &Subject) -> (f32, f32) {
        if subject.is_data() { gain(self.range) } else { (self.stops.exp2(), 0.0) }
    }

    fn flags(&self, subject: &Subject, compares: bool, zoom: f32) -> u32 {
        let is_smooth = self.smooth && zoom < SQUARES;
        let is_linear = subject.is_linear_color();
        let switches = [
            (is_smooth, Flags::SMOOTH),
            (is_linear, Flags::IS_LINEAR),
            (self.false_color && !subject.is_data(), Flags::FALSE_COLOR),
            (self.clipping && !subject.is_data(), Flags::CLIPPING),
            (self.faults && !subject.is_data(), Flags::FAULTS),
            (compares, Flags::COMPARES),
            (compares && self.comparison == Comparison::Difference, Flags::DIFFERS),
        ];
        switches.into_iter().filter(|(on, _)| *on).fold(0, |all, (_, flag)| all | flag)
    }

    /// Moves and enlarges the picture, and moves the line of a wipe.
    fn handle(&mut self, ui: &Ui, response: &egui::Response, subject: &Subject, area: Rect, compares: bool) {
        let line = area.min.x + area.width() * self.wipe;
        let wipes = compares && self.comparison == Comparison::Wipe;
        let is_near = |at: Pos2| wipes && (at.x - line).abs() < 8.0;
        if response.drag_started() {
            self.is_wiping = ui.input(|input| input.pointer.press_origin()).is_some_and(is_near);
        }
        if response.dragged() && self.is_wiping {
            let at = response.interact_pointer_pos().map_or(line, |at| at.x);
            self.wipe = ((at - area.min.x) / area.width()).clamp(0.0, 1.0);
        } else if response.dragged() {
            self.pan(ui, response.drag_delta(), area, subject);
        }
        if response.double_clicked() {
            self.zoom = if self.zoom.is_none() { Some(1.0) } else { None };
        }
        let Some(at) = response.hover_pos() else { return };
        if is_near(at) {
            ui.set_cursor_icon(egui::CursorIcon::ResizeHorizontal);
        }
        let turned = ui.input(|input| input.smooth_scroll_delta().y / 200.0 + input.zoom_delta().log2());
        if turned.abs() > 1e-3 {
            self.zoom_about(ui, at, turned.exp2(), area, subject);
        }
    }

    fn pan(&mut self, ui: &Ui, by: Vec2, area: Rect, subject: &Subject) {
        let zoom = self.zoom_in(ui, area, subject);
        if self.zoom.is_none() {
            (self.zoom, self.center) = (Some(zoom), Vec2::splat(0.5));
        }
        let center = self.center - by * ui.pixels_per_point() / (size_of(subject) * zoom);
        self.center = center.clamp(Vec2::ZERO, Vec2::splat(1.0));
    }

    /// Enlarges the picture; what is under the pointer stays there.
    fn zoom_about(&mut self, ui: &Ui, at: Pos2, factor: f32, area: Rect, subject: &Subject) {
        let before = self.zoom_in(ui, area, subject);
        let (origin, extent) = self.place(ui, area, subject);
        let place = (at.to_vec2() * ui.pixels_per_point() - origin) / extent;
        let zoom = (before * factor).clamp(ZOOMS.0, ZOOMS.1);
        self.zoom = Some(zoom);
        let from_center = (at - area.center()) * ui.pixels_per_point();
        self.center = place - from_center / (size_of(subject) * zoom);
    }

    /// The place in the picture under a point of the window.
    fn place_of(&self, ui: &Ui, at: Pos2, halves: &[Rect], subject: &Subject) -> Option<[f32; 2]> {
        let area = halves.iter().find(|half| half.contains(at))?;
        let (origin, extent) = self.place(ui, *area, subject);
        let place = (at.to_vec2() * ui.pixels_per_point() - origin) / extent;
        let is_inside = (0.0..1.0).contains(&place.x) && (0.0..1.0).contains(&place.y);
        is_inside.then_some([place.x, place.y])
    }

    /// The names of the pictures, where two are shown.
    fn say_names(&self, ui: &Ui, model: &Model, area: Rect, compares: bool) {
        let say = |at: Pos2, align: egui::Align2, text: &str| {
            let font = egui::FontId::proportional(12.0);
            let galley = ui.painter().layout_no_wrap(text.to_owned(), font, Color32::WHITE);
            let rect = align.anchor_size(at, galley.size());
            ui.painter().rect_filled(rect.expand2(Vec2::new(6.0, 3.0)), 3.0, Color32::from_black_alpha(0xb0));
            ui.painter().galley(rect.min, galley, Color32::WHITE);
        };
        if let Some(wire) = model.inspector().wire() {
            let mut name = model.inspected_image().map_or(wire.wire.clone(), |(image, _)| image.name);
            if let Some((level, count)) = model.inspected_level() {
                name += &format!(", level {level} of {count}");
            }
            say(area.left_top() + Vec2::new(14.0, 10.0), egui::Align2::LEFT_TOP, &format!("{name}  (Esc: the result)"));
        }
        if let Some(node) = &self.picks {
            let text = format!("Click what should be gray for `{node}`  (Esc: nothing)");
            say(area.center_top() + Vec2::new(0.0, 10.0), egui::Align2::CENTER_TOP, &text);
        }
        let Some(compared) = model.compared().filter(|_| compares) else { return };
        if let Some(figures) = &self.figures {
            say(area.left_bottom() + Vec2::new(14.0, -34.0), egui::Align2::LEFT_BOTTOM, figures);
        }
        if self.comparison == Comparison::Difference {
            let text = format!("The difference from {}, {DIFFERENCE} times as strong", compared.name());
            return say(area.left_top() + Vec2::new(14.0, 10.0), egui::Align2::LEFT_TOP, &text);
        }
        let line =
            if self.comparison == Comparison::Wipe { area.min.x + area.width() * self.wipe } else { area.center().x };
        say(Pos2::new(line - 14.0, area.max.y - 10.0), egui::Align2::RIGHT_BOTTOM, "as edited");
        say(Pos2::new(line + 14.0, area.max.y - 10.0), egui::Align2::LEFT_BOTTOM, &compared.name());
        if self.comparison == Comparison::Wipe {
            let at = Pos2::new(line, area.center().y);
            ui.painter().circle(at, 7.0, ACCENT, Stroke::new(1.0, Color32::BLACK));
        }
    }
}

/// The factor and the offset that show a range from black to white.
fn gain((low, high): (f32, f32)) -> (f32, f32) {
    let gain = 1.0 / (high - low).max(1e-6);
    (gain, -low * gain)
}

pub(super) fn size_of(subject: &Subject) -> Vec2 {
    Vec2::new(subject.image.width() as f32, subject.image.height() as f32)
}

/// The text in the place of a picture.
fn nothing(ui: &Ui, area: Rect, model: &Model) {
    let text = match (lacking(model), model.problem()) {
        (Some(text), _) => text,
        (None, Some(_)) => "There is no picture yet: the tab Messages says why.",
        (None, None) => "The first picture is on its way.",
    };
    let font = egui::FontId::proportional(14.0);
    ui.painter().text(area.center(), egui::Align2::CENTER_CENTER, text, font, Color32::from_gray(0x90));
}

/// Draws an image into an area of the window.
pub(super) fn paint(ui: &Ui, area: Rect, drawn: Drawn) {
    ui.painter_at(area).add(egui_wgpu::Callback::new_paint_callback(area, Callback(drawn)));
}

struct Callback(Drawn);

impl egui_wgpu::CallbackTrait for Callback {
    fn paint(
        &self,
        _: egui::PaintCallbackInfo,
        pass: &mut wgpu::RenderPass<'static>,
        _: &egui_wgpu::CallbackResources,
    ) {
        self.0.draw(pass);
    }
}
