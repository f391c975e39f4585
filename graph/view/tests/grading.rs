//! Controls for grading: the white picker and the plot of curves.

use crate::support::{SIZE, Window, apart, flat, gpu, of, parameter, picture, settle};
use afterimage_graph::value::Value;
use afterimage_media::{Picture, Pixels};
use afterimage_view::{InputData, InputFile, Model, TextProject, monotone};
use egui::{Key, Modifiers, pos2, vec2};

const BALANCE: &str = r#"Pipeline(
    inputs: { "image": Color },
    nodes: { "exposed": Exposure(source: "image"), "balance": WhiteBalance(source: "exposed") },
    outputs: { "image": "balance" },
)"#;

/// Gray of 18 % under a light of this xy, in linear Rec.709, by the matrix of IEC 61966-2-1.
fn gray_under(x: f64, y: f64) -> [f32; 3] {
    const FROM_XYZ: [[f64; 3]; 3] =
        [[3.2404542, -1.5371385, -0.4985314], [-0.9692660, 1.8760108, 0.0415560], [0.0556434, -0.2040259, 1.0572252]];
    let xyz = [x / y, 1.0, (1.0 - x - y) / y];
    FROM_XYZ.map(|row| 0.18 * row.iter().zip(xyz).map(|(a, b)| a * b).sum::<f64>() as f32)
}

/// The color of the picture at a place, in parts of its width.
fn color_at(model: &Model, part: f32) -> [f32; 3] {
    let texels = picture(model).to_floats();
    let at = SIZE.height / 2 * SIZE.width + (part * SIZE.width as f32) as u32;
    let [red, green, blue, _] = texels[at as usize];
    [red, green, blue]
}

/// Gray is neutral within 0.2 % of green: two steps of 16 bits.
fn is_neutral([red, green, blue]: [f32; 3]) -> bool {
    green > 0.0 && [red, blue].iter().all(|channel| (channel / green - 1.0).abs() < 2e-3)
}

fn number(model: &Model, name: &str) -> f64 {
    match model.editor().value(name) {
        Some(Value::Float(number)) => number,
        other => panic!("{name}: {other:?}"),
    }
}

#[test]
fn gray_under_a_colored_light_becomes_neutral_in_one_step_of_undo() {
    // Illuminants of CIE 15 with their temperatures, and one that is greener than any daylight.
    for (x, y, kelvin) in [
        (0.44757, 0.40745, Some(2856.0)),
        (0.34567, 0.35850, Some(5003.0)),
        (0.29902, 0.31485, Some(7504.0)),
        (0.37208, 0.38529, None),
    ] {
        let [red, green, blue] = gray_under(x, y);
        let mut model = of(Box::new(TextProject::new("balance.ron", BALANCE)));
        model.set_input(None, Some(flat("gray.exr", move || Ok([red, green, blue, 1.0])))).unwrap();
        settle(&mut model);
        let before = picture(&model);
        assert!(!is_neutral(color_at(&model, 0.5)));
        assert!(model.make_gray("balance", [red, green, blue].map(f64::from)));
        settle(&mut model);
        let after = color_at(&model, 0.5);
        assert!(is_neutral(after), "{x}, {y}: {after:?}");
        if let Some(kelvin) = kelvin {
            let found = number(&model, "balance.temperature");
            assert!((found / kelvin - 1.0).abs() < 5e-3, "{found} K, and not {kelvin} K");
            assert!(number(&model, "balance.tint").abs() < 5e-4);
        }
        assert_eq!(model.editor().value("balance.mode"), Some(Value::Choice("Temperature")));
        assert!(model.editor().text_with_changes().contains("mode: Temperature"));
        model.undo();
        settle(&mut model);
        assert!(model.editor().changes().is_empty() && apart(&picture(&model), &before) == 0);
    }
}

#[test]
fn what_is_gray_already_stays_and_what_no_light_makes_gray_is_refused() {
    let mut model = of(Box::new(TextProject::new("balance.ron", BALANCE)));
    settle(&mut model);
    for color in [[0.0; 3], [0.0, 0.0, 1.0], [f64::NAN, 1.0, 1.0], [-1.0, 0.1, 0.1]] {
        assert!(!model.make_gray("balance", color), "{color:?}");
    }
    assert!(!model.make_gray("exposed", [0.2, 0.3, 0.4]), "it balances no white");
    assert!(model.editor().changes().is_empty());
    assert!(model.make_gray("balance", [0.2001, 0.2, 0.2]));
    assert_eq!((number(&model, "balance.temperature"), number(&model, "balance.tint")), (6500.0, 0.0));
}

