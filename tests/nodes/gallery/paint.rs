//! Blurs of several shapes, paint, print and grades.

use super::sheet::Crop;
use super::{Page, Panel, size};

const NODES: &str = r#"
    "room": DemoScene(walk: 0.15, samples: 16, time: 1.0, objects: 2),
    "mask": GradientMask(source: "room", start: (0.5, 0.6), end: (0.5, 0.1), mirror: true, level: 0.1),
"#;

pub(super) fn page() -> Page {
    let (whole, near) = (Crop::new(0, 0, 1280), Crop::new(720, 180, 320));
    let zoom = "center: (0.45, 0.4), zoom: 0.15, spin: 3.0";
    let wheels = "shadows: (-0.6, -0.2, 0.5), highlights: (0.4, 0.1, -0.4)";
    let panels = vec![
        Panel::light(("VariableBlur", "sigma: 0.015"), ("room", "mask: \"mask\","), 0.5, whole),
        Panel::light(("DirectionalBlur", "length: 0.06, angle: 20.0"), ("room", ""), 0.5, whole),
        Panel::light(("RadialBlur", zoom), ("room", ""), 0.5, whole),
        Panel::encoded(("Kuwahara", "radius: 0.02"), "room", 0.5, near),
        Panel::encoded(("Newsprint", "cell: 0.014"), "room", 0.5, near),
        Panel::display(("GradientMap", ""), "room", 0.5, whole),
        Panel::display(("SaturationCurves", "vibrance: 1.0, black: 0.4"), "room", 0.5, whole),
        Panel::light(("LogWheels", wheels), ("room", ""), 0.5, whole),
    ];
    Page { nodes: NODES.to_owned(), panels, ..Page::new("kinds-paint.jpg", size(1280)) }
}
