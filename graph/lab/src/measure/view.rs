//! Conversion of the values of an output to the luminance or the signal of a display.

use afterimage_gpu::Texels;
use afterimage_graph::check::{Graph, GraphOutput};
use afterimage_graph::color::{Chromaticities, Colorimetry, GRAPHICS_WHITE, Transfer, hlg_gamma};
use afterimage_graph::image::ColorState;
use afterimage_graph::node::ImageColor;
use glam::{DMat3, DVec3};
use rayon::prelude::*;

use crate::LabError;
use crate::metrics::{Range, Shown, srgb_encode};

/// The interpretation of an output as a displayed image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct View {
    colorimetry: Colorimetry,
    /// The values are a signal, and not linear color, which has no upper limit.
    is_encoded: bool,
}

impl View {
    /// The view of an output, from its color state and its colorimetry.
    pub(crate) fn of(graph: &Graph, output: &GraphOutput) -> Result<Self, LabError> {
        let color = graph.colors().at(output.source).unwrap_or(ImageColor::of(output.state));
        if color.is_picture() {
            return Ok(Self { colorimetry: color.colorimetry, is_encoded: output.state == ColorState::Encoded });
        }
        let message = format!("output `{}` is {}, which cannot be displayed", output.name, output.state.name());
        Err(LabError::request(message).hint("choose another output with `--output`"))
    }

    /// The range of the display.
    pub(crate) fn range(self) -> Range {
        if self.is_encoded && !self.colorimetry.is_hdr() { Range::Sdr } else { Range::Hdr }
    }

    /// The displayed image; `None` if a value is not finite.
    pub(crate) fn shown(self, texels: &Texels) -> Option<Shown> {
        let numbers = texels.to_floats();
        let is_finite = |pixel: &[f32; 4]| pixel[..3].iter().all(|x| x.is_finite());
        if !numbers.par_iter().all(is_finite) {
            return None;
        }
        let to_rec709 = self.to_rec709();
        let pixels = numbers.par_iter().map(|[r, g, b, _]| self.pixel(&to_rec709, [*r, *g, *b])).collect();
        let size = texels.desc.size;
        Some(Shown { width: size.width as usize, height: size.height as usize, range: self.range(), pixels })
    }

    fn to_rec709(self) -> DMat3 {
        self.colorimetry.primaries.conversion(&Chromaticities::REC709)
    }

    fn pixel(self, to_rec709: &DMat3, rgb: [f32; 3]) -> [f32; 3] {
        let transfer = self.colorimetry.transfer;
        match self.range() {
            // An SDR image is compared by its signal, in the primaries of its own display.
            Range::Sdr if transfer == Transfer::Srgb => rgb.map(|x| x.clamp(0.0, 1.0)),
            Range::Sdr => rgb.map(|x| srgb_encode(transfer.to_light(f64::from(x)).clamp(0.0, 1.0)) as f32),
            Range::Hdr => {
                let nits = self.nits(DVec3::from_array(rgb.map(f64::from)));
                (*to_rec709 * nits).max(DVec3::ZERO).as_vec3().to_array()
            }
        }
    }

