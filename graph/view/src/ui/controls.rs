//! One control for each type of parameter, made from its declaration.

use std::f64::consts::TAU;
use std::path::Path;

use afterimage_graph::value::{ChoiceName, FileValue, Param, Type, Value};
use egui::{Color32, PopupCloseBehavior, Sense, Slider, Stroke, Ui, Vec2};

use super::list_keys::choose_by_keys;

/// A logarithmic slider from zero begins at this part of its upper end.
const LEAST: f64 = 1e-3;
/// The range of a number without a domain or a usual range.
const ANY: (f64, f64) = (-10.0, 10.0);
/// The width of the field of a text, in points.
const LINE_WIDTH: f32 = 164.0;
/// The domain is taken as the range of a slider up to this number.
const LARGEST: f64 = 1e5;

/// A change that a control made in a frame.
pub(super) struct ControlChange {
    pub(super) value: Value,
    /// The user is done: another change is another step of undo.
    pub(super) is_done: bool,
}

/// Shows the control of a parameter at its present value.
pub(super) fn control(ui: &mut Ui, param: &Param, value: &Value) -> Option<ControlChange> {
    match (param.ty, value) {
        (Type::Bool, Value::Bool(on)) => flag(ui, *on),
        (Type::Int, Value::Int(number)) => whole(ui, param, *number),
        (Type::Float, Value::Float(number)) => float(ui, param, *number),
        (Type::Vector(count), Value::Vector(numbers, _)) => vector(ui, param, *numbers, count),
        (Type::Choice(choices), Value::Choice(chosen)) => choice(ui, param, choices, chosen),
        (Type::Text, Value::Text(text)) => {
            let text = line(ui, &param.name, text, "", LINE_WIDTH)?;
            Some(ControlChange { value: Value::Text(text.into()), is_done: true })
        }
        (Type::File, Value::File(file)) => {
            let path = path_line(ui, &param.name, &file.path, "", LINE_WIDTH)?;
            Some(ControlChange { value: Value::File(FileValue { path: path.into(), bytes: None }), is_done: true })
        }
        _ => None,
    }
}

fn flag(ui: &mut Ui, mut on: bool) -> Option<ControlChange> {
    ui.checkbox(&mut on, "").changed().then_some(ControlChange { value: Value::Bool(on), is_done: true })
}

/// The range of a slider: the usual one, or the domain where it is not endless.
pub(super) fn range(param: &Param) -> (f64, f64) {
    let domain = param.domain.map(|(low, high)| (low.max(-LARGEST), high.min(LARGEST)));
    param.usual.or(domain).unwrap_or(ANY)
}

/// The slider of a number, in steps of equal ratio if the parameter declares it.
fn slider<'n, N: egui::emath::Numeric>(number: &'n mut N, param: &Param) -> Slider<'n> {
    let (low, high) = range(param);
    let slider = Slider::new(number, N::from_f64(low)..=N::from_f64(high)).show_value(false);
    slider.logarithmic(param.logarithmic).smallest_positive(LEAST * high)
}

fn whole(ui: &mut Ui, param: &Param, mut number: i64) -> Option<ControlChange> {
    let slid = ui.add(slider(&mut number, param).clamping(egui::SliderClamping::Edits));
    let response = slid | typed(ui, egui::DragValue::new(&mut number).speed(0.1));
    let number = within(param, number as f64) as i64;
    answer(&response, Value::Int(number))
}

fn float(ui: &mut Ui, param: &Param, mut number: f64) -> Option<ControlChange> {
    // What is typed may leave the usual range, but not the domain.
    let slid = ui.add(slider(&mut number, param).clamping(egui::SliderClamping::Never));
    let (low, high) = range(param);
    let response = slid | typed(ui, egui::DragValue::new(&mut number).speed(speed(low, high)).max_decimals(4));
    answer(&response, Value::Float(rounded(within(param, number))))
}

