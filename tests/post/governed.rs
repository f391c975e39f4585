//! A budget: the tier follows the times that the host reports.

use afterimage::host::{TierChangeReason, TierLimits};
use afterimage::{Post, Source};
use afterimage_gpu::wgpu;

use super::{Host, assert_same, fresh};
use crate::support::gpu::changed;

const TIERS: [&str; 3] = ["low", "high", "ultra"];
const COSTS: [f64; 3] = [0.5, 0.7, 1.0];

/// A host of `lynx.ron` at its best tier, without the claims of the file.
fn host() -> Host {
    let mut host = Host::new(changed("lynx.ron", None, &[]));
    let source = Source::text("look.ron", r#"Pipeline(extends: "lynx.ron")"#).tier("ultra");
    host.post = Post::open(&host.gpu, source).unwrap_or_else(|error| panic!("{error}"));
    host
}

/// Renders frames whose time is the load times the cost of their tier. Returns the tiers that they had.
fn render(host: &mut Host, load: f64, frames: usize) -> Vec<usize> {
    let mut rendered = Vec::new();
    for _ in 0..frames {
        host.frame().unwrap();
        let tier = host.post.governor().unwrap().tier();
        rendered.push(tier);
        host.post.report_frame_time(host.post.frame(), load * COSTS[tier]);
        host.post.finish_changes().unwrap();
    }
    rendered
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_best_tier_within_the_budget_is_rendered() {
    let mut host = host();
    host.post.govern(4.0, &TIERS).unwrap();
    assert_same(&host.shown(), &fresh("lynx.ron", Some("low"), &[]));
    // `ultra` would be over the budget, and `high` leaves too little room to try it.
    let rendered = render(&mut host, 5.0, 200);
    assert_eq!(rendered.last(), Some(&1), "{rendered:?}");
    assert_same(&host.shown(), &fresh("lynx.ron", Some("high"), &[]));
    assert_eq!(render(&mut host, 3.0, 200).last(), Some(&2));
    assert_same(&host.shown(), &fresh("lynx.ron", Some("ultra"), &[]));
    let up = host.post.tier_change().unwrap();
    assert_eq!((up.from.as_str(), up.to.as_str(), up.reason), ("high", "ultra", TierChangeReason::Trial));
    assert!((up.ms - 2.1).abs() < 1e-9, "{up}");
    assert_eq!(render(&mut host, 7.0, 60).last(), Some(&0));
    let down = host.post.tier_change().unwrap();
    assert_eq!((down.from.as_str(), down.to.as_str(), down.reason), ("ultra", "low", TierChangeReason::Over));
    // What `ultra` takes is known now: it is taken from `low` at once.
    assert_eq!(render(&mut host, 3.0, 60).last(), Some(&2));
    let up = host.post.tier_change().unwrap();
    assert_eq!((up.from.as_str(), up.to.as_str(), up.reason), ("low", "ultra", TierChangeReason::Room));
    assert!((up.ms - 1.5).abs() < 1e-9 && (up.expected_ms - 3.0).abs() < 0.1, "{up}");
    assert_eq!(render(&mut host, 7.0, 60).last(), Some(&0));
    host.post.stop_governing();
    assert!(host.post.governor().is_none());
    assert_same(&host.shown(), &fresh("lynx.ron", Some("low"), &[]));
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn times_of_frames_before_the_tier_do_not_count() {
    let mut host = host();
    host.frame().unwrap();
    let before = host.post.frame();
    host.post.govern(4.0, &TIERS).unwrap();
    for _ in 0..200 {
        host.post.report_frame_time(before, 1.0);
    }
    assert!(host.post.tier_change().is_none());
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_budget_without_a_tier_is_an_error_and_changes_nothing() {
    let mut host = host();
    let error = host.post.govern(4.0, &[]).unwrap_err().to_string();
    assert_eq!(error, "a budget needs at least one tier to choose from");
    assert!(host.post.governor().is_none());
}

/// The device measures the passes where it can: then the times are those of the passes.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn passes_are_measured_unless_the_host_measures() {
    let mut host = host();
    host.post.govern(1e6, &TIERS).unwrap();
    host.frame().unwrap();
    if !host.post.time_passes().unwrap() {
        return;
    }
    for _ in 0..200 {
        host.frame().unwrap();
        host.gpu.device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
        host.post.finish_changes().unwrap();
    }
    assert_eq!(host.post.governor().unwrap().name(), "ultra");
}

/// `lynx.ron`, with this claim of its tier `low`, and those of the others in JOD on two displays.
fn claiming(low: &str) -> String {
    format!(
        r#"Pipeline(extends: "lynx.ron", claims: {{
            "low": Claim({low}, on: "a test"),
            "high": Claim(jod: 9.25, for: "desk", on: "a test"),
            "ultra": Claim(jod: 9.75, for: "tv-hdr", on: "a test"),
        }})"#
    )
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn no_tier_is_rendered_that_claims_less_than_the_floor() {
    let mut host = host();
    let gpu = host.gpu.clone();
    let snapshot = |low: &str| {
        let opened =
            Post::open(&gpu, Source::text("look.ron", claiming(low))).unwrap_or_else(|error| panic!("{error}"));
        opened.snapshot().unwrap().clone()
    };
    host.post.replace(snapshot("ms: 0.1"), Some("ultra")).unwrap();
    host.post.govern(TierLimits::new(4.0).min_jod(9.0), &TIERS).unwrap();
    assert_same(&host.shown(), &fresh("lynx.ron", Some("high"), &[]));
    let load = |host: &mut Host| {
        for _ in 0..100 {
            host.frame().unwrap();
            host.post.report_frame_time(host.post.frame(), 7.0);
            host.post.finish_changes().unwrap();
        }
        host.post.governor().unwrap().shortfall().map(|shortfall| shortfall.to_string())
    };
    let dear = "high, of 9.25 JOD, takes 7.00 ms, over 4.00, and no cheaper tier claims 9.00 JOD";
    assert_eq!(load(&mut host).as_deref(), Some(dear));
    // The claims of the file change.
    host.post.reload(snapshot(r#"jod: 9.0, for: "desk""#)).unwrap();
    host.post.finish_changes().unwrap();
    assert_same(&host.shown(), &fresh("lynx.ron", Some("low"), &[]));
    // What is claimed for another display does not count.
    host.post.govern(TierLimits::new(4.0).min_jod(9.5).display("desk"), &TIERS).unwrap();
    host.post.finish_changes().unwrap();
    assert_same(&host.shown(), &fresh("lynx.ron", Some("high"), &[]));
    host.post.govern(TierLimits::new(4.0).min_jod(9.5), &TIERS).unwrap();
    host.post.finish_changes().unwrap();
    assert_same(&host.shown(), &fresh("lynx.ron", Some("ultra"), &[]));
}
