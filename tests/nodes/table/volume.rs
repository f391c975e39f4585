//! Rows of kinds that read volumes.

use super::Reference;
use crate::nodes::camera::depths;
use crate::nodes::color::{self, tolerance};
use crate::nodes::volume::fog;
use crate::reference::volume::{Composite, Volume};
use crate::support::gpu::SLICES;
use crate::support::harness::{Tolerance, image};

const FILTERED: Tolerance = tolerance(2e-5, 4e-5, "a logarithm and places between texels in f32");

pub(super) fn volume_kinds() -> Vec<Reference> {
    let row = |parameters: &str, composite: Composite| {
        let nodes = format!(
            "\"result\": VolumetricComposite(source: \"scene\", depth: \"data\", volume: \"volume\", {parameters})"
        );
        let expected = move |source: &_| apply(composite, source);
        Reference::new(("VolumetricComposite", "Color"), &nodes, color::light, FILTERED, expected)
            .with_data(depths)
            .with_volume(fog)
    };
    let whole = Composite { near: 0.5, far: 16.0, curve: 32.0_f64.ln(), is_end: true, light: 1.0, amount: 1.0 };
    vec![
        row("near: 0.5, far: 16.0", whole),
        row(
            "near: 0.0, far: 18.5, slices: Linear, texels: Middle",
            Composite { near: 0.0, far: 18.5, curve: 0.0, is_end: false, ..whole },
        ),
        row(
            "near: 1.0, far: 30.0, slices: Curved, curve: 0.001, light: 2.5, amount: 0.75",
            Composite { near: 1.0, far: 30.0, curve: f64::from(0.001_f32), light: 2.5, amount: 0.75, ..whole },
        ),
        row(
            "near: 0.0, far: 12.0, slices: Curved, curve: 6.0",
            Composite { near: 0.0, far: 12.0, curve: 6.0, ..whole },
        ),
    ]
}

fn apply(composite: Composite, source: &crate::reference::image::Image) -> crate::reference::image::Image {
    let size = [source.width as u32, source.height as u32];
    let (depth, volume) = (image(&depths(size)), image(&fog(size)));
    composite.apply(source, &depth, &Volume { all: &volume, depth: SLICES as usize })
}