/// A number next to a slider. What is typed counts when it is whole: "0." on the way to 0.45 is no change of its own.
fn typed(ui: &mut Ui, number: egui::DragValue<'_>) -> egui::Response {
    ui.add(number.update_while_editing(false))
}

/// The change of a number for each point of a drag.
fn speed(low: f64, high: f64) -> f64 {
    ((high - low) / 300.0).clamp(1e-4, 1.0)
}

fn within(param: &Param, number: f64) -> f64 {
    match param.domain {
        Some((low, high)) if number.is_finite() => number.clamp(low, high),
        _ => number,
    }
}

/// Rounds the value of a slider to as many digits as a file needs.
fn rounded(number: f64) -> f64 {
    let digits = 6 - number.abs().max(1e-6).log10().ceil() as i32;
    let scale = 10f64.powi(digits.clamp(0, 9));
    (number * scale).round() / scale
}

fn answer(response: &egui::Response, value: Value) -> Option<ControlChange> {
    let is_done = response.drag_stopped() || response.lost_focus();
    (response.changed() || is_done).then(|| ControlChange { value, is_done: is_done || !response.dragged() })
}

fn vector(ui: &mut Ui, param: &Param, mut numbers: [f64; 4], count: usize) -> Option<ControlChange> {
    let (low, high) = range(param);
    let speed = speed(low, high);
    let (mut responses, mut of_wheel) = (Vec::new(), None);
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 2.0;
        for number in &mut numbers[..count] {
            let drag = egui::DragValue::new(number).speed(speed).max_decimals(4).update_while_editing(false);
            responses.push(ui.add_sized([46.0, 20.0], drag));
            *number = rounded(within(param, *number));
        }
        if count == 3 && is_graded(param) {
            of_wheel = wheel(ui, &mut numbers, range(param));
            numbers[..3].iter_mut().for_each(|number| *number = within(param, *number));
        }
        if count == 3 && is_color(param) {
            responses.push(picker(ui, &mut numbers));
        }
    });
    let all = responses.into_iter().reduce(|all, response| all | response)?;
    // The wheel is in a layer of its own.
    let value = Value::Vector(numbers, count);
    of_wheel.and_then(|response| answer(&response, value.clone())).or_else(|| answer(&all, value))
}

/// True for numbers of red, green and blue that change nothing where they are equal, such as lift, gamma and gain.
fn is_graded(param: &Param) -> bool {
    matches!(param.neutral, Some(Value::Vector([red, green, blue, _], 3)) if red == green && green == blue)
}

fn is_color(param: &Param) -> bool {
    let is_light = range(param).0 >= 0.0;
    is_light && ["color", "tint", "red, green"].iter().any(|word| param.doc.to_lowercase().contains(word))
}

/// A linear color; those brighter than 1 keep their brightness.
fn picker(ui: &mut Ui, numbers: &mut [f64; 4]) -> egui::Response {
    let largest = numbers[..3].iter().fold(1.0, |largest: f64, number| largest.max(*number));
    let mut color: [f32; 3] = std::array::from_fn(|c| (numbers[c] / largest).clamp(0.0, 1.0) as f32);
    let response = ui.color_edit_button_rgb(&mut color);
    if response.changed() {
        for (number, channel) in numbers.iter_mut().zip(color) {
            *number = rounded(f64::from(channel) * largest);
        }
    }
    response
}

/// The angles of red, green and blue on a wheel, as on a vectorscope turned so that red is at the top.
const ANGLES: [f64; 3] = [0.25 * TAU, (0.25 + 1.0 / 3.0) * TAU, (0.25 + 2.0 / 3.0) * TAU];
/// The side of a wheel in points.
const WHEEL: f32 = 150.0;

