//! From the values of an output to the light or the signal of a display.

use afterimage_gpu::Texels;
use afterimage_graph::check::{Graph, GraphNode, GraphOutput, Source};
use afterimage_graph::image::ColorState;
use afterimage_graph::value::Value;
use glam::{DMat3, DVec3};
use rayon::prelude::*;

use crate::LabError;
use crate::metrics::{REC2020, Range, Shown, nits_of_pq, srgb_encode};

/// Light of the linear value 1: reference white (ITU-R BT.2408).
const WHITE_NITS: f64 = 203.0;

/// The transfer function of an output.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Signal {
    Srgb,
    /// A power; 1 for linear files.
    Gamma(f64),
    /// 1 is [`WHITE_NITS`].
    Linear,
    Pq,
    /// With the peak of the display.
    Hlg(f64),
}

/// How an output is displayed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct View {
    signal: Signal,
    /// Whether HDR light has the primaries of Rec.2020.
    wide: bool,
}

impl View {
    /// The view of an output, from its state and from the `Encode` node before it. A signal without one counts as sRGB.
    pub(crate) fn of(graph: &Graph, output: &GraphOutput) -> Result<Self, LabError> {
        match output.state {
            ColorState::Encoded => {
                Ok(encoder(graph, output.source).map_or(Self { signal: Signal::Srgb, wide: false }, Self::after))
            }
            ColorState::Scene | ColorState::Exposed | ColorState::DisplayLinear => {
                Ok(Self { signal: Signal::Linear, wide: false })
            }
            ColorState::LogLuminance | ColorState::Data => {
                let message = format!("output `{}` is {}, which cannot be displayed", output.name, output.state.name());
                Err(LabError::request(message).hint("choose another output with `--output`"))
            }
        }
    }

    fn after(encode: &GraphNode) -> Self {
        let choice = |name: &str| match encode.instance.value(name) {
            Some(Value::Choice(choice)) => *choice,
            _ => "",
        };
        let number = |name: &str, otherwise: f64| match encode.instance.value(name) {
            Some(Value::Float(number)) => *number,
            _ => otherwise,
        };
        let signal = match choice("transfer") {
            "Gamma" => Signal::Gamma(number("gamma", 2.2)),
            "Linear" => Signal::Gamma(1.0),
            "Pq" => Signal::Pq,
            "Hlg" => Signal::Hlg(number("peak_nits", 1000.0)),
            _ => Signal::Srgb,
        };
        Self { signal, wide: choice("primaries") == "Rec2020" }
    }

    /// Whether the display is SDR or HDR.
    pub(crate) fn range(self) -> Range {
        match self.signal {
            Signal::Srgb | Signal::Gamma(_) => Range::Sdr,
            Signal::Linear | Signal::Pq | Signal::Hlg(_) => Range::Hdr,
        }
    }

    /// The displayed image; `None` if a value is not finite.
    pub(crate) fn shown(self, texels: &Texels) -> Option<Shown> {
        let numbers = texels.to_floats();
        let is_finite = |pixel: &[f32; 4]| pixel[..3].iter().all(|x| x.is_finite());
        if !numbers.par_iter().all(is_finite) {
            return None;
        }
        let to_narrow = if self.wide { REC2020.inverse() } else { DMat3::IDENTITY };
        let pixels = numbers.par_iter().map(|[r, g, b, _]| self.pixel(&to_narrow, [*r, *g, *b])).collect();
        let size = texels.desc.size;
        Some(Shown { width: size.width as usize, height: size.height as usize, range: self.range(), pixels })
    }

    fn pixel(self, to_narrow: &DMat3, rgb: [f32; 3]) -> [f32; 3] {
        let light = |nits: DVec3| (*to_narrow * nits).max(DVec3::ZERO).as_vec3().to_array();
        let numbers = DVec3::from_array(rgb.map(f64::from));
        match self.signal {
            Signal::Srgb => rgb.map(|x| x.clamp(0.0, 1.0)),
            Signal::Gamma(gamma) => rgb.map(|x| srgb_encode(f64::from(x).clamp(0.0, 1.0).powf(gamma)) as f32),
            Signal::Linear => light(numbers * WHITE_NITS),
            Signal::Pq => light(numbers.map(nits_of_pq)),
            Signal::Hlg(peak) => light(hlg_light(numbers, peak)),
        }
    }
}

/// Light in cd/m² of an HLG signal on a display with that peak (ITU-R BT.2100, its gamma as in BT.2390).
fn hlg_light(signal: DVec3, peak: f64) -> DVec3 {
    const A: f64 = 0.178_832_77;
    const B: f64 = 1.0 - 4.0 * A;
    let c = 0.5 - A * (4.0 * A).ln();
    let scene = signal
        .clamp(DVec3::ZERO, DVec3::ONE)
        .map(|x| if x <= 0.5 { x * x / 3.0 } else { (((x - c) / A).exp() + B) / 12.0 });
    let gamma = match (400.0..=2000.0).contains(&peak) {
        true => 1.2 + 0.42 * (peak / 1000.0).log10(),
        false => 1.2 * 1.111_f64.powf((peak / 1000.0).log2()),
    };
    let luminance = scene.dot(DVec3::new(0.2627, 0.6780, 0.0593));
    scene * peak * luminance.max(0.0).powf(gamma - 1.0)
}

/// The `Encode` node before an output, also through nodes such as `Dither`.
fn encoder(graph: &Graph, from: Source) -> Option<&GraphNode> {
    let mut source = from;
    // A path that is longer than the number of nodes is a cycle through earlier frames.
    for _ in 0..graph.nodes.len() {
        let Source::Node { node, .. } = source else { return None };
        let node = &graph.nodes[node];
        if node.kind().name() == "Encode" {
            return Some(node);
        }
        source = node.wires.iter().flatten().next().copied()?;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(view: View, signal: f32) -> [f32; 3] {
        view.pixel(&if view.wide { REC2020.inverse() } else { DMat3::IDENTITY }, [signal; 3])
    }

    #[track_caller]
    fn close(found: [f32; 3], expected: f32) {
        assert!(found.iter().all(|x| (x - expected).abs() < 5e-4 * expected.max(1.0)), "{found:?} is not {expected}");
    }

    #[test]
    fn reference_white_has_the_levels_of_bt_2408() {
        // 203 cd/m² are 58 % of the PQ signal and 75 % of the HLG signal of a display of 1000 cd/m².
        for wide in [false, true] {
            close(shown(View { signal: Signal::Pq, wide }, 0.580_69), 203.0);
            close(shown(View { signal: Signal::Hlg(1000.0), wide }, 0.749_88), 203.0);
            close(shown(View { signal: Signal::Hlg(1000.0), wide }, 1.0), 1000.0);
        }
        close(shown(View { signal: Signal::Linear, wide: false }, 1.0), 203.0);
    }

    #[test]
    fn signals_of_other_curves_become_srgb() {
        close(shown(View { signal: Signal::Srgb, wide: false }, 0.5), 0.5);
        close(shown(View { signal: Signal::Gamma(1.0), wide: false }, 0.214_041), 0.5);
        close(shown(View { signal: Signal::Gamma(2.2), wide: false }, 0.496_1), 0.499_87);
        close(shown(View { signal: Signal::Srgb, wide: false }, 1.5), 1.0);
    }
}
