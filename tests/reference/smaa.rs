//! SMAA 1x (Jimenez and others, 2012): edges, their shapes and the mixture, with areas of clipped polygons.

use super::image::{Image, mix4};

pub(crate) struct Smaa {
    pub(crate) threshold: f64,
    pub(crate) corners: f64,
    /// Pixels along rows and columns.
    pub(crate) reach: i64,
    /// Pixels along diagonals; 0 for none.
    pub(crate) diagonals: i64,
    /// True if the image is linear light.
    pub(crate) is_light: bool,
}

type Place = (i64, i64);

/// The edges of an image: of each pixel the one to its left and the one above it.
struct Edges {
    width: i64,
    height: i64,
    found: Vec<[bool; 2]>,
}

/// Rows, or columns: then both axes are exchanged.
#[derive(Clone, Copy)]
struct Axis {
    is_column: bool,
}

impl Axis {
    /// A place `along` a line and `across` it from another.
    fn go(self, (x, y): Place, along: i64, across: i64) -> Place {
        if self.is_column { (x + across, y + along) } else { (x + along, y + across) }
    }
}

impl Edges {
    fn at(&self, (x, y): Place) -> [bool; 2] {
        let is_inside = (0..self.width).contains(&x) && (0..self.height).contains(&y);
        if is_inside { self.found[(y * self.width + x) as usize] } else { [false; 2] }
    }

    fn is_left(&self, place: Place) -> bool {
        self.at(place)[0]
    }

    fn is_above(&self, place: Place) -> bool {
        self.at(place)[1]
    }

    fn on(&self, axis: Axis, place: Place) -> bool {
        self.at(place)[usize::from(!axis.is_column)]
    }

    fn crosses(&self, axis: Axis, place: Place) -> bool {
        self.at(place)[usize::from(axis.is_column)]
    }
}

/// The end of a line: how far it is, the first pixel behind it, and whether edges go on before and behind the line.
struct End {
    distance: i64,
    place: Place,
    sides: [bool; 2],
}

impl Smaa {
    pub(crate) fn apply(&self, image: &Image) -> Image {
        let edges = self.edges(image);
        let (width, height) = (edges.width, edges.height);
        let all: Vec<[f64; 4]> = (0..width * height).map(|i| self.weights(&edges, (i % width, i / width))).collect();
        let weights = |(x, y): Place| if x < width && y < height { all[(y * width + x) as usize] } else { [0.0; 4] };
        Image::new(image.width, image.height, |x, y| {
            let (x, y) = (x as i64, y as i64);
            let [above, _, left, _] = weights((x, y));
            let (right, below) = (weights((x + 1, y))[3], weights((x, y + 1))[1]);
            let is_across = left.max(right) > above.max(below);
            let (before, behind, dx, dy) = if is_across { (left, right, 1, 0) } else { (above, below, 0, 1) };
            let color = image.texel(x, y);
            if before + behind < 1e-5 {
                return color;
            }
            let first = mix4(color, image.texel(x - dx, y - dy), before);
            let second = mix4(color, image.texel(x + dx, y + dy), behind);
            mix4(first, second, behind / (before + behind))
        })
    }

    fn edges(&self, image: &Image) -> Edges {
        let (width, height) = (image.width as i64, image.height as i64);
        let seen = |x: i64, y: i64| {
            let [r, g, b, _] = image.texel(x, y);
            [r, g, b].map(|c| if self.is_light { c.max(0.0).sqrt() } else { c.max(0.0) })
        };
        let apart = |a: [f64; 3], b: [f64; 3]| (0..3).map(|c| (a[c] - b[c]).abs()).fold(0.0, f64::max);
        let found = |i: i64| {
            let (x, y) = (i % width, i / width);
            let steps = [(1, 0), (0, 1)];
            let own = steps.map(|(dx, dy)| apart(seen(x, y), seen(x - dx, y - dy)));
            let others = steps.into_iter().flat_map(|(dx, dy)| {
                let next = apart(seen(x, y), seen(x + dx, y + dy));
                [next, apart(seen(x - dx, y - dy), seen(x - 2 * dx, y - 2 * dy))]
            });
            let strongest = others.chain(own).fold(0.0, f64::max);
            own.map(|delta| delta >= self.threshold && 2.0 * delta >= strongest)
        };
        Edges { width, height, found: (0..width * height).map(found).collect() }
    }

