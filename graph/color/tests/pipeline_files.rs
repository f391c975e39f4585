//! The tables that the built-in pipelines use.

use afterimage_color::lut::parse_cube;

/// The formula of the table: cool shadows, warm lights, soft contrast, less saturation.
fn dusk(rgb: [f64; 3]) -> [f64; 3] {
    let y = 0.2126390059 * rgb[0] + 0.7151686788 * rgb[1] + 0.0721923154 * rgb[2];
    let (cool, warm) = (4.0 * y * (1.0 - y) * (1.0 - y), 4.0 * y * y * (1.0 - y));
    let (shadows, lights) = ([-0.03, 0.008, 0.035], [0.04, 0.012, -0.045]);
    [0, 1, 2].map(|channel| {
        let held: f64 = (y + 0.9 * (rgb[channel] - y)).clamp(0.0, 1.0);
        let curved = held + 0.25 * (held * held * (3.0 - 2.0 * held) - held);
        (curved + cool * shadows[channel] + warm * lights[channel]).clamp(0.0, 1.0)
    })
}

#[test]
fn the_table_dusk_is_its_formula() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../pipelines/looks/dusk.cube");
    let text = std::fs::read_to_string(path).expect("the pipelines have the table");
    let table = parse_cube(&text).expect("a valid table").cube.expect("a cube");
    assert_eq!(table.entries.len(), 9 * 9 * 9);
    for (index, found) in table.entries.iter().enumerate() {
        let place = [index % 9, index / 9 % 9, index / 81].map(|level| level as f64 / 8.0);
        let expected = dusk(place);
        let close = (0..3).all(|channel| (f64::from(found[channel]) - expected[channel]).abs() < 6e-5);
        assert!(close, "{place:?}: {found:?} instead of {expected:?}");
    }
    assert_eq!((table.entries[0], table.entries[728]), ([0.0; 3], [1.0; 3]));
}
