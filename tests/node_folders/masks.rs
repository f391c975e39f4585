//! Masks of brightness, color and shape, and what is limited to them.

use crate::reference::transfer::srgb_decode;
use crate::support::gpu::Picture;
use crate::support::harness::Nodes;

/// The red channel of a mask that a kind makes of a picture.
fn mask(node: &str, picture: &Picture) -> Vec<f64> {
    let text = format!("\"result\": {node}");
    let found = Nodes::new(&text, &[("in", "DisplayLinear")]).exact(&[picture]);
    for pixel in &found.pixels {
        assert!((0.0..=1.0).contains(&pixel[0]) && pixel[1] == pixel[0] && pixel[2] == pixel[0], "{pixel:?}");
    }
    found.pixels.iter().map(|pixel| f64::from(pixel[0])).collect()
}

fn black(width: u32, height: u32) -> Picture {
    Picture::new(width, height, |_, _| [0.0, 0.0, 0.0, 1.0])
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_key_of_brightness_is_one_between_its_bounds_and_zero_beyond_its_slopes() {
    // Codes of 0.2 to 0.9.
    let picture = Picture::new(8, 1, |x, _| {
        let gray = srgb_decode(0.2 + 0.1 * f64::from(x)) as f32;
        [gray, gray, gray, 1.0]
    });
    let found = mask("LumaKey(source: \"in\", low: 0.4, high: 0.7, softness: 0.2)", &picture);
    for (found, wanted) in found.iter().zip([0.0, 0.5, 1.0, 1.0, 1.0, 1.0, 0.5, 0.0]) {
        assert!((found - wanted).abs() < 1e-4, "{found} instead of {wanted}");
    }
    let hard = mask("LumaKey(source: \"in\", low: 0.45, softness: 0.0)", &picture);
    assert_eq!(hard, [0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 1.0]);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_key_of_color_finds_it_at_any_brightness_and_knows_the_distance_of_gray() {
    // Green in 12 stops, then gray in as many.
    let picture = Picture::new(24, 1, |x, _| {
        let light = 2.0_f32.powi((x % 12) as i32 - 8);
        if x < 12 { [0.0, light, 0.0, 1.0] } else { [light, light, light, 1.0] }
    });
    let node = |tolerance: f64| format!("ColorKey(source: \"in\", tolerance: {tolerance:?}, softness: 0.0)");
    let near = mask(&node(0.33), &picture);
    assert_eq!(near[..12], [1.0; 12]);
    assert_eq!(near[12..], [0.0; 12]);
    // The chroma of green, 0.2948, over its lightness, 0.8664, is 0.3403.
    assert_eq!(mask(&node(0.35), &picture), [1.0; 24]);
    let soft = mask("ColorKey(source: \"in\", tolerance: 0.2403, softness: 0.2)", &picture);
    assert!(soft[12..].iter().all(|share| (share - 0.5).abs() < 0.01), "{:?}", &soft[12..]);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn shapes_have_their_areas() {
    let height = 96.0;
    let area = |node: &str| mask(node, &black(144, 96)).iter().sum::<f64>();
    // A rectangle loses at most a quarter of a pixel at each corner.
    for (size, wanted) in [("(0.5, 0.25)", 48.0 * 24.0), ("(0.53, 0.31)", 0.53 * height * 0.31 * height)] {
        let found = area(&format!("ShapeMask(source: \"in\", size: {size})"));
        assert!((found - wanted).abs() < 1.0, "{size}: {found} instead of {wanted}");
        let turned = area(&format!("ShapeMask(source: \"in\", size: {size}, rotation: 90.0)"));
        assert!((turned - found).abs() < 0.1, "{size} turned: {turned} instead of {found}");
        let outside = area(&format!("ShapeMask(source: \"in\", size: {size}, invert: true)"));
        assert!((found + outside - 144.0 * 96.0).abs() < 0.01, "{size}: {found} and {outside}");
    }
    let radii = std::f64::consts::PI * 0.25 * (0.8 * height) * (0.5 * height);
    let ellipse = area("ShapeMask(source: \"in\", size: (0.8, 0.5), ellipse: true)");
    assert!((ellipse / radii - 1.0).abs() < 2e-3, "{ellipse} instead of {radii}");
    // A square with the largest corners is a circle, and one with half of them loses the corners of a square.
    let circle = std::f64::consts::PI * 0.25 * (0.5 * height).powi(2);
    let round = area("ShapeMask(source: \"in\", size: (0.5, 0.5), roundness: 1.0)");
    assert!((round / circle - 1.0).abs() < 2e-3, "{round} instead of {circle}");
    let corners = (4.0 - std::f64::consts::PI) * (0.125 * height).powi(2);
    let half_round = area("ShapeMask(source: \"in\", size: (0.5, 0.5), roundness: 0.5)");
    assert!((half_round - (48.0 * 48.0 - corners)).abs() < 2.0, "{half_round}");
    // A slope has as much inside as outside, but for the corners.
    let soft = area("ShapeMask(source: \"in\", size: (0.5, 0.5), softness: 0.1)");
    assert!((soft / 2304.0 - 1.0).abs() < 0.01, "{soft}");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_shape_lies_where_its_center_is_and_turns_clockwise() {
    let found = mask("ShapeMask(source: \"in\", center: (0.25, 0.5), size: (0.25, 0.25))", &black(128, 64));
    let at = |x: usize, y: usize| found[y * 128 + x];
    assert_eq!(
        [at(32, 32), at(25, 32), at(22, 32), at(41, 32), at(32, 25), at(32, 22)],
        [1.0, 1.0, 0.0, 0.0, 1.0, 0.0]
    );
    let turned = mask("ShapeMask(source: \"in\", size: (1.0, 0.05), rotation: 45.0)", &black(64, 64));
    let at = |x: usize, y: usize| turned[y * 64 + x];
    assert_eq!([at(20, 20), at(44, 44), at(44, 20)], [1.0, 1.0, 0.0]);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_gradient_rises_along_its_way_alone() {
    let (width, height) = (80, 40);
    let at = |parameters: &str, place: [usize; 2]| {
        let found = mask(&format!("GradientMask(source: \"in\", {parameters})"), &black(width, height));
        found[place[1] * width as usize + place[0]]
    };
    // From the pixel at 16 to that at 48, so a pixel is 1/32 of the way.
    let way = "start: (0.20625, 0.5), end: (0.60625, 0.5)";
    let step = |t: f64| t * t * (3.0 - 2.0 * t);
    for (x, wanted) in [(0, 0.0), (16, 0.0), (24, step(0.25)), (32, 0.5), (40, step(0.75)), (48, 1.0), (79, 1.0)] {
        for y in [0, 39] {
            assert!((at(way, [x, y]) - wanted).abs() < 1e-5, "{} instead of {wanted} at {x}", at(way, [x, y]));
            let inverse = at(&format!("{way}, invert: true"), [x, y]);
            assert!((inverse - 1.0 + wanted).abs() < 1e-5, "{inverse} at {x}");
        }
    }
    assert!((at(&format!("{way}, level: 0.5"), [32, 3])).abs() < 1e-6);
    assert!((at(&format!("{way}, level: 0.5"), [40, 3]) - 0.5).abs() < 1e-5);
    let both = format!("{way}, mirror: true");
    assert!((at(&both, [8, 3]) - at(&both, [24, 3])).abs() < 1e-6 && at(&both, [8, 3]) > 0.1);
    // Lines of one value are at right angles to the way in pixels, not in uv.
    let slanted = "start: (0.25, 0.25), end: (0.5, 0.75)";
    assert!((at(slanted, [28, 20]) - at(slanted, [24, 24])).abs() < 1e-5);
    assert_eq!(at("start: (0.5, 0.5), end: (0.5, 0.5)", [70, 20]), 0.0);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_polygon_is_where_its_corners_are() {
    let (width, height) = (128, 96);
    let found = |corners: &[[f64; 2]], more: &str| {
        let places = corners.iter().enumerate().map(|(i, [u, v])| format!(", corner_{}: ({u:?}, {v:?})", i + 1));
        let places: String = places.collect();
        let node = format!("PolygonMask(source: \"in\", corners: {}{places}{more})", corners.len());
        mask(&node, &black(width, height))
    };
    // A rectangle is that of another kind, hard and soft.
    let rectangle = [[0.25, 0.25], [0.75, 0.25], [0.75, 0.75], [0.25, 0.75]];
    for (soft, wanted) in [("", ""), (", softness: 0.2", ", softness: 0.2"), (", invert: true", ", invert: true")] {
        let other = format!("ShapeMask(source: \"in\", size: (0.6666667, 0.5){wanted})");
        let pairs = found(&rectangle, soft).into_iter().zip(mask(&other, &black(width, height)));
        let off = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off < 1e-5, "{soft}: {off}");
    }
    // Areas by the formula of Gauss, also of a polygon that is not convex, in either direction.
    for corners in [
        vec![[0.1, 0.1], [0.9, 0.2], [0.3, 0.93]],
        vec![[0.3, 0.93], [0.9, 0.2], [0.1, 0.1]],
        vec![[0.1, 0.1], [0.9, 0.1], [0.9, 0.9], [0.5, 0.3], [0.1, 0.9]],
        (0..8)
            .map(|k| (f64::from(k) * std::f64::consts::FRAC_PI_4).sin_cos())
            .map(|(s, c)| [0.5 + 0.4 * c, 0.5 + 0.4 * s])
            .collect(),
    ] {
        let next = corners.iter().cycle().skip(1);
        let twice: f64 = corners.iter().zip(next).map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum();
        let wanted = 0.5 * twice.abs() * f64::from(width * height);
        let area: f64 = found(&corners, "").iter().sum();
        assert!((area - wanted).abs() < 3.0, "{corners:?}: {area} instead of {wanted}");
    }
    // A star in one line has a hole.
    let star: Vec<[f64; 2]> = (0..5)
        .map(|k| (f64::from(2 * k) * 72.0_f64.to_radians()).sin_cos())
        .map(|(sin, cos)| [0.5 + 0.36 * sin, 0.5 - 0.48 * cos])
        .collect();
    let found = found(&star, "");
    assert_eq!([found[48 * 128 + 64], found[14 * 128 + 64], found[80 * 128 + 64]], [0.0, 1.0, 0.0]);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_mask_takes_one_image_or_the_other() {
    let one = Picture::new(5, 3, |x, y| [x as f32 * 0.37, y as f32 * 11.3, 0.1, 0.75]);
    let other = Picture::new(5, 3, |x, y| [y as f32 * 0.21, 900.7, x as f32, 0.25]);
    let shares = Picture::new(5, 3, |x, _| [[-1.0, 0.0, 0.5, 1.0, 7.0][x as usize], 0.3, 0.3, 1.0]);
    let inputs = [("one", "Exposed"), ("other", "Exposed"), ("shares", "Data")];
    let nodes = "\"result\": Mix(source: \"one\", other: \"other\", mask: \"shares\")";
    let found = Nodes::new(nodes, &inputs).exact(&[&one, &other, &shares]);
    for y in 0..3 {
        for x in 0..5 {
            let [near, far] = [one.at(x, y), other.at(x, y)];
            let share = [0.0, 0.0, 0.5, 1.0, 1.0][x as usize];
            let wanted = [0, 1, 2, 3].map(|c| near[c] * (1.0 - share) + far[c] * share);
            assert_eq!(found.at(x, y), wanted, "at {x}, {y}");
        }
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn alpha_is_divided_out_multiplied_in_and_covers() {
    let front = Picture::new(4, 1, |x, _| {
        [[0.25, 0.5, 1.0, 0.5], [2.0, 1.0, 0.5, 0.0], [0.5, 0.25, 0.75, 1.0], [0.0; 4]][x as usize]
    });
    let behind = Picture::new(4, 1, |_, _| [0.5, 1.0, 2.0, 0.5]);
    let straight = "\"result\": Unpremultiply(source: \"front\")";
    let again = "\"s\": Unpremultiply(source: \"front\"), \"result\": Premultiply(source: \"s\")";
    let over = |opacity: f32| format!("\"result\": Over(source: \"behind\", front: \"front\", opacity: {opacity:?})");
    let one = |nodes: &str| Nodes::new(nodes, &[("front", "Color")]).exact(&[&front]).pixels;
    let both =
        |nodes: &str| Nodes::new(nodes, &[("front", "Color"), ("behind", "Color")]).exact(&[&front, &behind]).pixels;
    assert_eq!(one(straight), [[0.5, 1.0, 2.0, 0.5], [2.0, 1.0, 0.5, 0.0], [0.5, 0.25, 0.75, 1.0], [0.0; 4]]);
    assert_eq!(one(again), [front.at(0, 0), [0.0; 4], front.at(2, 0), [0.0; 4]]);
    assert_eq!(
        both(&over(1.0)),
        [[0.5, 1.0, 2.0, 0.75], [2.5, 2.0, 2.5, 0.5], [0.5, 0.25, 0.75, 1.0], [0.5, 1.0, 2.0, 0.5]]
    );
    assert_eq!(both(&over(0.0)), [[0.5, 1.0, 2.0, 0.5]; 4]);
    assert_eq!(both(&over(0.5))[2], [0.5, 0.625, 1.375, 0.75]);
}