    /// What of the pixel and of the one above it, and of the pixel and of the one to its left, belongs to the other.
    fn weights(&self, edges: &Edges, place: Place) -> [f64; 4] {
        let mut weights = [0.0; 4];
        if edges.is_above(place) {
            let [mut own, mut other] = [0.0; 2];
            if self.diagonals > 0 {
                let (rising, falling) = (self.diagonal(edges, place, true), self.diagonal(edges, place, false));
                (own, other) = (rising[0] + falling[1], rising[1] + falling[0]);
            }
            if own + other > 0.0 {
                return [own.min(1.0), other.min(1.0), 0.0, 0.0];
            }
            [weights[0], weights[1]] = self.line(edges, place, Axis { is_column: false });
        }
        if edges.is_left(place) {
            [weights[2], weights[3]] = self.line(edges, place, Axis { is_column: true });
        }
        weights
    }

    fn end(&self, edges: &Edges, place: Place, axis: Axis, side: i64) -> End {
        let mut distance = 0;
        loop {
            let last = axis.go(place, side * distance, 0);
            let border = if side > 0 { axis.go(last, 1, 0) } else { last };
            let sides = [-1, 0].map(|across| edges.crosses(axis, axis.go(border, 0, across)));
            let goes_on = edges.on(axis, axis.go(last, side, 0));
            if sides != [false; 2] || !goes_on || distance == self.reach {
                return End { distance, place: border, sides };
            }
            distance += 1;
        }
    }

    fn line(&self, edges: &Edges, place: Place, axis: Axis) -> [f64; 2] {
        let ends = [-1, 1].map(|side| self.end(edges, place, axis, side));
        let height = |end: &End| f64::from(i8::from(end.sides[0]) - i8::from(end.sides[1])) / 2.0;
        let mut heights = [height(&ends[0]), height(&ends[1])];
        for (one, other) in [(0, 1), (1, 0)] {
            if ends[one].sides == [true; 2] && ends[other].sides != [true; 2] {
                heights[one] = -heights[other];
            }
        }
        let length = (ends[0].distance + ends[1].distance + 1) as f64;
        let mut shares = [0.0; 2];
        for (end, height) in ends.iter().zip(heights) {
            let mut area = height.abs() * fall(end.distance as f64, length);
            if heights[0] == heights[1] {
                let part = (length / 32.0).min(1.0);
                area = part * area + (1.0 - part) * (2.0 * area).sqrt() / 2.0;
            }
            shares[usize::from(height > 0.0)] += area;
        }
        let nearest = ends[0].distance.min(ends[1].distance);
        let near: Vec<&End> = ends.iter().filter(|end| end.distance == nearest).collect();
        for (share, across) in shares.iter_mut().zip([1, -2]) {
            let longer = near.iter().filter(|end| edges.crosses(axis, axis.go(end.place, 0, across))).count();
            *share *= 1.0 - (1.0 - self.corners) * longer as f64 / near.len() as f64;
        }
        shares
    }

    /// Steps of a staircase, whether it ends within reach, and the edge above the pixel after the last step.
    fn staircase(&self, edges: &Edges, (x, y): Place, (dx, dy): Place) -> (i64, bool, bool) {
        let mut steps = 0;
        loop {
            let pixel = (x + (steps + 1) * dx, y + (steps + 1) * dy);
            let upright = if dx == dy { (pixel.0 + 1, pixel.1) } else { pixel };
            let (is_upright, is_above) = (edges.is_left(upright), edges.is_above(pixel));
            if !(is_upright && is_above) {
                return (steps, true, is_above);
            }
            steps += 1;
            if steps == self.diagonals {
                return (steps, false, true);
            }
        }
    }

    fn diagonal(&self, edges: &Edges, (x, y): Place, rises: bool) -> [f64; 2] {
        let slope = if rises { -1 } else { 1 };
        let is_upright = edges.is_left(if rises { (x, y) } else { (x + 1, y) });
        let (mut left, mut right) = ((0, true, false), (0, true, false));
        if is_upright || !rises {
            left = self.staircase(edges, (x, y), (-1, -slope));
        }
        if is_upright || rises {
            right = self.staircase(edges, (x, y), (1, slope));
        }
        let longer = if rises { &mut left } else { &mut right };
        longer.0 += i64::from(is_upright && longer.2);
        if left.0 + right.0 < 3 {
            return [0.0; 2];
        }
        let (first, last) = ((x - left.0, y - slope * left.0), (x + right.0, y + slope * right.0));
        let begins =
            [edges.is_above((first.0 - 1, first.1)), edges.is_left(if rises { first } else { (first.0, first.1 - 1) })];
        let ends = [
            edges.is_above((last.0 + 1, last.1)),
            edges.is_left(if rises { (last.0 + 1, last.1 - 1) } else { (last.0 + 1, last.1) }),
        ];
        let begins = if left.1 { begins } else { [false; 2] };
        let ends = if right.1 { ends } else { [false; 2] };
        diagonal_areas(left.0 as f64, right.0 as f64, begins, ends)
    }
}

