//! One control for each type of parameter, made from its declaration.

use afterimage_graph::value::{ChoiceName, FileValue, Param, Type, Value};
use egui::{Slider, Ui};

use super::list_keys::choose_by_keys;

/// A range this many times as wide as its lower end is shown in steps of equal ratio.
const WIDE: f64 = 200.0;
/// The range of a number without a domain or a usual range.
const ANY: (f64, f64) = (-10.0, 10.0);
/// The width of the field of a text, in points.
const LINE_WIDTH: f32 = 170.0;
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
            let path = line(ui, &param.name, &file.path, "", LINE_WIDTH)?;
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

fn is_wide(low: f64, high: f64) -> bool {
    low > 0.0 && high / low > WIDE || low == 0.0 && high > WIDE
}

fn whole(ui: &mut Ui, param: &Param, mut number: i64) -> Option<ControlChange> {
    let (low, high) = range(param);
    let slider = Slider::new(&mut number, low as i64..=high as i64).logarithmic(is_wide(low, high));
    let slid = ui.add(slider.clamping(egui::SliderClamping::Edits).show_value(false));
    let response = slid | typed(ui, egui::DragValue::new(&mut number).speed(0.1));
    let number = within(param, number as f64) as i64;
    answer(&response, Value::Int(number))
}

fn float(ui: &mut Ui, param: &Param, mut number: f64) -> Option<ControlChange> {
    let (low, high) = range(param);
    // What is typed may leave the usual range, but not the domain.
    let slider = Slider::new(&mut number, low..=high)
        .logarithmic(is_wide(low, high))
        .clamping(egui::SliderClamping::Never)
        .show_value(false);
    let slid = ui.add(slider);
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
    let mut responses = Vec::new();
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 2.0;
        for number in &mut numbers[..count] {
            let drag = egui::DragValue::new(number).speed(speed).max_decimals(4).update_while_editing(false);
            responses.push(ui.add_sized([48.0, 20.0], drag));
            *number = rounded(within(param, *number));
        }
        if count == 3 && is_color(param) {
            responses.push(picker(ui, &mut numbers));
        }
    });
    let all = responses.into_iter().reduce(|all, response| all | response)?;
    answer(&all, Value::Vector(numbers, count))
}

fn is_color(param: &Param) -> bool {
    ["color", "tint", "red, green"].iter().any(|word| param.doc.to_lowercase().contains(word))
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

/// A text that counts when it is finished. `hint` is shown while it is empty.
pub(super) fn line(ui: &mut Ui, name: &str, text: &str, hint: &str, width: f32) -> Option<String> {
    // An identity that egui counts changes with the rows above, and the field would lose the keyboard.
    let id = ui.id().with(("line", name));
    let mut typed = ui.data(|data| data.get_temp::<String>(id)).unwrap_or_else(|| text.to_owned());
    let response = ui.add(egui::TextEdit::singleline(&mut typed).id(id).hint_text(hint).desired_width(width));
    if response.has_focus() {
        ui.data_mut(|data| data.insert_temp(id, typed));
        return None;
    }
    let is_new = response.lost_focus() && typed != text;
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
    fn a_slider_has_the_usual_range_or_a_domain_that_ends() {
        let param = Param::new("x", "", Type::Float, Value::Float(1.0));
        assert_eq!(range(&param), ANY);
        let endless = Param::new("x", "", Type::Float, Value::Float(1.0)).within(0.0..=1e9);
        assert_eq!(range(&endless), (0.0, LARGEST));
        assert_eq!(range(&endless.usually(0.0..=2.0)), (0.0, 2.0));
    }
}
