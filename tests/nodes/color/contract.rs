//! The table and the plot of the tone curves in `graph/docs/color.md`.

use std::path::PathBuf;

use crate::reference::agx;
use crate::reference::curves::*;
use crate::reference::gt7;
use crate::reference::transfer::srgb_encode;
use afterimage_lab::plot::canvas::{Anchor, Canvas};

/// A curve on gray light: as published, and the factor of the light that makes 0.18 of 0.18.
struct Gray {
    name: &'static str,
    color: &'static str,
    published: fn(f64) -> f64,
    scale: f64,
    /// With the factor.
    matched: Box<dyn Fn(f64) -> f64>,
}

impl Gray {
    fn new(name: &'static str, color: &'static str, published: fn(f64) -> f64) -> Self {
        let scale = matched_scale(published);
        Self { name, color, published, scale, matched: Box::new(move |x| published(scale * x).min(1.0)) }
    }

    /// The light at which an sRGB display shows the code 250 of 255.
    fn code_250(&self) -> f64 {
        let wanted = 250.0 / 255.0;
        let (mut low, mut high) = (0.18, 65504.0);
        for _ in 0..80 {
            let middle: f64 = 0.5 * (low + high);
            if srgb_encode((self.matched)(middle)) < wanted { low = middle } else { high = middle }
        }
        low
    }

    fn row(&self) -> String {
        let at = |light: f64| format!("{:.3}", (self.matched)(light));
        format!(
            "| `{}` | {:.3} | {:.2} | {} | {} | {} | {} | {:.1} |",
            self.name,
            (self.published)(0.18),
            self.scale,
            at(0.018),
            at(1.0),
            at(4.0),
            at(16.0),
            self.code_250()
        )
    }
}

fn all() -> Vec<Gray> {
    // The white of the extended curve is exposed light, so it is scaled too.
    let white = 4.0;
    let scale = (1.0 - 0.18 / (white * white)) / 0.82;
    let extended = Gray {
        name: "ReinhardExtended",
        color: "#9b6bc9",
        published: |x| reinhard_extended(x, 4.0),
        scale,
        matched: Box::new(move |x| reinhard_extended(scale * x, scale * white).min(1.0)),
    };
    vec![
        Gray::new("None", "#9aa3ad", |x| x),
        Gray::new("Reinhard", "#c9a4e4", reinhard),
        extended,
        Gray::new("Exponential", "#7d8a2e", |x| exponential(x, 1.0)),
        Gray::new("Aces2ToneScale", "#1c2128", |x| aces2_tone_scale(x, 100.0)),
        Gray::new("AcesNarkowicz", "#c9621b", narkowicz),
        Gray::new("AcesHill", "#e4a06b", |x| hill([x; 3])[1]),
        Gray::new("Hable", "#8c5a3c", |x| hable(x, 2.0, 11.2)),
        Gray::new("Uchimura", "#2f6f4f", |x| uchimura(x, &UCHIMURA)),
        Gray::new("KhronosNeutral", "#138a86", |x| pbr_neutral([x; 3], 0.8, 0.15)[1]),
        Gray::new("AgX", "#3563c9", |x| agx::linear([x; 3], agx::sigmoid, &agx::BASE)[1]),
        Gray::new("Gt7", "#b8324f", |x| gt7::hdr([x; 3], 203.0)[1] / 2.03),
    ]
}

fn docs(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../graph/docs").join(name)
}

#[test]
fn the_table_in_the_docs_is_computed() {
    let text = std::fs::read_to_string(docs("color.md")).unwrap();
    let rows: Vec<String> = all().iter().map(Gray::row).collect();
    let missing = rows.iter().any(|row| !text.contains(row));
    assert!(!missing, "graph/docs/color.md has other figures than\n{}", rows.join("\n"));
}

/// With `AFTERIMAGE_WRITE_DOCS=1` this writes the plot.
#[test]
fn the_plot_in_the_docs_is_computed() {
    let svg = plot();
    if std::env::var_os("AFTERIMAGE_WRITE_DOCS").is_some() {
        std::fs::write(docs("curves.svg"), &svg).unwrap();
    }
    let found = std::fs::read_to_string(docs("curves.svg")).unwrap_or_default();
    assert!(found == svg, "graph/docs/curves.svg is old: run this test with AFTERIMAGE_WRITE_DOCS=1");
}

const LEFT: f64 = 60.0;
const RIGHT: f64 = 720.0;
const TOP: f64 = 30.0;
const BOTTOM: f64 = 430.0;
const INK: &str = "#1c2128";
const GRID: &str = "#e3e6ea";

/// Exposed light in stops from middle gray, from -7 to 7, against the code of an sRGB display.
fn plot() -> String {
    let x = |stops: f64| LEFT + (stops + 7.0) / 14.0 * (RIGHT - LEFT);
    let y = |signal: f64| BOTTOM - signal * (BOTTOM - TOP);
    let mut canvas = Canvas::new(900.0, 480.0);
    for stops in -7..=7 {
        let at = x(f64::from(stops));
        canvas.line((at, TOP), (at, BOTTOM), GRID, false);
        canvas.text((at, BOTTOM + 18.0), 12.0, Anchor::Middle, INK, &stops.to_string());
    }
    for code in [0, 50, 100, 118, 150, 200, 250] {
        let at = y(f64::from(code) / 255.0);
        canvas.line((LEFT, at), (RIGHT, at), GRID, code == 118);
        canvas.text((LEFT - 8.0, at + 4.0), 12.0, Anchor::End, INK, &code.to_string());
    }
    canvas.text((LEFT, 18.0), 13.0, Anchor::Start, INK, "sRGB code of exposed light in stops from middle gray (0.18)");
    for (index, curve) in all().iter().enumerate() {
        let point = |step: i32| {
            let stops = f64::from(step) / 16.0;
            (x(stops), y(srgb_encode((curve.matched)(0.18 * stops.exp2()).clamp(0.0, 1.0))))
        };
        canvas.path(&(-112..=112).map(point).collect::<Vec<_>>(), curve.color);
        canvas.text((RIGHT + 16.0, 50.0 + 20.0 * index as f64), 13.0, Anchor::Start, curve.color, curve.name);
    }
    canvas.finish()
}
