//! Reflections beside rays that are followed by their definition: a floor before a wall, and under a sky.

use afterimage_graph::node::Camera;
use glam::Mat4;
use glam::camera::rh::proj::directx;

use crate::support::gpu::Picture;
use crate::support::harness::Nodes;

const SIZE: [u32; 2] = [192, 128];
const FIELD: f32 = 1.1;
/// The distances of the floor below the camera and of the wall before it.
const DOWN: f32 = 1.0;
const WALL: f32 = 6.0;

fn camera() -> Camera {
    let projection = directx::perspective_infinite_reverse(FIELD, 1.5, 0.1).to_cols_array_2d();
    Camera::still(Mat4::IDENTITY.to_cols_array_2d(), projection)
}

/// The direction of a pixel at a distance of 1: right and up.
fn direction(x: u32, y: u32) -> [f32; 2] {
    let half = (0.5 * FIELD).tan();
    let [u, v] = [(x, SIZE[0]), (y, SIZE[1])].map(|(at, side)| (2 * at + 1) as f32 / side as f32 - 1.0);
    [1.5 * half * u, -half * v]
}

/// The distance of the floor, where a pixel sees it before the wall.
fn floor([_, up]: [f32; 2]) -> Option<f32> {
    Some(-DOWN / up).filter(|distance| up < 0.0 && *distance < WALL)
}

/// The wall's light at a place on it, or the sky's by its direction.
fn light([x, y]: [f32; 2]) -> f32 {
    1.0 + 0.5 * (1.3 * x).sin() + 0.4 * (1.7 * y).cos()
}

/// The light and the depth of a dark floor and what is behind it.
fn scene(behind: f32, shown: impl Fn([f32; 2]) -> f32) -> [Picture; 2] {
    let own = Picture::new(SIZE[0], SIZE[1], |x, y| {
        let way = direction(x, y);
        let light = if floor(way).is_some() { 0.0 } else { shown(way) };
        [light, 2.0 * light, 0.5 * light, 1.0]
    });
    let depth = Picture::new(SIZE[0], SIZE[1], |x, y| [floor(direction(x, y)).unwrap_or(behind), 0.0, 0.0, 1.0]);
    [own, depth]
}

fn reflected([own, depth]: &[Picture; 2], parameters: &str) -> Picture {
    let text = format!(
        "\"result\": Ssr(source: \"in\", depth: \"depth\", camera: \"camera\", {parameters}) -> result.reflection"
    );
    Nodes::new(&text, &[("in", "Exposed"), ("depth", "Data")]).camera(Some(&camera())).exact(&[own, depth])
}

/// Pixels of the floor that are far from all borders, and their directions and distances.
fn inner() -> impl Iterator<Item = (u32, u32, [f32; 2], f32)> {
    let pixels = (0..SIZE[1] - 1).flat_map(|y| (24..SIZE[0] - 24).map(move |x| (x, y)));
    pixels.filter_map(|(x, y)| {
        let way = direction(x, y);
        floor(way).filter(|distance| *distance < 0.9 * WALL).map(|distance| (x, y, way, distance))
    })
}

