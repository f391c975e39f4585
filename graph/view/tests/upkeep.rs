//! Recovery from texts with errors and lost devices, and sequences of images.

use crate::support::{SIZE, Window, apart, gpu, image, model, of, parameter, picture, render, settle};
use afterimage_graph::check::GraphInput;
use afterimage_graph::value::Value;
use afterimage_view::{Images, InputFile, Model, Problem, Rendered, Scene, TextProject};

#[test]
fn a_text_that_is_wrong_from_the_start_stays_the_problem() {
    let broken = TextProject::built_in("lynx").unwrap().text().replace("Composite(", "Compositor(");
    let mut model = of(Box::new(TextProject::new("broken.ron", &broken)));
    let scene = Scene::new(gpu(), SIZE).unwrap();
    model.set_images(Images::Scene(Box::new(scene)));
    assert_eq!(render(&mut model), Rendered::Same);
    assert!(matches!(model.problem(), Some(Problem::Pipeline(_))), "{:?}", model.problem());
}

#[test]
fn a_lost_device_is_replaced_and_the_picture_is_the_same() {
    let own = afterimage_gpu::Gpu::open(&afterimage_gpu::Opening::default()).unwrap();
    let scene = Scene::new(&own, SIZE).unwrap();
    let project = Box::new(TextProject::built_in("lynx").unwrap());
    let mut model = Model::new(&own, project, Images::Scene(Box::new(scene)));
    model.clock().is_playing = false;
    model.set(&parameter("lit.strength"), Some(Value::Float(0.4)));
    let frame = |gpu: &afterimage_gpu::Gpu, model: &mut Model| {
        let mut encoder = gpu.encoder();
        model.render(&mut encoder, 0.0);
        gpu.queue.submit([encoder.finish()]);
    };
    let read = |gpu: &afterimage_gpu::Gpu, model: &Model| {
        let picture = model.shown().unwrap().picture().unwrap();
        afterimage_gpu::download(&gpu.device, &gpu.queue, picture).unwrap()
    };
    frame(&own, &mut model);
    let before = read(&own, &model);
    own.device.destroy();
    for _ in 0..64 {
        model.clock().step();
        frame(&own, &mut model);
        if matches!(model.problem(), Some(Problem::DeviceLost)) {
            break;
        }
    }
    assert!(matches!(model.problem(), Some(Problem::DeviceLost)), "{:?}", model.problem());
    let other = afterimage_gpu::Gpu::open(&afterimage_gpu::Opening::default()).unwrap();
    model.rebuild(&other).unwrap();
    model.clock().seek(0.0);
    frame(&other, &mut model);
    assert!(apart(&read(&other, &model), &before) <= 1);
}

#[test]
fn the_whole_window_goes_on_after_its_device_is_lost() {
    let opened = || afterimage_gpu::Gpu::open(&afterimage_gpu::Opening::default()).unwrap();
    let (own, other) = (opened(), opened());
    let errors = own.log_errors();
    let scene = Scene::new(&own, SIZE).unwrap();
    let project = Box::new(TextProject::built_in("lynx").unwrap());
    let mut model = Model::new(&own, project, Images::Scene(Box::new(scene)));
    model.clock().is_playing = false;
    let mut window = Window::new(model);
    (0..8).for_each(|_| window.frame(Vec::new()));
    let before = window.texels();
    own.device.destroy();
    let is_lost = |window: &Window| matches!(window.ui.viewer.model.problem(), Some(Problem::DeviceLost));
    for _ in 0..64 {
        window.ui.viewer.model.clock().step();
        window.frame(Vec::new());
        if is_lost(&window) {
            break;
        }
    }
    assert!(is_lost(&window), "{:?} {:?}", window.ui.viewer.model.problem(), errors.take_first());
    window.replace_device(&other);
    window.ui.viewer.model.clock().seek(0.0);
    (0..16).for_each(|_| window.frame(Vec::new()));
    let after = window.texels();
    let equal = before.bytes.iter().zip(&after.bytes).filter(|(a, b)| a.abs_diff(**b) <= 2).count();
    // The time and the tab with the messages differ.
    assert!(equal * 100 > before.bytes.len() * 96, "{equal} of {}", before.bytes.len());
}

/// A sequence of frames of one gray each, three in a second. The first number is 11.
fn sequence(lights: &'static [f32]) -> InputFile {
    let read = move |_: &GraphInput, index: usize| Ok(image([lights[index], lights[index], lights[index], 1.0]));
    let numbers = (11..).take(lights.len()).collect();
    InputFile { numbers, fps: 3.0, ..InputFile::still("gray.####.exr", Box::new(read)) }
}

#[test]
fn a_sequence_adapts_while_it_plays_and_a_frame_that_is_gone_to_has_no_history() {
    const LIGHTS: &[f32] = &[0.02, 2.0, 2.0];
    let at = |seconds: f64, plays: bool| {
        let mut model = model("exposure");
        model.set_input(None, Some(sequence(LIGHTS))).unwrap();
        assert_eq!((model.images_length(), model.images().frame_number()), (Some((3, 3.0)), Some(11)));
        if plays {
            settle(&mut model);
            model.clock().is_playing = true;
            while model.clock().time < seconds {
                render(&mut model);
            }
            assert!(!model.clock().is_cut_shown());
        } else {
            model.clock().seek(seconds);
            settle(&mut model);
            assert!(model.clock().is_cut_shown(), "the window says that the frame has no history");
        }
        assert_eq!(model.images().frame_number(), Some(12));
        let texels = picture(&model).to_floats();
        f64::from(texels[texels.len() / 2][1])
    };
    // The eye is used to the dark when the light comes on.
    let (played, sought) = (at(0.4, true), at(0.4, false));
    assert!(played > sought + 0.1, "{played} {sought}");
}
