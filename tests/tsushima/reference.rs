//! The whole chain against its CPU references, with the numbers that the pipeline's file has.

use afterimage_graph::check::Graph;
use afterimage_graph::node::Bake;
use afterimage_graph::value::Value;
use afterimage_media::{Source, read};

use super::scene;
use crate::reference::bloom::{composite_add, knee_weight, levels, smoothed, weighted_chain};
use crate::reference::color::{BRADFORD, CUSTOM, REC709, conversion, white_balance_target};
use crate::reference::curves::{Uchimura, matched_scale, uchimura, whitened};
use crate::reference::exposure::{Bins, auto_exposure_stops, limit_mean};
use crate::reference::gaussian::{blur_axis, radius, taps};
use crate::reference::grade::LiftGammaGain;
use crate::reference::image::{Image, center_uv, rgb};
use crate::reference::local::{Grid, LocalToneMap, Range, Splat};
use crate::reference::math::{Rgb, largest, transform};
use crate::reference::oklab::{fitted, with_hue};
use crate::reference::purkinje::{full, strength_log};
use crate::reference::resample::{Down, Firefly, Up, area_average, upsample};
use crate::reference::sanitize::{MAX_HALF, extended, sanitized};
use crate::reference::transfer::srgb_encode;
use crate::reference::vignette;
use crate::support::gpu::{Picture, Run, changed};
use crate::support::harness::image;

/// The pipeline without its dither, whose noise no CPU reference has, and with changes.
pub(super) fn undithered(sets: &[(&str, &str)]) -> Graph {
    let sets: Vec<_> = sets.iter().copied().chain([("display", "Off")]).collect();
    changed(super::PIPELINE, None, &sets)
}

/// The parameters of a node.
struct Node<'g>(&'g Graph, &'static str);

impl Node<'_> {
    fn value(&self, parameter: &str) -> &Value {
        let Self(graph, name) = self;
        let (_, node) = graph.node(name).unwrap_or_else(|| panic!("there is a node `{name}`"));
        node.instance.value(parameter).unwrap_or_else(|| panic!("`{name}` has `{parameter}`"))
    }

    fn number(&self, parameter: &str) -> f64 {
        match self.value(parameter) {
            Value::Float(number) => *number,
            Value::Int(number) => *number as f64,
            other => panic!("{other:?} is no number"),
        }
    }

    fn whole(&self, parameter: &str) -> usize {
        self.number(parameter) as usize
    }

    fn triple(&self, parameter: &str) -> [f64; 3] {
        match self.value(parameter) {
            Value::Vector([x, y, z, _], _) => [*x, *y, *z],
            other => panic!("{other:?} is no vector"),
        }
    }

    fn range(&self) -> Range {
        Range { low: self.number("lo"), high: self.number("hi") }
    }
}

/// What the pipeline makes of a picture, step by step.
fn whole(graph: &Graph, picture: &Picture) -> Image {
    let scene = sanitized(&image(picture));
    let exposed = exposed(graph, &scene);
    let seen = seen(graph, &exposed);
    let local = local(graph, &exposed, &seen, contrast(graph, &scene));
    let white = lit(graph, &seen, &local).map_rgb(|color| balanced(graph, color));
    let mapped = vignetted(graph, &white).map_rgb(|color| graded(graph, color));
    mapped.map_rgb(|color| color.map(|x| srgb_encode(x.clamp(0.0, 1.0))))
}

fn bins(graph: &Graph) -> Bins {
    let counted = Node(graph, "counted");
    let Range { low, high } = counted.range();
    Bins { count: counted.whole("bins"), low, high, black: counted.number("black") }
}

/// The contrast between regions that the range of the scene leaves.
fn contrast(graph: &Graph, scene: &Image) -> f64 {
    let (metered, local, bins) = (Node(graph, "metered"), Node(graph, "local"), bins(graph));
    let counts = bins.histogram(scene);
    let [dark, bright] = ["dark", "bright"].map(|share| bins.around(&counts, metered.number(share)));
    (local.number("span") / (bright - dark)).clamp(local.number("contrast"), 1.0)
}

