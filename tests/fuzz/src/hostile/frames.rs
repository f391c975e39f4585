//! Frames with hostile numbers in every image, for each built-in kind that reads images alone: colors, depth and motion
//! that are not finite, huge, tiny, negative or zero.

use afterimage_generators::Rng;
use afterimage_graph::image::ColorState;
use afterimage_graph::node::{NodeKind, PortType};
use afterimage_media::{Encoding, Picture, Pixels, encode};

use crate::case::Case;
use crate::classes::Sources;

const SIDE: usize = 16;
/// Frames for each kind.
const FRAMES: u64 = 12;

const NUMBERS: [f32; 14] = [
    f32::NAN,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::MAX,
    f32::MIN,
    65504.0,
    -65504.0,
    1e-45,
    -0.0,
    0.0,
    1.0,
    -1.0,
    0.5,
    1e20,
];

/// The kinds whose inputs are images, and whose result is one.
fn kinds() -> Vec<&'static NodeKind> {
    let is_image = |kind: &&NodeKind| {
        kind.outputs()[0].ty == PortType::Image
            && kind.inputs().iter().any(|input| input.ty == PortType::Image)
            && kind.inputs().iter().all(|input| input.ty == PortType::Image || input.optional)
    };
    afterimage_nodes::ALL.iter().filter(is_image).collect()
}

pub(crate) fn cases() -> u64 {
    kinds().len() as u64 * FRAMES
}

pub(crate) fn case(sources: &Sources, number: u64) -> Case {
    let (kinds, mut rng) = (kinds(), Rng::new(sources.seed << 32 | number));
    let kind = kinds[number as usize % kinds.len()];
    let images: Vec<_> = kind.inputs().iter().filter(|input| input.ty == PortType::Image).collect();
    let state = |states: &[ColorState]| states.first().map_or("Color", |state| state.name());
    let declared: Vec<String> =
        images.iter().map(|input| format!("\"{}\": {}", input.name, state(&input.states))).collect();
    let mut fields: Vec<String> = images.iter().map(|input| format!("{0}: \"{0}\"", input.name)).collect();
    for param in kind.params() {
        let (is_set, is_low) = (rng.below(if param.replan { 3 } else { 9 }) == 0, rng.below(2) == 0);
        let extreme = if is_low { param.lowest() } else { param.highest() };
        fields.extend(extreme.filter(|_| is_set).map(|value| format!("{}: {value}", param.name)));
    }
    let text = format!(
        "Pipeline(inputs: {{ {} }}, nodes: {{ \"a\": {}({}) }}, outputs: {{ \"out\": \"a\" }})",
        declared.join(", "),
        kind.name(),
        fields.join(", ")
    );
    let is_encoded = images.first().is_some_and(|input| state(&input.states) == "Encoded");
    let mut case = Case::new("render p.ron").with("p.ron", text);
    for input in images {
        case = case.word("--input").word(format!("{0}={0}.exr", input.name));
        case = case.with(&format!("{}.exr", input.name), image(&mut rng));
    }
    case.word("-o").word(if is_encoded || kind.name() == "Encode" { "out.png" } else { "out.exr" })
}

/// An image all of one number, of any, or of ordinary ones with a few others.
pub(crate) fn image(rng: &mut Rng) -> Vec<u8> {
    let (one, share) = (NUMBERS[rng.below(NUMBERS.len())], [2, 40, 100][rng.below(3)]);
    let is_even = rng.below(4) == 0;
    let number = |at: usize| match (is_even, rng.per_cent(share)) {
        (true, _) => one,
        (false, true) => NUMBERS[rng.below(NUMBERS.len())],
        (false, false) => (at * 37 % 251) as f32 * 0.03,
    };
    let numbers = (0..SIDE * SIDE * 4).map(number).collect();
    let options = Encoding { bits: 32, ..Encoding::EXR };
    encode(&Picture::new(SIDE as u32, SIDE as u32, Pixels::Float(numbers)), &options).expect("a picture")
}
