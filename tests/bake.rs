//! Tables in the place of nodes: how close they are to the nodes, when they are filled, what they hold at their ends,
//! and which nodes become one.

use afterimage::offline::{LutErrors, Session, faults};
use afterimage_generators::Rng;
use afterimage_gpu::{Frame, Gpu, LoadedPlan, Texels, input_image};
use afterimage_graph::check::{Facts, Graph};
use afterimage_graph::node::{Bake, NodeKind, folder_kind_of};
use afterimage_plan::{Fault, Options, Plan, verify};

use crate::support::gpu::{Picture, Run, gpu, graph, graph_with};
use crate::support::layer;
use crate::support::player::Player;
use crate::support::sweep;

/// Nodes from exposed light to a signal that is stored in 32 bits. `bake` stands at the first.
fn pipeline(nodes: &str) -> String {
    format!("Pipeline(inputs: {{ \"in\": Exposed }}, nodes: {{ {nodes} }}, outputs: {{ \"out\": \"result\" }})")
}

const ENCODE: &str = r#""result": Encode(source: "mapped", format: Rgba32Float)"#;

fn tone_map(fields: &str) -> String {
    pipeline(&format!(r#""mapped": ToneMap(source: "in", {fields} bake: Auto), {ENCODE}"#))
}

fn shown(graph: &Graph, bake: Option<Bake>, picture: &Picture) -> Picture {
    let mut run = Run::new(graph);
    run.options.bake = bake;
    run.frame(&[("in", picture)]).remove(0)
}

fn plan(graph: &Graph, bake: Option<Bake>) -> Plan {
    let mut run = Run::new(graph);
    run.options.bake = bake;
    run.plan(&gpu(), &[("in", &gray_ramp())])
}

/// Colors of all levels of light from 2^-10 to 2^8 and of all saturations.
fn colors(seed: u64) -> Picture {
    let mut random = Random::new(seed);
    Picture::new(256, 256, |_, _| {
        let light = (18.0 * random.next() - 10.0).exp2();
        let [r, g, b] = [0; 3].map(|_| light * random.next());
        [r, g, b, random.next()]
    })
}

/// Colors of which one channel is zero, on the border of the gamut.
fn border(seed: u64) -> Picture {
    let mut colors = colors(seed);
    for (at, pixel) in colors.pixels.iter_mut().enumerate() {
        pixel[at % 3] = 0.0;
    }
    colors
}

/// Colors of AP1, many of which have negative channels in Rec.709.
fn wide(seed: u64) -> Picture {
    const TO_REC709: [[f32; 3]; 3] =
        [[1.70505, -0.62179, -0.08326], [-0.13026, 1.1408, -0.01055], [-0.024, -0.12897, 1.15297]];
    let mut colors = colors(seed);
    for pixel in &mut colors.pixels {
        let [r, g, b, alpha] = *pixel;
        let [red, green, blue] = TO_REC709.map(|row| row[0] * r + row[1] * g + row[2] * b);
        *pixel = [red, green, blue, alpha];
    }
    colors
}

fn gray_ramp() -> Picture {
    let gray = |x: u32, y: u32| (26.0 * (y * 128 + x) as f32 / (128.0 * 128.0) - 14.0).exp2();
    Picture::new(128, 128, |x, y| [gray(x, y), gray(x, y), gray(x, y), 1.0])
}

/// Numbers from 0 to 1.
struct Random(Rng);

impl Random {
    fn new(seed: u64) -> Self {
        Self(Rng::new(seed))
    }

    fn next(&mut self) -> f32 {
        self.0.below(1 << 24) as f32 / (1 << 24) as f32
    }
}

/// The largest differences of channels in codes of 255, of each pixel, in ascending order.
fn errors(a: &Picture, b: &Picture) -> Vec<f32> {
    let of_pixel = |(a, b): (&[f32; 4], &[f32; 4])| (0..3).map(|c| 255.0 * (a[c] - b[c]).abs()).fold(0.0, f32::max);
    let mut errors: Vec<f32> = a.pixels.iter().zip(&b.pixels).map(of_pixel).collect();
    errors.sort_by(f32::total_cmp);
    errors
}

/// The errors that 99 and 99.9 per cent of the pixels stay below.
fn shares(errors: &[f32]) -> [f32; 2] {
    [100, 1000].map(|part| errors[errors.len() - 1 - errors.len() / part])
}

/// By how many codes a ramp falls below what it was before.
fn fall(ramp: &Picture) -> f32 {
    let (mut most, mut fall) = ([0.0_f32; 3], 0.0_f32);
    for pixel in &ramp.pixels {
        for (most, channel) in most.iter_mut().zip(pixel) {
            *most = most.max(*channel);
            fall = fall.max(255.0 * (*most - channel));
        }
    }
    fall
}

/// A curve, the size of its table, and the errors that 99 and 99.9 % of random colors, 99 % of those on the border of
/// the gamut and 99 % of those of AP1 stay below, in codes of 8 bits.
type Case = (&'static str, u32, [f32; 4]);

const CASES: [Case; 9] = [
    ("", 64, [0.35, 0.6, 0.45, 1.6]),
    ("", 48, [0.55, 0.85, 0.75, 2.7]),
    ("", 33, [1.0, 1.5, 1.4, 5.0]),
    ("curve: AcesNarkowicz,", 64, [0.3, 0.75, 0.45, 2.0]),
    ("curve: Uchimura, linear_length: 0.3, space: Tsushima,", 64, [0.3, 0.55, 0.45, 1.9]),
    ("curve: KhronosNeutral,", 64, [0.4, 0.7, 0.5, 0.5]),
    ("curve: AgX,", 64, [0.45, 0.9, 0.65, 0.65]),
    ("curve: Gt7,", 64, [0.8, 2.8, 1.4, 2.1]),
    ("curve: Exponential,", 64, [0.3, 0.5, 0.55, 1.8]),
];

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_table_is_close_to_its_nodes_and_exact_for_grays() {
    let (colors, border, wide, ramp) = (colors(7), border(8), wide(9), gray_ramp());
    let mut above = String::new();
    for (fields, size, limits) in CASES {
        let graph = graph(&tone_map(fields));
        let compared = |picture: &Picture| {
            let [exact, table] = [Bake::Off, Bake::Size(size)].map(|bake| shown(&graph, Some(bake), picture));
            let is_same_alpha = exact.pixels.iter().zip(&table.pixels).all(|(a, b)| a[3] == b[3]);
            assert!(is_same_alpha, "{fields} {size}: alpha stays");
            (errors(&exact, &table), [exact, table])
        };
        let [of_colors, of_border, of_wide] = [&colors, &border, &wide].map(|picture| shares(&compared(picture).0));
        let (grays, shown) = compared(&ramp);
        let found = [of_colors[0], of_colors[1], of_border[0], of_wide[0]];
        let is_above = found.iter().zip(limits).any(|(found, limit)| *found > limit);
        let worst_gray = grays[grays.len() - 1];
        let [of_nodes, of_table] = shown.each_ref().map(fall);
        let tint = shown[1].pixels.iter().map(|p| (p[0] - p[1]).abs().max((p[2] - p[1]).abs())).fold(0.0, f32::max);
        if is_above || worst_gray > 0.3 || of_table > of_nodes + 1e-3 || 255.0 * tint > 0.13 {
            above +=
                &format!("{fields} {size}: {found:?}, grays {worst_gray}, falls {of_table}, tint {}\n", 255.0 * tint);
        }
        assert!(found[0] > 1e-3, "{fields} {size}: no table is exact, so there is none");
    }
    assert!(above.is_empty(), "{above}");
}

/// The curves, of which a short run of the tests takes some.
const CURVES: [&str; 14] = [
    "curve: None,",
    "curve: Reinhard,",
    "curve: ReinhardExtended,",
    "",
    "curve: ReinhardLuminance,",
    "curve: Exponential,",
    "curve: AcesNarkowicz,",
    "curve: AcesHill,",
    "curve: Hable,",
    "curve: Uchimura, linear_length: 0.3, space: Tsushima,",
    "curve: Uchimura,",
    "curve: KhronosNeutral,",
    "curve: AgX,",
    "curve: Gt7,",
];

/// The largest step between neighbors, in codes of 8 bits: 2.3 within AP0, 3.5 where the luminance of light ends. sRGB
/// alone moves a channel near black by 3.3 codes for a thousandth of white.
const STEP: f32 = 3.6;

/// Rows of the picture below with one exposure: the hues of five gamuts, the hues at the same distance from gray in
/// three shares of the way to a luminance of 0, and those a little beyond it.
fn rings() -> Vec<[f32; 3]> {
    const TO_REC709: [[[f32; 3]; 3]; 5] = [
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        [[1.22494, -0.22494, 0.0], [-0.042057, 1.042057, 0.0], [-0.019638, -0.078636, 1.098274]],
        [[1.660491, -0.587641, -0.07285], [-0.12455, 1.1329, -0.008349], [-0.018151, -0.100579, 1.11873]],
        [[1.705051, -0.621792, -0.083259], [-0.130256, 1.140805, -0.010548], [-0.024003, -0.128969, 1.152972]],
        [[2.521686, -1.134131, -0.387555], [-0.27648, 1.372719, -0.096239], [-0.015378, -0.152975, 1.168354]],
    ];
    let hues = (0..36).map(|hue| {
        let channel = |offset: f32| (((hue as f32 / 6.0 + offset) % 6.0 - 3.0).abs() - 1.0).clamp(0.0, 1.0);
        [channel(0.0), channel(4.0), channel(2.0)]
    });
    let luminance = |c: [f32; 3]| 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
    let mut all = Vec::new();
    for hue in hues {
        all.extend(TO_REC709.map(|rows| rows.map(|row| row[0] * hue[0] + row[1] * hue[1] + row[2] * hue[2])));
        let rest = hue.map(|x| 1.0 - x);
        let to_zero = luminance(hue) / luminance(rest);
        all.extend([0.25, 0.9, 0.999, 1.001].map(|share| [0, 1, 2].map(|c| hue[c] - share * to_zero * rest[c])));
    }
    all
}

/// Each color, and a step of a thousandth of its largest channel in red, green and blue: no curve turns it by more than
/// a few codes, though all hues of the light end where its luminance does.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn neighbors_among_colors_of_all_gamuts_stay_neighbors() {
    let rings = rings();
    let picture = Picture::new(4 * rings.len() as u32, 65, |x, y| {
        let light = (18.0 * y as f32 / 64.0 - 10.0).exp2();
        let [mut r, mut g, mut b] = rings[x as usize / 4].map(|channel| light * channel);
        let step = 1e-3 * r.max(g).max(b);
        for (at, channel) in [&mut r, &mut g, &mut b].into_iter().enumerate() {
            *channel += if x as usize % 4 == at + 1 { step } else { 0.0 };
        }
        [r, g, b, 1.0]
    });
    let step = |shown: &Picture| {
        let apart = |a: &[f32; 4], b: &[f32; 4]| (0..3).map(|c| 255.0 * (a[c] - b[c]).abs()).fold(0.0, f32::max);
        let steps =
            shown.pixels.chunks_exact(4).map(|p| apart(&p[0], &p[1]).max(apart(&p[0], &p[2])).max(apart(&p[0], &p[3])));
        steps.enumerate().map(|(at, step)| (step, at)).fold((0.0, 0), |a, b| if b.0 > a.0 { b } else { a })
    };
    let mut above = String::new();
    for curve in sweep::some(CURVES, 4) {
        let graph = graph(&tone_map(curve));
        for bake in [Bake::Off, Bake::Size(64)] {
            let (most, at) = step(&shown(&graph, Some(bake), &picture));
            let (ring, stops) = (rings[at % rings.len()], 18.0 * (at / rings.len()) as f32 / 64.0 - 10.0);
            if most > STEP {
                above += &format!("{curve} {bake:?}: {most} codes beside {ring:?} at {stops} stops\n");
            }
        }
    }
    assert!(above.is_empty(), "{above}");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn light_beyond_the_ends_of_a_table_is_that_of_its_ends() {
    let graph = graph(&tone_map(""));
    let picture = extremes();
    let table = shown(&graph, Some(Bake::Size(64)), &picture);
    let exact = shown(&graph, Some(Bake::Off), &picture);
    for ((color, exact), shown) in picture.pixels.iter().zip(&exact.pixels).zip(&table.pixels) {
        assert!(shown[..3].iter().all(|x| (0.0..=1.001).contains(x)) && shown[3] == exact[3], "{color:?}: {shown:?}");
        let is_gray = color[0].is_finite() && color[0] == color[1] && color[1] == color[2];
        let error = (0..3).map(|c| 255.0 * (shown[c] - exact[c]).abs()).fold(0.0, f32::max);
        assert!(!is_gray || error < 0.25, "{color:?}: {shown:?} and not {exact:?}");
    }
    let black = |color: &[f32; 4]| color[..3].iter().all(|x| *x <= 0.0);
    let is_black = |(color, shown): (&[f32; 4], &[f32; 4])| !black(color) || shown[..3] == [0.0; 3];
    assert!(picture.pixels.iter().zip(&table.pixels).all(is_black), "light that is not positive is black");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_run_ends_where_a_node_needs_more_than_a_color() {
    let baked = |nodes: &str, bake: Option<Bake>| {
        let plan = plan(&graph(&pipeline(nodes)), bake);
        assert_eq!(verify(&plan), Ok(()), "{}", plan.to_text());
        let filling = (0..plan.passes.len()).filter(|pass| plan.runs_on_change(*pass)).count();
        assert_eq!(filling, plan.savings.baked.len(), "{}", plan.to_text());
        plan.savings.baked.iter().map(|baked| (baked.nodes.join(" "), baked.size)).collect::<Vec<_>>()
    };
    let run = |nodes: &str, size: u32| vec![(nodes.to_owned(), size)];
    let whole = r#""white": WhiteBalance(source: "in", temperature: 5000.0, mode: Temperature),
        "mapped": ToneMap(source: "white", BAKE), "result": Encode(source: "mapped")"#;
    let asking = |bake: &str| whole.replace("BAKE", bake);
    assert_eq!(baked(&asking("bake: Auto"), None), run("mapped result", 64));
    assert_eq!(baked(&asking("bake: 33"), None), run("mapped result", 33));
    assert_eq!(baked(&asking("bake: 33"), Some(Bake::Size(48))), run("mapped result", 48));
    assert_eq!(baked(&asking(""), Some(Bake::Auto)), run("white mapped result", 64));
    assert_eq!(baked(&asking("bake: Auto"), Some(Bake::Off)), []);
    assert_eq!(baked(&asking(""), None), [], "no node asks for a table");
    let refused = asking("bake: Auto").replace(r#"source: "mapped""#, r#"source: "mapped", bake: Off"#);
    assert_eq!(baked(&refused, None), run("mapped", 64));
    let around = [run("white", 64), run("result", 64)].concat();
    assert_eq!(baked(&asking("bake: Off"), Some(Bake::Auto)), around);
    // A vignette and a dither depend on the position; the result of the curve is read twice.
    let cut = r#""white": WhiteBalance(source: "in", temperature: 5000.0, mode: Temperature),
        "dark": Vignette(source: "white", amount: 0.5), "mapped": ToneMap(source: "dark", bake: 48),
        "encoded": Encode(source: "mapped"), "result": Dither(source: "encoded", bits: 8)"#;
    assert_eq!(baked(cut, None), run("mapped encoded", 48));
    // A `Cdl` moves zero: neither it nor what follows is a function of light.
    let moved = r#""white": WhiteBalance(source: "in", temperature: 5000.0, mode: Temperature, bake: 33),
        "dark": Cdl(source: "white", offset: (-0.1, -0.1, -0.1), bake: 33), "mapped": ToneMap(source: "dark", bake: 33),
        "result": Encode(source: "mapped", bake: 33)"#;
    assert_eq!(baked(moved, None), run("white", 33));
    let twice = r#""mapped": ToneMap(source: "in", bake: 48), "soft": Gaussian(source: "mapped", sigma: 1.0),
        "lit": Composite(base: "mapped", bloom: "soft", blend: Mix, strength: 0.5), "result": Encode(source: "lit")"#;
    assert_eq!(baked(twice, None), run("mapped", 48));
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn an_exact_plan_and_a_small_device_have_no_tables() {
    let graph = graph(&tone_map(""));
    let gpu = gpu();
    assert_eq!(Run::new(&graph).exact().plan(&gpu, &[("in", &gray_ramp())]).savings.baked, []);
    let mut narrow: Gpu = (*gpu).clone();
    // A table of size 64 has 8192 texels a row.
    narrow.caps.max_side = 2048;
    assert_eq!(Run::new(&graph).plan(&narrow, &[("in", &gray_ramp())]).savings.baked, []);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn verify_finds_a_lut_that_is_evaluated_from_the_image() {
    let mut plan = plan(&graph(&tone_map("")), None);
    let lookup = plan.passes.iter().position(|planned| planned.pass.function_result() == Some(plan.outputs[0].image));
    let pixel = plan.passes[lookup.expect("a pass makes the output")].pass.kernels[0].args[0].clone();
    let filling = (0..plan.passes.len()).find(|pass| plan.runs_on_change(*pass)).expect("a pass evaluates the LUT");
    let color = &mut plan.passes[filling].pass.kernels[1].args[0];
    color.value = pixel.value;
    let faults: Vec<String> = verify(&plan).expect_err("it is wrong").iter().map(Fault::to_string).collect();
    assert!(faults.iter().any(|fault| fault.contains("evaluates a LUT from `in`")), "{faults:?}");
}

/// A slider moves: the next frame evaluates the LUT again, with the same plan, and shows what a new executor shows.
/// Frames between do not, and neither does another slider.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_lut_is_evaluated_when_a_number_in_it_has_changed() {
    let _alone = layer::alone();
    layer::messages();
    let text = |white: f32, dark: f32| {
        pipeline(&format!(
            r#""dark": Vignette(source: "in", amount: {dark:?}), "result": Encode(source: "mapped"),
            "mapped": ToneMap(source: "dark", curve: ReinhardExtended, white_level: {white:?}, bake: Auto)"#
        ))
    };
    let colors = colors(3);
    let mut player = Player::new();
    let input = player.upload(&colors);
    let mut filled = Vec::new();
    let changes = [(4.0, 0.5), (4.0, 0.5), (8.0, 0.5), (8.0, 0.5), (8.0, 0.25), (8.0, 0.25), (4.0, 0.5)];
    for (white, dark) in changes {
        let graph = graph(&text(white, dark));
        player.load(&Run::new(&graph), &[("in", &colors)]);
        player.run(&Frame { inputs: &[("in", &input)], ..Frame::default() }).expect("a frame");
        filled.push(player.executor.loaded().is_some_and(LoadedPlan::has_run_on_change));
        let mut other = Player::new();
        other.load(&Run::new(&graph), &[("in", &colors)]);
        other.frame(&[("in", &colors)], 0.0, false);
        assert!(other.executor.loaded().is_some_and(LoadedPlan::has_run_on_change));
        assert!(player.output("out") == other.output("out"), "{white} {dark}");
    }
    assert_eq!(filled, [true, false, true, false, false, false, true]);
    assert_eq!(layer::messages(), Vec::<String>::new());
}

/// What `plan --bake-error` prints is the error that the pictures of nodes and table have.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_table_is_compared_with_its_nodes_on_the_device() {
    let graph = graph(&tone_map("curve: AcesNarkowicz,"));
    let gpu = gpu();
    let gray = Picture::new(16, 16, |_, _| [0.18, 0.18, 0.18, 1.0]);
    let texels = Texels::from_floats(16, 16, &gray.pixels);
    let image = input_image(&gpu, "in", texels.desc, &texels.bytes).expect("it is uploaded");
    let probed = |size: u32| {
        let options = Options { bake: Some(Bake::Size(size)), ..Options::default() };
        let mut session = Session::new(&gpu, graph.clone(), Facts::default(), options);
        let all = faults::lut_errors(&mut session, texels.desc.size, std::slice::from_ref(&image)).expect("it renders");
        let [LutErrors { colors, grays }] = all.as_slice() else { panic!("one table and not {}", all.len()) };
        assert_eq!((colors.each_ref().map(Vec::len), grays.len()), ([1 << 18; 4], 1 << 16));
        // The published curve, with light at which middle gray is that of the others; and a ramp without a fall.
        let curve = |at: usize| {
            let x = 0.726 * (22.0 * at as f32 / 65536.0 - 14.0).exp2();
            let shown = (x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14)).clamp(0.0, 1.0);
            if shown <= 0.0031308 { 12.92 * shown } else { 1.055 * shown.powf(1.0 / 2.4) - 0.055 }
        };
        for (at, [exact, shown]) in grays.iter().enumerate().step_by(997) {
            assert!((exact - curve(at)).abs() < 2e-3, "gray {at}: {exact} and not {}", curve(at));
            assert!((exact - shown).abs() < 0.3 / 255.0, "gray {at}: {shown} and not {exact}");
        }
        assert!(grays.windows(2).all(|pair| pair[1][1] > pair[0][1] - 1e-6), "{size}: a ramp falls");
        [0, 3].map(|gamut: usize| shares(&colors[gamut]).map(|error| 255.0 * error))
    };
    for size in [33, 64] {
        for (found, picture) in probed(size).into_iter().zip([colors(12), wide(12)]) {
            let [exact, table] = [Bake::Off, Bake::Size(size)].map(|bake| shown(&graph, Some(bake), &picture));
            let seen = shares(&errors(&exact, &table));
            assert!((0..2).all(|i| (found[i] / seen[i] - 1.0).abs() < 0.25), "{size}: {found:?} and {seen:?}");
        }
    }
    let mut exact = Session::new(&gpu, graph.clone(), Facts::default(), Options { exact: true, ..Options::default() });
    assert!(
        faults::lut_errors(&mut exact, texels.desc.size, std::slice::from_ref(&image)).expect("it renders").is_empty()
    );
}

/// The parts of random chains: what they take, and what they give.
const PARTS: [(&str, &str, &str); 13] = [
    ("Exposed", "Exposed", "WhiteBalance(mode: Temperature, temperature: 5200.0,"),
    ("Exposed", "Exposed", "Saturation(amount: 1.3,"),
    ("Exposed", "Exposed", "Contrast(amount: 1.1,"),
    ("Exposed", "Display", "ToneMap(curve: AcesNarkowicz,"),
    ("Exposed", "Display", "ToneMap(curve: AgX,"),
    ("Exposed", "Display", "ToneMap(curve: Reinhard,"),
    ("Display", "Display", "LiftGammaGain(gamma: (1.1, 1.0, 0.95),"),
    ("Display", "Display", "Saturation(amount: 0.8,"),
    ("Display", "Display", "Fade(meter: \"meter\", bake: 33,"),
    ("Exposed", "Exposed", "Cdl(slope: (1.6, 0.6, 0.8), offset: (-0.08, -0.18, -0.13),"),
    ("Display", "Encoded", "Encode("),
    ("Encoded", "Encoded", "Brightness(amount: 0.02,"),
    ("Encoded", "Encoded", "ColorBalance(midtones: (0.02, 0.0, -0.02),"),
];

/// Nodes from exposed light to a signal, at random.
fn chain(seed: u64) -> String {
    let mut rng = Rng::new(seed);
    let (mut state, mut before, mut nodes) = ("Exposed", "in".to_owned(), String::new());
    for number in 0..12 {
        let fitting: Vec<_> = PARTS.iter().filter(|(takes, ..)| *takes == state).collect();
        let (_, gives, text) = fitting[rng.below(fitting.len())];
        // What stands before the curve is not asked for.
        let bake = if *gives == "Exposed" || text.contains("bake") { "" } else { "bake: Auto" };
        nodes += &format!("\"node{number}\": {text} source: \"{before}\", {bake}), ");
        (state, before) = (gives, format!("node{number}"));
        if state == "Encoded" && rng.per_cent(50) {
            break;
        }
    }
    for (from, to, text) in [("Exposed", "Display", "ToneMap("), ("Display", "Encoded", "Encode(")] {
        if state == from {
            nodes += &format!("\"{to}\": {text} source: \"{before}\", bake: Auto), ");
            (state, before) = (to, to.to_owned());
        }
    }
    nodes
        + &format!(
            r#""result": Brightness(source: "{before}", amount: 0.001, format: Rgba32Float, bake: Auto),
        "bins": Histogram(source: "in"), "meter": AutoExposure(histogram: "bins")"#
        )
}

/// Sizes of tables, and the errors that 99 and 99.9 % of random colors stay below in a random chain, in codes of 255.
const SIZES: [(u32, [f32; 2]); 3] = [(64, [0.8, 3.5]), (48, [1.3, 5.0]), (33, [2.5, 10.0])];

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn random_chains_with_and_without_a_table_agree() {
    let fade = kind(FADE, ("fade.wgsl", FADE_SHADER));
    let mut metered = 0;
    for seed in 0..16 {
        let text = pipeline(&chain(seed));
        let graph = graph_with(&text, std::slice::from_ref(&fade));
        let baked = plan(&graph, None).savings.baked;
        let is_metered = baked.iter().any(|baked| baked.in_every_frame);
        assert_eq!(baked.len(), usize::from(!text.contains("Cdl")), "{text}");
        assert_eq!(is_metered, !baked.is_empty() && text.contains("Fade"), "{text}");
        metered += usize::from(is_metered);
        let (colors, extremes) = (colors(100 + seed), extremes());
        let [exact, at_ends] = [&colors, &extremes].map(|picture| shown(&graph, Some(Bake::Off), picture));
        let numbers = || exact.pixels.iter().chain(&at_ends.pixels).flat_map(|pixel| &pixel[..3]).copied();
        let (least, most) = (numbers().fold(f32::INFINITY, f32::min), numbers().fold(0.0, f32::max));
        for (size, limits) in sweep::some(SIZES.iter().cycle().skip(seed as usize % 3).take(3), 1) {
            let table = |picture: &Picture| shown(&graph, Some(Bake::Size(*size)), picture);
            let found = shares(&errors(&exact, &table(&colors)));
            assert!(found[0] < limits[0] && found[1] < limits[1], "{size}: {found:?} of {text}");
            // A channel that a larger one exceeds by more than a table divides may be off, but is no other number.
            for ((color, exact), shown) in extremes.pixels.iter().zip(&at_ends.pixels).zip(&table(&extremes).pixels) {
                let is_known = shown[..3].iter().all(|x| (least - 0.02..=most + 0.02).contains(x));
                assert!(is_known && shown[3] == exact[3], "{size}: {color:?} is {shown:?} and not {exact:?} in {text}");
                let is_gray = color[0].is_finite() && color[0] == color[1] && color[1] == color[2];
                let error = (0..3).map(|c| 255.0 * (shown[c] - exact[c]).abs()).fold(0.0, f32::max);
                assert!(!is_gray || error < 0.5, "{size}: {color:?} is {shown:?} and not {exact:?} in {text}");
            }
        }
    }
    assert!(metered > 1, "{metered}");
}

/// Fades an image toward gray by an exposure that the device knows.
const FADE: &str = r#"Kind(
    name: "Fade", doc: "Fades an image toward gray where it is dark.", of_color: true,
    inputs: {
        "source": Image(doc: "An image.", accepts: [Exposed, DisplayLinear]),
        "meter": Value(doc: "Stops.", content: "exposure"),
    },
    outputs: { "result": Image(doc: "The image.", state: Same("source")) },
)"#;
const FADE_SHADER: &str = "fn fade(source: vec4f, meter: f32) -> vec4f {
    let gray = max(dot(source.rgb, vec3f(0.2126, 0.7152, 0.0722)), 0.0);
    return vec4f(mix(source.rgb, vec3f(gray), 0.4 / (1.0 + exp2(meter))), source.a);
}";

fn kind(declaration: &str, shader: (&str, &str)) -> NodeKind {
    folder_kind_of(("node.ron", declaration), &[shader]).unwrap_or_else(|errors| panic!("{errors}"))
}

/// The light changes, and what a meter has of it changes in the frames after: a table with a meter in it is that of
/// each frame. It is filled in the turns of what is held, and the frames may be recorded before one is submitted.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_table_with_a_meter_in_it_is_that_of_the_frame() {
    let fade = kind(FADE, ("fade.wgsl", FADE_SHADER));
    let colors = colors(21);
    let lights = [1.0, 16.0, 16.0, 16.0, 0.05, 0.05, 0.05, 0.05, 0.05];
    let pictures = lights.map(|light| {
        let at = |pixel: [f32; 4]| [light * pixel[0], light * pixel[1], light * pixel[2], pixel[3]];
        Picture { pixels: colors.pixels.iter().copied().map(at).collect(), ..colors.clone() }
    });
    for (bins, result) in [("", ""), ("every: 2", ""), ("", "every: 3")] {
        let text = pipeline(&format!(
            r#""bins": Histogram(source: "in", {bins}), "meter": AutoExposure(histogram: "bins"),
            "dim": Fade(source: "in", meter: "meter", bake: 48), "mapped": ToneMap(source: "dim", bake: Auto),
            "faded": Fade(source: "mapped", meter: "meter", bake: 33),
            "result": Encode(source: "faded", format: Rgba32Float, {result})"#
        ));
        let graph = graph_with(&text, std::slice::from_ref(&fade));
        // Each frame alone, and two recorded before they are submitted.
        let frames = |bake: Option<Bake>, recorded: usize| {
            let mut player = Player::new();
            let mut run = Run::new(&graph);
            run.options.bake = bake;
            let plan = player.load(&run, &[("in", &pictures[0])]);
            assert_eq!(verify(&plan), Ok(()));
            let found: Vec<_> = plan.savings.baked.iter().map(|baked| (baked.size, baked.in_every_frame)).collect();
            assert_eq!(found, if bake.is_none() { vec![(48, true)] } else { vec![] }, "{}", plan.to_text());
            let mut shown = Vec::new();
            for pictures in pictures.chunks(recorded) {
                let mut encoder = player.gpu.device.create_command_encoder(&Default::default());
                for picture in pictures {
                    let view = player.upload(picture);
                    let frame = Frame { inputs: &[("in", &view)], dt: 0.3, ..Frame::default() };
                    player.executor.encode(&mut encoder, &frame).expect("a frame");
                }
                player.gpu.queue.submit([encoder.finish()]);
                shown.push(player.output("out"));
            }
            assert!(!player.executor.loaded().is_some_and(LoadedPlan::has_run_on_change), "no LUT outlives a frame");
            shown
        };
        let (exact, tables, by_threes) = (frames(Some(Bake::Off), 1), frames(None, 1), frames(None, 3));
        for (at, (exact, table)) in exact.iter().zip(&tables).enumerate() {
            let found = shares(&errors(exact, table));
            assert!(found[0] < 1.5 && found[1] < 3.0 && found[0] > 1e-3, "{bins} {result} {at}: {found:?}");
        }
        assert!(by_threes.iter().zip(tables.iter().skip(2).step_by(3)).all(|(a, b)| a == b), "{bins} {result}");
        // The light stays, the meter moves: the table of the frame before would be seen.
        if result.is_empty() {
            let moved = shares(&errors(&exact[5], &exact[8]))[0];
            assert!(moved > 3.0, "{bins}: {moved}");
        }
    }
}

/// All triples of what a picture may hold besides colors.
fn extremes() -> Picture {
    let numbers = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -65504.0, -1.0, -1e-6, 0.0, 1e-7, 1.0, 65504.0, 3e38];
    let of = |at: u32| numbers[at as usize % numbers.len()];
    Picture::new(121, 11, |x, y| [of(x / 11), of(x), of(y), 0.5])
}

