//! Nodes whose results are for a display must suit the displays that these are encoded for.

use std::collections::BTreeSet;

use super::Graph;
use super::draft::DraftGraph;
use super::reports::Reports;
use afterimage_base::color::Colorimetry;
use afterimage_base::diagnostic::{Diagnostic, quote};

impl DraftGraph {
    /// Reports the nodes whose results do not suit a display after them.
    pub(super) fn agree_on_displays(&self, graph: &Graph, reports: &mut Reports) {
        let colors = graph.colors();
        for (index, node) in graph.nodes.iter().enumerate() {
            let mut displays = colors.displays_after(index).iter();
            if let Some(why) = displays.find_map(|display| node.instance.verify_display(display).err()) {
                let draft = &self.nodes[index];
                let message = format!("{} does not suit the display after it: {why}", quote(&draft.name.value));
                let diagnostic = Diagnostic::error("display-conflict", message).at(&draft.kind_location, "");
                reports.push(diagnostic.help("make this node and the encoding after it for one display"));
            }
        }
    }
}

/// The display with the primaries of the largest triangle in xy.
pub(super) fn widest(displays: &BTreeSet<Colorimetry>) -> Option<&Colorimetry> {
    let area = |display: &Colorimetry| {
        let primaries = &display.primaries;
        let [red, green, blue] = [primaries.red, primaries.green, primaries.blue].map(|xy| xy.to_vec());
        (green - red).perp_dot(blue - red).abs()
    };
    // Equal areas are compared by all numbers, so that the order of the wires does not matter.
    displays.iter().max_by(|a, b| area(a).total_cmp(&area(b)).then(a.cmp(b)))
}

/// The displays that decide about a node, of all that its results are encoded for: see `ImageColors::displays_after`.
/// Their number is limited, so that a graph with many encodings needs no more than its size.
pub(super) fn decisive(displays: BTreeSet<Colorimetry>) -> BTreeSet<Colorimetry> {
    let with_white = || displays.iter().filter(|display| display.is_hdr() && display.white_nits.is_some());
    let with_peak = displays.iter().filter(|display| display.is_hdr() && display.peak_nits.is_some());
    let all = [
        widest(&displays),
        displays.iter().find(|display| !display.is_hdr()),
        with_white().min_by_key(|display| (display.white_nits, **display)),
        with_white().max_by_key(|display| (display.white_nits, **display)),
        with_peak.min_by_key(|display| (display.peak_nits, **display)),
    ];
    all.into_iter().flatten().copied().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use afterimage_base::color::{Chromaticities, Transfer, Xy};

    /// Against the shoelace formula, for triangles of all shapes and places.
    #[test]
    fn the_widest_display_has_the_largest_triangle() {
        // The finalizer of murmur3 spreads consecutive numbers.
        let spread = |at: u32| (at ^ at >> 16).wrapping_mul(0x85eb_ca6b);
        let number = |at: u32| f64::from(spread(spread(at + 1)).wrapping_mul(0xc2b2_ae35) >> 16) / 65536.0;
        let xy = |at: u32| (0.05 + 0.6 * number(at), 0.05 + 0.3 * number(at + 1));
        let area = |[(ax, ay), (bx, by), (cx, cy)]: [(f64, f64); 3]| {
            (ax * by - bx * ay + bx * cy - cx * by + cx * ay - ax * cy).abs()
        };
        for first in (0..600).step_by(30) {
            let triangles: Vec<[(f64, f64); 3]> = (0..4).map(|at| [0, 2, 4].map(|k| xy(first + 6 * at + k))).collect();
            let display = |[red, green, blue]: [(f64, f64); 3]| {
                let [red, green, blue] = [red, green, blue].map(|(x, y)| Xy::new(x, y));
                Colorimetry::new(Chromaticities { red, green, blue, white: Xy::D65 }, Transfer::Srgb)
            };
            let largest = triangles.iter().max_by(|a, b| area(**a).total_cmp(&area(**b))).expect("there are four");
            let displays = triangles.iter().map(|triangle| display(*triangle)).collect();
            assert_eq!(widest(&displays), Some(&display(*largest)), "{triangles:?}");
        }
    }

    #[test]
    fn of_many_displays_the_extremes_decide_in_any_order() {
        let hdr = |white: f64, peak: f64| Colorimetry::new(Chromaticities::REC2020, Transfer::Pq).nits(white, peak);
        let displays: Vec<Colorimetry> = (0..400).map(|i| hdr(100.0 + f64::from(i), 4000.0 - f64::from(i))).collect();
        let sdr = Colorimetry::SRGB;
        let all = decisive(displays.iter().copied().chain([sdr]).collect());
        assert!(all.len() <= 5 && [displays[0], displays[399], sdr].iter().all(|display| all.contains(display)));
        let one_by_one = displays.iter().rev().fold(BTreeSet::from([sdr]), |mut found, display| {
            found.insert(*display);
            decisive(found)
        });
        assert_eq!(one_by_one, all);
    }
}