/// The place of three numbers on a wheel of a radius: to the right and up, both zero where they are equal.
fn on_wheel(numbers: [f64; 4], radius: f64) -> [f64; 2] {
    let mean = numbers[..3].iter().sum::<f64>() / 3.0;
    let along = |axis: fn(f64) -> f64| {
        let parts = ANGLES.iter().zip(numbers).map(|(angle, number)| (number - mean) * axis(*angle));
        2.0 / 3.0 / radius * parts.sum::<f64>()
    };
    [along(f64::cos), along(f64::sin)]
}

/// The numbers at a place of a wheel, which have the mean of before.
fn from_wheel(numbers: [f64; 4], [x, y]: [f64; 2], radius: f64) -> [f64; 4] {
    let mean = numbers[..3].iter().sum::<f64>() / 3.0;
    let number = |angle: f64| rounded(mean + radius * (x * angle.cos() + y * angle.sin()));
    [number(ANGLES[0]), number(ANGLES[1]), number(ANGLES[2]), numbers[3]]
}

/// A wheel for three numbers, in a menu: its middle is where they are equal, and a slider moves all of them.
fn wheel(ui: &mut Ui, numbers: &mut [f64; 4], (low, high): (f64, f64)) -> Option<egui::Response> {
    let radius = 0.25 * (high - low);
    let button = egui::containers::menu::MenuButton::new("●")
        .config(egui::containers::menu::MenuConfig::new().close_behavior(PopupCloseBehavior::CloseOnClickOutside));
    let (button, shown) = button.ui(ui, |ui| {
        let (rect, mut response) = ui.allocate_exact_size(Vec2::splat(WHEEL), Sense::click_and_drag());
        let scale = f64::from(rect.width()) / 2.0;
        if let Some(at) = response.interact_pointer_pos().filter(|_| response.dragged()) {
            let from = (at - rect.center()) / scale as f32;
            let from = from / from.length().max(1.0);
            *numbers = from_wheel(*numbers, [from.x.into(), (-from.y).into()], radius);
            response.mark_changed();
        }
        if response.double_clicked() {
            *numbers = from_wheel(*numbers, [0.0, 0.0], radius);
            response.mark_changed();
        }
        let [x, y] = on_wheel(*numbers, radius);
        draw_wheel(ui, rect, Vec2::new(x as f32, -y as f32));
        let mean = numbers[..3].iter().sum::<f64>() / 3.0;
        let mut moved = mean;
        ui.spacing_mut().slider_width = WHEEL;
        let slid = ui.add(Slider::new(&mut moved, low..=high).show_value(false)).on_hover_text("All three together");
        numbers[..3].iter_mut().for_each(|number| *number = rounded(*number + moved - mean));
        response | slid
    });
    button.on_hover_text("A wheel: the middle is gray, a double click goes there");
    shown.map(|shown| shown.inner)
}

fn draw_wheel(ui: &Ui, rect: egui::Rect, at: Vec2) {
    let (painter, center, radius) = (ui.painter_at(rect), rect.center(), rect.width() / 2.0 - 4.0);
    for step in 0..96 {
        let angle = TAU * f64::from(step) / 96.0;
        let part = |own: f64| (255.0 * (0.5 + 0.5 * (angle - own).cos())) as u8;
        let color = Color32::from_rgb(part(ANGLES[0]), part(ANGLES[1]), part(ANGLES[2]));
        let direction = Vec2::new(angle.cos() as f32, -angle.sin() as f32);
        let next = Vec2::angled(-(angle + TAU / 96.0) as f32);
        painter.line_segment([center + radius * direction, center + radius * next], Stroke::new(4.0, color));
    }
    let faint = Stroke::new(1.0, Color32::from_gray(0x48));
    painter.line_segment([center - Vec2::X * radius, center + Vec2::X * radius], faint);
    painter.line_segment([center - Vec2::Y * radius, center + Vec2::Y * radius], faint);
    painter.circle(center + radius * at, 5.0, Color32::from_gray(0xe0), Stroke::new(1.5, Color32::BLACK));
}

