//! The menu: tiers, facts and parameters of the pipeline of the only camera.

use afterimage::host::{FactKind, Graph, Type, Value};
use bevy::diagnostic::DiagnosticsStore;
use bevy::prelude::*;
use bevy::ui::RelativeCursorPosition;
use bevy_afterimage::{Afterimage, AfterimageStatus, Pipeline};

/// The parameters that a look is made of; a pipeline has some of them.
const PREFERRED: [&str; 12] = [
    "exposed.stops",
    "metered.compensation",
    "local.contrast",
    "local.detail",
    "bright.threshold",
    "lit.strength",
    "bloom.radius",
    "bloom.spread",
    "foggy.density",
    "vignette.amount",
    "grain.amount",
    "sharp.amount",
];
const MAX_SLIDERS: usize = 7;

const PANEL: Color = Color::srgba(0.035, 0.04, 0.055, 0.86);
const TRACK: Color = Color::srgba(1.0, 1.0, 1.0, 0.12);
const ACCENT: Color = Color::srgb(0.98, 0.72, 0.36);
const BRIGHT: Color = Color::srgb(0.93, 0.93, 0.95);
const DIM: Color = Color::srgb(0.6, 0.62, 0.68);

/// What can be chosen, and what is chosen.
#[derive(Resource)]
pub(crate) struct Menu {
    tiers: Vec<Option<String>>,
    facts: Vec<(String, bool)>,
    sliders: Vec<Slider>,
    /// The line that the keyboard changes.
    line: usize,
    /// The slider that the mouse has.
    dragged: Option<usize>,
    is_new: bool,
}

struct Slider {
    name: String,
    unit: String,
    range: (f32, f32),
    /// The value of the file at the present tier, and that of the player.
    written: f32,
    set: Option<f32>,
    tier: usize,
}

impl Slider {
    fn value(&self) -> f32 {
        self.set.unwrap_or(self.written)
    }

    fn share(&self) -> f32 {
        ((self.value() - self.range.0) / (self.range.1 - self.range.0)).clamp(0.0, 1.0)
    }
}

/// What a part of the panel is for.
#[derive(Component, Clone, Copy, PartialEq)]
pub(crate) enum Part {
    Tier(usize),
    Fact(usize),
    Slider(usize),
    Fill(usize),
    Number(usize),
    Label(usize),
    Status,
}

/// Builds the menu once the pipeline is there.
pub(crate) fn build(
    mut commands: Commands,
    menu: Option<Res<Menu>>,
    pipelines: Res<Assets<Pipeline>>,
    assets: Res<AssetServer>,
    look: Single<&Afterimage>,
) {
    if menu.is_some() {
        return;
    }
    let Some(pipeline) = pipelines.get(&look.pipeline) else { return };
    let Ok(graph) = pipeline.graph(look.tier.as_deref()) else { return };
    let tiers = std::iter::once(None).chain(pipeline.tiers().iter().cloned().map(Some)).collect();
    let facts = graph.facts().into_iter().filter(|(_, kind)| *kind == FactKind::Flag);
    let facts = facts.map(|(name, _)| (name, true)).collect();
    let sliders = PREFERRED.iter().filter_map(|name| slider(&graph, name)).take(MAX_SLIDERS).collect();
    let menu = Menu { tiers, facts, sliders, line: 0, dragged: None, is_new: true };
    let file = assets.get_path(look.pipeline.id()).map_or(String::new(), |path| path.to_string());
    spawn(&mut commands, &menu, &file);
    commands.insert_resource(menu);
}

fn slider(graph: &Graph, name: &str) -> Option<Slider> {
    let place = graph.parameter(name).ok()?;
    let declared = graph.declaration(place);
    let (low, high) = declared.usual.or(declared.domain).filter(|_| declared.ty == Type::Float)?;
    let Value::Float(written) = graph.value(place) else { return None };
    // A longer one does not fit into the panel.
    let unit = declared.unit.to_string();
    let unit = if unit.len() > 6 { String::new() } else { unit };
    let range = (low as f32, high.min(low + 16.0) as f32);
    Some(Slider { name: name.to_owned(), unit, range, written: *written as f32, set: None, tier: 0 })
}

