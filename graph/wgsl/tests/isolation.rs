//! Files with unkind names and formatting in one module.

use crate::hostile::{Kernel, pair};
use afterimage_wgsl::{Instance, Library, Linker, SampleMode, Shader, limits, validate};

/// Pairs that the test links: 200 for `tests/sweeps.sh`. `AFTERIMAGE_HOSTILE_PAIRS=20000` links more.
fn pairs() -> u64 {
    let is_all = std::env::var("AFTERIMAGE_SWEEPS").is_ok_and(|asked| asked == "all");
    let more = std::env::var("AFTERIMAGE_HOSTILE_PAIRS").ok().and_then(|count| count.parse().ok());
    more.unwrap_or(if is_all { 200 } else { 20 })
}

#[test]
fn files_with_unkind_names_become_one_valid_module() {
    for seed in 0..pairs() {
        let pair = pair(seed);
        let shader = |file: &str, kernel: &Kernel| {
            let library = Library::of_files([("shared.wgsl".to_owned(), kernel.shared.clone())], []);
            Shader::untrusted(file.into(), kernel.text.clone()).with_loaded_library(library)
        };
        let (one, two) = (shader("one.wgsl", &pair.hostile[0]), shader("two.wgsl", &pair.hostile[1]));
        let mut linker = Linker::new(SampleMode::Sanitized);
        let mut calls = String::new();
        for (index, shader) in [&one, &two].into_iter().enumerate() {
            shader.reflect().unwrap_or_else(|error| panic!("pair {seed} is not WGSL: {error}\n{}", shader.text()));
            let instance = linker.add(shader.source(), &[]).expect("it imports what there is");
            let function = linker.name(instance, &pair.hostile[index].function);
            let before = linker.before_call(limits::LOOP_STEPS).expect("the kernels have loops");
            calls += &format!("    {before}\n    let kernel{} = {function}(kernel{index});\n", index + 1);
        }
        let code = format!(
            "struct PassUniform {{ size: vec4f }}
@group(0) @binding(0) var image0: texture_2d<f32>;
@group(0) @binding(1) var<uniform> params1: PassUniform;
fn run(at: Point) -> vec4f {{
    let kernel0 = sanitize_texel(image0, at.pixel, 1u) + params1.size;
{calls}    return kernel2;
}}
@fragment
fn fragment(@builtin(position) at: vec4f) -> @location(0) vec4f {{ return run(Point(vec2i(at.xy), at.xy, at.xy)); }}"
        );
        let linked = linker.link(code, &[(Instance::GENERATED, "fragment")]).expect("all names are known");
        let module = validate(&linked.text, &linked.map);
        let module = module.unwrap_or_else(|error| panic!("pair {seed}: {error}\n{}", linked.text));
        assert_eq!(module.entry_points[0].name, linked.entries[0]);
    }
}
