//! A transform of OpenColorIO as a kernel function of WGSL, and the tables that it reads as textures.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::sync::Arc;

use afterimage_graph::image::{Format, ImageDesc, Size};
use afterimage_graph::wgsl::Shader;
use ocio::gpu::wgsl::{WgslTextureBinding, WgslTextureFormat};
use ocio::gpu::{GpuShaderCreator as _, GpuShaderDesc};
use ocio::{GpuLanguage, Processor};

use super::config::sentence;

/// A table of a transform, for the argument of its name.
pub(super) struct Table {
    pub(super) argument: Arc<str>,
    pub(super) desc: ImageDesc,
    pub(super) bytes: Arc<[u8]>,
}

/// The kernel function of a transform.
pub(super) struct Function {
    pub(super) shader: Arc<Shader>,
    pub(super) tables: Vec<Table>,
}

impl Function {
    pub(super) const NAME: &str = "ocio_transform";

    /// `result` is the expression of the result, of the color `v` that the transform returns.
    pub(super) fn new(processor: &Processor, result: &str) -> Result<Self, String> {
        let mut desc = GpuShaderDesc::new();
        desc.set_language(GpuLanguage::Wgsl);
        desc.set_allow_texture_1d(false);
        let gpu = processor.default_gpu_processor().map_err(|error| sentence(&error))?;
        gpu.extract_gpu_shader_info(&mut desc).map_err(|error| sentence(&error))?;
        let bindings = desc.wgsl_bindings().ok_or("OpenColorIO has no WGSL for it")?;
        if bindings.uniform_binding.is_some() {
            return Err("it has dynamic properties, which nodes cannot set: make them fixed in the file".into());
        }
        let tables = bindings.textures.iter().map(|texture| table(&desc, texture)).collect::<Result<_, _>>()?;
        let text = with_arguments(desc.shader_text(), &bindings.textures, result);
        let shader = Shader::loaded("ocio_transform.wgsl".into(), text);
        shader.reflect().map_err(|error| format!("OpenColorIO makes no valid WGSL of it: {error}"))?;
        Ok(Self { shader: Arc::new(shader), tables })
    }
}

fn table(desc: &GpuShaderDesc, texture: &WgslTextureBinding) -> Result<Table, String> {
    let name = &texture.texture_name;
    let is_volume = texture.dimensions == 3;
    let values = if is_volume {
        let known = (0..desc.num_3d_textures()).find(|at| desc.texture_3d(*at).is_ok_and(|t| t.texture_name == *name));
        known.map(|at| desc.texture_3d_values(at))
    } else {
        let known = (0..desc.num_textures()).find(|at| desc.texture(*at).is_ok_and(|t| t.texture_name == *name));
        known.map(|at| desc.texture_values(at))
    };
    let values = values.ok_or_else(|| format!("its table `{name}` is missing"))?;
    let values = values.map_err(|error| sentence(&error))?;
    let (width, height) = (texture.width, texture.height);
    // A table with an entry for each half float has some that are not finite.
    let is_of_half_floats = !is_volume && width * height > u32::from(u16::MAX);
    if !is_of_half_floats && values.iter().any(|value| !value.is_finite()) {
        return Err(
            "a table has numbers that are not finite; write its file again with the program that made it".into()
        );
    }
    let bytes = texture.texel_data(values).map_err(|error| sentence(&error))?;
    let desc = match is_volume {
        true => ImageDesc::volume(Size::volume(width, height, texture.depth)),
        false => ImageDesc::new(Size::new(width, height)),
    };
    let format = match texture.format {
        WgslTextureFormat::R32Float => Format::R32Float,
        WgslTextureFormat::Rgba32Float => Format::Rgba32Float,
    };
    Ok(Table { argument: name.as_str().into(), desc: desc.format(format), bytes: bytes.into() })
}

/// The module with its textures as arguments of the functions that read them, since kernel functions have no bindings.
fn with_arguments(module: &str, textures: &[WgslTextureBinding], result: &str) -> String {
    let is_binding = |line: &&str| line.starts_with("@group");
    let lines: Vec<&str> = module.lines().filter(|line| !is_binding(line)).collect();
    let body = lines.join("\n");
    let readers = readers(&lines, textures);
    let mut text = String::from(
        "import afterimage::color::extended_light;\nimport afterimage::grade::bounded;\n\
         import afterimage::sanitize::sanitize_signed;\n\n",
    );
    text.push_str(&with_textures(&body, &readers, textures));
    let names: Vec<&str> = textures.iter().map(|texture| texture.texture_name.as_str()).collect();
    let declared: String = textures.iter().map(declaration).collect();
    let main: String = names
        .iter()
        .filter(|name| readers.get("OCIOMain").is_some_and(|read| read.contains(*name)))
        .map(|name| format!("{name}, "))
        .collect();
    let name = Function::NAME;
    let _ = write!(
        text,
        "\n\nfn {name}(source: vec4f, {declared}) -> vec4f {{\n    \
         let v = sanitize_signed(OCIOMain({main}vec4f(source.rgb, 1.0))).rgb;\n    \
         return vec4f({result}, source.a);\n}}\n"
    );
    text
}

