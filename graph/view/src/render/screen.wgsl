// From what the viewer draws to what the swap chain of an HDR screen holds.

struct Screen {
    // From Rec.709 to the primaries of the swap chain: the rows of the matrix.
    red: vec4f,
    green: vec4f,
    blue: vec4f,
    // The encoding of the swap chain: see the constants.
    encoding: u32,
    // The luminance of SDR white, in the unit of the encoding.
    white: f32,
    // The exponent of HLG's system.
    gamma: f32,
    unused: f32,
}

const LINEAR = 0u;
const SRGB = 1u;
const PQ = 2u;
const HLG = 3u;

@group(0) @binding(0) var<uniform> screen: Screen;
@group(0) @binding(1) var drawn: texture_2d<f32>;

@vertex
fn corner(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return vec4f(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

// SMPTE ST 2084; 1 is 10000 cd/m2.
fn encode_pq(light: vec3f) -> vec3f {
    let power = pow(clamp(light, vec3f(0.0), vec3f(1.0)), vec3f(0.1593017578125));
    return pow((0.8359375 + 18.8515625 * power) / (1.0 + 18.6875 * power), vec3f(78.84375));
}

// ITU-R BT.2100: 1 is the peak of the display.
fn encode_hlg(display: vec3f) -> vec3f {
    let shown = clamp(display, vec3f(0.0), vec3f(1.0));
    let luminance = dot(shown, vec3f(0.2627, 0.6780, 0.0593));
    let scene = shown * pow(max(luminance, 1e-6), 1.0 / screen.gamma - 1.0);
    let high = 0.17883277 * log(max(12.0 * scene - 0.28466892, vec3f(1e-6))) + 0.55991073;
    return clamp(select(high, sqrt(3.0 * scene), scene <= vec3f(1.0 / 12.0)), vec3f(0.0), vec3f(1.0));
}

@fragment
fn convert(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let light = decode(textureLoad(drawn, vec2i(position.xy), 0).rgb);
    let converted = vec3f(dot(screen.red.xyz, light), dot(screen.green.xyz, light), dot(screen.blue.xyz, light));
    let shown = converted * screen.white;
    if (screen.encoding == PQ) {
        return vec4f(encode_pq(shown), 1.0);
    }
    if (screen.encoding == HLG) {
        return vec4f(encode_hlg(shown), 1.0);
    }
    return vec4f(select(shown, encode(shown), screen.encoding == SRGB), 1.0);
}
