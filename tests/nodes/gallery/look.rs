//! Looks: lines, large pixels, tubes and faulty signals.

use super::sheet::Crop;
use super::{Page, Panel, size};

pub(super) fn page() -> Page {
    let surfaces = "depth: \"room.depth\", normal: \"room.normal\",";
    let outline = "depth_threshold: 0.02, color: (0.01, 0.012, 0.02)";
    let panels = vec![
        Panel::light(("Outline", outline), ("room", surfaces), 0.5, Crop::new(0, 200, 640)),
        Panel::display(("Pixelate", "side: 16.0"), "room", 0.5, Crop::new(640, 100, 640)),
        Panel::display(("Crt", "lines: 180.0, stripe_width: 2.0"), "room", 0.5, Crop::new(640, 0, 640)),
        Panel::display(("Glitch", "amount: 0.06"), "room", 0.5, Crop::new(0, 0, 1280)),
    ];
    Page {
        nodes: "\"room\": DemoScene(walk: 0.15, samples: 16, time: 1.0, objects: 2),".to_owned(),
        panels,
        own: ["pixelate", "crt", "glitch"].map(crate::node_folders::kind).to_vec(),
        ..Page::new("kinds-look.jpg", size(1280))
    }
}
