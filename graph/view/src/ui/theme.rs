//! Colors and sizes: neutral grays, so that nothing around the picture changes how its colors look, and one accent.

use afterimage_graph::node::PortType;
use egui::{Color32, CornerRadius, FontData, FontDefinitions, FontFamily, FontId, Stroke, TextStyle, Visuals};
use epaint_default_fonts::{HACK_REGULAR, UBUNTU_LIGHT};

/// The color of selections and changes.
pub(super) const ACCENT: Color32 = Color32::from_rgb(0xf2, 0xb1, 0x34);
pub(super) const ERROR: Color32 = Color32::from_rgb(0xf0, 0x6a, 0x5c);
/// Text that is less important.
pub(super) const DIM: Color32 = Color32::from_gray(0x96);
/// The color around the picture.
pub(super) const SURROUND: Color32 = Color32::from_gray(0x17);
const PANEL: Color32 = Color32::from_gray(0x20);
/// Fields and the backs of plots.
pub(super) const FIELD: Color32 = Color32::from_gray(0x15);

/// The color of what a wire carries.
pub(super) fn wire_color(ty: PortType) -> Color32 {
    match ty {
        PortType::Image => Color32::from_rgb(0x6c, 0xa8, 0xe0),
        PortType::Multisampled => Color32::from_rgb(0x8c, 0x8c, 0xe6),
        PortType::Pyramid => Color32::from_rgb(0x5a, 0xc8, 0xc0),
        PortType::Volume => Color32::from_rgb(0x8a, 0xc9, 0x66),
        PortType::Table => Color32::from_rgb(0xe0, 0x9a, 0x5c),
        PortType::Value => Color32::from_rgb(0xe0, 0xd0, 0x6c),
        PortType::Block => Color32::from_rgb(0xb4, 0x8e, 0xe0),
    }
}

/// Sets the look of everything.
pub(super) fn apply(ctx: &egui::Context) {
    ctx.set_fonts(fonts());
    let mut visuals = Visuals::dark();
    (visuals.panel_fill, visuals.window_fill) = (PANEL, PANEL);
    (visuals.extreme_bg_color, visuals.faint_bg_color) = (FIELD, Color32::from_gray(0x26));
    visuals.selection.bg_fill = Color32::from_rgb(0x6e, 0x52, 0x1c);
    visuals.selection.stroke = Stroke::new(1.0, ACCENT);
    visuals.hyperlink_color = ACCENT;
    visuals.slider_trailing_fill = true;
    let corner = CornerRadius::same(3);
    let widgets = &mut visuals.widgets;
    widgets.noninteractive.fg_stroke.color = Color32::from_gray(0xcc);
    widgets.inactive.fg_stroke.color = Color32::from_gray(0xd4);
    widgets.inactive.bg_fill = Color32::from_gray(0x3a);
    widgets.inactive.weak_bg_fill = Color32::from_gray(0x30);
    for look in [&mut widgets.inactive, &mut widgets.hovered, &mut widgets.active, &mut widgets.open] {
        look.corner_radius = corner;
    }
    // A browser would choose by its own preference.
    ctx.set_theme(egui::Theme::Dark);
    ctx.set_visuals(visuals);
    ctx.all_styles_mut(|style| {
        style.spacing.item_spacing = egui::vec2(6.0, 4.0);
        style.spacing.slider_width = 112.0;
        style.spacing.interact_size.y = 20.0;
        let sizes =
            [(TextStyle::Body, 12.5), (TextStyle::Button, 12.5), (TextStyle::Small, 10.5), (TextStyle::Heading, 14.0)];
        for (style_name, size) in sizes {
            style.text_styles.insert(style_name, FontId::new(size, FontFamily::Proportional));
        }
        style.text_styles.insert(TextStyle::Monospace, FontId::new(11.5, FontFamily::Monospace));
    });
}

/// The fonts. Those of egui's emoji are a seventh of the page in the browser, and the viewer writes none.
fn fonts() -> FontDefinitions {
    let mut fonts = FontDefinitions::empty();
    for (name, bytes) in [("Ubuntu-Light", UBUNTU_LIGHT), ("Hack", HACK_REGULAR)] {
        fonts.font_data.insert(name.into(), FontData::from_static(bytes).into());
    }
    // Each has letters that the other lacks.
    let families =
        [(FontFamily::Proportional, ["Ubuntu-Light", "Hack"]), (FontFamily::Monospace, ["Hack", "Ubuntu-Light"])];
    fonts.families = families.map(|(family, names)| (family, names.map(str::to_owned).to_vec())).into();
    fonts
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The area of a glyph in the texture of its font.
    fn drawn(ctx: &egui::Context, font: &FontId, letter: char) -> impl PartialEq {
        let line = ctx.fonts_mut(|fonts| fonts.layout_no_wrap(letter.into(), font.clone(), Color32::WHITE));
        line.rows[0].glyphs[0].uv_rect
    }

    #[test]
    fn the_fonts_have_the_letters_that_the_viewer_and_the_built_in_texts_write() {
        let ctx = egui::Context::default();
        apply(&ctx);
        ctx.run_ui(egui::RawInput::default(), |_| {}).textures_delta.clear();
        for font in [FontId::proportional(12.5), FontId::monospace(11.5)] {
            let lacks = |letter: &char| drawn(&ctx, &font, *letter) == drawn(&ctx, &font, '\u{10ffff}');
            let lacking: String = "▾…–−±×²³→Δµ·“”●😀".chars().filter(lacks).collect();
            assert_eq!(lacking, "😀", "{font:?}");
        }
    }
}
