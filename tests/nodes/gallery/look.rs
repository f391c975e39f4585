//! Looks: curves, tints, masks, shafts of light, palettes, large pixels, tubes, faulty signals, grain and reflections.

use afterimage_nodes::DemoScene;

use super::sheet::Crop;
use super::{Page, Panel, size};

const NODES: &str = r#"
    "room": DemoScene(walk: 0.15, samples: 16, time: 1.0, objects: 2),
    "bright": Extract(source: "room", method: Gate, threshold: 2.0, knee: 0.5),
    "gray": Saturation(source: "Mix-0-mapped", amount: 0.0),
    "mask": ShapeMask(
        source: "Mix-0-mapped",
        center: (0.74, 0.42),
        size: (0.6, 0.5),
        ellipse: true,
        softness: 0.2,
        invert: true,
    ),
"#;

pub(super) fn page() -> Page {
    let whole = Crop::new(0, 0, 1280);
    let curves = "luminance_shadows: (0.25, 0.17), luminance_highlights: (0.75, 0.85), blue_black: (0.0, 0.08)";
    let tints = "shadow_amount: 0.5, highlight_amount: 0.6";
    let hues = "hue_orange: -30.0, saturation_orange: 1.3, saturation_cyan: 2.5, lightness_blue: -1.0";
    let shafts = "light: (0.45, 0.2), strength: 0.1, limit: 4.0, color: (1.0, 0.85, 0.65)";
    let surfaces = "depth: \"room.depth\", camera: \"camera\", normal: \"room.normal\",";
    let lit = "depth: \"room.depth\", camera: \"camera\", normal: \"room.normal\", albedo: \"room.albedo\",";
    let sepia = "red: (0.393, 0.769, 0.189), green: (0.349, 0.686, 0.168), blue: (0.272, 0.534, 0.131)";
    let polish = "roughness: 0.12, reflectance: (0.15, 0.15, 0.15), steps: 256";
    let panels = vec![
        Panel::display(("Curves", curves), "room", 0.5, whole),
        Panel::display(("SplitToning", tints), "room", 0.5, whole),
        Panel::display(("HueCurves", hues), "room", 0.5, whole),
        Panel::display(("Mix", "other: \"gray\", mask: \"mask\""), "room", 0.5, whole),
        Panel::light(("GodRays", shafts), ("room", "bright: \"bright\","), 0.5, whole),
        Panel::encoded(("OrderedDither", "levels: 3, dot: 2"), "room", 0.5, Crop::new(640, 100, 640)),
        Panel::display(("Pixelate", "side: 16.0"), "room", 0.5, Crop::new(640, 100, 640)),
        Panel::display(("Crt", "lines: 180.0, stripe_width: 2.0"), "room", 0.5, Crop::new(640, 0, 640)),
        Panel::display(("Glitch", "amount: 0.06"), "room", 0.5, Crop::new(0, 0, 1280)),
        Panel::encoded(("FilmGrain", "amount: 0.3"), "room", 0.5, Crop::new(0, 180, 160)),
        Panel::encoded(("Palette", "dot: 2"), "room", 0.5, Crop::new(640, 100, 640)),
        Panel::light(("Ssr", polish), ("room", surfaces), 0.5, Crop::new(640, 0, 640)),
        Panel::light(("Ssgi", ""), ("room", lit), 0.5, Crop::new(480, 300, 640)),
        Panel::display(("ChannelMixer", sepia), "room", 0.5, whole),
    ];
    let camera = DemoScene { walk: 0.15, ..DemoScene::default() }.camera(size(1280));
    Page {
        inputs: "\"camera\": Camera,",
        nodes: NODES.to_owned(),
        panels,
        blocks: vec![("camera", camera)],
        ..Page::new("kinds-look.jpg", size(1280))
    }
}
