//! Lenses, shutters, frames and edges against their definitions in f64: integrals over an aperture, over the time of a
//! shutter and over pixels, and laws of optics. Nothing here repeats how a kind computes.

use afterimage_graph::node::Camera;
use glam::{DVec2, dvec2};

use super::surface::eye;
use super::taa::halton;
use crate::support::gpu::{Picture, Run};
use crate::support::harness::Nodes;
use crate::support::sequence::Sequence;

const SIZE: [u32; 2] = [80, 64];
/// Pixels at the border, beyond which a node sees nothing.
const BORDER: u32 = 12;
const SAMPLES: u32 = 500;

/// True if the surface in front is at a place in pixels, and the light of a surface there.
type Front = fn(DVec2) -> bool;
type Light = fn(DVec2) -> f64;

/// Two surfaces: where the one in front is, and the light of both.
#[derive(Clone, Copy)]
struct Surfaces {
    is_front: Front,
    front: Light,
    back: Light,
}

fn disc(p: DVec2) -> bool {
    p.distance(dvec2(40.3, 31.7)) < 15.0
}

fn slope(p: DVec2) -> bool {
    p.x + 0.23 * p.y < 48.0
}

fn bar(p: DVec2) -> bool {
    (p.x + 0.35 * p.y - 51.0).abs() < 2.7
}

const FRONTS: [(&str, Front); 3] = [("disc", disc), ("slope", slope), ("bar", bar)];

fn dark(_: DVec2) -> f64 {
    0.1
}

fn bright(_: DVec2) -> f64 {
    1.0
}

/// Ripples of eight pixels around 1.
fn ripples(p: DVec2) -> f64 {
    1.0 + 0.4 * (0.8 * p.x + 0.3 * p.y).sin() * (0.7 * p.y).cos()
}

/// Steps of sequences that fill the unit square evenly, over a pixel and over an aperture.
const PIXEL: [f64; 2] = [0.754_877_666, 0.569_840_291];
const APERTURE: [f64; 2] = [0.236_067_977, 0.645_751_311];

fn even(i: u32, steps: [f64; 2]) -> DVec2 {
    DVec2::from_array(steps.map(|step| ((f64::from(i) + 0.5) * step).fract()))
}

impl Surfaces {
    fn light(&self, front: DVec2, back: DVec2) -> f64 {
        if (self.is_front)(front) { (self.front)(front) } else { (self.back)(back) }
    }

    /// The mean over a pixel, and over samples of a lens or of a moment that are moved in the front and in the back.
    fn mean(&self, moved: impl Fn(u32) -> [DVec2; 2]) -> Vec<f64> {
        let pixel = |x: u32, y: u32| {
            let sample = |i: u32| {
                let place = dvec2(f64::from(x), f64::from(y)) + even(i, PIXEL);
                let [front, back] = moved(i);
                self.light(place + front, place + back)
            };
            (0..SAMPLES).map(sample).sum::<f64>() / f64::from(SAMPLES)
        };
        (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| (x, y))).map(|(x, y)| pixel(x, y)).collect()
    }

    /// The image of a renderer: the mean over each pixel.
    fn drawn(&self) -> Picture {
        let mean = self.mean(|_| [DVec2::ZERO; 2]);
        Picture::new(SIZE[0], SIZE[1], |x, y| gray(mean[(y * SIZE[0] + x) as usize]))
    }

    fn is_front_at(&self, x: u32, y: u32) -> bool {
        (self.is_front)(dvec2(f64::from(x) + 0.5, f64::from(y) + 0.5))
    }

    /// Numbers of the surface in the middle of each pixel.
    fn data(&self, front: [f32; 2], back: [f32; 2]) -> Picture {
        Picture::new(SIZE[0], SIZE[1], |x, y| {
            let [a, b] = if self.is_front_at(x, y) { front } else { back };
            [a, b, 0.0, 1.0]
        })
    }

    /// Root mean square of the error at the edge of the front, where the next pixel shows the other surface, and the
    /// largest one anywhere.
    fn errors(&self, found: &Picture, wanted: &[f64]) -> [f64; 2] {
        let (mut square, mut count, mut most) = (0.0, 0.0, 0.0_f64);
        for (x, y) in (BORDER..SIZE[1] - BORDER).flat_map(|y| (BORDER..SIZE[0] - BORDER).map(move |x| (x, y))) {
            let error = f64::from(found.at(x, y)[0]) - wanted[(y * SIZE[0] + x) as usize];
            most = most.max(error.abs());
            let around = [(x - 1, y), (x + 1, y), (x, y - 1), (x, y + 1)];
            if around.into_iter().any(|(i, j)| self.is_front_at(i, j) != self.is_front_at(x, y)) {
                square += error * error;
                count += 1.0;
            }
        }
        [f64::sqrt(square / f64::max(count, 1.0)), most]
    }
}

