//! Snapshots, figures of differences, and what the shown image cannot show.

use std::path::PathBuf;
use std::sync::Arc;

use crate::support::{SIZE, Window, apart, image, model, parameter, picture, settle, texels};
use afterimage_gpu::wgpu;
use afterimage_graph::check::Edit;
use afterimage_graph::value::Value;
use afterimage_view::render::{Grid, Painter};
use afterimage_view::{CompareWith, InputFile, InspectedWire, MeasureDifference, Slot, Tab, Target, TextProject};
use egui::{Event, Key, Modifiers, PointerButton, Pos2, vec2};

fn open(name: &str) -> Window {
    let mut window = Window::new(model(name));
    settle(&mut window.ui.viewer.model);
    (0..4).for_each(|_| window.frame(Vec::new()));
    window
}

fn set_strength(window: &mut Window, strength: f64) {
    window.ui.viewer.model.set(&parameter("lit.strength"), Some(Value::Float(strength)));
    window.ui.viewer.model.release();
}

fn strength(window: &Window) -> Option<Value> {
    window.ui.viewer.model.editor().value("lit.strength")
}

#[test]
fn a_snapshot_is_taken_compared_with_and_gone_back_to_in_one_step() {
    let mut window = open("lynx");
    window.key(Key::Num1, Modifiers::ALT);
    assert!(window.says("There is no snapshot A") && window.ui.viewer.model.compared().is_none());
    set_strength(&mut window, 0.9);
    settle(&mut window.ui.viewer.model);
    let strong = picture(&window.ui.viewer.model);
    window.key(Key::Num1, Modifiers::COMMAND);
    set_strength(&mut window, 0.0);
    window.ui.viewer.model.edit_graph(&Edit::Rename { node: "mapped".into(), name: "curve".into() }).unwrap();
    window.key(Key::Num1, Modifiers::ALT);
    assert_eq!(window.ui.viewer.model.compared(), Some(&CompareWith::Snapshot(Slot::A)));
    (0..4).for_each(|_| window.frame(Vec::new()));
    settle(&mut window.ui.viewer.model);
    assert!(window.says("snapshot A"));
    let compared = texels(window.ui.viewer.model.compared_picture().unwrap());
    assert!(apart(&compared, &strong) <= 1 && apart(&compared, &picture(&window.ui.viewer.model)) > 5);
    window.key(Key::Num1, Modifiers::COMMAND | Modifiers::ALT);
    assert_eq!(strength(&window), Some(Value::Float(0.9)));
    assert!(window.ui.viewer.model.editor().graph().unwrap().node("mapped").is_some());
    window.key(Key::Z, Modifiers::COMMAND);
    assert_eq!(strength(&window), Some(Value::Float(0.0)));
    // The other one is another one; of another pipeline there is none.
    window.key(Key::Num2, Modifiers::ALT);
    assert!(window.says("There is no snapshot B"));
    window.ui.viewer.model.open(Box::new(TextProject::built_in("caracal").unwrap()));
    assert!(window.ui.viewer.model.editor().snapshot(Slot::A).is_none());
}

#[test]
fn another_tier_is_compared_with_the_nodes_that_the_user_has_switched_off() {
    let mut model = model("tsushima");
    model.set(&Target::Node("grain".into()), Some(Value::Bool(false)));
    model.set_compared(Some(CompareWith::Tier(Some("low".into()))));
    let (_, compared) = model.comparison().unwrap();
    assert!(compared.graph().node("grain").unwrap().1.off);
}

/// The number of texels that differ.
fn counting() -> MeasureDifference {
    Arc::new(|reference, shown| {
        let [reference, shown] = [reference, shown].map(|one| one.texels.to_floats());
        let differing = reference.iter().zip(&shown).filter(|(a, b)| a != b).count();
        Ok(format!("{differing} of {} differ", shown.len()))
    })
}

#[test]
fn a_comparison_is_measured_on_request_until_something_changes() {
    let mut window = open("lynx");
    window.key(Key::R, Modifiers::NONE);
    assert!(!window.says("Measure"), "nothing measures");
    window.key(Key::R, Modifiers::NONE);
    window.ui.viewer.measure_by(counting());
    set_strength(&mut window, 0.9);
    window.key(Key::W, Modifiers::NONE);
    window.frame(Vec::new());
    assert!(window.says("Measure") && !window.says("differ"));
    window.key(Key::E, Modifiers::NONE);
    assert!(window.says("Measuring"));
    let is_measured = |window: &mut Window| {
        window.frame(Vec::new());
        std::thread::sleep(std::time::Duration::from_millis(5));
        window.says(&format!("of {} differ  (frame 0)", SIZE.width * SIZE.height))
    };
    assert!((0..2000).any(|_| is_measured(&mut window)), "{:?}", window.texts());
    assert!(!window.says(" 0 of"));
    set_strength(&mut window, 0.8);
    window.frame(Vec::new());
    assert!(!window.says("differ"), "that was another picture");
}