/// The mean height between `from` and `from + 1` of a line that falls from 1 at 0 to 0 at half the length.
fn fall(from: f64, length: f64) -> f64 {
    let height = |x: f64| (1.0 - 2.0 * x / length).max(0.0);
    let cuts = [from, (length / 2.0).clamp(from, from + 1.0), from + 1.0];
    cuts.windows(2).map(|cut| (cut[1] - cut[0]) * (height(cut[0]) + height(cut[1])) / 2.0).sum()
}

/// The shares of a diagonal. The staircase's corners are at (1, 0), (1, 1), (2, 1) and so on; an end with one edge is
/// known, and of an end with none or both two lines are possible.
fn diagonal_areas(left: f64, right: f64, begins: [bool; 2], ends: [bool; 2]) -> [f64; 2] {
    let length = left + right + 1.0;
    let (low, inner, high) = ([0.0, 0.0], [1.0, 0.0], [1.0, 1.0]);
    let is_open = begins == [false; 2] && ends == [false; 2];
    let possible = |sides: [bool; 2]| match sides {
        [true, false] => [high, high],
        [false, true] => [inner, inner],
        [true, true] => [high, inner],
        [false, false] => [if is_open { high } else { low }, inner],
    };
    let starts = possible(begins);
    let stops = possible(if ends[0] == ends[1] { ends } else { [ends[1], ends[0]] });
    let mut shares = [0.0; 2];
    for (start, stop) in starts.into_iter().zip(stops) {
        let stop = [stop[0] + length, stop[1] + length];
        let share = |corner: [f64; 2]| area(&clip(corner, start, stop));
        shares[0] += (1.0 - share([1.0 + left, left])) / 2.0;
        shares[1] += share([1.0 + left, 1.0 + left]) / 2.0;
    }
    shares
}

/// The part of the unit square at `corner` to one side of a line.
fn clip([x, y]: [f64; 2], start: [f64; 2], stop: [f64; 2]) -> Vec<[f64; 2]> {
    let square = [[x, y], [x + 1.0, y], [x + 1.0, y + 1.0], [x, y + 1.0]];
    let side = |p: [f64; 2]| (stop[1] - start[1]) * (p[0] - start[0]) - (stop[0] - start[0]) * (p[1] - start[1]);
    let mut kept = Vec::new();
    for (index, &from) in square.iter().enumerate() {
        let to = square[(index + 1) % 4];
        let (a, b) = (side(from), side(to));
        if a >= 0.0 {
            kept.push(from);
        }
        if a * b < 0.0 {
            let t = a / (a - b);
            kept.push([from[0] + t * (to[0] - from[0]), from[1] + t * (to[1] - from[1])]);
        }
    }
    kept
}

/// The area of a polygon.
fn area(polygon: &[[f64; 2]]) -> f64 {
    let next = polygon.iter().cycle().skip(1);
    let twice: f64 = polygon.iter().zip(next).map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum();
    twice.abs() / 2.0
}

#[test]
fn a_step_in_the_middle_of_an_edge_becomes_a_straight_line() {
    // An edge that falls by one row in the middle: the line goes from half a row above to half a row below.
    let image = Image::new(16, 6, |x, y| [if y < 3 + x / 8 { 0.2 } else { 0.8 }; 4]);
    let smaa = Smaa { threshold: 0.1, corners: 0.25, reach: 32, diagonals: 8, is_light: false };
    let smooth = smaa.apply(&image);
    // Both edges end at the border without another step: an L, whose line ends in the middle.
    let row: Vec<f64> = (8..16).map(|x| (smooth.texel(x, 3)[0] - 0.2) / 0.6).collect();
    let wanted = [7.0 / 16.0, 5.0 / 16.0, 3.0 / 16.0, 1.0 / 16.0, 0.0, 0.0, 0.0, 0.0];
    assert!(row.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-12), "{row:?}");
}

#[test]
fn half_of_each_pixel_beside_a_diagonal_of_one_step_is_taken() {
    // In the middle of a long staircase the line goes through the middles of its steps.
    let [own, other] = diagonal_areas(5.0, 5.0, [false; 2], [false; 2]);
    assert!((own - 0.25).abs() < 1e-12 && (other - 0.25).abs() < 1e-12, "{own} {other}");
}
