//! The picture of `graph/docs/effects.md`: what kinds do to the built-in scene.

use std::fmt::Write as _;

use afterimage_graph::check::{CheckOptions, Graph, NoFiles, check};
use afterimage_graph::document::parse;
use afterimage_graph::image::Size;
use afterimage_graph::node::Registry;
use afterimage_nodes::DemoScene;

use crate::support::docs;
use crate::support::gpu::{Picture, Run};

/// What a panel shows at its left and at its right, and how it gets to a display.
enum Panel {
    /// Light before exposure: the scene, and the result of a node.
    Light(&'static str),
    /// Light for a `Composite`, from the blurred or the sharp bright light: its share.
    Added(&'static str, f32),
    /// An encoded image: the wire of the source.
    Encoded(&'static str, &'static str),
    /// A display-linear image.
    Display(&'static str),
}

use Panel::{Added, Display, Encoded, Light};

/// The kinds of the table in `effects.md`, in its order.
const PANELS: [(&str, Panel); 20] = [
    ("Gtao", Light("depth: \"scene.depth\", camera: \"camera\", normal: \"scene.normal\", radius: 1.0")),
    ("Ssao", Light("depth: \"scene.depth\", camera: \"camera\", normal: \"scene.normal\", radius: 1.0")),
    ("Fog", Light("depth: \"scene.depth\", camera: \"camera\", density: 0.1, falloff: 0.4, color: (0.3, 0.35, 0.4)")),
    ("DepthOfField", Light("depth: \"scene.depth\", focus: 2.2, f_stop: 1.4, amount: 4.0, largest: 0.06")),
    ("MotionBlur", Light("motion: \"scene.motion\", depth: \"scene.depth\", largest: 0.1, shutter: 360.0")),
    ("Smaa", Encoded("jagged", "")),
    ("Fxaa", Encoded("jagged", "")),
    ("Cas", Encoded("seen", "sharpness: 1.0")),
    ("Sharpen", Encoded("seen", "amount: 1.5")),
    ("Outline", Light("depth: \"scene.depth\", normal: \"scene.normal\"")),
    ("ChromaticAberration", Light("red: 0.02, blue: -0.02")),
    ("LensDistortion", Light("k1: 0.3")),
    ("HeatHaze", Light("strength: 0.02")),
    ("LensFlare", Added("source: \"bloom\"", 0.1)),
    ("LensDirt", Added("source: \"bloom\", strength: 8.0", 0.1)),
    ("Streaks", Added("source: \"bright\", length: 0.2", 0.3)),
    ("Halation", Light("strength: 0.5, radius: 0.03")),
    ("Pixelate", Display("side: 10.0")),
    ("Crt", Display("lines: 90.0")),
    ("Glitch", Display("amount: 0.15")),
];

const SCENE: &str = r#"
    "scene": DemoScene(walk: 0.3, samples: 16, step: 0.01, time: 1.0, dt: 0.04, objects: 2),
    "aliased": DemoScene(walk: 0.3, samples: 1, step: 0.01, time: 1.0, dt: 0.04, objects: 2),
    "bright": Extract(source: "scene", method: Gate, threshold: 4.0, knee: 0.1),
    "mips": Downsample(source: "bright", levels: 5, filter: Tap13),
    "bloom": Upsample(source: "mips", blend: Add, filter: Tent, radius: 0.85),
"#;

/// Nodes that expose, map and encode light.
fn shown(name: &str, light: &str) -> String {
    format!(
        "\"{name}-exposed\": Exposure(source: \"{light}\", stops: 0.5), \
         \"{name}-mapped\": ToneMap(source: \"{name}-exposed\"), \
         \"{name}\": Encode(source: \"{name}-mapped\"),\n"
    )
}

/// The pipeline of all panels. Its outputs: two encoded images for each panel.
fn text() -> String {
    let mut nodes = SCENE.to_owned() + &shown("seen", "scene") + &shown("jagged", "aliased");
    let mut outputs = String::new();
    for (kind, panel) in &PANELS {
        let (before, node) = match panel {
            Light(more) => ("seen", format!("\"{kind}-light\": {kind}(source: \"scene\", {more}),\n")),
            Added(more, share) => (
                "seen",
                format!(
                    "\"{kind}-made\": {kind}({more}), \"{kind}-light\": Composite(base: \"scene\", \
                     bloom: \"{kind}-made\", blend: Add, strength: {share}),\n"
                ),
            ),
            Encoded(source, more) => (*source, format!("\"{kind}\": {kind}(source: \"{source}\", {more}),\n")),
            Display(more) => (
                "seen",
                format!(
                    "\"{kind}-made\": {kind}(source: \"seen-mapped\", {more}), \
                     \"{kind}\": Encode(source: \"{kind}-made\"),\n"
                ),
            ),
        };
        nodes += &node;
        if matches!(panel, Light(_) | Added(..)) {
            nodes += &shown(kind, &format!("{kind}-light"));
        }
        write!(outputs, "\"{kind}-0\": \"{before}\", \"{kind}-1\": \"{kind}\", ").expect("a string takes all text");
    }
    format!("Pipeline(inputs: {{ \"camera\": Camera }}, nodes: {{ {nodes} }}, outputs: {{ {outputs} }})")
}

fn graph() -> Graph {
    let folders = ["pixelate", "crt", "glitch"].map(crate::node_folders::kind);
    let registry = Registry::new(&[afterimage_nodes::ALL, &folders]).expect("no two kinds share a name");
    let document = parse("gallery.ron", &text()).unwrap_or_else(|errors| panic!("{errors:?}"));
    let options = CheckOptions { tier: None, sets: Vec::new(), loader: &NoFiles };
    check(&document, &registry, &options).unwrap_or_else(|errors| panic!("{errors:?}")).0
}

/// Each kind changes the right half of its panel. With `AFTERIMAGE_WRITE_DOCS=1` this writes the picture.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_picture_of_kinds_is_drawn() {
    let size = if docs::are_written() { Size::new(320, 180) } else { Size::new(64, 36) };
    let graph = graph();
    let scene = DemoScene { walk: 0.3, ..DemoScene::default() };
    let mut run = Run::new(&graph).camera(Some(&scene.camera(size)));
    run.size = size;
    let found = run.frame(&[]);
    let panel = |(pair, (kind, _)): (&[Picture], &(&str, Panel))| {
        let (before, after) = (&pair[0], &pair[1]);
        let panel = Picture::new(size.width, size.height, |x, y| {
            let [r, g, b, _] = if x < size.width / 2 { before.at(x, y) } else { after.at(x, y) };
            [r, g, b, 1.0]
        });
        let changed = panel.pixels.iter().zip(&before.pixels).filter(|(a, b)| a[..3] != b[..3]).count();
        assert!(changed > panel.pixels.len() / 100, "{kind} changes {changed} pixels");
        panel
    };
    let panels: Vec<Picture> = found.chunks(2).zip(&PANELS).map(panel).collect();
    docs::write_panels("kinds.jpg", 4, &panels);
}
