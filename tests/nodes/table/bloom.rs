//! Rows of bloom and blur.

use super::Reference;
use crate::nodes::bloom::{self, blurred, caracal_taps, levels};
use crate::reference::bloom::{additive_chain, composite_lerp, knee_weight, lerp_chain};
use crate::reference::image::{Image, rgb};
use crate::reference::math::largest;
use crate::reference::resample::{Down, Firefly, Up, downsample, half_size, upsample};

pub(super) fn bloom_kinds() -> Vec<Reference> {
    let [loaded, sampled] = [bloom::WHOLE, bloom::SAMPLED].map(|precision| precision.within(precision.exact, 0.0));
    let mips = |image: &Image| levels(image, 3, Down::FourTap, Firefly::Off);
    let downsampled = "\"mips\": Downsample(source: \"scene\", levels: 3, filter: Tap4)";
    let light = |size| bloom::picture(size, false);
    vec![
        Reference::new(
            ("Extract", "Color"),
            "\"result\": Extract(source: \"scene\", threshold: 0.5, knee: 0.25)",
            light,
            loaded,
            |image| {
                image.map_rgb(|rgb| {
                    let weight = knee_weight(largest(rgb), 0.5, 0.25);
                    rgb.map(|x| x * weight)
                })
            },
        ),
        Reference::new(
            ("Downsample", "Color"),
            &format!("{downsampled} -> mips.coarsest"),
            light,
            sampled,
            move |image| mips(image).pop().expect("a pyramid has a level"),
        ),
        Reference::new(
            ("Upsample", "Color"),
            &format!("{downsampled}, \"result\": Upsample(source: \"mips\", blend: Add)"),
            light,
            sampled,
            move |image| additive_chain(&mips(image), Up::Tent, 1.0),
        ),
        Reference::new(
            ("GaussianPyramid", "Color"),
            &format!(
                "{downsampled}, \"soft\": GaussianPyramid(source: \"mips\", kernel: Caracal9), \
                 \"result\": Upsample(source: \"soft\", spread: 0.85, filter: Bilinear)"
            ),
            light,
            sampled,
            move |image| {
                let soft: Vec<Image> = mips(image).iter().map(blurred(&caracal_taps())).collect();
                lerp_chain(&soft, 0.85, Up::Bilinear, 1.0)
            },
        ),
        Reference::new(
            ("Gaussian", "Color"),
            "\"result\": Gaussian(source: \"scene\", kernel: Caracal9, taps: Exact)",
            light,
            loaded,
            |image| blurred(&caracal_taps())(image),
        ),
        Reference::new(
            ("Composite", "Color"),
            "\"half\": Downsample(source: \"scene\", levels: 1, filter: Box), \
             \"result\": Composite(base: \"scene\", bloom: \"half.coarsest\", blend: Mix, strength: 0.25)",
            light,
            sampled,
            |image| {
                let level = downsample(image, half_size(image.width, image.height), Down::Box);
                let bloom = upsample(&level, [image.width, image.height], Up::Tent, 1.0);
                Image::new(image.width, image.height, |x, y| {
                    let [base, bloom] = [image, &bloom].map(|image| image.texel(x as i64, y as i64));
                    let [r, g, b] = composite_lerp(rgb(base), rgb(bloom), 0.25);
                    [r, g, b, base[3]]
                })
            },
        ),
    ]
}