const KIND: &str = r#"Kind(
    name: "Tint", doc: "Tints an image.", of_color: true,
    inputs: { "source": Image(doc: "An image.", accepts: [DisplayLinear]) },
    outputs: { "result": Image(doc: "The image.", state: Same("source")) },
    parameters: { "amount": Float(doc: "How much.", default: 0.5, within: (0.0, 1.0)) },
)"#;
const SHADER: &str = "struct Tint { amount: f32 }
fn tint(source: vec4f, params: Tint) -> vec4f {
    return vec4f(mix(source.rgb, source.gbr, params.amount * 0.1), source.a);
}";

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_kind_in_a_folder_is_part_of_a_run_if_it_says_so() {
    let text = pipeline(&format!(
        r#""before": ToneMap(source: "in", bake: Auto), "mapped": Tint(source: "before"), {ENCODE}"#
    ));
    let [says_so, does_not] = [KIND.to_owned(), KIND.replace(" of_color: true,", "")];
    let with = graph_with(&text, &[kind(&says_so, ("tint.wgsl", SHADER))]);
    let nodes =
        |graph: &Graph| plan(graph, None).savings.baked.iter().map(|baked| baked.nodes.join(" ")).collect::<Vec<_>>();
    assert_eq!(nodes(&with), ["before mapped result"]);
    assert_eq!(nodes(&graph_with(&text, &[kind(&does_not, ("tint.wgsl", SHADER))])), ["before"]);
    let colors = colors(5);
    let [exact, table] = [Some(Bake::Off), None].map(|bake| shown(&with, bake, &colors));
    let found = shares(&errors(&exact, &table));
    assert!(found[0] < 0.5 && found[1] < 1.0 && found[0] > 1e-3, "{found:?}");
}