/// The light that comes to a place of the floor from the wall.
fn from_wall([right, up]: [f32; 2], distance: f32) -> f32 {
    light([WALL * right, -DOWN - (WALL - distance) * up])
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_floor_that_is_a_mirror_shows_the_wall() {
    let scene = scene(WALL, |[right, up]| light([WALL * right, WALL * up]));
    let mirror = reflected(&scene, "roughness: 0.0, reflectance: (1.0, 1.0, 1.0)");
    let glass = reflected(&scene, "roughness: 0.0, reflectance: (0.04, 0.04, 0.04)");
    assert!(inner().count() > 3000);
    for (x, y, way, distance) in inner() {
        let wanted = from_wall(way, distance);
        let [red, green, _, known] = mirror.at(x, y);
        assert!((known - 1.0).abs() < 1e-3, "at {x}, {y}: {known} is known");
        assert!((red - wanted).abs() < 0.02 && (green - 2.0 * wanted).abs() < 0.04, "at {x}, {y}: {red}, not {wanted}");
        // Schlick, 1994: the cosine is that of the ray to the floor.
        let cosine = -way[1] / (1.0 + way[0] * way[0] + way[1] * way[1]).sqrt();
        let share = 0.04 + 0.96 * (1.0 - cosine).powi(5);
        let found = glass.at(x, y)[0];
        assert!((found - red * share).abs() < 2e-3, "at {x}, {y}: {found}, not {share} of {red}");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_floor_that_is_a_mirror_shows_the_sky() {
    let sky = |[right, up]: [f32; 2]| light([3.0 * right, 3.0 * up]);
    let mirror = reflected(&scene(65504.0, sky), "roughness: 0.0, reflectance: (1.0, 1.0, 1.0)");
    for (x, y, [right, up], distance) in inner().filter(|(.., distance)| *distance > 2.2) {
        let (found, wanted) = (mirror.at(x, y)[0], sky([right, -up]));
        assert!((found - wanted).abs() < 0.02, "at {x}, {y}, {distance} m: {found}, not {wanted}");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn rough_floors_blur_the_wall_more_the_farther_it_is_and_keep_its_mean() {
    let mut stripes = scene(WALL, |_| 0.0);
    // The floor has them, too, so that a wide mean has as much light.
    stripes[0] = Picture::new(SIZE[0], SIZE[1], |x, y| {
        let light = if (48.0 * direction(x, y)[0]).sin() > 0.0 { 2.0 } else { 0.0 };
        [light, light, light, 1.0]
    });
    // The standard deviation of the rows near the camera, and of those near the wall.
    let spread = |roughness: f32| {
        let found = reflected(&stripes, &format!("roughness: {roughness:?}, reflectance: (1.0, 1.0, 1.0)"));
        [(0.0, 2.0), (4.0, 5.0)].map(|(near, far)| {
            let rows = inner().filter(|(.., distance)| (near..far).contains(distance));
            let values: Vec<f32> = rows.map(|(x, y, ..)| found.at(x, y)[0]).collect();
            let mean = values.iter().sum::<f32>() / values.len() as f32;
            assert!((mean - 1.0).abs() < 0.1, "{roughness}: the mean is {mean}");
            (values.iter().map(|value| (value - mean).powi(2)).sum::<f32>() / values.len() as f32).sqrt()
        })
    };
    let [mirror, satin, matt] = [0.0, 0.25, 0.5].map(spread);
    assert!(mirror[0] > 0.8 && mirror[1] > 0.8, "{mirror:?}");
    assert!(satin[0] < 0.6 * mirror[0] && satin[0] < 0.8 * satin[1], "{satin:?}");
    assert!(matt[0] < 0.2 && matt[1] < 0.7 * satin[1], "{satin:?} and {matt:?}");
    let none = reflected(&stripes, "roughness: 0.8");
    assert!(none.pixels.iter().all(|pixel| *pixel == [0.0; 4]), "nothing is known of matt surfaces");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_reflection_is_added_by_its_amount() {
    let scene = scene(WALL, |[right, up]| light([WALL * right, WALL * up]));
    let inputs = [("in", "Exposed"), ("depth", "Data")];
    let made = |amount: f32| {
        let node = format!(
            "\"result\": Ssr(source: \"in\", depth: \"depth\", camera: \"camera\", amount: {amount:?}, \
             reflectance: (1.0, 1.0, 1.0), roughness: 0.0)"
        );
        Nodes::new(&node, &inputs).camera(Some(&camera())).exact(&[&scene[0], &scene[1]])
    };
    assert!(made(0.0) == scene[0], "nothing is added");
    let half = made(0.5);
    for (x, y, way, distance) in inner() {
        let (found, wanted) = (half.at(x, y)[0], 0.5 * from_wall(way, distance));
        assert!((found - wanted).abs() < 0.02, "at {x}, {y}: {found}, not {wanted}");
    }
}