fn spawn(commands: &mut Commands, menu: &Menu, file: &str) {
    let panel = Node {
        position_type: PositionType::Absolute,
        right: px(20),
        top: px(20),
        width: px(312),
        padding: UiRect::all(px(18)),
        flex_direction: FlexDirection::Column,
        row_gap: px(11),
        border_radius: BorderRadius::all(px(10)),
        ..default()
    };
    commands.spawn((panel, BackgroundColor(PANEL))).with_children(|panel| {
        panel.spawn(text(file, 19.0, BRIGHT));
        let row = Node { column_gap: px(5), margin: UiRect::bottom(px(4)), ..default() };
        panel.spawn(row).with_children(|row| {
            for (index, tier) in menu.tiers.iter().enumerate() {
                let name = tier.as_deref().unwrap_or("file");
                row.spawn(button(Part::Tier(index), 1.0)).with_child(text(name, 12.5, BRIGHT));
            }
        });
        for (index, (name, _)) in menu.facts.iter().enumerate() {
            panel.spawn(button(Part::Fact(index), 0.0)).with_child(text(name, 13.0, BRIGHT));
        }
        for (index, slider) in menu.sliders.iter().enumerate() {
            let line = Node { flex_direction: FlexDirection::Column, row_gap: px(5), ..default() };
            panel.spawn(line).with_children(|line| {
                let names = Node { justify_content: JustifyContent::SpaceBetween, ..default() };
                line.spawn(names).with_children(|names| {
                    names.spawn((text(&slider.name, 13.5, DIM), Part::Label(index)));
                    names.spawn((text("", 13.5, BRIGHT), Part::Number(index)));
                });
                // The track is thin, and the mouse takes all of the line.
                let grip = Node { height: px(16), align_items: AlignItems::Center, ..default() };
                line.spawn((grip, RelativeCursorPosition::default(), Part::Slider(index))).with_children(|grip| {
                    let track =
                        Node { width: percent(100), height: px(5), border_radius: BorderRadius::MAX, ..default() };
                    let fill = Node { height: percent(100), border_radius: BorderRadius::MAX, ..default() };
                    let fill = (fill, BackgroundColor(ACCENT), Part::Fill(index));
                    grip.spawn((track, BackgroundColor(TRACK))).with_child(fill);
                });
            });
        }
        panel.spawn((text("", 12.5, DIM), Part::Status));
    });
    let hint = Node { position_type: PositionType::Absolute, left: px(22), bottom: px(18), ..default() };
    let keys = "W A S D  walk     left, right  turn     Tab  choose     - =  change     0-9  tier";
    commands.spawn((hint, text(keys, 12.5, BRIGHT), TextShadow::default()));
}

fn text(words: &str, size: f32, color: Color) -> impl Bundle {
    (Text::new(words), TextFont::from_font_size(size), TextColor(color))
}

fn button(part: Part, grow: f32) -> impl Bundle {
    let node = Node {
        flex_grow: grow,
        justify_content: JustifyContent::Center,
        padding: UiRect::axes(px(8), px(5)),
        border_radius: BorderRadius::all(px(5)),
        ..default()
    };
    (node, BackgroundColor(TRACK), RelativeCursorPosition::default(), part)
}

/// Tab and the arrows choose a line, minus and equals change it, digits choose a tier.
pub(crate) fn keys(
    keys: Res<ButtonInput<KeyCode>>,
    time: Res<Time>,
    menu: Option<ResMut<Menu>>,
    mut look: Single<&mut Afterimage>,
) {
    let Some(mut menu) = menu else { return };
    let lines = menu.sliders.len() + menu.facts.len();
    let digits = [KeyCode::Digit0, KeyCode::Digit1, KeyCode::Digit2, KeyCode::Digit3, KeyCode::Digit4, KeyCode::Digit5];
    let tier = digits.iter().position(|key| keys.just_pressed(*key)).filter(|tier| *tier < menu.tiers.len());
    if let Some(tier) = tier {
        choose(&mut menu, &mut look, Part::Tier(tier));
    }
    if lines == 0 {
        return;
    }
    let down = keys.any_just_pressed([KeyCode::Tab, KeyCode::ArrowDown]);
    let step = usize::from(down) + (lines - 1) * usize::from(keys.just_pressed(KeyCode::ArrowUp));
    if step > 0 {
        menu.line = (menu.line + step) % lines;
        menu.is_new = true;
    }
    let way = f32::from(keys.pressed(KeyCode::Equal)) - f32::from(keys.pressed(KeyCode::Minus));
    let line = menu.line;
    match menu.sliders.get_mut(line) {
        Some(slider) if way != 0.0 => {
            let length = slider.range.1 - slider.range.0;
            let value = slider.value() + way * 0.4 * length * time.delta_secs();
            slider.set = Some(value.clamp(slider.range.0, slider.range.1));
            menu.is_new = true;
        }
        None if keys.any_just_pressed([KeyCode::Equal, KeyCode::Minus]) => {
            let fact = line - menu.sliders.len();
            choose(&mut menu, &mut look, Part::Fact(fact));
        }
        _ => {}
    }
}