#[test]
fn nan_in_the_shown_wire_is_counted_and_something_is_wrong() {
    let mut window = open("lynx");
    window.ui.viewer.tabs.open = Some(Tab::Messages);
    window.frame(Vec::new());
    assert!(window.says("Nothing is wrong in the text and in the shown image."));
    let half = SIZE.width * SIZE.height / 2;
    let picture = move |_: &afterimage_graph::check::GraphInput, _| {
        let afterimage_view::InputData::Image(_, desc) = image([0.5; 4]) else { unreachable!("it is one") };
        let texel = |at: u32| if at < half { [0.5, 0.5, 0.5, 1.0] } else { [0.5, f32::NAN, 0.5, 1.0] };
        let texels = (0..SIZE.width * SIZE.height).flat_map(texel).collect();
        let pixels = afterimage_media::Pixels::Float(texels);
        let picture = afterimage_media::Picture::new(SIZE.width, SIZE.height, pixels);
        Ok(afterimage_view::InputData::Image(Box::new(picture), desc))
    };
    window.ui.viewer.model.set_input(None, Some(InputFile::still("half.exr", Box::new(picture)))).unwrap();
    window.ui.viewer.model.inspect_wire(Some(InspectedWire::new("scene")));
    for _ in 0..20 {
        window.frame(Vec::new());
        let _ = crate::support::gpu().wait();
    }
    assert!(window.says(&format!("scene has {half} pixels with NaN")), "{:?}", window.texts());
    assert!(!window.says("Nothing is wrong"));
}

#[test]
fn nan_in_an_image_that_is_not_shown_is_found_while_probe_is_on() {
    let mut window = open("lynx");
    window.ui.viewer.tabs.open = Some(Tab::Messages);
    window.ui.viewer.inspects_pixels = true;
    let searched = |window: &mut Window, text: &str| {
        for _ in 0..2000 {
            window.frame(Vec::new());
            let _ = crate::support::gpu().wait();
            if window.says(text) {
                return true;
            }
            std::thread::sleep(std::time::Duration::from_millis(5));
        }
        false
    };
    assert!(searched(&mut window, "images has NaN"), "{:?}", window.texts());
    assert!(window.says("Nothing is wrong: none of "));
    let nan = crate::support::flat("nan.exr", || Ok([0.5, f32::NAN, 0.5, 1.0]));
    window.ui.viewer.model.set_input(None, Some(nan)).unwrap();
    let all = SIZE.width * SIZE.height;
    assert!(searched(&mut window, &format!("scene has {all} pixels with NaN")), "{:?}", window.texts());
    assert!(!window.says("Nothing is wrong"));
}

#[test]
fn infinities_and_nan_are_counted_in_every_channel_and_slice() {
    let gpu = crate::support::gpu();
    let painter = Painter::new(gpu, wgpu::TextureFormat::Rgba8Unorm);
    let mut grid = Grid::new(&gpu.device);
    let (nan, infinite) = (f32::NAN, f32::NEG_INFINITY);
    for (dimension, depth, faults) in [
        (wgpu::TextureDimension::D3, 5, vec![]),
        (wgpu::TextureDimension::D3, 5, vec![(0, [0.5, infinite, 0.5, 1.0]), (4 * 7 * 3 + 2, [0.5, 0.5, 0.5, nan])]),
        (wgpu::TextureDimension::D2, 1, vec![(7, [f32::INFINITY; 4])]),
    ] {
        let size = wgpu::Extent3d { width: 7, height: 3, depth_or_array_layers: depth };
        let mut texels = vec![[0.5, 0.5, 0.5, 1.0_f32]; (7 * 3 * depth) as usize];
        faults.iter().for_each(|(at, texel)| texels[*at as usize] = *texel);
        let desc = wgpu::TextureDescriptor {
            label: None,
            size,
            mip_level_count: 1,
            sample_count: 1,
            dimension,
            format: wgpu::TextureFormat::Rgba32Float,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        };
        let image = gpu.device.create_texture(&desc);
        let bytes: Vec<u8> = texels.iter().flatten().flat_map(|number| number.to_le_bytes()).collect();
        let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(7 * 16), rows_per_image: Some(3) };
        gpu.queue.write_texture(image.as_image_copy(), &bytes, layout, size);
        let mut encoder = gpu.encoder();
        assert!(grid.record(&gpu.device, &painter, &mut encoder, &image, depth / 2));
        gpu.queue.submit([encoder.finish()]);
        grid.request();
        gpu.wait().unwrap();
        let pixels = grid.take().unwrap();
        let counted: f32 = pixels.iter().map(|pixel| pixel[3]).sum();
        assert_eq!(counted as usize, faults.len(), "{dimension:?}");
        assert!(pixels.iter().flatten().all(|number| number.is_finite()));
    }
}

