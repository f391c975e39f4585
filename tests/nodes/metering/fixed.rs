//! A fixed exposure: what nobody reads is not metered, and the picture stays the same.

use afterimage_graph::check::{Graph, NoFiles};
use afterimage_graph::image::Size;

use super::super::probes::scene;
use crate::support::gpu::{Picture, Run, changed, gpu};
use crate::support::harness::checked;
use crate::support::sequence::Sequence;

/// Both meters with both limits at `EV`, and further parameters at `MORE`.
const METERS: [&str; 2] = [
    "\"h\": Histogram(source: \"scene\"), \
     \"auto\": AutoExposure(histogram: \"h\", min_ev: EV, max_ev: EV, compensation: 0.3, MORE)",
    "\"h\": MeanLuminance(source: \"scene\"), \
     \"auto\": Adapt(mean: \"h\", min_ev: EV, max_ev: EV, compensation: 0.3, MORE)",
];

/// A metered picture; `further` are more nodes, and `output` one of them that is shown, too.
fn graph(meter: &str, ev: f64, more: &str, further: &str, output: &str) -> Graph {
    let meter = meter.replace("EV", &format!("{ev:?}")).replace("MORE", more);
    let text = format!(
        "Pipeline(inputs: {{ \"scene\": Color }}, nodes: {{ {meter}, \
         \"exposed\": Exposure(source: \"scene\", meter: \"auto\"), {further} }}, \
         outputs: {{ \"out\": \"exposed\", {output} }})"
    );
    checked(&text, &NoFiles)
}

/// True if the plan of a graph has a pass of the node `h`, and whether it leaves something for the next frame.
fn meters(graph: &Graph) -> [bool; 2] {
    let picture = Picture::new(16, 8, |_, _| [0.5; 4]);
    let plan = Run::new(graph).plan(&gpu(), &[("scene", &picture)]);
    [plan.work().any(|pass| pass.nodes.iter().any(|node| node == "h")), !plan.state().is_empty()]
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_fixed_exposure_shows_the_same_without_its_meter() {
    for meter in METERS {
        for ev in [-10.0, 2.3, 19.0] {
            let fixed = graph(meter, ev, "", "", "");
            let metered = graph(meter, ev, "", "\"value\": ShowValue(value: \"auto\")", "\"value\": \"value\"");
            assert_eq!(meters(&fixed), [false; 2], "{meter} {ev}");
            assert_eq!(meters(&metered), [true; 2], "{meter} {ev}: somebody reads the mean");
            for (width, height) in [(1, 1), (161, 89)] {
                let frames = [scene(width, height), Picture::new(width, height, |x, _| [0.01 * x as f32 + 0.1; 4])];
                let (run, metered_run) = (Run::new(&fixed), Run::new(&metered));
                let (mut one, mut other) = (Sequence::new(&run), Sequence::new(&metered_run));
                for picture in frames.iter().chain(&frames) {
                    one.frame(&[("scene", picture)], 0.1, false);
                    other.frame(&[("scene", picture)], 0.1, false);
                    assert!(one.output("out") == other.output("out"), "{meter} {ev} at {width}x{height}");
                }
            }
        }
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_fixed_exposure_states_its_brightness() {
    for meter in METERS {
        let fixed = graph(meter, 5.0, "", "", "");
        let gpu = gpu();
        let mut session = Run::new(&fixed).session(&gpu);
        let texels = afterimage_gpu::Texels::from_floats(2, 1, &[[0.1; 4], [3.0; 4]]);
        let image = session.feed("scene", texels.desc, &texels.bytes).expect("it can be fed");
        session.render(Size::new(2, 1), &[image], Default::default()).expect("it can be rendered");
        let [stops, mean, lux, valid] = session.value("auto.result").expect("it can be read").expect("there is one");
        // EV100 5 is a luminance of 4.
        assert!((f64::from(stops) - (0.18_f64 / 4.0).log2() - 0.3).abs() < 1e-5, "{meter}: {stops}");
        assert!((f64::from(lux) - std::f64::consts::PI * 4.0 / 0.18).abs() < 1e-3, "{meter}: {lux}");
        assert_eq!([mean, valid], [2.0, 1.0], "{meter}");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn what_depends_on_the_scene_is_metered() {
    let night = "\"night\": Purkinje(source: \"exposed\", meter: \"auto\")";
    for meter in METERS {
        assert_eq!(meters(&graph(meter, 3.0, "", night, "\"night\": \"night\"")), [true; 2], "{meter}");
        assert_eq!(meters(&graph(&meter.replacen("EV", "2.5", 1), 3.0, "", "", "")), [true; 2], "{meter}");
    }
    let range = "\"range\": ShowValue(value: \"auto.range\")";
    assert_eq!(meters(&graph(METERS[0], 3.0, "", range, "\"range\": \"range\"")), [true; 2]);
    for more in ["highlights: Protect", "curve_stops: (0.0, 0.0, 0.0, 0.5)"] {
        assert_eq!(meters(&graph(METERS[0], 3.0, more, "", "")), [true; 2], "{more}");
    }
    for more in ["hold: true", "rate_dark: 0.0", "adaptation: Linear"] {
        assert_eq!(meters(&graph(METERS[0], 3.0, more, "", "")), [false; 2], "{more}: it is fixed all the same");
    }
}

/// In the built-in pipelines nothing else reads what is metered, but for the range that local tone mapping reduces.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_fixed_exposure_spares_built_in_pipelines_their_histogram() {
    let fixed = |name: &str, meter: &str, more: &[(&str, &str)]| {
        let limits = ["min_ev", "max_ev"].map(|limit| format!("{meter}.{limit}"));
        let mut sets: Vec<(&str, &str)> = limits.iter().map(|limit| (limit.as_str(), "4.0")).collect();
        sets.extend(more);
        let plan = Run::new(&changed(name, None, &sets))
            .plan(&gpu(), &[("scene", &Picture::new(64, 36, |x, _| [x as f32 / 64.0; 4]))]);
        plan.work().any(|pass| pass.nodes.iter().any(|node| node == "bins" || node == "counted"))
    };
    assert!(!fixed("exposure.ron", "meter", &[]));
    assert!(!fixed("tsushima.ron", "metered", &[("local", "Off")]));
    assert!(fixed("tsushima.ron", "metered", &[]), "the range is metered");
}
