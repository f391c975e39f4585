//! Light that surfaces scatter onto each other, beside the sum over all pixels that its definition is: the corner of a
//! room, whose walls all see each other.

use afterimage_graph::node::Camera;
use glam::camera::rh::proj::directx;
use glam::{DVec3, Mat4};

use crate::support::gpu::{Picture, Run};
use crate::support::harness::Nodes;
use crate::support::sequence::Sequence;

const SIZE: [u32; 2] = [192, 128];
const FIELD: f32 = 1.1;
/// The normals of the walls, how far each is, and its light: the floor, the wall ahead, both sides, the ceiling.
const WALLS: [(DVec3, f64, [f32; 3]); 5] = [
    (DVec3::Y, 1.0, [0.05, 0.05, 0.05]),
    (DVec3::Z, 6.0, [1.0, 0.9, 0.6]),
    (DVec3::X, 2.0, [1.5, 0.1, 0.1]),
    (DVec3::NEG_X, 2.5, [0.1, 0.8, 0.2]),
    (DVec3::NEG_Y, 1.5, [0.3, 0.3, 0.3]),
];

fn camera() -> Camera {
    let projection = directx::perspective_infinite_reverse(FIELD, 1.5, 0.1).to_cols_array_2d();
    Camera::still(Mat4::IDENTITY.to_cols_array_2d(), projection)
}

/// The view of a pixel: the place, the wall, and the area of the wall that it shows.
#[derive(Clone, Copy)]
struct Seen {
    place: DVec3,
    wall: usize,
    area: f64,
}

fn seen(x: u32, y: u32) -> Seen {
    let half = f64::from(0.5 * FIELD).tan();
    let [u, v] = [(x, SIZE[0]), (y, SIZE[1])].map(|(at, side)| f64::from(2 * at + 1) / f64::from(side) - 1.0);
    let way = DVec3::new(1.5 * half * u, -half * v, -1.0);
    let distance = |wall: usize| {
        let (normal, apart, _) = WALLS[wall];
        let toward = -way.dot(normal);
        if toward > 1e-9 { apart / toward } else { f64::INFINITY }
    };
    let wall = (0..WALLS.len()).min_by(|a, b| distance(*a).total_cmp(&distance(*b))).expect("there are walls");
    let place = way * distance(wall);
    // The solid angle of a pixel, spread over the wall.
    let pixel = (3.0 * half / f64::from(SIZE[0])) * (2.0 * half / f64::from(SIZE[1])) / way.length().powi(3);
    let area = pixel * place.length_squared() / -place.normalize().dot(WALLS[wall].0);
    Seen { place, wall, area }
}

/// The wall's light at a place, with ripples.
fn light(seen: Seen) -> [f32; 3] {
    let ripple = 1.0 + 0.6 * seen.place.dot(DVec3::new(2.3, 1.7, 1.1)).sin() as f32;
    WALLS[seen.wall].2.map(|light| light * ripple)
}

fn room() -> [Picture; 3] {
    let own = Picture::new(SIZE[0], SIZE[1], |x, y| {
        let [red, green, blue] = light(seen(x, y));
        [red, green, blue, 1.0]
    });
    let depth = Picture::new(SIZE[0], SIZE[1], |x, y| [-seen(x, y).place.z as f32, 0.0, 0.0, 1.0]);
    let albedo = Picture::new(SIZE[0], SIZE[1], |_, _| [0.5, 0.25, 0.0, 1.0]);
    [own, depth, albedo]
}

/// The light of all pixels that a white surface at a place would scatter.
fn scattered(at: Seen, all: &[(Seen, [f32; 3])]) -> [f64; 3] {
    let normal = WALLS[at.wall].0;
    let mut sum = [0.0; 3];
    for (other, light) in all.iter().filter(|(other, _)| other.wall != at.wall) {
        let way = other.place - at.place;
        let square = way.length_squared();
        let cosines = way.dot(normal).max(0.0) * (-way.dot(WALLS[other.wall].0)).max(0.0) / square;
        let share = cosines * other.area / (std::f64::consts::PI * square);
        (0..3).for_each(|i| sum[i] += share * f64::from(light[i]));
    }
    sum
}

/// Texels of half the size that are not beside another wall, and what they should be.
fn wanted() -> Vec<([u32; 2], [f64; 3])> {
    let pixels = (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| seen(x, y)));
    let all: Vec<_> = pixels.map(|seen| (seen, light(seen))).collect();
    let texels = (4..SIZE[1] / 2 - 4).step_by(3).flat_map(|y| (4..SIZE[0] / 2 - 4).step_by(3).map(move |x| [x, y]));
    let at = |[x, y]: [u32; 2]| seen(2 * x + 1, 2 * y + 1);
    let is_inner = |[x, y]: &[u32; 2]| {
        let wall = at([*x, *y]).wall;
        [[x - 3, *y], [x + 3, *y], [*x, y - 3], [*x, y + 3]].iter().all(|near| at(*near).wall == wall)
    };
    texels.filter(is_inner).map(|texel| (texel, scattered(at(texel), &all))).collect()
}