#[test]
fn a_pipeline_that_was_opened_before_is_opened_from_the_menu() {
    let mut window = open("lynx");
    let before = [PathBuf::from("/looks/tsushima.ron"), PathBuf::from("/looks/lynx.ron")];
    window.ui.viewer.list_recent_by(Box::new(move |_| before.to_vec()));
    window.frame(Vec::new());
    let menu = window.place_of("lynx.ron ▾");
    window.click(menu);
    window.frame(Vec::new());
    let entry = window.place_of("tsushima.ron");
    window.click(entry);
    (0..2).for_each(|_| window.frame(Vec::new()));
    assert_eq!(window.ui.viewer.model.editor().project().name(), "tsushima.ron");
}

#[test]
fn the_layers_of_a_file_are_listed_and_chosen() {
    let mut window = open("lynx");
    let layers = vec!["albedo".to_owned(), "Z".to_owned()];
    let file = InputFile { layers, ..InputFile::still("all.exr", Box::new(|_, _| Ok(image([0.5; 4])))) };
    window.ui.viewer.model.set_input(None, Some(file)).unwrap();
    window.frame(Vec::new());
    let combo = window.place_of("the likely one");
    window.click(combo);
    window.frame(Vec::new());
    let layer = window.place_of("albedo");
    window.click(layer);
    let named = window.ui.viewer.take_named_file().unwrap();
    assert_eq!(named, (Some("scene".to_owned()), "all.exr#albedo".into()));
}

/// The left end of the slider of a parameter.
fn slider_of(window: &mut Window, name: &str) -> Pos2 {
    let texts = window.texts();
    let (_, area) = texts.iter().find(|(text, _)| text == name).expect("the name is shown");
    area.left_center() + vec2(104.0, 0.0)
}

#[test]
fn usual_parameters_are_above_the_rest_and_set_the_same_value() {
    let mut window = open("lynx");
    window.frame(Vec::new());
    assert!(window.says("Usual"));
    // The name with its node stands there alone.
    let slider = slider_of(&mut window, "lit.strength");
    window.drag(slider + vec2(40.0, 0.0), slider + vec2(70.0, 0.0));
    let Some(Value::Float(set)) = strength(&window) else { panic!("it is a number") };
    assert!((set - 0.15).abs() > 0.01, "{set}");
    assert!(window.ui.viewer.model.editor().text().contains("\"lit.strength\": \"factor of the bloom\""));
}

#[test]
fn a_logarithmic_slider_gives_each_decade_the_same_room() {
    let mut window = open("lynx");
    let slider = slider_of(&mut window, "lit.strength");
    let at = |window: &mut Window, part: f32| {
        let button = |pos, pressed| Event::PointerButton {
            pos,
            button: PointerButton::Primary,
            pressed,
            modifiers: Modifiers::NONE,
        };
        let pos = slider + vec2(8.0 + part * 84.0, 0.0);
        window.frame(vec![Event::PointerMoved(pos)]);
        window.frame(vec![button(pos, true)]);
        window.frame(vec![button(pos, false)]);
        let Some(Value::Float(number)) = strength(window) else { panic!("it is a number") };
        number
    };
    let [low, middle, high] = [0.2, 0.5, 0.8].map(|part| at(&mut window, part));
    let (first, second) = (middle / low, high / middle);
    assert!(first > 3.0 && (first / second - 1.0).abs() < 0.3, "{low} {middle} {high}");
}

#[test]
fn a_wheel_opens_and_a_drag_in_it_changes_the_numbers_and_not_their_mean() {
    let mut window = open("grade");
    let lift = |window: &Window| match window.ui.viewer.model.editor().value("graded.lift") {
        Some(Value::Vector(numbers, 3)) => numbers,
        other => panic!("{other:?}"),
    };
    let before = lift(&window);
    let wheel = window.place_of("●");
    window.click(wheel);
    (0..4).for_each(|_| window.frame(Vec::new()));
    window.drag(wheel + vec2(70.0, 90.0), wheel + vec2(100.0, 60.0));
    (0..4).for_each(|_| window.frame(Vec::new()));
    let after = lift(&window);
    let mean = |numbers: [f64; 4]| numbers[..3].iter().sum::<f64>() / 3.0;
    assert!(after != before && (mean(after) - mean(before)).abs() < 1e-5, "{before:?} {after:?}");
}