/// A click on a button, or a slider that the mouse moves.
pub(crate) fn mouse(
    buttons: Res<ButtonInput<MouseButton>>,
    menu: Option<ResMut<Menu>>,
    mut look: Single<&mut Afterimage>,
    parts: Query<(&RelativeCursorPosition, &Part)>,
) {
    let Some(mut menu) = menu else { return };
    if !buttons.pressed(MouseButton::Left) {
        menu.dragged = None;
        return;
    }
    for (cursor, part) in &parts {
        if buttons.just_pressed(MouseButton::Left) && cursor.cursor_over {
            match part {
                Part::Slider(index) => (menu.dragged, menu.line) = (Some(*index), *index),
                part => choose(&mut menu, &mut look, *part),
            }
        }
        if let (Some(dragged), Some(at)) = (menu.dragged, cursor.normalized)
            && *part == Part::Slider(dragged)
        {
            let slider = &mut menu.sliders[dragged];
            let share = (at.x + 0.5).clamp(0.0, 1.0);
            slider.set = Some(slider.range.0 + share * (slider.range.1 - slider.range.0));
            menu.is_new = true;
        }
    }
}

fn choose(menu: &mut Menu, look: &mut Afterimage, part: Part) {
    match part {
        Part::Tier(index) => look.tier = menu.tiers[index].clone(),
        Part::Fact(index) => {
            let (name, is_on) = &mut menu.facts[index];
            *is_on = !*is_on;
            look.facts.insert(name.clone(), (*is_on).into());
        }
        _ => {}
    }
    menu.is_new = true;
}

/// Sets the parameters that have been changed.
pub(crate) fn apply(menu: Option<Res<Menu>>, mut look: Single<&mut Afterimage>) {
    let Some(menu) = menu.filter(|menu| menu.is_new) else { return };
    for (name, value) in menu.sliders.iter().filter_map(|slider| Some((&slider.name, slider.set?))) {
        if look.parameters.get(name) != Some(&value.into()) {
            look.parameters.insert(name.clone(), value.into());
        }
    }
}

type Look = (
    &'static Part,
    Option<&'static mut Text>,
    Option<&'static mut TextColor>,
    Option<&'static mut Node>,
    Option<&'static mut BackgroundColor>,
);

/// Shows what is chosen, and the state of the pipeline.
pub(crate) fn show(
    menu: Option<ResMut<Menu>>,
    pipelines: Res<Assets<Pipeline>>,
    times: Res<DiagnosticsStore>,
    camera: Single<(&Afterimage, &AfterimageStatus)>,
    mut parts: Query<Look>,
) {
    let Some(mut menu) = menu else { return };
    let (look, status) = *camera;
    let tier = menu.tiers.iter().position(|tier| *tier == look.tier).unwrap_or(0);
    if menu.sliders.iter().any(|slider| slider.tier != tier)
        && let Some(Ok(graph)) = pipelines.get(&look.pipeline).map(|pipeline| pipeline.graph(look.tier.as_deref()))
    {
        for slider in &mut menu.sliders {
            let written = self::slider(&graph, &slider.name).map(|new| new.written);
            (slider.tier, slider.written) = (tier, written.unwrap_or(slider.written));
        }
        menu.is_new = true;
    }
    let is_new = std::mem::take(&mut menu.is_new);
    let chosen = |is_chosen: bool| if is_chosen { ACCENT.with_alpha(0.55) } else { TRACK };
    for (part, words, color, node, back) in &mut parts {
        match (part, words, color, node, back) {
            (Part::Status, Some(mut words), ..) => {
                let new = line_of(status, &times);
                words.set_if_neq(Text(new));
            }
            _ if !is_new => {}
            (Part::Tier(index), .., Some(mut back)) => back.0 = chosen(*index == tier),
            (Part::Fact(index), .., Some(mut back)) => back.0 = chosen(menu.facts[*index].1),
            (Part::Number(index), Some(mut words), ..) => {
                let Slider { unit, .. } = &menu.sliders[*index];
                words.0 = format!("{:.2} {unit}", menu.sliders[*index].value()).trim_end().to_owned();
            }
            (Part::Label(index), _, Some(mut color), ..) => {
                color.0 = if *index == menu.line { ACCENT } else { DIM };
            }
            (Part::Fill(index), _, _, Some(mut node), _) => node.width = percent(100.0 * menu.sliders[*index].share()),
            _ => {}
        }
    }
}

/// One line about the pipeline.
fn line_of(status: &AfterimageStatus, times: &DiagnosticsStore) -> String {
    let errors = status.files.iter().chain(&status.settings).chain(&status.frame);
    if let Some(error) = errors.chain(&status.others).next() {
        return error.trim().lines().next().unwrap_or_default().to_owned();
    }
    if !status.is_running {
        return "no frame yet".into();
    }
    let gpu = times.iter().find(|time| time.path().as_str() == "render/afterimage/elapsed_gpu");
    let gpu = gpu.and_then(|time| time.smoothed()).map_or(String::new(), |ms| format!(", {ms:.2} ms"));
    let next = if status.is_changing { ", the next plan is being made" } else { "" };
    format!("{} passes{gpu}{next}", status.passes.len())
}