fn gray(light: f64) -> [f32; 4] {
    [light as f32, light as f32, light as f32, 1.0]
}

/// The radius of the circle of confusion in pixels, with its sign, of a thin lens of 100 mm at f/1.2 and a sensor of 24
/// mm: by the images of both distances behind the lens.
fn circle(focus: f64, distance: f64) -> f64 {
    let image = |distance: f64| 1.0 / (1.0 / 100.0 - 1.0 / (1000.0 * distance));
    0.5 * (100.0 / 1.2) * (image(focus) - image(distance)) / image(distance) / 24.0 * f64::from(SIZE[1])
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
#[expect(clippy::print_stdout, reason = "the figures say how good the kind is")]
fn a_lens_shows_the_mean_of_what_is_seen_through_its_aperture() {
    const NEAR: f64 = 2.0;
    const FAR: f64 = 40.0;
    // The focus, and the largest errors at the edge and anywhere: of surfaces of one color, and with ripples behind.
    // Nothing says how much a pixel beside a front in focus shows of it: there ripples behind stay as they are drawn.
    let limits =
        [(FAR, [[0.02, 0.06], [0.15, 0.35]]), (NEAR, [[0.02, 0.1], [0.14, 0.45]]), (4.0, [[0.02, 0.06], [0.1, 0.25]])];
    for (focus, [plain, rippled]) in limits {
        let backs: [(Light, [f64; 2]); 2] = [(bright, plain), (ripples, rippled)];
        for (back, limits) in backs {
            for (name, is_front) in FRONTS {
                let surfaces = Surfaces { is_front, front: dark, back };
                let wanted = surfaces.mean(|i| {
                    let place = even(i, APERTURE);
                    let (radius, angle) = (place.x.sqrt(), std::f64::consts::TAU * place.y);
                    let aperture = radius * dvec2(angle.cos(), angle.sin());
                    [NEAR, FAR].map(|distance| circle(focus, distance) * aperture)
                });
                let depth = surfaces.data([NEAR as f32, 0.0], [FAR as f32, 0.0]);
                let text = format!(
                    "\"result\": DepthOfField(source: \"in\", depth: \"depth\", focus: {focus:?}, f_stop: 1.2, \
                     focal_length: 100.0, largest: 0.1, rings: 12)"
                );
                let nodes = Nodes::new(&text, &[("in", "Color"), ("depth", "Depth")]);
                let drawn = surfaces.drawn();
                let [edge, most] = surfaces.errors(&nodes.exact(&[&drawn, &depth]), &wanted);
                let without = surfaces.errors(&drawn, &wanted);
                println!("focus on {focus} m, {name}: {edge:.4}, {most:.3}; without {without:.3?}");
                assert!(edge < limits[0] && most < limits[1], "focus on {focus} m, {name}: {edge}, {most}");
            }
        }
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
#[expect(clippy::print_stdout, reason = "the figures say how good the kind is")]
fn a_shutter_shows_the_mean_of_the_moments_while_it_is_open() {
    // Half of the ways in pixels of the front and of the back.
    for ways in [[dvec2(6.0, 0.0), DVec2::ZERO], [dvec2(5.0, 2.5), DVec2::ZERO], [DVec2::ZERO, dvec2(6.0, 0.0)]] {
        for (name, is_front) in FRONTS {
            let surfaces = Surfaces { is_front, front: bright, back: dark };
            let wanted = surfaces.mean(|i| {
                let moment = 2.0 * (f64::from(i) + 0.5) / f64::from(SAMPLES) - 1.0;
                ways.map(|way| -moment * way)
            });
            let [front, back] = ways.map(|way| (2.0 * way).as_vec2().to_array());
            let (motion, depth) = (surfaces.data(front, back), surfaces.data([2.0, 0.0], [8.0, 0.0]));
            let text = "\"result\": MotionBlur(source: \"in\", motion: \"motion\", depth: \"depth\", unit: Pixels, \
                        shutter: 360.0, largest: 0.1, samples: 64)";
            let nodes = Nodes::new(text, &[("in", "Color"), ("motion", "Motion"), ("depth", "Depth")]);
            let drawn = surfaces.drawn();
            let [edge, most] = surfaces.errors(&nodes.exact(&[&drawn, &motion, &depth]), &wanted);
            let without = surfaces.errors(&drawn, &wanted);
            println!("{ways:?} {name}: {edge:.4}, {most:.3}; without {without:.3?}");
            assert!(edge < 0.025 && most < 0.1, "{ways:?} {name}: {edge}, {most}");
        }
    }
}

/// Light as a simple display shows it: `white` is half as bright as it can be.
fn shown(light: f64, white: f64) -> f64 {
    light / (light + white)
}

/// A slanted edge before a sky of this light, in frames of one sample in each pixel: root mean squares of the errors of
/// one frame and of the mean of many, as they are shown, and the largest of the latter.
fn errors_before_a_sky(sky: f64, slant: f64, parameters: &str) -> [f64; 3] {
    const WHITE: f64 = 8.0;
    let light = |p: DVec2| if p.y - slant * (p.x - 32.0) > 24.3 { 0.1 } else { sky };
    let text = format!(
        "\"result\": Taa(source: \"in\", history: \"result@previous\", depth: \"depth\", camera: \"camera\", \
         white: {WHITE:?}, {parameters})"
    );
    let camera = eye();
    let graph = Nodes::new(&text, &[("in", "Color"), ("depth", "Depth")]).camera(Some(&camera)).graph();
    let run = Run::new(&graph).camera(Some(&camera)).exact();
    let mut sequence = Sequence::new(&run);
    let depth = Picture::new(64, 48, |_, _| [3.0, 0.0, 0.0, 1.0]);
    let middle = |x: u32, y: u32| dvec2(f64::from(x) + 0.5, f64::from(y) + 0.5);
    for index in 0..48_u32 {
        let jitter = [halton(index % 16 + 1, 2), halton(index % 16 + 1, 3)];
        sequence.camera(&Camera { jitter, ..eye() });
        let moved = dvec2(f64::from(jitter[0]), f64::from(jitter[1]));
        let frame = Picture::new(64, 48, |x, y| gray(light(middle(x, y) + moved)));
        sequence.frame(&[("in", &frame), ("depth", &depth)], 0.04, index == 0);
    }
    let found = sequence.output("out");
    let (mut one, mut many, mut most) = (0.0, 0.0, 0.0_f64);
    for (x, y) in (4..44).flat_map(|y| (4..60).map(move |x| (x, y))) {
        // The mean of the light as it is shown, over a pixel with the sharp filter of a renderer.
        let (mut sum, mut total) = (0.0, 0.0);
        for i in 0..SAMPLES {
            let apart = 3.0 * (even(i, PIXEL) - 0.5);
            let weight = (-2.29 * apart.length_squared()).exp();
            sum += weight * shown(light(middle(x, y) + apart), WHITE);
            total += weight;
        }
        let off = shown(f64::from(found.at(x, y)[0]), WHITE) - sum / total;
        one += (shown(light(middle(x, y)), WHITE) - sum / total).powi(2);
        many += off * off;
        most = most.max(off.abs());
    }
    [f64::sqrt(one / many), f64::sqrt(many / (40.0 * 56.0)), most]
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
#[expect(clippy::print_stdout, reason = "the figures say how good the kind is")]
fn frames_become_the_mean_over_a_pixel_before_any_sky() {
    for (sky, parameters) in
        [(1.0, ""), (16.0, ""), (1000.0, ""), (100.0, "keep_above: 64.0"), (1000.0, "keep_above: 64.0")]
    {
        for slant in [0.07, 0.35] {
            let [gain, error, most] = errors_before_a_sky(sky, slant, parameters);
            println!("sky of {sky}, {slant}, {parameters}: error {error:.4}, {most:.3}, of one frame {gain:.1} times");
            // A running mean with 0.08 of each new frame counts 24 of them: the error of independent samples falls to a
            // fifth.
            assert!(gain > 4.0 && most < 0.12, "a sky of {sky}, {slant}, {parameters}: {gain}, {error}, {most}");
        }
    }
}

/// The share of a pixel above a line of that slope through a place.
fn coverage(x: u32, y: u32, slope: f64, at: DVec2) -> f64 {
    let column = |i: u32| {
        let across = f64::from(x) + (f64::from(i) + 0.5) / 64.0;
        (at.y + slope * (across - at.x) - f64::from(y)).clamp(0.0, 1.0)
    };
    (0..64).map(column).sum::<f64>() / 64.0
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
#[expect(clippy::print_stdout, reason = "the figures say how good the kinds are")]
fn edges_of_every_slope_come_near_to_their_coverage() {
    // Steps of 1 to 30 pixels, lying and upright, bright above and below.
    for state in ["DisplayLinear", "Encoded"] {
        let mut sums = [0.0; 3];
        for slope in [0.033, 0.05, 0.09, 0.17, 0.31, 0.41, 0.59, 0.83, 0.96] {
            let mut errors = [0.0; 3];
            for turn in 0..4 {
                let share = |x: u32, y: u32| {
                    let (x, y) = if turn & 1 == 0 { (x, y) } else { (y, x) };
                    let upper = coverage(x, y, slope, dvec2(32.3, 31.8));
                    0.05 + 0.9 * if turn & 2 == 0 { upper } else { 1.0 - upper }
                };
                let aliased = Picture::new(64, 64, |x, y| gray(if share(x, y) > 0.5 { 0.95 } else { 0.05 }));
                let smooth = |node: &str| {
                    Nodes::new(&format!("\"result\": {node}(source: \"in\")"), &[("in", state)]).exact(&[&aliased])
                };
                for (error, picture) in errors.iter_mut().zip([&aliased, &smooth("Smaa"), &smooth("Fxaa")]) {
                    for (x, y) in (8..56).flat_map(|y| (8..56).map(move |x| (x, y))) {
                        *error += (f64::from(picture.at(x, y)[0]) - share(x, y)).powi(2);
                    }
                }
            }
            let [none, smaa, fxaa] = errors.map(f64::sqrt);
            println!("{state} {slope}: Smaa {:.2}, Fxaa {:.2} of the error", smaa / none, fxaa / none);
            assert!(smaa < 0.6 * none && fxaa < 0.8 * none, "{state} {slope}: {smaa}, {fxaa} of {none}");
            for (sum, error) in sums.iter_mut().zip(errors) {
                *sum += error;
            }
        }
        let [none, smaa, fxaa] = sums.map(f64::sqrt);
        println!("{state}: Smaa {:.3}, Fxaa {:.3} of the error", smaa / none, fxaa / none);
    }
}

/// The light of one pixel through a node.
fn of_a_light(node: &str, [width, height]: [u32; 2], at: [u32; 2], radius: f64) -> Picture {
    let lit = Picture::new(width, height, |x, y| {
        let apart = dvec2(f64::from(x) - f64::from(at[0]), f64::from(y) - f64::from(at[1]));
        gray(if radius == 0.0 {
            f64::from(u8::from(apart == DVec2::ZERO))
        } else {
            (-0.5 * (apart / radius).length_squared()).exp()
        })
    });
    Nodes::new(&format!("\"result\": {node}"), &[("in", "Exposed")]).exact(&[&lit])
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_streak_is_an_exponential_that_holds_all_of_the_light() {
    for (rotation, length, size, at) in [(0, 6.4, [128, 5], [61, 2]), (90, 3.0, [7, 100], [3, 55])] {
        let node = format!(
            "Streaks(source: \"in\", length: {:?}, rotation: {rotation}.0, tint: (1.0, 1.0, 1.0))",
            length / f64::from(size[1])
        );
        let found = of_a_light(&node, size, at, 0.0);
        let sum: f64 = found.pixels.iter().map(|pixel| f64::from(pixel[0])).sum();
        assert!((sum - 1.0).abs() < 0.002, "{rotation}: {sum} of the light");
        for (index, pixel) in found.pixels.iter().enumerate() {
            let place = [index as u32 % size[0], index as u32 / size[0]].map(f64::from);
            let apart = [place[0] - f64::from(at[0]), place[1] - f64::from(at[1])];
            let (along, aside) = if rotation == 0 { (apart[0], apart[1]) } else { (apart[1], apart[0]) };
            // Of two geometric series, one to each side.
            let whole = 0.5 * (1.0 - (-1.0 / length).exp()) * (-along.abs() / length).exp();
            let wanted = if aside != 0.0 {
                0.0
            } else if along == 0.0 {
                2.0 * whole
            } else {
                whole
            };
            let error = (f64::from(pixel[0]) - wanted).abs();
            assert!(
                along.abs() > 5.0 * length || error < 0.008 * wanted + 1e-7,
                "{rotation} {along}: {pixel:?}, not {wanted}"
            );
        }
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_star_has_its_points_and_holds_all_of_the_light() {
    let (side, at, length) = (181, [90, 90], 8.0);
    for (points, rotation) in [(1, 30.0), (3, 20.0), (4, 45.0), (6, -13.0), (8, 0.0)] {
        let node = format!(
            "Streaks(source: \"in\", length: {:?}, points: {points}, rotation: {rotation:?}, tint: (1.0, 1.0, 1.0))",
            length / f64::from(side)
        );
        let found = of_a_light(&node, [side, side], at, 0.0);
        let lit = found.pixels.iter().enumerate().map(|(index, pixel)| {
            let place = dvec2(f64::from(index as u32 % side), f64::from(index as u32 / side)) - 90.0;
            (place, f64::from(pixel[0]))
        });
        let sum: f64 = lit.clone().map(|(_, light)| light).sum();
        assert!((sum - 1.0).abs() < 0.004, "{points}: {sum} of the light");
        for point in 0..points {
            let turn = (360.0 * f64::from(point) / f64::from(points) + rotation).to_radians();
            let axis = dvec2(turn.cos(), turn.sin());
            // The light from 12 to 28 pixels along the line, all across it.
            let is_there = |place: DVec2| {
                let (along, aside) = (place.dot(axis), place.perp_dot(axis).abs());
                (12.0..28.0).contains(&along) && aside < 3.0
            };
            let there: f64 = lit.clone().filter(|(place, _)| is_there(*place)).map(|(_, light)| light).sum();
            let wanted = (f64::exp(-12.0 / length) - f64::exp(-28.0 / length)) / f64::from(points);
            assert!((there / wanted - 1.0).abs() < 0.12, "{points}, line {point}: {there}, not {wanted}");
        }
    }
}

/// The middle of light, and its standard deviation across.
fn moments(light: impl Iterator<Item = (DVec2, f64)> + Clone) -> (DVec2, f64) {
    let sum: f64 = light.clone().map(|(_, light)| light).sum();
    let middle = light.clone().map(|(place, light)| light * place).sum::<DVec2>() / sum;
    let square: f64 = light.map(|(place, light)| light * (place.x - middle.x).powi(2)).sum();
    (middle, (square / sum).sqrt())
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn ghosts_lie_on_the_line_through_the_middle_and_the_ring_is_round() {
    let (size, at, radius) = ([120, 80], [72, 46], 2.5);
    let ghosts = |count: u32| {
        let node = format!(
            "LensFlare(source: \"in\", ghosts: {count}, spacing: 0.4, ghost_strength: 1.0, halo_strength: 0.0, \
             dispersion: 0.0)"
        );
        of_a_light(&node, size, at, radius)
    };
    let middle = dvec2(60.0, 40.0);
    let light = dvec2(f64::from(at[0]) + 0.5, f64::from(at[1]) + 0.5) - middle;
    let place = |index: usize| dvec2((index % 120) as f64 + 0.5, (index / 120) as f64 + 0.5);
    let mut before = vec![0.0; 120 * 80];
    for count in 1..=4_u32 {
        // The mean of some ghosts without that of all before it is the last one.
        let all: Vec<f64> = ghosts(count).pixels.iter().map(|pixel| f64::from(count) * f64::from(pixel[1])).collect();
        let last = all.iter().zip(&before).enumerate().map(|(index, (all, before))| (place(index), all - before));
        let magnification = if count % 2 == 1 { -0.4 } else { 0.4 } * f64::from(count);
        let (found, width) = moments(last);
        before = all;
        let wanted = middle + magnification * light;
        assert!(found.distance(wanted) < 0.1, "ghost {count}: at {found}, not {wanted}");
        assert!((width / (magnification.abs() * radius) - 1.0).abs() < 0.1, "ghost {count}: {width} wide");
    }
    let node = "LensFlare(source: \"in\", ghosts: 0, halo_radius: 0.3, halo_strength: 1.0, dispersion: 0.0)";
    let ring = of_a_light(node, size, [60, 40], radius);
    let green = ring.pixels.iter().map(|pixel| f64::from(pixel[1]));
    let lit = green.enumerate().map(|(i, light)| (place(i).distance(middle - 0.5), light));
    let lit: Vec<(f64, f64)> = lit.filter(|(radius, _)| *radius > 1.0).collect();
    // Rings are the longer the wider they are.
    let along: f64 = lit.iter().map(|(radius, light)| light / radius).sum();
    let mean = lit.iter().map(|(_, light)| light).sum::<f64>() / along;
    let square = lit.iter().map(|(radius, light)| (radius - 24.0).powi(2) * light / radius).sum::<f64>() / along;
    assert!((mean - 24.0).abs() < 0.3 && square < 2.0 * radius * radius, "{mean}, {square}");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_line_is_drawn_at_steps_and_folds_of_surfaces_and_nowhere_else() {
    let (size, tangent) = ([96, 64], 0.5);
    // The distance of a plane with this normal, the eye 1.5 m from it, along the ray of a pixel: the law of a pinhole.
    let plane = |normal: [f64; 3], x: u32, y: u32| {
        let up = tangent * (1.0 - 2.0 * (f64::from(y) + 0.5) / 64.0);
        let right = tangent * 1.5 * (2.0 * (f64::from(x) + 0.5) / 96.0 - 1.0);
        let facing = normal[0] * right + normal[1] * up - normal[2];
        if facing < 0.0 { (-1.5 / facing).min(60000.0) } else { 60000.0 }
    };
    let lines = |width: u32, depth: &dyn Fn(u32, u32) -> f64| {
        let distances = Picture::new(size[0], size[1], |x, y| [depth(x, y) as f32, 0.0, 0.0, 1.0]);
        let white = Picture::new(size[0], size[1], |_, _| [1.0; 4]);
        let text = format!("\"result\": Outline(source: \"in\", depth: \"depth\", width: {width})");
        Nodes::new(&text, &[("in", "Exposed"), ("depth", "Depth")]).exact(&[&white, &distances])
    };
    // Floors and walls that the eye sees at any angle, down to one degree.
    for degrees in [1.0, 5.0, 20.0, 45.0, 80.0_f64] {
        for side in [0.0, 0.3, 1.0] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let normal = [cos * side, cos * (1.0_f64 - side * side).sqrt(), sin];
            let depth = |x: u32, y: u32| plane(normal, x, y);
            let found = lines(1, &depth);
            let is_whole = |x: u32, y: u32| {
                [(x - 1, y), (x + 1, y), (x, y - 1), (x, y + 1)].iter().all(|(x, y)| depth(*x, *y) < 2000.0)
            };
            for (x, y) in (1..63).flat_map(|y| (1..95).map(move |x| (x, y))).filter(|(x, y)| is_whole(*x, *y)) {
                assert!(found.at(x, y)[0] > 0.999, "{degrees} degrees, {side}: a line at {x}, {y}");
            }
        }
    }
    // A step: the line is as wide to both sides of it. A fold between floor and wall is a line, too.
    for width in [1, 2, 3] {
        let found = lines(width, &|x, _| if x < 40 { 2.0 } else { 3.0 });
        let dark: Vec<u32> = (0..96).filter(|x| found.at(*x, 30)[0] < 0.01).collect();
        assert_eq!(dark, (40 - width..40 + width).collect::<Vec<_>>());
    }
    let folded = lines(1, &|x, y| plane([0.0, 1.0, 0.0], x, y).min(20.0));
    let rows: Vec<u32> = (2..62).filter(|y| folded.at(48, *y)[0] < 0.5).collect();
    assert!((1..=2).contains(&rows.len()), "{rows:?}");
}

/// The source of each pixel's light, in pixels: an image of places, seen through the air.
fn places(text: &str, mask: Option<&Picture>, time: f64) -> Vec<DVec2> {
    let ramp = Picture::new(120, 80, |x, y| [x as f32 + 0.5, y as f32 + 0.5, 0.0, 1.0]);
    let inputs = [("in", "Color"), ("mask", "Mask")];
    let wire = if mask.is_some() { "mask: \"mask\"" } else { "" };
    let graph = Nodes::new(
        &format!("\"result\": HeatHaze(source: \"in\", {text} {wire})"),
        &inputs[..1 + usize::from(mask.is_some())],
    )
    .graph();
    let mut run = Run::new(&graph).exact();
    run.time = time;
    let given: Vec<_> = [Some(("in", &ramp)), mask.map(|mask| ("mask", mask))].into_iter().flatten().collect();
    let found = run.frame(&given).remove(0);
    let apart = |(found, own): (&[f32; 4], &[f32; 4])| {
        dvec2(f64::from(found[0]) - f64::from(own[0]), f64::from(found[1]) - f64::from(own[1]))
    };
    found.pixels.iter().zip(&ramp.pixels).map(apart).collect()
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn hot_air_moves_places_to_and_fro_within_its_strength_and_as_time_passes() {
    // 0.05 heights are 4 pixels, which are all seen inside of a border of 4.
    let inner = |index: &usize| (5..115).contains(&(index % 120)) && (5..75).contains(&(index / 120));
    let text = "strength: 0.05, scale: 0.1, speed: 0.25, shape: 1.0,";
    let [now, soon, later] = [3.0, 3.02, 4.0].map(|time| places(text, None, time));
    let inside: Vec<usize> = (0..120 * 80).filter(inner).collect();
    let mean = inside.iter().map(|i| now[*i]).sum::<DVec2>() / inside.len() as f64;
    let most = inside.iter().map(|i| now[*i].abs().max_element()).fold(0.0, f64::max);
    let spread = (inside.iter().map(|i| now[*i].length_squared()).sum::<f64>() / (2 * inside.len()) as f64).sqrt();
    assert!(most <= 4.0 + 1e-3 && most > 2.0 && mean.abs().max_element() < 0.35, "{most}, {mean}");
    let apart = |other: &[DVec2]| {
        (inside.iter().map(|i| now[*i].distance_squared(other[*i])).sum::<f64>() / (2 * inside.len()) as f64).sqrt()
    };
    // In a fiftieth of a second swirls of 8 pixels rise by 0.4; in a second by 20, and nothing is left of them.
    assert!(apart(&soon) < 0.3 * spread && apart(&later) > spread, "{}, {} of {spread}", apart(&soon), apart(&later));
    let risen = inside.iter().filter(|i| *i / 120 < 55).map(|i| later[*i].distance(now[*i + 20 * 120]));
    assert!(risen.fold(0.0, f64::max) < 0.02, "swirls rise as they are");
    let half = Picture::new(120, 80, |x, _| [if x < 60 { 0.0 } else { 0.5 }, 0.0, 0.0, 1.0]);
    let masked = places(text, Some(&half), 3.0);
    for index in inside {
        let wanted = if index % 120 < 60 { DVec2::ZERO } else { 0.5 * now[index] };
        let is_edge = (58..62).contains(&(index % 120));
        assert!(is_edge || masked[index].distance(wanted) < 0.01, "{index}: {}, not {wanted}", masked[index]);
    }
}
