//! Nodes that run in one of several frames, against those that run in all.

use afterimage::offline::Session;
use afterimage_gpu::{FrameKind, FrameStep, Texels};
use afterimage_graph::check::{Graph, NoFiles};
use afterimage_graph::image::Size;
use afterimage_graph::value::Value;
use afterimage_plan::{Plan, Refresh, verify};

use crate::support::gpu::{Picture, Run, Shared, changed, gpu, tiers};
use crate::support::harness::checked;

/// A bloom of which `FIELDS` of the last node are to be filled in, and the picture beside it.
fn bloom(fields: &str) -> Graph {
    let text = format!(
        "Pipeline(inputs: {{ \"scene\": Exposed }}, nodes: {{ \
         \"bright\": Extract(source: \"scene\", threshold: 0.5), \
         \"mips\": Downsample(source: \"bright\", levels: 3), \
         \"bloom\": Upsample(source: \"mips\", {fields}), \
         \"lit\": Composite(base: \"scene\", bloom: \"bloom\", blend: Add, strength: 0.5) }}, \
         outputs: {{ \"bloom\": \"bloom\", \"lit\": \"lit\" }})"
    );
    checked(&text, &NoFiles)
}

/// A meter and what shows its result; the fields are those of the histogram and of the meter.
fn meter(counted: &str, metered: &str) -> Graph {
    let text = format!(
        "Pipeline(inputs: {{ \"scene\": Color }}, nodes: {{ \"counted\": Histogram(source: \"scene\", {counted}), \
         \"metered\": AutoExposure(histogram: \"counted\", {metered}), \"stops\": ShowValue(value: \"metered\"), \
         \"lit\": Exposure(source: \"scene\", meter: \"metered\") }}, \
         outputs: {{ \"lit\": \"lit\", \"stops\": \"stops\" }})"
    );
    checked(&text, &NoFiles)
}

/// A spot that moves over a gray ground whose light changes.
fn moving(size: [u32; 2], frame: u32) -> Picture {
    let light = 0.2 * (0.9 * frame as f32).sin() + 0.3;
    Picture::new(size[0], size[1], |x, y| {
        let is_lit = x.abs_diff(3 * frame % size[0]) < 3 && y.abs_diff(size[1] / 2) < 3;
        let light = if is_lit { 9.0 } else { light * (1.0 + 0.1 * (x as f32 * 0.3).sin()) };
        [light, 0.9 * light, 0.7 * light, 1.0]
    })
}

/// A session, frame by frame.
struct Film {
    session: Session,
    _gpu: Shared,
}

impl Film {
    fn new(graph: &Graph) -> Self {
        let gpu = gpu();
        Self { session: Run::new(graph).session(&gpu), _gpu: gpu }
    }

    /// The outputs of a frame of that number.
    fn frame(&mut self, number: u32, picture: &Picture, dt: f32, reset: bool) -> Vec<Picture> {
        let texels = Texels::from_floats(picture.width, picture.height, &picture.pixels);
        let image = self.session.feed("scene", texels.desc, &texels.bytes).expect("it can be fed");
        self.session.number_next(number);
        let size = Size::new(picture.width, picture.height);
        self.session
            .render(size, &[image], FrameStep { time: 0.0, dt, kind: FrameKind::cut_if(reset) })
            .expect("it can be rendered");
        assert_eq!(verify(self.session.plan()), Ok(()));
        let names: Vec<String> = self.session.plan().outputs.iter().map(|output| output.name.clone()).collect();
        names.iter().map(|name| Picture::of(&self.session.output(name).expect("it can be read"))).collect()
    }

    /// All outputs of frames of these numbers.
    fn frames(graph: &Graph, size: [u32; 2], numbers: impl Iterator<Item = u32>) -> Vec<Vec<Picture>> {
        let mut film = Self::new(graph);
        numbers.map(|number| film.frame(number, &moving(size, number % 64), 0.1, false)).collect()
    }
}

fn plan(graph: &Graph) -> Plan {
    Run::new(graph).plan(&gpu(), &[("scene", &moving([64, 36], 0))])
}

