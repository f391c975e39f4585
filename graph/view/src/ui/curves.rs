//! Curves: a plot of parameters that are points, which are dragged.

use afterimage_graph::value::{Param, Type, Value};
use egui::{Color32, Pos2, Rect, Sense, Shape, Stroke, Ui, Vec2, pos2};

use super::controls::ControlChange;
use super::theme::{ACCENT, FIELD};
use crate::monotone::monotone;

/// The longest side of a plot, in points.
const SIDE: f32 = 260.0;
/// Points within which a press takes a point of the curve.
const REACH: f32 = 14.0;
/// The least distance of two points in x.
const STEP: f64 = 1.0 / 1024.0;

/// Parameters that are the points of a curve, from left to right.
#[derive(Debug, PartialEq)]
pub(super) struct Curve {
    /// The beginning of the names of the parameters.
    pub(super) name: String,
    /// Their places in the table of the kind.
    pub(super) points: Vec<usize>,
}

/// The curves among the parameters of a kind: neighbors with one beginning of their names, each a point that changes
/// nothing on the diagonal, one to the right of the other.
pub(super) fn curves(params: &[Param]) -> Vec<Curve> {
    let mut found: Vec<Curve> = Vec::new();
    let mut last = f64::MAX;
    for (index, param) in params.iter().enumerate() {
        let Some((name, x)) = point(param) else {
            last = f64::MAX;
            continue;
        };
        match found.last_mut().filter(|curve| curve.name == name && x > last) {
            Some(curve) => curve.points.push(index),
            None => found.push(Curve { name: name.to_owned(), points: vec![index] }),
        }
        last = x;
    }
    found.retain(|curve| curve.points.len() > 2);
    found
}

/// The name of the curve of a point, and its place on the diagonal.
fn point(param: &Param) -> Option<(&str, f64)> {
    let (name, _) = param.name.rsplit_once('_')?;
    match (param.ty, &param.neutral) {
        (Type::Vector(2), Some(Value::Vector([x, y, ..], _))) if x == y => Some((name, *x)),
        _ => None,
    }
}

/// A change of a point; `None` goes back to the value of the file.
pub(super) struct PointChange {
    /// The index of the point on the curve.
    pub(super) point: usize,
    pub(super) change: Option<ControlChange>,
}

/// Shows the curve through points, which can be dragged.
pub(super) fn plot(ui: &mut Ui, curve: &Curve, points: &[[f64; 2]]) -> Option<PointChange> {
    let side = SIDE.min(ui.available_width());
    let (outer, response) = ui.allocate_exact_size(Vec2::splat(side), Sense::click_and_drag());
    let area = outer.shrink(6.0);
    let at = |[x, y]: [f64; 2]| pos2(area.left() + x as f32 * area.width(), area.bottom() - y as f32 * area.height());
    draw(ui, outer, area, curve, points, &at);
    let near = |pointer: Pos2| {
        let distances = points.iter().enumerate().map(|(index, point)| (index, at(*point).distance(pointer)));
        let (nearest, distance) = distances.min_by(|one, other| one.1.total_cmp(&other.1))?;
        (distance < REACH).then_some(nearest)
    };
    let id = response.id.with("dragged");
    if response.drag_started() {
        let pressed = ui.input(|input| input.pointer.press_origin()).and_then(near);
        ui.data_mut(|data| data.insert_temp(id, pressed));
    }
    let hovered = response.hover_pos().and_then(near);
    let dragged = if response.dragged() || response.drag_stopped() {
        ui.data(|data| data.get_temp::<Option<usize>>(id)).flatten()
    } else {
        None
    };
    if let Some(shown) = dragged.or(hovered) {
        ui.painter().circle_stroke(at(points[shown]), 8.0, Stroke::new(1.5, ACCENT));
        let [x, y] = points[shown];
        let text = format!("{x:.3} to {y:.3}");
        let font = egui::FontId::proportional(11.0);
        ui.painter().text(area.right_bottom(), egui::Align2::RIGHT_BOTTOM, text, font, Color32::from_gray(0xb0));
    }
    if let Some(point) = hovered.filter(|_| response.double_clicked()) {
        return Some(PointChange { point, change: None });
    }
    let (point, pointer) = (dragged?, response.interact_pointer_pos()?);
    let place = (pointer - area.left_bottom()) / area.size();
    let value = moved(points, point, [place.x.into(), (-place.y).into()]);
    let value = Value::Vector([value[0], value[1], 0.0, 0.0], 2);
    Some(PointChange { point, change: Some(ControlChange { value, is_done: response.drag_stopped() }) })
}

