//! Looks: large pixels, tubes, faulty signals and grain.

use super::sheet::Crop;
use super::{Page, Panel, size};

pub(super) fn page() -> Page {
    let panels = vec![
        Panel::display(("Pixelate", "side: 16.0"), "room", 0.5, Crop::new(640, 100, 640)),
        Panel::display(("Crt", "lines: 180.0, stripe_width: 2.0"), "room", 0.5, Crop::new(640, 0, 640)),
        Panel::display(("Glitch", "amount: 0.06"), "room", 0.5, Crop::new(0, 0, 1280)),
        Panel::encoded(("FilmGrain", "amount: 0.3"), "room", 0.5, Crop::new(0, 180, 160)),
    ];
    Page {
        nodes: "\"room\": DemoScene(walk: 0.15, samples: 16, time: 1.0, objects: 2),".to_owned(),
        panels,
        ..Page::new("kinds-look.jpg", size(1280))
    }
}
