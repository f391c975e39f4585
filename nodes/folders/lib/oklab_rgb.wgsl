// Oklab (Ottosson, "A perceptual color space for image processing", 2020) of linear light in the primaries of Rec.709.
import afterimage::oklab::{oklab, oklab_deviation};

// Lightness, a and b. White is (1, 0, 0); light times 8 doubles all three.
fn oklab_from_rgb(rgb: vec3f) -> vec3f {
    return oklab(vec3f(
        dot(rgb, vec3f(0.4122214708, 0.5363325363, 0.0514459929)),
        dot(rgb, vec3f(0.2119034982, 0.6806995451, 0.1073969566)),
        dot(rgb, vec3f(0.0883024619, 0.2817188376, 0.6299787005)),
    ));
}

fn oklab_to_rgb(lab: vec3f) -> vec3f {
    let roots = lab.x + oklab_deviation(lab.yz);
    let lms = roots * roots * roots;
    return vec3f(
        dot(lms, vec3f(4.0767416621, -3.3077115913, 0.2309699292)),
        dot(lms, vec3f(-1.2684380046, 2.6097574011, -0.3413193965)),
        dot(lms, vec3f(-0.0041960863, -0.7034186147, 1.7076147010)),
    );
}