#[test]
fn a_click_in_the_picture_chooses_what_is_gray_and_esc_does_not() {
    let mut window = Window::new(of(Box::new(TextProject::new("balance.ron", BALANCE))));
    let [red, green, blue] = gray_under(0.44757, 0.40745);
    let read = move |_: &afterimage_graph::check::GraphInput, _: usize| {
        let gray = [red, green, blue, 1.0];
        let texel = |at: u32| if at % SIZE.width < SIZE.width / 2 { gray } else { [0.05, 0.1, 0.9, 1.0] };
        let texels = (0..SIZE.width * SIZE.height).flat_map(texel).collect();
        let picture = Picture::new(SIZE.width, SIZE.height, Pixels::Float(texels));
        let desc = picture.desc();
        Ok(InputData::Image(Box::new(picture), desc))
    };
    window.ui.viewer.model.set_input(None, Some(InputFile::still("half.exr", Box::new(read)))).unwrap();
    settle(&mut window.ui.viewer.model);
    (0..4).for_each(|_| window.frame(Vec::new()));
    let button = window.place_of("pick gray");
    window.click(button);
    window.frame(Vec::new());
    assert!(window.says("Click what should be gray for `balance`"));
    window.key(Key::Escape, Modifiers::NONE);
    window.frame(Vec::new());
    assert!(!window.says("Click what should be gray"));
    window.click(button);
    // The left half of the picture.
    window.click(pos2(520.0, 230.0));
    for _ in 0..400 {
        window.frame(Vec::new());
        let _ = gpu().wait();
        if !window.ui.viewer.model.editor().changes().is_empty() {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    // A message is drawn once its size is known.
    window.frame(Vec::new());
    assert!(window.says("`balance` makes this gray."), "{:?}", window.texts());
    let model = &mut window.ui.viewer.model;
    settle(model);
    assert!(is_neutral(color_at(model, 0.25)), "{:?}", color_at(model, 0.25));
    assert!((number(model, "balance.temperature") / 2856.0 - 1.0).abs() < 5e-3);
    window.frame(Vec::new());
    assert!(window.ui.viewer.model.inspector().stored().is_none(), "nothing is read any more");
}

/// Curves whose third point is moved, because it is not to the left of the fourth.
const CURVES: &str = r#"Pipeline(
    inputs: { "image": DisplayLinear },
    nodes: {
        "bent": Curves(source: "image", rgb_shadows: (0.2, 0.35), rgb_middle: (0.6, 0.5), rgb_highlights: (0.6, 0.9)),
    },
    outputs: { "image": "bent" },
)"#;

#[test]
fn the_curve_that_is_drawn_is_the_one_that_renders() {
    let to_code = |light: f64| if light <= 0.0031308 { 12.92 * light } else { 1.055 * light.powf(1.0 / 2.4) - 0.055 };
    let to_light = |code: f64| if code <= 0.04045 { code / 12.92 } else { ((code + 0.055) / 1.055).powf(2.4) };
    let points = [[0.0, 0.0], [0.2, 0.35], [0.6, 0.5], [0.6, 0.9], [1.0, 1.0]];
    let mut model = of(Box::new(TextProject::new("curves.ron", CURVES)));
    for step in 0..=20 {
        let code = f64::from(step) / 20.0;
        let light = to_light(code) as f32;
        model.set_input(None, Some(flat("gray.exr", move || Ok([light, light, light, 1.0])))).unwrap();
        settle(&mut model);
        assert!(model.problem().is_none(), "{:?}", model.problem());
        let rendered = to_code(color_at(&model, 0.5)[1].into());
        let drawn = monotone(&points, code);
        assert!((rendered - drawn).abs() < 1e-3, "{code}: {rendered} is rendered, and {drawn} is drawn");
    }
}

#[test]
fn a_point_of_a_curve_is_dragged_in_one_step_and_a_double_click_takes_it_back() {
    let text = r#"Pipeline(inputs: { "image": DisplayLinear }, nodes: { "bent": Curves(source: "image") },
        outputs: { "image": "bent" })"#;
    let mut window = Window::new(of(Box::new(TextProject::new("curves.ron", text))));
    let gray = flat("gray.exr", || Ok([0.2, 0.2, 0.2, 1.0]));
    window.ui.viewer.model.set_input(None, Some(gray)).unwrap();
    (0..4).for_each(|_| window.frame(Vec::new()));
    assert!(window.says("luminance_middle") && !window.says("rgb_middle"), "the shown curve has rows");
    let choice = window.place_of("rgb");
    window.click(choice);
    window.frame(Vec::new());
    assert!(window.says("rgb_middle") && !window.says("luminance_middle"));
    let texts = window.texts();
    let area = |name: &str| texts.iter().find(|(text, _)| text == name).unwrap().1;
    // The plot lies between the choice and the rows.
    let (left, above, below) = (area("luminance").min.x, area("rgb").max.y, area("rgb_black").min.y);
    let middle = pos2(left + 126.0, (above + below) / 2.0);
    let value = |window: &Window| match window.ui.viewer.model.editor().value("bent.rgb_middle") {
        Some(Value::Vector([x, y, ..], 2)) => [x, y],
        other => panic!("{other:?}"),
    };
    window.drag(middle, middle + vec2(12.4, -49.6));
    let [x, y] = value(&window);
    assert!((x - 0.55).abs() < 0.03 && (y - 0.7).abs() < 0.03, "{x} {y}");
    assert!(!window.ui.viewer.model.editor().changes().is_dragging(), "it was let go");
    window.ui.viewer.model.undo();
    assert!(window.ui.viewer.model.editor().changes().is_empty());
    window.ui.viewer.model.redo();
    assert_eq!(value(&window), [x, y]);
    let at = middle + vec2(12.4, -49.6);
    // The click on the choice is long ago: a third one would be no double click.
    (0..40).for_each(|_| window.frame(Vec::new()));
    window.click(at);
    window.click(at);
    assert_eq!(window.ui.viewer.model.editor().changes().get(&parameter("bent.rgb_middle")), None);
}