fn choice(ui: &mut Ui, param: &Param, choices: &'static [ChoiceName], chosen: &'static str) -> Option<ControlChange> {
    let mut new = chosen;
    egui::ComboBox::from_id_salt(("choice", ui.id(), &*param.name))
        .selected_text(chosen)
        .width(if param.replan { 104.0 } else { 150.0 })
        .show_ui(ui, |ui| {
            let entry = |choice: &ChoiceName| {
                let response = ui.selectable_value(&mut new, choice.name, choice.name).on_hover_text(choice.doc);
                (response, choice.name)
            };
            let entries: Vec<_> = choices.iter().map(entry).collect();
            let present = choices.iter().position(|choice| choice.name == chosen);
            choose_by_keys(ui, &entries, present.unwrap_or(0));
        });
    (new != chosen).then_some(ControlChange { value: Value::Choice(new), is_done: true })
}

/// The path of a file, of which the name alone is shown until it is typed in.
pub(super) fn path_line(ui: &mut Ui, name: &str, path: &str, hint: &str, width: f32) -> Option<String> {
    let short = Path::new(path).file_name().map_or(path.into(), |name| name.to_string_lossy());
    field(ui, name, path, &short, hint, width)
}

/// A text that counts when it is finished. `hint` is shown while it is empty.
fn line(ui: &mut Ui, name: &str, text: &str, hint: &str, width: f32) -> Option<String> {
    field(ui, name, text, text, hint, width)
}

/// A field for `text` that has `shown` in its place until it is typed in.
fn field(ui: &mut Ui, name: &str, text: &str, shown: &str, hint: &str, width: f32) -> Option<String> {
    // An identity that egui counts changes with the rows above, and the field would lose the keyboard.
    let id = ui.id().with(("line", name));
    let begun = ui.data(|data| data.get_temp::<String>(id));
    let is_begun = begun.is_some();
    let mut typed = begun.unwrap_or_else(|| shown.to_owned());
    let response = ui.add(egui::TextEdit::singleline(&mut typed).id(id).hint_text(hint).desired_width(width));
    let response = if shown == text { response } else { response.on_hover_text(text) };
    if response.has_focus() {
        if !is_begun && typed == shown {
            typed = text.to_owned();
        }
        ui.data_mut(|data| data.insert_temp(id, typed));
        return None;
    }
    let is_new = response.lost_focus() && is_begun && typed != text;
    ui.data_mut(|data| data.remove::<String>(id));
    is_new.then_some(typed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_that_nobody_typed_are_dropped() {
        assert_eq!(rounded(0.123_456_789), 0.123457);
        assert_eq!(rounded(321.098_765), 321.099);
        assert_eq!(rounded(-0.1 - 0.2), -0.3);
        assert_eq!(rounded(0.0), 0.0);
    }

    #[test]
    fn a_wheel_keeps_the_mean_and_gives_back_what_it_was_given() {
        for numbers in [[1.0, 1.0, 1.0, 0.0], [1.04, 1.02, 1.0, 0.0], [-0.02, 0.05, 0.01, 0.0]] {
            let place = on_wheel(numbers, 0.5);
            assert_eq!(from_wheel(numbers, place, 0.5), numbers);
        }
        let red = from_wheel([1.0; 4], [0.0, 1.0], 0.5);
        assert_eq!(red, [1.5, 0.75, 0.75, 1.0], "red is at the top");
    }

    #[test]
    fn a_slider_has_the_usual_range_or_a_domain_that_ends() {
        let param = Param::new("x", "", Type::Float, Value::Float(1.0));
        assert_eq!(range(&param), ANY);
        let endless = Param::new("x", "", Type::Float, Value::Float(1.0)).within(0.0..=1e9);
        assert_eq!(range(&endless), (0.0, LARGEST));
        assert_eq!(range(&endless.usually(0.0..=2.0)), (0.0, 2.0));
    }
}