fn exposed(graph: &Graph, scene: &Image) -> Image {
    let (metered, bins) = (Node(graph, "metered"), bins(graph));
    let mean = bins.trimmed_mean(&bins.histogram(scene), metered.number("low"), metered.number("high"));
    let limited =
        limit_mean(mean.expect("the picture is not black"), metered.number("min_ev"), metered.number("max_ev"));
    let gain = auto_exposure_stops(limited, metered.number("key"), metered.number("compensation")).exp2();
    scene.map_rgb(|color| color.map(|x| (x * gain).clamp(-MAX_HALF, MAX_HALF)))
}

fn seen(graph: &Graph, exposed: &Image) -> Image {
    let night = strength_log(Node(graph, "seen").number("illuminance"));
    let scale = Node(graph, "seen").number("scale");
    exposed.map_rgb(|color| if night > 0.0 { full(color, night, scale) } else { color })
}

/// What is bright around a place is judged before night vision, as the pipeline has it.
fn local(graph: &Graph, exposed: &Image, seen: &Image, contrast: f64) -> Image {
    let (build, blur, around) = (Node(graph, "grid"), Node(graph, "smooth"), Node(graph, "around"));
    let size = ["width", "height", "depth"].map(|side| build.whole(side));
    let sigmas = blur.triple("sigma");
    let grid = Grid::build(exposed, size, build.range(), Splat::Nearest)
        .blurred(sigmas, sigmas.map(radius))
        .sloped(blur.number("slope"));
    let [width, height] = ["width", "height"].map(|side| around.whole(side));
    let range = around.range();
    let logs = exposed.map(|pixel| [range.log_luminance(rgb(pixel)); 4]);
    let aspect = seen.width as f64 / seen.height as f64;
    let sigma = around.number("sigma");
    let [across, down] = [sigma * width as f64, sigma * height as f64 * aspect].map(|sigma| taps(sigma, radius(sigma)));
    let wide = blur_axis(&blur_axis(&area_average(&logs, [width, height]), &across, [1, 0]), &down, [0, 1]);
    let node = Node(graph, "local");
    let [bilateral, middle, detail] = ["share", "midpoint", "detail"].map(|parameter| node.number(parameter));
    LocalToneMap { bilateral, middle, contrast, detail }.apply(seen, &grid, &wide)
}

fn lit(graph: &Graph, seen: &Image, local: &Image) -> Image {
    let node = Node(graph, "bright");
    let (threshold, knee) = (node.number("threshold"), node.number("knee"));
    // In the first frame, no light counts as a firefly.
    let bright = seen.map_rgb(|color| {
        let weight = knee_weight(largest(color), threshold, knee);
        color.map(|x| (x * weight).min(MAX_HALF))
    });
    let bloom = glow(&bright, Node(graph, "mips"), Node(graph, "bloom").number("radius"));
    let node = Node(graph, "lit");
    let size = [seen.width, seen.height];
    let bloom = upsample(&smoothed(&bloom), size, Up::Bilinear, 1.0);
    let strength = node.number("strength");
    Image::new(seen.width, seen.height, |x, y| {
        let [base, glow] = [local, &bloom].map(|image| image.texel(x as i64, y as i64));
        let [r, g, b] = composite_add(rgb(base), rgb(glow), strength).map(|x| x.min(MAX_HALF));
        [r, g, b, base[3]]
    })
}