/// A place for a point, within the plot and between its neighbors, in as many digits as a screen shows.
fn moved(points: &[[f64; 2]], point: usize, [x, y]: [f64; 2]) -> [f64; 2] {
    let low = if point == 0 { 0.0 } else { points[point - 1][0] + STEP };
    let high = points.get(point + 1).map_or(1.0, |next| next[0] - STEP);
    let rounded = |number: f64| (number * 1e4).round() / 1e4;
    [rounded(x.min(high).max(low).clamp(0.0, 1.0)), rounded(y.clamp(0.0, 1.0))]
}

fn draw(ui: &Ui, outer: Rect, area: Rect, curve: &Curve, points: &[[f64; 2]], at: &dyn Fn([f64; 2]) -> Pos2) {
    let painter = ui.painter_at(outer);
    painter.rect_filled(outer, 3.0, FIELD);
    let faint = Stroke::new(1.0, Color32::from_gray(0x30));
    for part in [0.25, 0.5, 0.75] {
        painter.line_segment([at([part, 0.0]), at([part, 1.0])], faint);
        painter.line_segment([at([0.0, part]), at([1.0, part])], faint);
    }
    painter.line_segment([at([0.0, 0.0]), at([1.0, 1.0])], Stroke::new(1.0, Color32::from_gray(0x48)));
    let color = match &*curve.name {
        "red" => Color32::from_rgb(0xe0, 0x5a, 0x50),
        "green" => Color32::from_rgb(0x66, 0xc0, 0x5c),
        "blue" => Color32::from_rgb(0x5c, 0x8c, 0xf0),
        _ => Color32::from_gray(0xd8),
    };
    let columns = area.width().max(1.0) as usize;
    let line = (0..=columns).map(|column| column as f64 / columns as f64).map(|x| at([x, monotone(points, x)]));
    painter.with_clip_rect(area.expand(1.0)).add(Shape::line(line.collect(), Stroke::new(1.5, color)));
    for point in points {
        painter.circle(at(*point), 4.0, color, Stroke::new(1.0, Color32::BLACK));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_points_of_a_kind_are_its_curves() {
        let registry = afterimage_graph::node::Registry::new(&[afterimage_nodes::ALL]).expect("names differ");
        let names = |kind: &str| -> Vec<(String, usize)> {
            let kind = registry.get(kind).expect("it is built in");
            curves(kind.params()).into_iter().map(|curve| (curve.name, curve.points.len())).collect()
        };
        let of_curves = ["luminance", "rgb", "red", "green", "blue"].map(|name| (name.to_owned(), 5));
        assert_eq!(names("Curves"), of_curves);
        assert!(names("LiftGammaGain").is_empty());
    }

    #[test]
    fn a_point_stays_between_its_neighbors_and_in_the_plot() {
        let points = [[0.0, 0.0], [0.25, 0.25], [0.5, 0.5], [0.75, 0.75], [1.0, 1.0]];
        assert_eq!(moved(&points, 2, [0.61234567, 0.4]), [0.6123, 0.4]);
        assert_eq!(moved(&points, 2, [0.9, 1.4]), [0.749, 1.0]);
        assert_eq!(moved(&points, 2, [-3.0, -1.0]), [0.251, 0.0]);
        assert_eq!(moved(&points, 0, [-3.0, 0.1]), [0.0, 0.1]);
        assert_eq!(moved(&points, 4, [3.0, 0.9]), [1.0, 0.9]);
    }
}