/// The frame from which the bloom of the frame `at` comes.
fn turn(numbers: &[u32], at: usize, every: u32) -> usize {
    (1..=at).rev().find(|at| numbers[*at] / every != numbers[*at - 1] / every).unwrap_or(0)
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_node_in_every_frame_is_a_node_without_the_field() {
    assert_eq!(plan(&bloom("every: 1")), plan(&bloom("")));
    assert_eq!(plan(&meter("every: 1", "every: 1")), plan(&meter("", "")));
    let cached = plan(&bloom("every: 4"));
    let spared = cached.passes.len() - running(&cached).count();
    assert_eq!(spared, cached.passes.len() - 2, "all but the last pass and a copy: {}", cached.to_text());
    assert!(cached.bytes_moved() < plan(&bloom("")).bytes_moved());
    let text = cached.to_text();
    for line in ["cached between the frames that compute them", "bloom  runs in one of 4 frames"] {
        assert!(text.contains(line), "{line}: {text}");
    }
}

/// At sizes of a pixel and odd ones, at any number of frames and in any steps of these.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_cached_bloom_is_that_of_the_last_frame_that_was_due() {
    let steps: [Vec<u32>; 4] =
        [(0..9).collect(), (5..14).collect(), (0xff_fffd..0x100_0006).collect(), vec![1, 5, 9, 10, 13, 14, 30, 31]];
    for (size, numbers) in [[1, 1], [37, 23], [64, 36], [3, 50]].into_iter().zip(&steps) {
        let exact = Film::frames(&bloom(""), size, numbers.iter().copied());
        let held = Film::frames(&bloom("every: 4"), size, numbers.iter().copied());
        for at in 0..numbers.len() {
            let from = turn(numbers, at, 4);
            assert!(held[at][0] == exact[from][0], "{size:?}: bloom of frame {} from {}", numbers[at], numbers[from]);
            let is_new = held[at][1] == exact[at][1];
            assert!(is_new || from != at, "{size:?}: the frame {} is new", numbers[at]);
        }
    }
}

