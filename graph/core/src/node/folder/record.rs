//! The passes of a kind without Rust.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::sync::Arc;

use super::declaration::{Declaration, Made, Pyramid, Shape, SizeRule, Source};
use crate::node::{Fallback, ImageId, Input, InputValue, InputValues, Node, Output, PortType, Recorder};
use afterimage_base::Shared;
use afterimage_base::image::{Format, ImageDesc, Size};
use afterimage_base::value::{Param, Value};
use afterimage_wgsl::{ArgType, Shader};

/// The words of a table, two in a texel, as the library's `table` reads them.
static WORDS: Shader = Shader::new(
    "table_words.wgsl",
    "@group(0) @binding(0) var<storage, read> table: array<u32>;
@group(0) @binding(1) var words: texture_storage_2d<rgba32float, write>;
fn table_halves(index: u32) -> vec2f {
    let word = select(0u, table[min(index, arrayLength(&table) - 1u)], index < arrayLength(&table));
    return vec2f(f32(word & 0xffffu), f32(word >> 16u));
}
@compute @workgroup_size(16, 16)
fn table_words(@builtin(global_invocation_id) id: vec3u) {
    let size = textureDimensions(words);
    if any(id.xy >= size) { return; }
    let index = 2u * (id.y * size.x + id.x);
    textureStore(words, id.xy, vec4f(table_halves(index), table_halves(index + 1u)));
}",
);

/// Texels in a row of the image of a table, and the most rows: what lies beyond is not read.
const TABLE_WIDTH: u64 = 256;
const MAX_ROWS: u64 = 8192;

/// A node of a kind without Rust.
pub(super) struct FolderNode {
    passes: Arc<FolderPasses>,
    params: Arc<[Param]>,
    /// True if each parameter has its neutral value, or has none.
    is_neutral: Vec<bool>,
}

impl FolderNode {
    pub(super) fn new(passes: Arc<FolderPasses>, params: Arc<[Param]>, values: &[Value]) -> Self {
        let is_neutral = params.iter().zip(values).map(|(param, value)| is_neutral(param, value)).collect();
        Self { passes, params, is_neutral }
    }

    /// Sets the parameter at this place.
    pub(super) fn set(&mut self, index: usize, value: &Value) {
        self.is_neutral[index] = is_neutral(&self.params[index], value);
    }
}

fn is_neutral(param: &Param, value: &Value) -> bool {
    param.neutral.as_ref().is_none_or(|neutral| neutral == value)
}

/// Passes of a folder kind, shared by its nodes. They do not depend on the parameters, which are uniforms.
pub(super) struct FolderPasses {
    pub(super) inputs: Vec<Input>,
    pub(super) outputs: Vec<Output>,
    steps: Vec<Step>,
    shader: Arc<Shader>,
    /// True if the first output can be replaced by its fallback, which then has its size.
    can_be_skipped: bool,
}

/// A function and what it makes.
struct Step {
    name: Shared<str>,
    function: Shared<str>,
    levels: Levels,
    size: SizeRule,
    format: Format,
    /// The images of its arguments, where the recorder does not find them by their names.
    reads: Vec<(Shared<str>, Source)>,
}

/// For what the function is called.
enum Levels {
    Image { workgroup: Option<[u32; 2]> },
    Down { of: Source, levels: u32 },
    Each(Pyramid),
    Up(Pyramid),
}

impl FolderPasses {
    /// The passes of a declaration that agrees with its shader.
    pub(super) fn new(declared: &Declaration, shader: Arc<Shader>) -> Self {
        let inputs = declared.inputs.iter().map(|(port, _)| port.clone()).collect();
        let outputs = declared.made.iter().filter_map(|made| made.port.clone()).collect();
        let steps = declared.made.iter().enumerate().map(|(at, made)| step(declared, at, made, &shader)).collect();
        Self { inputs, outputs, steps, shader, can_be_skipped: can_be_skipped(declared) }
    }

    /// The functions whose results are read.
    fn needed(&self, pass: &Recorder<'_>) -> Vec<bool> {
        let mut needed: Vec<bool> = self.steps.iter().map(|step| pass.is_output_used(&step.name)).collect();
        // Each reads only those before it.
        for at in (0..self.steps.len()).rev() {
            if needed[at] {
                self.steps[at].reads_of_made().for_each(|made| needed[made] = true);
            }
        }
        needed
    }

    /// The size of the first image, or of the frame.
    fn size(&self, pass: &mut Recorder<'_>) -> Size {
        let mut images = self.inputs.iter().filter(|port| is_image(port));
        let first = images.find(|port| pass.wired(&port.name) && !pass.is_zero(&port.name));
        let image = match first {
            Some(port) if port.ty == PortType::Pyramid => pass.pyramid(&port.name)[0],
            Some(port) => pass.image(&port.name),
            None => return pass.frame_size,
        };
        pass.desc(image).size
    }
}

