//! Cameras of files, with numbers and matrices that no camera has, for a folder kind and a built-in one; and the kind and
//! the pipeline with changes.

use afterimage_generators::{Rng, mutated};

use crate::case::Case;
use crate::classes::Sources;
use crate::frames;

/// A kind that reads a camera, its shader, and a pipeline with two cameras.
const TEXTS: [&str; 3] = [
    r#"Kind(name: "Haze", doc: "Fog.",
    inputs: {
        "source": Image(doc: "Light."),
        "depth": Image(doc: "Depth.", accepts: [Data]),
        "camera": Camera(doc: "The camera."),
    },
    outputs: { "result": Image(doc: "Light.", state: Same("source")) })"#,
    "import afterimage::camera::{Camera, camera_distance, camera_position, camera_previous_uv, camera_world};
fn haze(source: vec4f, depth: texture_2d<f32>, camera: Camera, at: Point) -> vec4f {
    let far = camera_distance(camera, at.uv, texel(depth, at.pixel).x);
    let seen = camera_previous_uv(camera, camera_world(camera, camera_position(camera, at.uv, far)));
    return source * exp(-far) + vec4f(seen, camera.jitter.x);
}",
    r#"Pipeline(inputs: { "scene": Color, "depth": Depth, "camera": Camera, "light": Camera(optional: true) },
    nodes: {
        "a": Haze(source: "scene", depth: "depth", camera: "camera"),
        "b": Haze(source: "a", depth: "depth", camera: "light"),
        "far": LinearDepth(depth: "depth", camera: "camera"),
    },
    outputs: { "out": "b", "far": "far" })"#,
];
/// Additions to the texts.
const OTHERS: [&str; 12] =
    ["(", ")", "{", "\"", ":", "Camera", "camera", "Image", "light", "optional", "0", "import afterimage::camera;"];

/// Numbers of a file, some of which are none.
const NUMBERS: [&str; 18] = [
    "0", "-0", "1", "-1", "0.1", "1e-45", "1e-7", "1e30", "-1e30", "3.4e38", "-3.4e38", "1e39", "1e999", "NaN", "null",
    "\"1\"", "[]", "1e-400",
];

/// Most cases have a camera of hostile numbers; every fourth has a change of one of the texts instead.
pub(crate) fn case(sources: &Sources, number: u64) -> Case {
    let seed = sources.seed << 32 | number;
    let (mut rng, changed) = (Rng::new(seed), number % 12 / 4);
    let texts = [0, 1, 2].map(|at| match number.is_multiple_of(4) && changed == at {
        true => mutated(TEXTS[at as usize], seed, &OTHERS),
        false => TEXTS[at as usize].to_owned(),
    });
    let [declaration, shader, pipeline] = texts;
    let of_light = if rng.below(2) == 0 { " --input light=light.json" } else { "" };
    let line = "render p.ron scene.exr --input depth=depth.exr --input camera=camera.json";
    Case::new(&format!("{line}{of_light} --output out=out.exr --output far=far.exr --nodes haze"))
        .with("p.ron", pipeline)
        .with("haze/node.ron", declaration)
        .with("haze/haze.wgsl", shader)
        .with("camera.json", file(&mut rng, number.is_multiple_of(4)))
        .with("light.json", file(&mut rng, number.is_multiple_of(2)))
        .with("scene.exr", frames::image(&mut rng))
        .with("depth.exr", frames::image(&mut rng))
}

const TAME: [&str; 2] = [
    "[[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, -3], [0, 0, 0, 1]]",
    "[[1, 0, 0, 0], [0, 2, 0, 0], [0, 0, 0, 0.1], [0, 0, -1, 0]]",
];

/// The text of a camera.
fn file(rng: &mut Rng, is_tame: bool) -> String {
    let [view, projection] = match is_tame || rng.below(4) == 0 {
        true => TAME.map(str::to_owned),
        false => [(); 2].map(|()| matrix(rng)),
    };
    let pair = |rng: &mut Rng| format!("[{}, {}]", NUMBERS[rng.below(13)], NUMBERS[rng.below(13)]);
    let more = match rng.below(6) {
        0 => format!(", \"previous_view\": {}, \"previous_projection\": {}", matrix(rng), matrix(rng)),
        1 => format!(", \"jitter\": {}, \"previous_jitter\": {}", pair(rng), pair(rng)),
        2 if !is_tame => format!(", \"more\": {}", "[".repeat(1 << rng.below(20))),
        3 if !is_tame => ", \"view\": 1".to_owned(),
        _ => String::new(),
    };
    let whole = format!("{{ \"view\": {view}, \"projection\": {projection}{more} }}");
    match rng.below(20) {
        0 if !is_tame => whole[..rng.below(whole.len())].to_owned(),
        1 if !is_tame => mutated(&whole, rng.below(1 << 20) as u64, &["[", "]", "{", ",", ":", "1", "\"", "-"]),
        2 if !is_tame => whole + &" ".repeat(1 << 21),
        _ => whole,
    }
}

/// Rows of numbers: all equal, with a row twice, with a few hostile numbers, or of any.
fn matrix(rng: &mut Rng) -> String {
    let (known, way) = ([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1], rng.below(5));
    let (one, most) = (NUMBERS[rng.below(13)], if rng.below(3) == 0 { NUMBERS.len() } else { 11 });
    let mut numbers: Vec<String> = known.map(|number: i32| number.to_string()).into();
    for (at, number) in numbers.iter_mut().enumerate() {
        match way {
            0 => *number = one.to_owned(),
            1 => *number = known[at % 4 + 4 * (at / 8)].to_string(),
            2 if rng.below(6) == 0 => *number = NUMBERS[rng.below(most)].to_owned(),
            3 => *number = NUMBERS[rng.below(most)].to_owned(),
            _ => {}
        }
    }
    let rows: Vec<String> = numbers.chunks(4).map(|row| format!("[{}]", row.join(", "))).collect();
    let count = if rng.below(30) == 0 { 3 } else { 4 };
    format!("[{}]", rows[..count].join(", "))
}