/// For each color, the mean and the root mean square of the errors, as shares of the mean light.
fn errors(found: &Picture, wanted: &[([u32; 2], [f64; 3])]) -> [[f64; 2]; 3] {
    let count = wanted.len() as f64;
    [0, 1, 2].map(|i| {
        let mean = wanted.iter().map(|(_, light)| light[i]).sum::<f64>() / count;
        let off = wanted.iter().map(|([x, y], light)| f64::from(found.at(*x, *y)[i]) - light[i]);
        let square = off.clone().map(|off| off * off).sum::<f64>() / count;
        [off.sum::<f64>() / count / mean, square.sqrt() / mean]
    })
}

const WIRES: &str = "source: \"in\", depth: \"depth\", albedo: \"albedo\", camera: \"camera\"";
const INPUTS: [(&str, &str); 3] = [("in", "Exposed"), ("depth", "Data"), ("albedo", "Data")];

fn made(parameters: &str, output: &str, [own, depth, albedo]: &[Picture; 3]) -> Picture {
    let text = format!("\"result\": Ssgi({WIRES}, {parameters}) -> result.{output}");
    Nodes::new(&text, &INPUTS).camera(Some(&camera())).exact(&[own, depth, albedo])
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
#[expect(clippy::print_stdout, reason = "the figures are in graph/docs/measurements/depth.md")]
fn the_corner_of_a_room_gets_the_sum_of_what_all_pixels_send() {
    let (room, wanted) = (room(), wanted());
    assert!(wanted.len() > 300);
    for (parameters, mean, square) in [("slices: 2", 0.12, 0.2), ("slices: 8, steps: 24", 0.06, 0.14)] {
        let found = made(&format!("radius: 20.0, largest: 4.0, {parameters}"), "light", &room);
        let errors = errors(&found, &wanted);
        println!("{parameters}: mean and root mean square of the errors, as shares of the light: {errors:.3?}");
        assert!(errors.iter().all(|[off, _]| off.abs() < mean), "{parameters}: {errors:.3?}");
        assert!(errors.iter().all(|[_, off]| *off < square), "{parameters}: {errors:.3?}");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_wall_sends_nothing_to_itself_and_albedo_scatters_what_arrives() {
    let [own, depth, albedo] = room();
    let even = Picture::new(SIZE[0], SIZE[1], |_, _| [3.0, 0.0, 0.0, 1.0]);
    let wall = made("radius: 20.0", "light", &[own.clone(), even, albedo.clone()]);
    assert!(wall.pixels.iter().all(|pixel| pixel[..3].iter().all(|light| *light < 2e-3)), "a wall lights itself");
    let scene = [own, depth, albedo];
    let (light, half) = (made("radius: 20.0", "light", &scene), made("radius: 20.0, amount: 0.5", "result", &scene));
    assert!(made("amount: 0.0", "result", &scene).pixels == scene[0].pixels, "nothing is added");
    for ([x, y], _) in wanted() {
        let near = light.at(x, y);
        let added = [0, 1, 2].map(|i| half.at(2 * x + 1, 2 * y + 1)[i] - scene[0].at(2 * x + 1, 2 * y + 1)[i]);
        let wanted = [0.25 * near[0], 0.125 * near[1], 0.0];
        let off = (0..3).map(|i| (added[i] - wanted[i]).abs()).fold(0.0, f32::max);
        assert!(off < 0.01 * (near[0] + near[1]) + 1e-3, "at {x}, {y}: {added:?}, not {wanted:?}");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn frames_make_the_light_steady_where_nothing_moves() {
    let text = format!(
        "\"result\": Ssgi({WIRES}, history: \"result.light@previous\", radius: 20.0, largest: 4.0, slices: 1, \
         blend: 0.1) -> result.light"
    );
    let camera = camera();
    let graph = Nodes::new(&text, &INPUTS).camera(Some(&camera)).graph();
    let run = Run::new(&graph).camera(Some(&camera)).exact();
    let mut sequence = Sequence::new(&run);
    let [own, depth, albedo] = room();
    let frames: Vec<Picture> = (0..40)
        .map(|index| {
            sequence.frame(&[("in", &own), ("depth", &depth), ("albedo", &albedo)], 0.04, index == 0);
            sequence.output("out")
        })
        .collect();
    let wanted = wanted();
    let square = |picture: &Picture| errors(picture, &wanted).iter().map(|[_, off]| off).sum::<f64>();
    let [first, last] = [&frames[0], &frames[39]].map(square);
    assert!(last < first, "{first} becomes {last}");
    let change = |a: &Picture, b: &Picture| {
        let pairs = wanted.iter().map(|([x, y], light)| f64::from(a.at(*x, *y)[0] - b.at(*x, *y)[0]).abs() / light[0]);
        pairs.sum::<f64>() / wanted.len() as f64
    };
    let (early, late) = (change(&frames[0], &frames[1]), change(&frames[38], &frames[39]));
    assert!(late < 0.02 && late < early, "from frame to frame {early}, later {late}");
}
