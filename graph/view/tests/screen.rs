//! Conversion for HDR screens, for each color space that a swap chain may have.

use crate::support::{gpu, texels};
use afterimage_gpu::wgpu::{self, SurfaceColorSpace};
use afterimage_gpu::{Texels, upload};
use afterimage_graph::color::{Chromaticities, Transfer, hlg_gamma};
use afterimage_view::render::{SDR_WHITE, Screen};

/// Colors as signals of extended sRGB: grays from black to beyond white, and colors within and outside of Rec.709.
const COLORS: [[f32; 4]; 8] = [
    [0.0, 0.0, 0.0, 1.0],
    [0.25, 0.25, 0.25, 1.0],
    [1.0, 1.0, 1.0, 1.0],
    [1.5, 1.5, 1.5, 1.0],
    [1.9, 1.9, 1.9, 1.0],
    [0.75, 0.5, 0.25, 1.0],
    [1.0, -0.125, 0.25, 1.0],
    [0.1, 0.9, 1.25, 1.0],
];

/// The colors in the swap chain.
fn converted(space: SurfaceColorSpace) -> Vec<[f32; 4]> {
    let device = &gpu().device;
    let colors = Texels::from_floats_as_half(COLORS.len() as u32, 1, &COLORS);
    let drawn = upload(device, &gpu().queue, &colors).unwrap();
    let target = device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: drawn.size(),
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba32Float,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    let screen = Screen::new(gpu(), target.format(), space, SDR_WHITE);
    let mut encoder = gpu().encoder();
    let view = |texture: &wgpu::Texture| texture.create_view(&Default::default());
    screen.convert(&mut encoder, &view(&drawn), &view(&target));
    gpu().queue.submit([encoder.finish()]);
    texels(&target).to_floats()
}

/// Light of a signal of extended sRGB, where 1 is SDR white.
fn light(signal: f64) -> f64 {
    let sized = signal.abs();
    let curve = if sized <= 0.04045 { sized / 12.92 } else { ((sized + 0.055) / 1.055).powf(2.4) };
    curve * signal.signum()
}

/// The signal of light in extended sRGB.
fn signal(light: f64) -> f64 {
    let sized = light.abs();
    let curve = if sized <= 0.003_130_8 { sized * 12.92 } else { 1.055 * sized.powf(1.0 / 2.4) - 0.055 };
    curve * light.signum()
}

/// The same in double precision.
fn expected(space: SurfaceColorSpace, color: [f32; 4]) -> [f64; 3] {
    let half = |x: f32| f64::from(half::f16::from_f32(x).to_f32());
    let linear = [0, 1, 2].map(|c| light(half(color[c])));
    let to = |primaries: &Chromaticities| {
        let matrix = Chromaticities::REC709.conversion(primaries);
        (matrix * glam::DVec3::from_array(linear)).to_array()
    };
    match space {
        SurfaceColorSpace::ExtendedSrgbLinear => linear,
        SurfaceColorSpace::ExtendedSrgb => linear.map(signal),
        SurfaceColorSpace::DisplayP3 | SurfaceColorSpace::ExtendedDisplayP3 => {
            to(&Chromaticities::DISPLAY_P3).map(signal)
        }
        SurfaceColorSpace::Bt2100Pq => {
            to(&Chromaticities::REC2020).map(|light| Transfer::Pq.to_signal(light * SDR_WHITE / 10_000.0))
        }
        _ => {
            let display = to(&Chromaticities::REC2020).map(|light| (light * SDR_WHITE / 1000.0).clamp(0.0, 1.0));
            let luminance = 0.2627 * display[0] + 0.6780 * display[1] + 0.0593 * display[2];
            let scale = luminance.max(1e-6).powf(1.0 / hlg_gamma(1000.0) - 1.0);
            display.map(|light| Transfer::Hlg.to_signal(light * scale))
        }
    }
}

#[test]
fn every_color_space_gets_the_light_that_was_drawn() {
    use SurfaceColorSpace as Space;
    for space in [
        Space::ExtendedSrgbLinear,
        Space::ExtendedSrgb,
        Space::DisplayP3,
        Space::ExtendedDisplayP3,
        Space::Bt2100Pq,
        Space::Bt2100Hlg,
    ] {
        for (color, got) in COLORS.into_iter().zip(converted(space)) {
            let wanted = expected(space, color);
            for channel in 0..3 {
                let apart = (f64::from(got[channel]) - wanted[channel]).abs();
                assert!(apart < 4e-5 * (1.0 + wanted[channel].abs()), "{space:?} {color:?}: {got:?} {wanted:?}");
            }
        }
    }
}

#[test]
fn sdr_white_is_203_candela_in_pq() {
    let white = converted(SurfaceColorSpace::Bt2100Pq)[2];
    // ITU-R BT.2408: 58 %.
    assert!((white[1] - 0.5807).abs() < 2e-4, "{white:?}");
}