/// Returns whether the first output has the size of its fallback: that of the first image, if nothing else is stated.
fn can_be_skipped(declared: &Declaration) -> bool {
    let Some(main) = declared.made.iter().find(|made| made.port.is_some()) else { return false };
    let first = declared.inputs.iter().map(|(input, _)| input).find(|input| is_image(input));
    let fallback = main.port.as_ref().map(|port| &port.fallback);
    let has_size_of_first = matches!(main.shape, Shape::Image { .. }) && main.size == SizeRule::Same;
    match fallback {
        Some(Fallback::Input(name)) => has_size_of_first && first.is_some_and(|first| first.name == *name),
        Some(Fallback::Zero) => true,
        _ => false,
    }
}

fn is_image(port: &Input) -> bool {
    matches!(port.ty, PortType::Image | PortType::Pyramid)
}

fn step(declared: &Declaration, at: usize, made: &Made, shader: &Shader) -> Step {
    let reflection = shader.reflect().expect("the shader was read before the kind was made");
    let function = &made.function.value;
    let args = &reflection.function(function).expect("the function was found before the kind was made").args;
    // The recorder finds the numbers of inputs itself, also where nothing arrives.
    let reads = args.iter().filter_map(|(name, ty)| {
        let source = declared.source(at, name)?;
        let is_own = matches!(source, Source::Input(input) if declared.inputs[input].0.name == *name);
        let is_image = matches!(ty, ArgType::Texture | ArgType::Volume);
        (is_image || (matches!(ty, ArgType::Floats(_)) && !is_own)).then(|| (name.clone().into(), source))
    });
    let of = |name: &str| declared.named(name, at).expect("what it goes through was found before the kind was made");
    let pyramid = |name: &str| match of(name) {
        Source::Made(made) => Pyramid::Made(made),
        Source::Input(input) => Pyramid::Input(input),
        other => panic!("a name means an input or an image, not {other:?}"),
    };
    let levels = match &made.shape {
        Shape::Image { workgroup } => Levels::Image { workgroup: *workgroup },
        Shape::Down { of: name, levels } => Levels::Down { of: of(&name.value), levels: *levels },
        Shape::Each { of } => Levels::Each(pyramid(&of.value)),
        Shape::Up { of } => Levels::Up(pyramid(&of.value)),
    };
    let (name, function) = (made.name.value.clone().into(), function.clone().into());
    Step { name, function, levels, size: made.size, format: made.format, reads: reads.collect() }
}

impl Step {
    /// The places of what other functions make and this one reads.
    fn reads_of_made(&self) -> impl Iterator<Item = usize> + '_ {
        let through = match self.levels {
            Levels::Down { of: Source::Made(made), .. }
            | Levels::Each(Pyramid::Made(made))
            | Levels::Up(Pyramid::Made(made)) => Some(made),
            _ => None,
        };
        let reads = self.reads.iter().filter_map(|(_, source)| match source {
            Source::Made(made) | Source::Level(Pyramid::Made(made), _) => Some(*made),
            _ => None,
        });
        through.into_iter().chain(reads)
    }
}

impl Node for FolderNode {
    /// All parameters with a neutral value have it. Other outputs, such as masks, may differ from their fallbacks then.
    fn identity_of(&self, output: &str, inputs: &InputValues) -> bool {
        let Some(main) = self.passes.outputs.first().filter(|main| main.name == *output) else { return false };
        let arrives = match &main.fallback {
            Fallback::Input(name) => !inputs.is_absent(name),
            _ => true,
        };
        let has_neutral = self.params.iter().any(|param| param.neutral.is_some());
        let is_neutral = has_neutral && self.is_neutral.iter().all(|neutral| *neutral);
        is_neutral && arrives && self.passes.can_be_skipped
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let node = &*self.passes;
        let needed = node.needed(pass);
        let size = node.size(pass);
        let mut recorder = FolderRecorder { node, size, made: Vec::new(), tables: BTreeMap::new(), pass };
        for (step, needed) in node.steps.iter().zip(needed) {
            let made = if needed { recorder.step(step) } else { InputValue::Absent };
            if recorder.pass.is_output_used(&step.name) {
                recorder.pass.set_output(&step.name, made.clone());
            }
            recorder.made.push(made);
        }
    }
}

struct FolderRecorder<'n, 'r, 'a> {
    node: &'n FolderPasses,
    size: Size,
    /// Results of the functions before.
    made: Vec<InputValue>,
    /// The tables that have been read, as images.
    tables: BTreeMap<usize, ImageId>,
    pass: &'r mut Recorder<'a>,
}

/// Additional sources of a function that is called for several levels.
#[derive(Clone, Copy, Default)]
struct Moving {
    at_hand: Option<ImageId>,
    coarser: Option<ImageId>,
}

