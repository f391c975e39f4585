//! Matrices between RGB spaces and transfer functions, against published values.
#![allow(missing_docs, reason = "a test binary exports nothing")]

use afterimage_base::color::{Chromaticities, Colorimetry, Decimal, Transfer, Xy, hlg_gamma};
use glam::DVec3;

const SPACES: [Chromaticities; 5] = [
    Chromaticities::REC709,
    Chromaticities::DISPLAY_P3,
    Chromaticities::REC2020,
    Chromaticities::ACES_CG,
    Chromaticities::ACES_AP0,
];

#[test]
fn a_decimal_keeps_the_number_that_its_float_was_made_of() {
    for number in [0.3127, 0.32168, -0.0770, 0.0321, 203.0, 2.2, 10000.0, 1e-6] {
        assert_eq!([Decimal::new(number), Decimal::from(number)].map(Decimal::get), [number; 2]);
    }
    assert_eq!(Xy::from([0.3127_f32, 0.3290_f32]), Xy::D65, "the f32 nearest to 0.3127 is 0.3127");
    assert_eq!([f64::NAN, 1e300, -1e300].map(|x| Decimal::new(x).get().signum()), [1.0, 1.0, -1.0]);
    assert_eq!(Decimal::new(f64::NAN).get(), 0.0);
}

#[test]
fn white_stays_white_and_a_conversion_inverts_its_opposite() {
    for (a, b) in SPACES.iter().flat_map(|a| SPACES.iter().map(move |b| (a, b))) {
        let white = a.conversion(b) * DVec3::ONE;
        assert!(white.abs_diff_eq(DVec3::ONE, 1e-12), "{a:?} to {b:?}: {white}");
        let color = DVec3::new(0.1, 0.7, -0.2);
        let back = b.conversion(a) * (a.conversion(b) * color);
        assert!(back.abs_diff_eq(color, 1e-12), "{a:?} to {b:?} and back: {back}");
    }
}

#[test]
fn the_matrices_are_the_published_ones() {
    // ITU-R BT.2087, table 2: Rec.709 to Rec.2020, with four digits.
    let green = Chromaticities::REC709.conversion(&Chromaticities::REC2020) * DVec3::Y;
    assert!(green.abs_diff_eq(DVec3::new(0.3293, 0.9195, 0.0880), 5e-5), "{green}");
    // SMPTE ST 2065-1, annex A: AP0 to XYZ.
    let blue = Chromaticities::ACES_AP0.to_xyz() * DVec3::Z;
    assert!(blue.abs_diff_eq(DVec3::new(0.0000936786, -0.0721325464, 1.0088251844), 1e-9), "{blue}");
}

#[test]
fn numbers_that_span_no_colors_are_no_space() {
    let numbers = [0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290];
    assert_eq!(Chromaticities::from_numbers(numbers), Some(Chromaticities::REC709));
    for (at, wrong) in [(2, f64::NAN), (4, f64::INFINITY), (7, 0.0), (0, 1e9)] {
        let mut broken = numbers;
        broken[at] = wrong;
        assert_eq!(Chromaticities::from_numbers(broken), None, "{broken:?}");
    }
    assert_eq!(Chromaticities::from_numbers([0.1, 0.1, 0.2, 0.2, 0.3, 0.3, 0.3, 0.3]), None, "on one line");
}

#[test]
fn a_transfer_function_inverts_itself() {
    let gamma = Transfer::Gamma(Decimal::new(2.4));
    for transfer in [Transfer::Linear, Transfer::Srgb, gamma, Transfer::Pq, Transfer::Hlg] {
        for step in 0..=1000 {
            let signal = f64::from(step) / 1000.0;
            let back = transfer.to_signal(transfer.to_light(signal));
            assert!((back - signal).abs() < 1e-6, "{transfer:?}: {signal} became {back}");
        }
    }
}

#[test]
fn transfer_functions_have_the_values_of_their_standards() {
    // ITU-R BT.2408, table 1: 58 % and 75 % are 203 cd/m2 in PQ and HLG; 75 % PQ is 983 cd/m2.
    let nits = |signal| Transfer::Pq.to_light(signal) * 10000.0;
    assert!((nits(0.5806888810416109) - 203.0).abs() < 1e-6, "{}", nits(0.5806888810416109));
    assert!((nits(0.75) - 983.0).abs() < 1.0, "{}", nits(0.75));
    let hlg_white = 1000.0 * Transfer::Hlg.to_light(0.75).powf(hlg_gamma(1000.0));
    assert!((hlg_white - 203.0).abs() < 0.5, "{hlg_white}");
    // IEC 61966-2-1: 50 % gray is 21.4 % light.
    assert!((Transfer::Srgb.to_light(0.5) - 0.21404114048223255).abs() < 1e-12);
    assert_eq!([hlg_gamma(1000.0), Transfer::Pq.to_light(0.0), Transfer::Hlg.to_light(0.0)], [1.2, 0.0, 0.0]);
}

#[test]
fn colorimetry_survives_json() {
    let hdr = Colorimetry::new(Chromaticities::REC2020, Transfer::Pq).nits(203.0, 1000.0);
    let gamma = Colorimetry::new(Chromaticities::DISPLAY_P3, Transfer::Gamma(Decimal::new(2.2)));
    for colorimetry in [hdr, gamma, Colorimetry::SRGB, Colorimetry::linear(Chromaticities::ACES_CG)] {
        let json = serde_json::to_string(&colorimetry).expect("it is plain data");
        assert_eq!(serde_json::from_str::<Colorimetry>(&json).expect("it was written by serde"), colorimetry, "{json}");
    }
}

#[test]
fn the_system_gamma_of_hlg_is_that_of_bt_2390() {
    // ITU-R BT.2100, note 5f: 1.2 at 1000 cd/m2; BT.2390, 6.2: the extended range.
    for (peak, gamma) in [
        (1000.0, 1.2),
        (400.0, 1.2 + 0.42 * 0.4_f64.log10()),
        (2000.0, 1.2 + 0.42 * 2.0_f64.log10()),
        (4000.0, 1.2 * 1.111 * 1.111),
        (250.0, 1.2 / (1.111 * 1.111)),
        (125.0, 1.2 / 1.111_f64.powi(3)),
    ] {
        assert!((hlg_gamma(peak) - gamma).abs() < 1e-12, "{peak}: {}", hlg_gamma(peak));
    }
}

#[test]
fn spaces_are_close_if_every_coordinate_is() {
    for space in &SPACES {
        assert!(space.close_to(space, 1e-9));
        for axis in 0..2 {
            for point in 0..4 {
                let mut moved = *space;
                let points = [&mut moved.red, &mut moved.green, &mut moved.blue, &mut moved.white];
                let [x, y] = [points[point].x.get(), points[point].y.get()];
                let shifted = if axis == 0 { [x + 0.01, y] } else { [x, y - 0.01] };
                *points.into_iter().nth(point).expect("four points") = Xy::from(shifted.map(|c| c as f32));
                assert!(space.close_to(&moved, 0.011) && moved.close_to(space, 0.011));
                assert!(!space.close_to(&moved, 0.009) && !moved.close_to(space, 0.009));
            }
        }
    }
}