fn declaration(texture: &WgslTextureBinding) -> String {
    format!("{}: texture_{}d<f32>, ", texture.texture_name, texture.dimensions)
}

/// The functions that read textures, themselves or through others, and which.
fn readers<'a>(lines: &[&'a str], textures: &'a [WgslTextureBinding]) -> BTreeMap<&'a str, BTreeSet<&'a str>> {
    let mut readers: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    let mut inside = "";
    // A function follows those that it calls.
    for line in lines {
        if let Some(head) = line.strip_prefix("fn ") {
            inside = head.split('(').next().unwrap_or_default();
            continue;
        }
        for texture in textures {
            let name = texture.texture_name.as_str();
            let is_read = words(line)
                .any(|(_, word)| word == name || readers.get(word).is_some_and(|textures| textures.contains(name)));
            if is_read {
                readers.entry(inside).or_default().insert(name);
            }
        }
    }
    readers
}

/// The text in which each declaration and each call of a reader has the textures first.
fn with_textures(body: &str, readers: &BTreeMap<&str, BTreeSet<&str>>, textures: &[WgslTextureBinding]) -> String {
    let mut text = String::new();
    let mut copied = 0;
    for (end, word) in words(body) {
        let Some(read) = readers.get(word) else { continue };
        let is_declared = body[..end - word.len()].ends_with("fn ");
        let arguments: String = textures
            .iter()
            .filter(|texture| read.contains(texture.texture_name.as_str()))
            .map(|texture| if is_declared { declaration(texture) } else { format!("{}, ", texture.texture_name) })
            .collect();
        // The parenthesis that follows the name.
        text.push_str(&body[copied..=end]);
        text.push_str(&arguments);
        copied = end + 1;
    }
    text.push_str(&body[copied..]);
    text
}

/// The identifiers of a text, and where each ends.
fn words(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let is_of_word = |c: char| c.is_ascii_alphanumeric() || c == '_';
    text.split(move |c| !is_of_word(c)).filter(|word| !word.is_empty()).map(move |word| {
        let end = word.as_ptr() as usize - text.as_ptr() as usize + word.len();
        (end, word)
    })
}

#[cfg(test)]
mod tests {
    use ocio::Interpolation;

    use super::*;

    #[test]
    fn textures_are_arguments_of_the_functions_that_read_them() {
        let texture = WgslTextureBinding {
            texture_name: "hues".into(),
            sampler_name: String::new(),
            group: 0,
            binding: 1,
            dimensions: 2,
            width: 4,
            height: 1,
            depth: 1,
            format: WgslTextureFormat::R32Float,
            interpolation: Interpolation::Linear,
        };
        let module = "@group(0) @binding(1) var hues: texture_2d<f32>;\n\
                      fn hue(at: i32) -> f32 {\n    return textureLoad(hues, vec2i(at, 0), 0).x;\n}\n\
                      fn twice(x: f32) -> f32 {\n    return 2.0 * x;\n}\n\
                      fn OCIOMain(v: vec4f) -> vec4f {\n    return vec4f(twice(hue(3) + hue(2)));\n}\n";
        let text = with_arguments(module, &[texture], "v");
        assert!(!text.contains("@group"), "{text}");
        for line in [
            "fn hue(hues: texture_2d<f32>, at: i32) -> f32 {",
            "    return vec4f(twice(hue(hues, 3) + hue(hues, 2)));",
            "fn OCIOMain(hues: texture_2d<f32>, v: vec4f) -> vec4f {",
            "fn ocio_transform(source: vec4f, hues: texture_2d<f32>, ) -> vec4f {",
            "    let v = sanitize_signed(OCIOMain(hues, vec4f(source.rgb, 1.0))).rgb;",
        ] {
            assert!(text.lines().any(|found| found == line), "{line}\n{text}");
        }
    }
}