    /// The color of an HDR image in cd/m², in its own primaries.
    fn nits(self, numbers: DVec3) -> DVec3 {
        let Colorimetry { primaries, transfer, white_nits, peak_nits, .. } = self.colorimetry;
        let linear = numbers.map(|x| transfer.to_light(x));
        match transfer {
            Transfer::Pq => linear * 10000.0,
            Transfer::Hlg => {
                // The system gamma of ITU-R BT.2100, on a display of 1000 cd/m² where no peak is stated.
                let peak = peak_nits.map_or(1000.0, |peak| peak.get());
                let luminance = linear.dot(primaries.to_xyz().row(1)).max(0.0);
                linear * peak * luminance.powf(hlg_gamma(peak) - 1.0)
            }
            Transfer::Linear | Transfer::Srgb | Transfer::Gamma(_) => {
                linear * white_nits.unwrap_or(GRAPHICS_WHITE).get()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use afterimage_graph::check::{CheckOptions, NoFiles, check};
    use afterimage_graph::document::parse;
    use afterimage_graph::node::Registry;

    use super::*;

    fn encoded(colorimetry: Colorimetry) -> View {
        View { colorimetry, is_encoded: true }
    }

    fn shown(view: View, signal: f32) -> [f32; 3] {
        view.pixel(&view.to_rec709(), [signal; 3])
    }

    #[track_caller]
    fn close(found: [f32; 3], expected: f32) {
        assert!(found.iter().all(|x| (x - expected).abs() < 5e-4 * expected.max(1.0)), "{found:?} is not {expected}");
    }

    #[test]
    fn an_output_is_seen_as_its_nodes_state() {
        let text = r#"Pipeline(inputs: { "in": Color },
            nodes: {
                "exposed": Exposure(source: "in"),
                "mapped": ToneMap(source: "exposed"),
                "hdr": Encode(source: "mapped", transfer: Pq, primaries: Rec2020),
                "depth": DemoScene(),
            },
            outputs: { "hdr": "hdr", "depth": "depth.depth" })"#;
        let registry = Registry::new(&[afterimage_nodes::ALL]).expect("no two kinds share a name");
        let document = parse("view.ron", text).unwrap_or_else(|errors| panic!("{errors}"));
        let options = CheckOptions { tier: None, sets: Vec::new(), loader: &NoFiles };
        let graph = check(&document, &registry, &options).unwrap_or_else(|errors| panic!("{errors}")).0;
        let view = View::of(&graph, &graph.outputs[0]).expect("a picture");
        let seen = (view.colorimetry.transfer, view.colorimetry.primaries, view.is_encoded);
        assert_eq!(seen, (Transfer::Pq, Chromaticities::REC2020, true));
        assert!(
            View::of(&graph, &graph.outputs[1]).is_err_and(|error| error.to_string().contains("cannot be displayed"))
        );
    }

    #[test]
    fn reference_white_has_the_levels_of_bt_2408() {
        // 203 cd/m² are 58 % of the PQ signal and 75 % of the HLG signal of a display of 1000 cd/m².
        for primaries in [Chromaticities::REC709, Chromaticities::DISPLAY_P3, Chromaticities::REC2020] {
            let hdr = |transfer| encoded(Colorimetry::new(primaries, transfer).nits(203.0, 1000.0));
            close(shown(hdr(Transfer::Pq), 0.580_69), 203.0);
            close(shown(hdr(Transfer::Hlg), 0.749_88), 203.0);
            close(shown(hdr(Transfer::Hlg), 1.0), 1000.0);
        }
        close(shown(View { colorimetry: Colorimetry::linear(Chromaticities::REC709), is_encoded: false }, 1.0), 203.0);
    }

    #[test]
    fn signals_of_other_curves_become_srgb() {
        let sdr = |transfer| encoded(Colorimetry::new(Chromaticities::REC709, transfer));
        close(shown(sdr(Transfer::Srgb), 0.5), 0.5);
        close(shown(sdr(Transfer::Linear), 0.214_041), 0.5);
        close(shown(sdr(Transfer::Gamma(2.2.into())), 0.496_1), 0.499_87);
        close(shown(sdr(Transfer::Srgb), 1.5), 1.0);
    }

    #[test]
    fn light_of_a_wide_display_becomes_that_of_rec_709() {
        let view = encoded(Colorimetry::new(Chromaticities::REC2020, Transfer::Pq).nits(203.0, 1000.0));
        // Red of Rec.709 at 203 cd/m² in Rec.2020 (ITU-R BT.2087): 0.6274, 0.0691, 0.0164.
        let signal = [0.6274, 0.0691, 0.0164].map(|x| Transfer::Pq.to_signal(x * 203.0 / 10000.0) as f32);
        let [red, green, blue] = view.pixel(&view.to_rec709(), signal);
        assert!((red - 203.0).abs() < 0.05 && green < 0.05 && blue < 0.05, "{red} {green} {blue}");
    }
}