/// Each level of a frame of `lines` gives its weight to the two of the same width in this one, or to the finest.
fn glow(bright: &Image, mips: Node<'_>, radius: f64) -> Image {
    let (count, lines) = (mips.whole("levels"), mips.number("lines"));
    let place = |level: usize| level as f64 + (bright.height as f64 / lines).log2();
    let largest = bright.width.max(bright.height).ilog2() as usize;
    let count_here = ((place(count - 1).ceil() + 1.0).max(1.0) as usize).min(largest.max(1));
    let mut weights = vec![0.0; count_here];
    for level in 0..count {
        let place = place(level).clamp(0.0, count_here as f64 - 1.0);
        let (finer, coarser) = (place.floor() as usize, place.ceil() as usize);
        // Widths of 1 and 2, of which the mean square is that of the width between them.
        let share = (place.fract().exp2().powi(2) - 1.0) / 3.0;
        weights[finer] += (1.0 - share) / count as f64;
        weights[coarser] += share / count as f64;
    }
    weighted_chain(&levels(bright, count_here, Down::Binomial, Firefly::Off), &weights, Up::Tent, radius)
}

fn balanced(graph: &Graph, color: Rgb) -> Rgb {
    let balance = white_balance_target(&BRADFORD, Node(graph, "white").triple("target"), true);
    extended(transform(&balance, color))
}

fn graded(graph: &Graph, color: Rgb) -> Rgb {
    let node = Node(graph, "mapped");
    let [maximum, contrast, start, length, toe, pedestal] =
        ["maximum", "contrast", "linear_start", "linear_length", "toe", "pedestal"].map(|name| node.number(name));
    let curve = Uchimura { maximum, contrast, start, length, toe, pedestal };
    let scale = matched_scale(|x| uchimura(x, &curve));
    let light = whitened(transform(&conversion(&REC709, &CUSTOM), color).map(|x| scale * x), 1.0);
    let inside = light.map(|x| uchimura(x, &curve));
    let mapped = with_hue(transform(&conversion(&CUSTOM, &REC709), inside), color);
    let mapped = fitted(mapped, 1.0, node.number("gamut_knee"));
    let node = Node(graph, "graded");
    let [lift, gamma, gain] = ["lift", "gamma", "gain"].map(|name| node.triple(name));
    LiftGammaGain { lift, gamma, gain }.apply(mapped)
}

fn vignetted(graph: &Graph, exposed: &Image) -> Image {
    let node = Node(graph, "vignette");
    let [amount, intensity, smoothness] = ["amount", "intensity", "smoothness"].map(|name| node.number(name));
    let (width, height) = (exposed.width, exposed.height);
    Image::new(width, height, |x, y| {
        let factor = vignette::factor(center_uv(x, y, width, height), intensity, smoothness, 1.0);
        let light = vignette::blended(factor, amount);
        let [r, g, b, a] = exposed.texel(x as i64, y as i64);
        [r * light, g * light, b * light, a]
    })
}

/// The largest difference of a display number from the reference's, and the pixel that has it.
fn off(picture: &Picture, reference: &Image) -> (f64, String) {
    let worst = |(index, (a, b)): (usize, (&[f32; 4], &[f64; 4]))| {
        let off = (0..3).map(|c| (f64::from(a[c]) - b[c]).abs()).fold(0.0, f64::max);
        (off, format!("({}, {}): {a:?} and {b:?}", index % reference.width, index / reference.width))
    };
    let pairs = picture.pixels.iter().zip(&reference.pixels).enumerate().map(worst);
    pairs.max_by(|a, b| a.0.total_cmp(&b.0)).expect("the picture has pixels")
}

const ONE_CODE: f64 = 1.0 / 255.0;

/// Each stage that the file leaves at its neutral values, and then all of them.
const CASES: [&[(&str, &str)]; 5] = [
    &[],
    &[("seen.illuminance", "0.4")],
    &[("white.target", "(0.86, 0.95, 1.0)")],
    &[("graded.lift", "(0.01, 0.0, 0.02)"), ("graded.gamma", "(1.1, 1.0, 0.95)"), ("graded.gain", "(0.97, 1.0, 1.03)")],
    &[
        ("seen.illuminance", "0.02"),
        ("white.target", "(0.86, 0.95, 1.0)"),
        ("graded.lift", "(0.01, 0.0, 0.02)"),
        ("graded.gamma", "(1.1, 1.0, 0.95)"),
        ("graded.gain", "(0.97, 1.0, 1.03)"),
    ],
];