/// A history that only a cached bloom reads advances in its frames: the bloom is that of a sequence of these frames.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_cached_bloom_reads_the_history_of_its_own_frames() {
    let limited = |fields: &str| {
        let text = format!(
            "Pipeline(inputs: {{ \"scene\": Exposed }}, nodes: {{ \
             \"bright\": Extract(source: \"scene\", before: \"bright.peaks@previous\", fireflies: Limit), \
             \"mips\": Downsample(source: \"bright\", levels: 3), \
             \"bloom\": Upsample(source: \"mips\", {fields}), \
             \"lit\": Composite(base: \"scene\", bloom: \"bloom\", blend: Add, strength: 0.5) }}, \
             outputs: {{ \"bloom\": \"bloom\", \"lit\": \"lit\" }})"
        );
        checked(&text, &NoFiles)
    };
    for every in [2, 3] {
        let held = limited(&format!("every: {every}"));
        for size in [[1, 1], [37, 23], [64, 36]] {
            let all = Film::frames(&held, size, 0..12);
            let turns = Film::frames(&limited(""), size, (0..12).step_by(every));
            for (at, shown) in all.iter().enumerate() {
                assert!(shown[0] == turns[at / every][0], "every {every}, {size:?}: frame {at}");
            }
        }
        let plan = plan(&held);
        assert_eq!(running(&plan).count(), 2, "all but the last pass and a copy: {}", plan.to_text());
        assert!(
            plan.to_text().contains(&format!("bright.peaks    32x18 R16Float, {every} frames")),
            "{}",
            plan.to_text()
        );
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn what_does_not_move_is_the_same_without_a_step() {
    let sets = [("mips.every", "4"), ("grid.every", "3"), ("around.every", "2"), ("counted.every", "4")];
    for (name, sets) in [("tsushima.ron", &sets[..]), ("exposure.ron", &[("bins.every", "4")])] {
        let (exact, held) = (changed(name, None, &[]), changed(name, None, sets));
        let (mut one, mut other) = (Film::new(&exact), Film::new(&held));
        for frame in 0..7 {
            // Time may stand still, too, and a still resets.
            let (dt, reset) = (if frame == 3 { 0.0 } else { 0.1 }, frame == 5);
            let picture = moving([64, 36], 2);
            let [one, other] = [&mut one, &mut other].map(|film| film.frame(frame, &picture, dt, reset));
            assert!(one == other, "{name}: frame {frame}");
        }
        assert!(!other.session.plan().savings.cached.is_empty());
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_cut_another_size_and_another_number_run_all() {
    let [exact, held] = ["", "every: 8"].map(bloom);
    let (mut one, mut other) = (Film::new(&exact), Film::new(&held));
    let mut shown = |frame: u32, size: [u32; 2], reset: bool, strength: f32| {
        let picture = moving(size, frame);
        let shown = [(&mut one, &exact), (&mut other, &held)].map(|(film, graph)| {
            let mut graph = graph.clone();
            for name in ["lit.strength", "bright.threshold"] {
                let parameter = graph.parameter(name).expect("it has one");
                graph.nodes[parameter.node].instance.set(parameter.index, Value::Float(f64::from(strength)));
            }
            film.session.change(graph, Default::default());
            film.frame(frame, &picture, 0.1, reset)
        });
        shown[0] == shown[1]
    };
    let size = [40, 24];
    assert!(shown(1, size, false, 0.5), "the first frame");
    assert!(!shown(2, size, false, 0.5) && !shown(3, size, false, 0.5));
    assert!(shown(4, size, true, 0.5), "a cut");
    assert!(!shown(5, size, false, 0.5));
    assert!(shown(6, size, false, 0.25), "another value");
    assert!(!shown(7, size, false, 0.25));
    assert!(shown(8, size, false, 0.25), "its turn");
    assert!(!shown(9, size, false, 0.25));
    assert!(shown(10, [48, 24], false, 0.25), "another size");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn nodes_with_a_state_are_not_cached() {
    let held = plan(&meter("", "every: 4"));
    assert!(held.savings.cached[0].results.is_empty() && running(&held).count() == held.passes.len());
    assert!(held.to_text().contains("metered  runs in every frame, because it keeps a state"));
    let remembered = "Pipeline(inputs: { \"scene\": Color }, nodes: { \
        \"trail\": Composite(base: \"scene\", bloom: \"trail@previous\", every: 4) }, \
        outputs: { \"out\": \"trail\" })";
    let held = plan(&checked(remembered, &NoFiles));
    assert!(held.savings.cached[0].results.is_empty(), "{}", held.to_text());
}

/// With what it meters shown, a meter runs in every frame, and its own `hold` keeps the exposure.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn an_exposure_that_stays_meters_the_first_frame_alone() {
    for metered in ["hold: true", "rate_dark: 0.0, rate_bright: 0.0"] {
        let text = format!(
            "Pipeline(inputs: {{ \"scene\": Color }}, nodes: {{ \"counted\": Histogram(source: \"scene\", every: 2), \
             \"metered\": AutoExposure(histogram: \"counted\", {metered}), \
             \"lit\": Exposure(source: \"scene\", meter: \"metered\") }}, outputs: {{ \"lit\": \"lit\" }})"
        );
        let settled = checked(&text, &NoFiles);
        let shown = meter("", metered);
        for size in [[1, 1], [37, 23]] {
            let (mut one, mut other) = (Film::new(&settled), Film::new(&shown));
            for frame in 0..9 {
                // A cut resets.
                let (picture, reset) = (moving(size, frame), frame == 5);
                let [one, other] = [&mut one, &mut other].map(|film| film.frame(frame, &picture, 0.1, reset));
                assert!(one[0] == other[0], "{metered}, {size:?}: frame {frame}");
            }
        }
        let plan = plan(&settled);
        assert!(plan.to_text().contains("metered  runs in the first frame of a sequence, because its state stays"));
        let every_frame: Vec<&str> = running(&plan).flatten().map(String::as_str).collect();
        assert_eq!(every_frame, ["lit"], "{}", plan.to_text());
        assert!(running(&self::plan(&shown)).flatten().any(|node| node == "counted"));
    }
}

/// The nodes of each pass that runs in every frame.
fn running(plan: &Plan) -> impl Iterator<Item = &Vec<String>> {
    let passes = plan.passes.iter().filter(|pass| pass.refresh.contains(&Refresh::EachFrame));
    passes.map(|pass| &pass.pass.nodes)
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn every_pipeline_with_a_meter_can_do_without() {
    let fixed = &[("min_ev", "3.0"), ("max_ev", "3.0")];
    let standing = &[("rate_dark", "0.0"), ("rate_bright", "0.0")];
    for (name, bins, metered, needs_range) in [
        ("tsushima.ron", "counted", "metered", true),
        ("cinematic.ron", "counted", "metered", true),
        ("exposure.ron", "bins", "meter", false),
        ("hdr.ron", "bins", "meter", false),
        ("matinee.ron", "bins", "meter", false),
        ("cookbook.ron", "mean", "metered", false),
    ] {
        let has_low = tiers(name).iter().any(|tier| tier == "low");
        for tier in [None].into_iter().chain(has_low.then_some(Some("low"))) {
            for sets in [&[("hold", "true")][..], fixed, standing] {
                let sets: Vec<(String, &str)> =
                    sets.iter().map(|(set, to)| (format!("{metered}.{set}"), *to)).collect();
                let sets: Vec<(&str, &str)> = sets.iter().map(|(set, to)| (set.as_str(), *to)).collect();
                let plan = plan(&changed(name, tier, &sets));
                // Local tone mapping follows the range of the scene, whatever the exposure.
                let meters = needs_range && sets[0].0.ends_with("min_ev");
                let runs = running(&plan).flatten().any(|node| node == bins);
                assert_eq!(runs, meters, "{name} {tier:?} {sets:?}: {}", plan.to_text());
            }
        }
    }
}

/// The change of the picture from frame to frame, relative to that without.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
#[expect(clippy::print_stdout, reason = "the figures are for people")]
fn the_largest_steps_of_a_moving_sequence() {
    let mean = |picture: &Picture| {
        let sum: f64 = picture.pixels.iter().map(|pixel| f64::from(pixel[1])).sum();
        sum / picture.pixels.len() as f64
    };
    let step = |sets: &[(&str, &str)]| {
        let mut film = Film::new(&changed("tsushima.ron", None, sets));
        let mut shown: Vec<Picture> = Vec::new();
        for frame in 0..24 {
            // A pan at a walk's pace over a scene whose light fades.
            let light = 2.0 * (-0.05 * frame as f32).exp();
            let picture = Picture::new(160, 90, |x, y| {
                let lit = light * (1.2 + (0.05 * (x + frame) as f32).sin() * (0.08 * y as f32).cos());
                let lamp = if (x + frame) % 80 < 4 && y % 45 < 4 { 40.0 } else { 0.0 };
                [lit + lamp, 0.8 * lit + lamp, 0.6 * lit + 0.5 * lamp, 1.0]
            });
            shown.push(film.frame(frame, &picture, 1.0 / 24.0, false).remove(0));
        }
        let steps = shown.windows(2).map(|pair| 255.0 * (mean(&pair[1]) - mean(&pair[0])).abs());
        (steps.fold(0.0, f64::max), shown)
    };
    let (exact, wanted) = step(&[]);
    for sets in [
        &[("counted.every", "4")][..],
        &[("mips.every", "2")],
        &[("counted.every", "4"), ("mips.every", "4"), ("smooth.every", "4")],
    ] {
        let (largest, found) = step(sets);
        let errors = wanted.iter().zip(&found).flat_map(|(one, other)| one.pixels.iter().zip(&other.pixels));
        let most = errors.map(|(one, other)| 255.0 * (one[1] - other[1]).abs()).fold(0.0, f32::max);
        println!("{sets:?}: the mean steps by {largest:.3} codes, exactly by {exact:.3}; most {most:.1} codes");
        assert!(largest < 4.0 * exact + 1.0, "{sets:?}: a visible step of {largest} codes");
    }
}
