//! Layout of the panels: around the picture in a wide window, below it in a narrow one, next to it in a flat one.

use egui::{Panel, TextWrapMode, Ui, Vec2};

use super::picture::Subject;
use super::{Tab, Viewer, toolbar, wire_bar};

/// The arrangement of the panels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Arrangement {
    /// Parameters to the left, scopes to the right, tabs below.
    Around,
    /// The picture above, and one panel with all tabs below.
    Below,
    /// The picture to the left, and one panel with all tabs to the right.
    Beside,
}

/// Less width than this leaves too little of the picture between parameters and scopes.
const MIN_WIDE: f32 = 960.0;
/// Less height than this leaves no room for a panel below the picture.
const MIN_HIGH: f32 = 520.0;
/// The least share of a narrow window that the panel below the picture gets.
const MIN_SHARE: f32 = 0.36;
/// The height of the bars below the picture, about, and that of a second row of the time.
const BARS: f32 = 118.0;
const SECOND_ROW: f32 = 30.0;

impl Arrangement {
    pub(super) fn of(window: Vec2) -> Self {
        match window.x < MIN_WIDE {
            false => Self::Around,
            true if window.y < MIN_HIGH && window.x > window.y => Self::Beside,
            true => Self::Below,
        }
    }
}

impl Viewer {
    /// The panels in the arrangement for the present size of the window.
    pub(super) fn panels(&mut self, ui: &mut Ui) {
        let arrangement = Arrangement::of(ui.available_size());
        self.tabs.set_narrow(arrangement != Arrangement::Around);
        match arrangement {
            Arrangement::Around => self.panels_around(ui),
            Arrangement::Below | Arrangement::Beside => {
                // Fingers are wider than the arrow of a mouse.
                ui.spacing_mut().interact_size.y = 26.0;
                ui.spacing_mut().button_padding = egui::vec2(6.0, 4.0);
                self.panels_in_one(ui, arrangement);
            }
        }
        if self.model.inspector().wire().is_some() {
            Panel::top("wire").show(ui, |ui| wire_bar::show(ui, &mut self.model, &mut self.picture, &self.scopes));
        }
    }

    fn panels_around(&mut self, ui: &mut Ui) {
        Panel::top("top").show(ui, |ui| self.top_bar(ui));
        self.bottom_panel(ui);
        Panel::left("parameters").default_size(308.0).size_range(240.0..=460.0).show(ui, |ui| {
            ui.add_space(4.0);
            self.show_parameters(ui);
        });
        if self.shows_scopes || self.inspects_pixels {
            Panel::right("scopes").default_size(264.0).size_range(200.0..=420.0).show(ui, |ui| self.right_panel(ui));
        }
        Panel::bottom("picture bar").show(ui, |ui| {
            ui.horizontal(|ui| toolbar::picture_bar(ui, &mut self.picture));
            toolbar::time_bar(ui, &mut self.model, false);
        });
    }

    /// One panel with all tabs, which takes what the picture leaves at the width of the window.
    fn panels_in_one(&mut self, ui: &mut Ui, arrangement: Arrangement) {
        Panel::top("narrow top").show(ui, |ui| {
            ui.add_space(2.0);
            ui.style_mut().wrap_mode = Some(TextWrapMode::Extend);
            self.narrow_bars(ui);
        });
        self.apply_hidden_text();
        let window = ui.available_size();
        let picture = Subject::of(&self.model)
            .map_or(9.0 / 16.0, |subject| subject.image.height() as f32 / subject.image.width() as f32);
        // A flat window has no room for a second row.
        let is_split = arrangement == Arrangement::Below && window.x < toolbar::MIN_TIME_BAR;
        let bars = BARS + if is_split { SECOND_ROW } else { 0.0 };
        let rest = window.y - window.x * picture - bars;
        match (arrangement, self.tabs.open) {
            (_, None) => drop(Panel::bottom("closed narrow tabs").show(ui, |ui| self.tab_bar(ui))),
            (Arrangement::Beside, Some(tab)) => {
                let panel = Panel::right("tabs beside").resizable(true).default_size(0.44 * window.x);
                panel.size_range(220.0..=0.7 * window.x).show(ui, |ui| self.tab_and_content(ui, tab));
            }
            (_, Some(tab)) => {
                let height = rest.clamp(MIN_SHARE * window.y, 0.75 * window.y);
                let panel = Panel::bottom("narrow tabs").resizable(true).default_size(height);
                panel.size_range(90.0..=0.85 * window.y).show(ui, |ui| self.tab_and_content(ui, tab));
            }
        }
        Panel::bottom("narrow picture bar").show(ui, |ui| {
            ui.horizontal_wrapped(|ui| toolbar::picture_bar(ui, &mut self.picture));
            toolbar::time_bar(ui, &mut self.model, is_split);
        });
    }

    fn tab_and_content(&mut self, ui: &mut Ui, tab: Tab) {
        ui.take_available_space();
        self.tab_bar(ui);
        ui.separator();
        self.tab_content(ui, tab);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_phone_a_tablet_and_a_desk_have_arrangements_of_their_own() {
        let of = |x, y| Arrangement::of(Vec2::new(x, y));
        assert_eq!([of(390.0, 844.0), of(768.0, 1024.0)], [Arrangement::Below; 2]);
        assert_eq!(of(844.0, 390.0), Arrangement::Beside);
        assert_eq!([of(1400.0, 900.0), of(1280.0, 720.0), of(1024.0, 768.0)], [Arrangement::Around; 3]);
    }
}
