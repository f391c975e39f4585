//! The chart of the walk: the exposure over time, and the differences between frame rates.

use afterimage_lab::plot::canvas::{Anchor, Canvas};
use afterimage_lab::plot::palette::{BLUE, GREEN, GRID, INK, ORANGE, SOFT};

use super::walk::{CUT, END, Track, WALK, Walk};

const WIDTH: f64 = 1280.0;
const HEIGHT: f64 = 800.0;
const LEFT: f64 = 90.0;
const RIGHT: f64 = 1240.0;
/// From the bottom to the top of both charts.
const EXPOSURE: (f64, f64) = (530.0, 130.0);
const DIFFERENCE: (f64, f64) = (720.0, 600.0);
/// The largest difference between frame rates, in percent.
const MOST: f64 = 1.0;

const WANTED: &str = "#a9b1bb";
const UNDECLARED: &str = ORANGE;
/// Of each rate.
const COLORS: [&str; 3] = ["#c2347c", BLUE, GREEN];

/// A linear axis from `low` to `high`.
#[derive(Clone, Copy)]
struct Axis {
    low: f64,
    high: f64,
    places: (f64, f64),
}

impl Axis {
    fn place(self, number: f64) -> f64 {
        let (from, to) = self.places;
        from + (number - self.low) / (self.high - self.low) * (to - from)
    }

    fn whole_numbers(self) -> impl Iterator<Item = f64> {
        (self.low.ceil() as i32..=self.high.floor() as i32).map(f64::from)
    }
}

const SECONDS: Axis = Axis { low: 0.0, high: END, places: (LEFT, RIGHT) };

/// The charts as an SVG file.
pub(super) fn svg(walk: &Walk) -> String {
    let mut canvas = Canvas::new(WIDTH, HEIGHT);
    canvas.text((40.0, 52.0), 28.0, Anchor::Start, INK, "An exposure follows a camera from the room to the window");
    exposure(&mut canvas, walk);
    difference(&mut canvas, walk);
    canvas.finish()
}

fn exposure(canvas: &mut Canvas, walk: &Walk) {
    let stops: Vec<f64> = walk.wanted.stops.iter().chain(&walk.undeclared.stops).copied().collect();
    let (low, high) = (stops.iter().copied().fold(f64::MAX, f64::min), stops.iter().copied().fold(f64::MIN, f64::max));
    let up = Axis { low: low.floor(), high: high.ceil(), places: EXPOSURE };
    grid(canvas, up, "stops");
    events(canvas);
    let line = |points: &mut dyn Iterator<Item = (f64, f64)>| points.map(|point| place(up, point)).collect::<Vec<_>>();
    canvas.path(&line(&mut walk.wanted.points()), WANTED);
    canvas.path(&line(&mut walk.undeclared.points().filter(|(seconds, _)| *seconds >= CUT)), UNDECLARED);
    if let Some((highest, others)) = walk.followed.split_last() {
        canvas.path(&line(&mut highest.points()), COLORS[others.len()]);
        dots(canvas, up, others.iter().map(|track| track.common().collect()));
    }
    legend(canvas, walk);
}

fn difference(canvas: &mut Canvas, walk: &Walk) {
    let up = Axis { low: -MOST, high: MOST, places: DIFFERENCE };
    let highest = walk.followed.last().map_or(0, |track| track.rate);
    grid(canvas, up, &format!("percent of light more or less than at {highest} frames per second"));
    let (_, others) = walk.followed.split_last().expect("there are several rates");
    dots(canvas, up, others.iter().map(|track| walk.difference(track)));
    for second in SECONDS.whole_numbers() {
        let at = (SECONDS.place(second), DIFFERENCE.0 + 24.0);
        canvas.text(at, 15.0, Anchor::Middle, SOFT, &second.to_string());
    }
    let middle = f64::midpoint(LEFT, RIGHT);
    canvas.text((middle, DIFFERENCE.0 + 54.0), 16.0, Anchor::Middle, INK, "seconds");
}

fn place(up: Axis, (seconds, number): (f64, f64)) -> (f64, f64) {
    (SECONDS.place(seconds), up.place(number))
}

fn grid(canvas: &mut Canvas, up: Axis, name: &str) {
    let (bottom, top) = up.places;
    for number in up.whole_numbers() {
        let y = up.place(number);
        canvas.line((LEFT, y), (RIGHT, y), GRID, false);
        canvas.text((LEFT - 12.0, y + 5.0), 15.0, Anchor::End, SOFT, &number.to_string());
    }
    for second in SECONDS.whole_numbers() {
        let x = SECONDS.place(second);
        canvas.line((x, bottom), (x, top), GRID, false);
    }
    canvas.text((40.0, top - 16.0), 16.0, Anchor::Start, INK, name);
}

/// Marks the events of the walk.
fn events(canvas: &mut Canvas) {
    for (seconds, what) in [(WALK, "at the window"), (CUT, "cut to the room")] {
        let x = SECONDS.place(seconds);
        canvas.line((x, EXPOSURE.0), (x, EXPOSURE.1), SOFT, true);
        canvas.text((x, EXPOSURE.1 - 8.0), 15.0, Anchor::Middle, SOFT, what);
    }
}

/// Two tracks that may coincide: rings around small dots.
fn dots(canvas: &mut Canvas, up: Axis, tracks: impl Iterator<Item = Vec<(f64, f64)>>) {
    for ((points, color), (radius, fill)) in tracks.zip(COLORS).zip([(5.0, "none"), (1.5, COLORS[1])]) {
        for point in points {
            canvas.dot(place(up, point), radius, fill, color, "");
        }
    }
}

fn legend(canvas: &mut Canvas, walk: &Walk) {
    let frames = |track: &Track| format!("{} frames per second", track.rate);
    let rates = walk.followed.iter().map(frames).zip(COLORS);
    let others = [("exposure of the view alone".to_owned(), WANTED), ("no reset at the cut".to_owned(), UNDECLARED)];
    let mut x = 46.0;
    for (name, color) in rates.chain(others) {
        canvas.dot((x, 78.0), 5.0, color, color, "");
        canvas.text((x + 13.0, 83.0), 14.0, Anchor::Start, SOFT, &name);
        x += 44.0 + 6.8 * name.chars().count() as f64;
    }
}