/// By how many codes pictures are off at most.
fn assert_are_their_references(pictures: &[(String, Picture)]) -> f64 {
    let mut worst = 0.0;
    let shown: Vec<&Picture> = pictures.iter().map(|named| &named.1).collect();
    for sets in CASES {
        let graph = undithered(sets);
        let references: Vec<Image> = shown.iter().map(|picture| whole(&graph, picture)).collect();
        let mut without_table = Run::new(&graph);
        without_table.options.bake = Some(Bake::Off);
        for (run, limit) in [(Run::new(&graph).exact(), 0.5), (without_table, 1.0)] {
            for (at, made) in run.shown(&shown).iter().enumerate() {
                let (off, place) = off(made, &references[at]);
                let what = &pictures[at].0;
                assert!(off < limit * ONE_CODE, "{what}, {sets:?}: {:.3} codes off at {place}", 255.0 * off);
                worst = f64::max(worst, 255.0 * off);
            }
        }
    }
    worst
}

/// Sixteen stops of gradients and edges in all colors, with a lamp, black, and numbers that are sanitized.
fn synthetic(width: u32, height: u32) -> Picture {
    Picture::new(width, height, |x, y| {
        let (u, v) = (f64::from(x) / f64::from(width), f64::from(y) / f64::from(height));
        let window = if u > 0.6 && v < 0.55 { 6.0 } else { 0.0 };
        let light =
            (-6.0 + 3.0 * u + 1.5 * (7.0 * v).sin() + window + 0.3 * (50.0 * u).sin() * (37.0 * v).cos()).exp2();
        let hue = [0.0, 2.1, 4.2].map(|phase| (light * (1.0 + 0.6 * (9.0 * u + 4.0 * v + phase).cos())) as f32);
        match (x, y) {
            (30, 20) => [900.0, 400.0, 90.0, 1.0],
            (31, 70) => [0.0, 0.0, 0.0, 1.0],
            (90, 12) => [f32::NAN, -3.0, f32::INFINITY, 1.0],
            _ => [hue[0], hue[1], hue[2], 1.0],
        }
    })
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_pipeline_equals_its_cpu_reference_on_a_synthetic_picture() {
    let sizes = [(131, 77), (1, 1)];
    assert_are_their_references(&sizes.map(|(width, height)| (format!("{width}x{height}"), synthetic(width, height))));
}

/// A part of the built-in scene as a large picture of it has it.
fn cut_out(walk: f64, left: u32, top: u32) -> Picture {
    let all = scene(640, 360, walk);
    Picture::new(160, 90, |x, y| all.at(left + x, top + y))
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_pipeline_equals_its_cpu_reference_on_the_built_in_scene() {
    assert_are_their_references(&[
        ("the room".into(), scene(160, 90, 0.0)),
        ("the window".into(), scene(160, 90, 1.0)),
        ("where the window meets the room".into(), cut_out(0.0, 240, 90)),
        ("a corner".into(), cut_out(0.5, 20, 200)),
    ]);
}

/// Files named in `AFTERIMAGE_PICTURES`, divided as `PATH` is: for pictures that the repository does not carry.
/// `--nocapture` shows the figures.
#[test]
#[expect(clippy::print_stdout, reason = "the figures are what somebody who names pictures wants to know")]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_pipeline_equals_its_cpu_reference_on_pictures_of_your_own() {
    for path in std::env::var_os("AFTERIMAGE_PICTURES").iter().flat_map(std::env::split_paths) {
        let file = read(&Source::file(&path)).unwrap_or_else(|error| panic!("{error}"));
        let numbers = file.pixels.to_f32();
        let pixels = numbers.chunks_exact(4).map(|pixel| [pixel[0], pixel[1], pixel[2], pixel[3]]).collect();
        let picture = Picture { width: file.width, height: file.height, pixels };
        let worst = assert_are_their_references(&[(path.display().to_string(), picture)]);
        println!("{}: at most {worst:.3} of 255 codes off", path.display());
    }
}
