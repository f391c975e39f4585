//! Positions of names next to dots, without overlap.

use super::svg::Anchor;

/// Left, top, right, bottom.
type Box4 = [f64; 4];

/// Mean width of a letter, as a share of the font size.
const LETTER: f64 = 0.53;

pub(crate) struct Labels {
    taken: Vec<Box4>,
    bounds: Box4,
}

/// The position of a name.
pub(crate) struct Spot {
    pub(crate) at: (f64, f64),
    pub(crate) anchor: Anchor,
}

impl Labels {
    /// Names do not cover dots or the step line, and stay within the bounds.
    pub(crate) fn new(dots: &[(f64, f64)], steps: &[(f64, f64)], bounds: Box4) -> Self {
        let around = |(x, y): &(f64, f64)| [x - 7.0, y - 7.0, x + 7.0, y + 7.0];
        let along = |pair: &[(f64, f64)]| {
            let ((x0, y0), (x1, y1)) = (pair[0], pair[1]);
            [x0.min(x1) - 1.0, y0.min(y1) - 1.0, x0.max(x1) + 1.0, y0.max(y1) + 1.0]
        };
        Self { taken: dots.iter().map(around).chain(steps.windows(2).map(along)).collect(), bounds }
    }

    /// Takes the first free position around a dot.
    pub(crate) fn place(&mut self, (x, y): (f64, f64), size: f64, text: &str) -> Option<Spot> {
        let middle = y + 0.35 * size;
        let (above, below) = (y - 11.0, y + 11.0 + 0.75 * size);
        let places = [
            (x + 12.0, middle, Anchor::Start),
            (x - 12.0, middle, Anchor::End),
            (x, above, Anchor::Middle),
            (x, below, Anchor::Middle),
            (x + 9.0, above, Anchor::Start),
            (x + 9.0, below, Anchor::Start),
            (x - 9.0, above, Anchor::End),
            (x - 9.0, below, Anchor::End),
        ];
        let width = LETTER * size * text.chars().count() as f64;
        for (x, y, anchor) in places {
            let label = extent((x, y), anchor, width, size);
            if inside(label, self.bounds) && !self.taken.iter().any(|taken| meet(*taken, label)) {
                self.taken.push(label);
                return Some(Spot { at: (x, y), anchor });
            }
        }
        None
    }
}

fn extent((x, y): (f64, f64), anchor: Anchor, width: f64, size: f64) -> Box4 {
    let left = match anchor {
        Anchor::Start => x,
        Anchor::Middle => x - width / 2.0,
        Anchor::End => x - width,
    };
    [left, y - 0.8 * size, left + width, y + 0.25 * size]
}

fn inside(a: Box4, bounds: Box4) -> bool {
    a[0] >= bounds[0] && a[1] >= bounds[1] && a[2] <= bounds[2] && a[3] <= bounds[3]
}

fn meet(a: Box4, b: Box4) -> bool {
    a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3]
}
