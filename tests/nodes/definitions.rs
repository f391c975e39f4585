//! Lenses, lines and hot air by what their manuals define, without the formulas of their CPU references: the place, the
//! width and the sum of what they make of shapes that have closed forms.

use crate::support::gpu::Picture;
use crate::support::harness::Nodes;

fn made(node: &str, picture: &Picture) -> Picture {
    Nodes::new(&format!("\"result\": {node}"), &[("in", "Exposed")]).exact(&[picture])
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_streak_falls_to_its_part_at_its_length_and_keeps_the_light() {
    let point = Picture::new(257, 5, |x, y| if (x, y) == (128, 2) { [8.0, 8.0, 8.0, 1.0] } else { [0.0; 4] });
    for length in [0.03_f32, 0.05] {
        let found = made(&format!("Streaks(source: \"in\", length: {length:?}, tint: (1.0, 0.5, 0.25))"), &point);
        let row: Vec<f64> = (0..257).map(|x| f64::from(found.at(x, 2)[0])).collect();
        let pixels = f64::from(length) * 257.0;
        for away in [2, 5, 9, 14_usize] {
            let wanted = (-(away as f64 - 1.0) / pixels).exp();
            for at in [128 - away, 128 + away] {
                let share = row[at] / row[127];
                assert!((share - wanted).abs() < 0.01, "{length}, {away} pixels: {share}, not {wanted}");
            }
        }
        let sum: f64 = row.iter().sum();
        assert!((sum / 8.0 - 1.0).abs() < 0.01, "{length}: the sum of the light is {sum}, not 8");
        assert!((0..257).all(|x| found.at(x, 1)[0] == 0.0), "other rows are dark");
        assert!((found.at(120, 2)[1] / found.at(120, 2)[0] - 0.5).abs() < 1e-3, "the tint");
    }
}

/// A disc of light at a place from the middle, in heights.
fn disc([right, down]: [f32; 2], radius: f32) -> Picture {
    Picture::new(320, 180, |x, y| {
        let away = [x as f32 + 0.5 - 160.0 - 180.0 * right, y as f32 + 0.5 - 90.0 - 180.0 * down];
        let light = (radius + 0.5 - away[0].hypot(away[1])).clamp(0.0, 1.0);
        [light, light, light, 1.0]
    })
}

/// The sum of green, its middle in heights from that of the image, and its mean distance from there.
fn gathered(picture: &Picture) -> (f64, [f64; 2], f64) {
    let (mut sum, mut middle, mut distance) = (0.0, [0.0; 2], 0.0);
    for y in 0..picture.height {
        for x in 0..picture.width {
            let light = f64::from(picture.at(x, y)[1]);
            let place = [(f64::from(x) + 0.5 - 160.0) / 180.0, (f64::from(y) + 0.5 - 90.0) / 180.0];
            sum += light;
            distance += light * place[0].hypot(place[1]);
            (0..2).for_each(|i| middle[i] += light * place[i]);
        }
    }
    (sum, middle.map(|middle| middle / sum), distance / sum)
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_ghost_is_the_light_magnified_through_the_middle_and_the_ring_has_its_radius() {
    let light = disc([0.3, -0.15], 8.0);
    let own = gathered(&light).0;
    for spacing in [0.35_f32, 0.5, 0.8] {
        let node = format!(
            "LensFlare(source: \"in\", ghosts: 1, spacing: {spacing:?}, ghost_strength: 1.0, halo_strength: 0.0, \
             dispersion: 0.0)"
        );
        let (sum, middle, _) = gathered(&made(&node, &light));
        let wanted = [-0.3, 0.15].map(|place| place * f64::from(spacing));
        assert!((0..2).all(|i| (middle[i] - wanted[i]).abs() < 0.003), "{spacing}: {middle:?}, not {wanted:?}");
        // Its area is that of the light times the square of the magnification; coatings leave green nearly as it is.
        let area = sum / own / f64::from(spacing * spacing);
        assert!((area - 1.0785).abs() < 0.03, "{spacing}: {area}");
    }
    for radius in [0.2_f32, 0.4] {
        let node = format!(
            "LensFlare(source: \"in\", ghosts: 0, ghost_strength: 0.0, halo_radius: {radius:?}, halo_strength: 1.0, \
             dispersion: 0.0)"
        );
        let (sum, middle, distance) = gathered(&made(&node, &disc([0.0, 0.0], 4.0)));
        assert!(sum > 0.0 && middle[0].hypot(middle[1]) < 0.003, "{radius}: {middle:?}");
        assert!((distance - f64::from(radius)).abs() < 0.01, "{radius}: the ring's radius is {distance}");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn lines_are_drawn_at_the_outline_of_a_ball_and_nowhere_else() {
    const SIDES: [u32; 2] = [160, 120];
    // A ball of 0.8 m at 4 m before a floor and a wall, seen through 90 degrees.
    let way = |x: u32, y: u32| [(x as f32 + 0.5) / 80.0 - 1.0, 0.75 - (y as f32 + 0.5) / 80.0];
    let ball = |x: u32, y: u32| {
        let [right, up] = way(x, y);
        let (a, b) = (right * right + up * up + 1.0, 4.0);
        let root = b * b - a * (16.0 - 0.64);
        (root > 0.0).then(|| (b - root.sqrt()) / a)
    };
    let depth = Picture::new(SIDES[0], SIDES[1], |x, y| {
        let [right, up] = way(x, y);
        let floor = if up < 0.0 { -1.5 / up } else { f32::INFINITY };
        let wall = 9.0 / (1.0 + 0.4 * right);
        [ball(x, y).unwrap_or(floor.min(wall)), 0.0, 0.0, 1.0]
    });
    let white = Picture::new(SIDES[0], SIDES[1], |_, _| [1.0; 4]);
    let node = "\"result\": Outline(source: \"in\", depth: \"depth\", depth_threshold: 0.1)";
    let found = Nodes::new(node, &[("in", "Exposed"), ("depth", "Data")]).exact(&[&white, &depth]);
    let around =
        |x: u32, y: u32, is: &dyn Fn(u32, u32) -> bool| (x - 1..=x + 1).any(|u| (y - 1..=y + 1).any(|v| is(u, v)));
    let outline =
        |x: u32, y: u32| [[x + 1, y], [x, y + 1]].iter().any(|[u, v]| ball(x, y).is_some() != ball(*u, *v).is_some());
    let line = |x: u32, y: u32| found.at(x, y)[0] < 0.5;
    let (mut lines, mut outlines) = (0, 0);
    for (x, y) in (2..SIDES[1] - 2).flat_map(|y| (2..SIDES[0] - 2).map(move |x| (x, y))) {
        lines += u32::from(line(x, y));
        outlines += u32::from(outline(x, y));
        assert!(!line(x, y) || around(x, y, &outline), "a line at {x}, {y}, {}", depth.at(x, y)[0]);
        assert!(!outline(x, y) || around(x, y, &line), "no line at {x}, {y}");
    }
    assert!(lines > 80 && outlines > 80, "{lines}, {outlines}");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn hot_air_moves_places_by_at_most_its_strength_on_average_by_nothing_and_rises_at_its_speed() {
    use crate::support::gpu::Run;
    let [width, height] = [256_u32, 128];
    // A picture of its own places: what is read says where it comes from.
    let places = Picture::new(width, height, |x, y| [x as f32 + 0.5, y as f32 + 0.5, 0.0, 1.0]);
    let text = "\"result\": HeatHaze(source: \"in\", strength: 0.05, scale: 0.1, speed: 0.25)";
    let graph = Nodes::new(text, &[("in", "Exposed")]).graph();
    let [now, later] = [0.0, 1.0].map(|time| {
        let mut run = Run::new(&graph).exact();
        run.time = time;
        run.frame(&[("in", &places)]).remove(0)
    });
    let off = |picture: &Picture, x: u32, y: u32| {
        let [u, v, ..] = picture.at(x, y);
        [u - (x as f32 + 0.5), v - (y as f32 + 0.5)].map(|pixels| pixels / height as f32)
    };
    let inner = || (8..height - 40).flat_map(|y| (8..width - 8).map(move |x| (x, y)));
    let (mut mean, mut most, mut count) = ([0.0; 2], 0.0_f32, 0.0);
    for (x, y) in inner() {
        let own = off(&now, x, y);
        most = own.iter().fold(most, |most, way| most.max(way.abs()));
        (0..2).for_each(|i| mean[i] += own[i]);
        count += 1.0;
        // 32 lines in a second.
        let risen = off(&later, x, y);
        let before = off(&now, x, y + 32);
        assert!((0..2).all(|i| (risen[i] - before[i]).abs() < 1e-4), "at {x}, {y}: {risen:?}, before {before:?}");
    }
    let mean = mean.map(|sum| sum / count);
    assert!((0.03..=0.0501).contains(&most), "the farthest way is {most}");
    assert!(mean.iter().all(|way| way.abs() < 0.005), "the mean way is {mean:?}");
}
