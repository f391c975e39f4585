//! Exposure values, the histogram, adaptation and the pyramid.

use super::{Case, Op, flat};
use crate::reference::exposure::{
    Aim, Bins, adapt_exponential, adapt_linear, auto_exposure_stops, ev100_camera, ev100_from_illuminance,
    ev100_from_luminance, illuminance, mip_count, multiplier_from_ev100, pyramid_mean,
};

pub(super) const OPS: &[Op] = &[
    ("ev100_camera", |case| {
        let [aperture, seconds, iso] = case.array();
        vec![ev100_camera(aperture, seconds, iso)]
    }),
    ("ev100_from_luminance", |case| vec![ev100_from_luminance(case.number())]),
    ("ev100_from_illuminance", |case| vec![ev100_from_illuminance(case.number())]),
    ("exposure_from_ev100", |case| vec![multiplier_from_ev100(case.number())]),
    ("auto_exposure_stops", |case| vec![auto_exposure_stops(case.number(), 0.18, 0.0)]),
    ("hist_bin", |case| vec![bins(case).bin(case.number()) as f64]),
    ("hist_center", |case| vec![bins(case).center(case.number() as usize)]),
    ("hist_mean_log2", |case| {
        let (low, high) = (case.part_number("low"), case.part_number("high"));
        vec![bins(case).trimmed_mean(&counts(case), low, high).unwrap_or(f64::NAN)]
    }),
    ("adapt_exp", |case| {
        let [stops, wanted, dt] = case.array();
        let (dark, bright) = (case.param("rate_dark"), case.param("rate_bright"));
        vec![adapt_exponential(stops, Aim::at(wanted), dt, dark, bright)]
    }),
    ("adapt_linear", |case| {
        let [stops, wanted, dt] = case.array();
        vec![adapt_linear(stops, Aim::at(wanted), dt, 1.5, 1.5)]
    }),
    ("illuminance_lambert", |case| {
        let [luminance, albedo] = case.array();
        vec![illuminance(luminance, albedo)]
    }),
    ("pyramid_mean", |case| {
        let luminances = case.numbers();
        let arithmetic = luminances.iter().sum::<f64>() / luminances.len() as f64;
        vec![arithmetic, pyramid_mean(&luminances, -10.0)]
    }),
    ("mip_count", |case| {
        let [width, height] = case.array();
        vec![f64::from(mip_count(width as usize, height as usize))]
    }),
];

fn bins(case: &Case) -> Bins {
    Bins { count: case.param("bins") as usize, low: case.param("lo"), high: case.param("hi"), black: 0.0 }
}

/// The histogram that the case lists as pairs of bin and count.
fn counts(case: &Case) -> Vec<u32> {
    let mut counts = vec![0; case.param("bins") as usize];
    for pair in flat(case.part("bins")).chunks(2) {
        counts[pair[0] as usize] = pair[1] as u32;
    }
    counts
}

#[test]
fn exposure_references_agree_with_the_vectors() {
    super::check(OPS);
}
