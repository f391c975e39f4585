//! Lenses and film.

use super::sheet::Crop;
use super::{Page, Panel, size};

/// The room, and the sun before the window, with its light in bloom of several widths.
const NODES: &str = r#"
    "room": DemoScene(walk: 0.15, samples: 16, time: 1.0, objects: 2),
    "sun": DemoScene(walk: 0.62, samples: 16, time: 1.0),
    "bright": Extract(source: "sun", method: Gate, threshold: 30.0, knee: 4.0),
    "quarter": Downsample(source: "bright", levels: 2, filter: Tap13),
    "mips": Downsample(source: "bright", levels: 6, filter: Tap13),
    "bloom": Upsample(source: "mips", blend: Add, filter: Tent, radius: 0.85),
    "wide-mips": Downsample(source: "bright", levels: 8, filter: Tap13),
    "wide": Upsample(source: "wide-mips", blend: Add, filter: Tent, radius: 1.0),
    "clean": Composite(base: "sun", bloom: "wide", blend: Add, strength: 0.12),
"#;

pub(super) fn page() -> Page {
    let (whole, beside_the_sun) = (Crop::new(0, 0, 1280), Crop::new(100, 20, 640));
    let (room, sun) = (("room", ""), ("sun", ""));
    let streaks = ("Streaks", "length: 0.27");
    let panels = vec![
        Panel::light(("ChromaticAberration", "red: 0.004, blue: -0.004"), room, 0.5, Crop::new(0, 240, 160)),
        Panel::light(("LensDistortion", "k1: -0.2, zoom: 1.25"), room, 0.5, whole),
        Panel::light(("HeatHaze", "strength: 0.006"), sun, -1.0, Crop::new(440, 400, 320)),
        Panel::light(("Halation", "strength: 0.2, radius: 0.012"), room, 0.5, Crop::new(720, 180, 320)),
        Panel::added(("LensFlare", ""), ["sun", "sun", "bloom"], 0.2, -2.0, whole),
        Panel::added(("LensDirt", "strength: 8.0"), ["clean", "sun", "wide"], 0.12, -2.0, beside_the_sun),
        Panel::added(streaks, ["sun", "sun", "quarter.coarsest"], 0.06, -2.0, beside_the_sun),
        Panel::light(("Vignette", "amount: 0.6, smoothness: 0.5"), room, 0.5, whole),
    ];
    Page { nodes: NODES.to_owned(), panels, ..Page::new("kinds-lens.jpg", size(1280)) }
}