impl FolderRecorder<'_, '_, '_> {
    fn step(&mut self, step: &Step) -> InputValue {
        match step.levels {
            Levels::Image { .. } => {
                let image = self.target(step, &step.name, step.size.of(self.size));
                self.call(step, Moving::default(), image);
                InputValue::Image(image)
            }
            Levels::Down { of, levels } => self.down(step, of, levels),
            Levels::Each(of) => {
                let levels = self.pyramid(of).into_iter().enumerate();
                let level = |(index, level)| self.level(step, index, level, Moving::default());
                InputValue::Pyramid(levels.map(level).collect())
            }
            Levels::Up(of) => {
                let levels = self.pyramid(of);
                let (coarsest, finer) = levels.split_last().expect("a pyramid has a level");
                let upwards = finer.iter().enumerate().rev();
                InputValue::Image(upwards.fold(*coarsest, |coarser, (index, level)| {
                    self.level(step, index, *level, Moving { coarser: Some(coarser), ..Moving::default() })
                }))
            }
        }
    }

    fn down(&mut self, step: &Step, of: Source, levels: u32) -> InputValue {
        let mut above = self.image(of, Moving::default());
        let mut size = self.pass.desc(above).size;
        let mut made = Vec::new();
        for index in 0..levels.min(size.levels()).max(1) {
            size = size.half();
            let image = self.target(step, format_args!("{}.{index}", step.name), size);
            self.call(step, Moving { at_hand: Some(above), coarser: None }, image);
            made.push(image);
            above = image;
        }
        InputValue::Pyramid(made)
    }

    /// Calls the function for a level of a pyramid; the result has its size.
    fn level(&mut self, step: &Step, index: usize, level: ImageId, moving: Moving) -> ImageId {
        let size = self.pass.desc(level).size;
        let image = self.target(step, format_args!("{}.{index}", step.name), size);
        self.call(step, Moving { at_hand: Some(level), ..moving }, image);
        image
    }

    /// An image for a result. The format that a pipeline sets is for outputs.
    fn target(&mut self, step: &Step, name: impl Display, size: Size) -> ImageId {
        let desc = ImageDesc::new(size).format(step.format);
        match self.pass.is_output_used(&step.name) {
            true => self.pass.level(name, desc),
            false => self.pass.transient(name, desc),
        }
    }

    fn call(&mut self, step: &Step, moving: Moving, result: ImageId) {
        let reads: Vec<_> = step.reads.iter().map(|(name, of)| (name.clone(), self.image(*of, moving))).collect();
        let size = self.pass.desc(result).size;
        let label = match step.levels {
            Levels::Image { .. } => step.function.to_string(),
            _ => format!("{} {size}", step.function),
        };
        let call = self.pass.function(self.node.shader.clone(), step.function.clone()).label(label);
        let call = reads.into_iter().fold(call, |call, (name, image)| call.read(name, image));
        match step.levels {
            Levels::Image { workgroup: Some(invocations) } => call.workgroup(invocations).write_to(result),
            _ => call.write_to(result),
        }
    }

    fn image(&mut self, source: Source, moving: Moving) -> ImageId {
        match source {
            Source::Input(input) => self.input(input),
            Source::Made(made) => match &self.made[made] {
                InputValue::Image(image) => *image,
                other => panic!("an image was made before its readers, not {other:?}"),
            },
            Source::Level(of, level) => {
                let levels = self.pyramid(of);
                levels[(level as usize).min(levels.len() - 1)]
            }
            Source::AtHand => moving.at_hand.expect("the function goes through levels"),
            Source::Coarser => moving.coarser.expect("the function goes up through levels"),
        }
    }

    /// The image of an input; one black texel where nothing arrives.
    fn input(&mut self, input: usize) -> ImageId {
        let port = &self.node.inputs[input];
        match (self.pass.wired(&port.name), port.ty) {
            (false, ty) => self.black(ty == PortType::Volume),
            (true, PortType::Table) => self.table(input),
            (true, _) => self.pass.image(&port.name),
        }
    }

    /// The words of a table as an image: a function cannot take a buffer.
    fn table(&mut self, input: usize) -> ImageId {
        if let Some(image) = self.tables.get(&input) {
            return *image;
        }
        let name = &self.node.inputs[input].name;
        let buffer = self.pass.buffer(name);
        let texels = self.pass.buffer_bytes(buffer).div_ceil(8);
        let rows = texels.div_ceil(TABLE_WIDTH).clamp(1, MAX_ROWS);
        let desc = ImageDesc::new(Size::new(TABLE_WIDTH as u32, rows as u32)).format(Format::Rgba32Float);
        let image = self.pass.transient(format_args!("{name}.words"), desc);
        let groups = desc.size.div_up(16);
        let call = self.pass.compute(&WORDS, "table_words").buffer("table", buffer).image("words", image);
        call.dispatch([groups.width, groups.height, 1]);
        self.tables.insert(input, image);
        image
    }

    fn pyramid(&mut self, of: Pyramid) -> Vec<ImageId> {
        match of {
            Pyramid::Made(made) => match &self.made[made] {
                InputValue::Pyramid(levels) => levels.clone(),
                other => panic!("a pyramid was made before its readers, not {other:?}"),
            },
            Pyramid::Input(input) => {
                let port = &self.node.inputs[input];
                match self.pass.wired(&port.name) {
                    true => self.pass.pyramid(&port.name).into_owned(),
                    false => vec![self.black(false)],
                }
            }
        }
    }

    fn black(&mut self, volume: bool) -> ImageId {
        let black = ImageDesc { volume, ..ImageDesc::new(Size::new(1, 1)) };
        self.pass.constant("black", black, vec![0; black.bytes() as usize])
    }
}
