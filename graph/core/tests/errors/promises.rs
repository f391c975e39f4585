//! The contract of kinds, one broken promise after the other: a kind that keeps it is changed in one thing, and the
//! complaints are compared with `promises.told`, to the letter: none is missing, and there is none beside them.
//! `AFTERIMAGE_BLESS=1` writes the file anew.

use std::fmt::Write as _;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use afterimage_graph::node::{CAMERA, Fallback, InputValues, Kind, NodeKind, contract};
use afterimage_graph::prelude::*;
use afterimage_graph::value::{ChoiceName, Param, Quality, Type, Value, When};

static SHADER: Shader = Shader::new(
    "mist.wgsl",
    "import afterimage::camera::Camera;
struct Eye { view: mat4x4f }
fn mist(source: vec4f) -> vec4f { return source; }
fn mist_seen(source: vec4f, eye: Camera) -> vec4f { return eye.view * source; }
fn mist_other(source: vec4f, eye: Eye) -> vec4f { return eye.view * source; }
@group(0) @binding(0) var source: texture_2d<f32>;
@group(0) @binding(1) var result: texture_storage_2d<rgba16float, write>;
@compute @workgroup_size(8, 8) fn mist_fill(@builtin(global_invocation_id) id: vec3u) {
    textureStore(result, id.xy, textureLoad(source, vec2i(id.xy), 0));
}
@compute @workgroup_size(1, 1, 65) fn mist_deep(@builtin(global_invocation_id) id: vec3u) {
    textureStore(result, id.xy, textureLoad(source, vec2i(id.xy), 0));
}",
);
static STRAY: Shader = Shader::new("Stray.wgsl", "fn stray(source: vec4f) -> vec4f { return source; }");

const CHOICES: &[ChoiceName] =
    &[ChoiceName { name: "One", doc: "The first." }, ChoiceName { name: "Two", doc: "The other." }];
const BAD_CHOICES: &[ChoiceName] =
    &[ChoiceName { name: "one", doc: "The first." }, ChoiceName { name: "Two", doc: " " }];

/// What a kind declares and records.
#[derive(Clone)]
struct Declared {
    name: &'static str,
    doc: &'static str,
    params: Vec<Param>,
    inputs: Vec<Input>,
    outputs: Vec<Output>,
    record: fn(&Values, &mut Recorder<'_>),
    identity: fn(&Values, &str, &InputValues) -> bool,
}

/// A node of the kind at its values.
struct Values(Vec<Value>, Declared);

impl Kind for Declared {
    fn name(&self) -> &str {
        self.name
    }
    fn doc(&self) -> &str {
        self.doc
    }
    fn params(&self) -> &[Param] {
        &self.params
    }
    fn inputs(&self) -> &[Input] {
        &self.inputs
    }
    fn outputs(&self) -> &[Output] {
        &self.outputs
    }
    fn instantiate(&self, values: &[Value]) -> Arc<dyn Node> {
        Arc::new(Values(values.to_vec(), self.clone()))
    }
}

impl Node for Values {
    fn identity_of(&self, output: &str, inputs: &InputValues) -> bool {
        (self.1.identity)(self, output, inputs)
    }
    fn record(&self, pass: &mut Recorder<'_>) {
        (self.1.record)(self, pass);
    }
}

fn plain(_: &Values, pass: &mut Recorder<'_>) {
    let source = pass.image("source");
    let desc = pass.desc(source);
    pass.function(&SHADER, "mist").write("result", desc);
}

fn number(name: &'static str, domain: (f64, f64)) -> Param {
    let mut param = Param::new(name, "A number.", Type::Float, Value::Float(0.5));
    param.domain = Some(domain);
    param
}

fn choice(choices: &'static [ChoiceName], default: &'static str) -> Param {
    Param::new("mode", "A choice.", Type::Choice(choices), Value::Choice(default))
}

/// A kind that keeps every promise.
fn good() -> Declared {
    let mut amount = number("amount", (0.0, 1.0));
    (amount.usual, amount.neutral) = (Some((0.0, 0.5)), Some(Value::Float(0.0)));
    amount.quality = Some(Quality { exact: Value::Float(1.0), cheaper: vec![Value::Float(0.25)] });
    Declared {
        name: "Mist",
        doc: "Mist.",
        params: vec![amount],
        inputs: vec![
            Input::image("source", "An image.").accepts(&[ColorState::Scene]),
            Input::new("meter", PortType::Value, "A value.").optional().content("mean-luminance"),
        ],
        outputs: vec![Output::image("result", OutputState::same("source"), "An image.").or_input("source")],
        record: plain,
        identity: |_, _, _| false,
    }
}

/// A second output of a type, which the kind gives as a buffer.
fn with_buffer(draft: &mut Declared, port: Output) {
    draft.outputs.push(port);
    draft.record = |values, pass| {
        plain(values, pass);
        let buffer = pass.add_buffer("other", 16, BufferLife::Frame);
        pass.set_output("other", InputValue::Buffer(buffer));
    };
}

fn value(state: OutputState) -> Output {
    Output::new("other", PortType::Value, state, "A value.")
}

type Change = fn(&mut Declared);

const DECLARED: &[(&str, Change)] = &[
    ("nothing", |_| {}),
    ("a small name", |d| d.name = "mist"),
    ("a name of pipeline files", |d| d.name = "Off"),
    ("no doc", |d| d.doc = " "),
    ("a name twice", |d| d.inputs[1].name = "source".into()),
    ("a parameter with the name of an input", |d| d.params[0].name = "meter".into()),
    ("a name in capitals", |d| d.inputs[1].name = "Meter".into()),
    ("a name that ends in a line", |d| d.inputs[1].name = "meter_".into()),
    ("a name with a meaning of its own", |d| d.params[0].name = "frame".into()),
    ("an output with a name of WGSL", |d| d.outputs[0].name = "target".into()),
    ("an input with a name of WGSL", |d| d.inputs[1].name = "target".into()),
    ("an input without doc", |d| d.inputs[1].doc = "".into()),
    ("an output without doc", |d| d.outputs[0].doc = "\n".into()),
    ("a value with a state", |d| d.inputs[1] = d.inputs[1].clone().accepts(&[ColorState::Data])),
    ("a block without declaration", |d| d.inputs[1].ty = PortType::Block),
    ("a declaration of a block for a value", |d| d.inputs[1].block = Some(&CAMERA)),
    ("a block with a state", |d| {
        d.inputs[1] = Input::block("meter", &CAMERA, "A camera.").accepts(&[ColorState::Data])
    }),
    ("an image with a content", |d| d.inputs[0] = d.inputs[0].clone().content("light")),
    ("a content in capitals", |d| d.inputs[1] = d.inputs[1].clone().content("Mean")),
    ("a content with spaces", |d| d.inputs[1] = d.inputs[1].clone().content("mean luminance")),
    ("an empty content", |d| d.inputs[1] = d.inputs[1].clone().content("")),
    ("a volume with a content", |d| {
        d.inputs[1] = Input::new("meter", PortType::Volume, "A volume.").content("grid-2").optional()
    }),
    ("a pyramid with a content", |d| {
        d.inputs[1] = Input::new("meter", PortType::Pyramid, "A pyramid.").content("levels").optional()
    }),
    ("an image without a state", |d| d.outputs[0].state = OutputState::Nothing),
    ("an image that is always one state", |d| d.outputs[0].state = OutputState::Always(ColorState::Data)),
    ("a value without a state", |d| with_buffer(d, value(OutputState::Nothing))),
    ("a value that is always one state", |d| with_buffer(d, value(OutputState::Always(ColorState::Data)))),
    ("a table without a content", |d| {
        with_buffer(d, Output::new("other", PortType::Table, OutputState::Nothing, "A table."));
    }),
    ("a table with a content", |d| {
        with_buffer(d, Output::new("other", PortType::Table, OutputState::Nothing, "A table.").content("counts"));
    }),
    ("a block as an output", |d| {
        with_buffer(d, Output::new("other", PortType::Block, OutputState::Nothing, "A camera."));
    }),
    ("the state of a value", |d| d.outputs[0].state = OutputState::same("meter")),
    ("the state of no input", |d| d.outputs[0].state = OutputState::same("elsewhere")),
    ("the state of an optional input", |d| d.inputs[0] = d.inputs[0].clone().optional()),
    ("a state that a number chooses", |d| d.outputs[0].state = OutputState::chosen("amount")),
    ("a state that nothing chooses", |d| d.outputs[0].state = OutputState::chosen("mode")),
    ("a state that a choice chooses", |d| {
        d.params.push(choice(CHOICES, "One"));
        d.outputs[0].state = OutputState::chosen("mode");
    }),
    ("a state that a choice chooses without an image", |d| {
        d.params.push(choice(CHOICES, "One"));
        d.outputs[0].state = OutputState::chosen("mode");
        d.inputs[0] = d.inputs[0].clone().optional();
    }),
    ("a state that a choice chooses after a value", |d| {
        d.params.push(choice(CHOICES, "One"));
        d.outputs[0].state = OutputState::chosen("mode");
        d.inputs.swap(0, 1);
        d.inputs[0].optional = false;
    }),
    ("a fallback to zero of a value", |d| with_buffer(d, value(OutputState::Nothing).or(Fallback::Zero))),
    ("a fallback to a value", |d| with_buffer(d, value(OutputState::Nothing).or_input("meter"))),
    ("a fallback to no input", |d| d.outputs[0] = d.outputs[0].clone().or_input("elsewhere")),
    ("a fallback to another type", |d| d.outputs[0] = d.outputs[0].clone().or_input("meter")),
    ("a fallback to nothing", |d| d.outputs[0] = d.outputs[0].clone().or(Fallback::Absent)),
    ("a fallback to zero", |d| d.outputs[0] = d.outputs[0].clone().or(Fallback::Zero)),
    ("a parameter without doc", |d| d.params[0].doc = String::new()),
    ("a domain without end", |d| d.params[0].domain = Some((0.0, f64::INFINITY))),
    ("a domain without beginning", |d| d.params[0].domain = Some((f64::NEG_INFINITY, 1.0))),
    ("an empty domain", |d| d.params[0].domain = Some((0.5, 0.5))),
    ("no domain", |d| d.params[0].domain = None),
    ("a usual range that begins early", |d| d.params[0].usual = Some((-0.5, 0.5))),
    ("a usual range that ends late", |d| d.params[0].usual = Some((0.5, 1.5))),
    ("a usual range of one number", |d| d.params[0].usual = Some((0.5, 0.5))),
    ("a logarithmic range below zero", |d| {
        (d.params[0].domain, d.params[0].logarithmic) = (Some((-1.0, 1.0)), true);
        d.params[0].usual = None;
    }),
    ("the whole domain as the usual range", |d| d.params[0].usual = Some((0.0, 1.0))),
    ("a default outside", |d| d.params[0].default = Value::Float(2.0)),
    ("a neutral value outside", |d| d.params[0].neutral = Some(Value::Float(-1.0))),
    ("a quality outside", |d| {
        d.params[0].quality = Some(Quality { exact: Value::Float(2.0), cheaper: vec![Value::Float(3.0)] });
    }),
    ("a whole number without a domain", |d| d.params.push(Param::new("count", "A number.", Type::Int, Value::Int(1)))),
    ("a vector without a domain", |d| {
        d.params.push(Param::new("place", "A place.", Type::Vector(2), Value::Vector([0.0; 4], 2)));
    }),
    ("a flag, which needs no domain", |d| d.params.push(Param::new("flag", "A flag.", Type::Bool, Value::Bool(true)))),
    ("no choices", |d| d.params.push(choice(&[], "One"))),
    ("conditions of a parameter", |d| {
        d.params.push(choice(CHOICES, "One"));
        let choice = |name| Value::Choice(name);
        d.params[0].when = vec![
            When::OneOf("mode".into(), vec![choice("One"), choice("Two")]),
            When::NoneOf("mode".into(), vec![choice("Two")]),
            When::Wired("meter".into(), false),
        ];
    }),
    ("conditions on nothing, on itself, of another type and on a required input", |d| {
        d.params.push(Param::new("flag", "A flag.", Type::Bool, Value::Bool(true)));
        d.params[0].when = vec![
            When::OneOf("mode".into(), vec![Value::Bool(true)]),
            When::OneOf("amount".into(), vec![Value::Float(0.5)]),
            When::NoneOf("flag".into(), vec![Value::Int(1)]),
            When::Wired("source".into(), true),
        ];
    }),
    ("choices in small letters and without doc", |d| d.params.push(choice(BAD_CHOICES, "Two"))),
];

static ROUND: AtomicU32 = AtomicU32::new(0);

const RECORDED: &[(&str, Change)] = &[
    ("a write to what was given", |d| {
        d.record = |values, pass| {
            plain(values, pass);
            let source = pass.image("source");
            pass.function(&SHADER, "mist").write_to(source);
        };
    }),
    ("a write to a constant", |d| {
        d.record = |values, pass| {
            plain(values, pass);
            let constant = pass.constant("table", ImageDesc::new(Size::new(1, 1)), vec![0; 8]);
            pass.function(&SHADER, "mist").write_to(constant);
        };
    }),
    ("a write to an image of its own", |d| {
        d.record = |values, pass| {
            plain(values, pass);
            let own = pass.transient("own", ImageDesc::new(pass.frame_size));
            pass.function(&SHADER, "mist").write_to(own);
        };
    }),
    ("a block in its struct", |d| {
        d.inputs.push(Input::block("eye", &CAMERA, "A camera."));
        d.record = |_, pass| {
            let source = pass.image("source");
            let desc = pass.desc(source);
            pass.function(&SHADER, "mist_seen").write("result", desc);
        };
    }),
    ("a block in another struct", |d| {
        d.inputs.push(Input::block("eye", &CAMERA, "A camera."));
        d.record = |_, pass| {
            let source = pass.image("source");
            let desc = pass.desc(source);
            pass.function(&SHADER, "mist_other").write("result", desc);
        };
    }),
    ("a file that is not called after a kind", |d| {
        d.record = |_, pass| {
            let source = pass.image("source");
            let desc = pass.desc(source);
            pass.function(&STRAY, "stray").write("result", desc);
        };
    }),
    ("an output that is not given", |d| d.record = |_, _| {}),
    ("an output of another type", |d| {
        d.record = |_, pass| {
            let buffer = pass.add_buffer("other", 16, BufferLife::Frame);
            pass.set_output("result", InputValue::Buffer(buffer));
        };
    }),
    ("a pyramid for an image", |d| {
        d.record = |_, pass| {
            let image = pass.image("source");
            pass.set_output("result", InputValue::Pyramid(vec![image]));
        };
    }),
    ("zero for an image", |d| d.record = |_, pass| pass.set_output("result", InputValue::Zero)),
    ("another recording each time", |d| {
        d.record = |values, pass| {
            plain(values, pass);
            pass.add_buffer(
                "round",
                16 * u64::from(1 + ROUND.fetch_add(1, Ordering::Relaxed) % 1000),
                BufferLife::Frame,
            );
        };
    }),
    ("a panic", |d| d.record = |_, _| panic!("no image at {}", 7)),
    ("a parameter that changes passes", |d| {
        d.record = |values, pass| {
            plain(values, pass);
            if values.0[0] == Value::Float(1.0) {
                pass.add_buffer("more", 16, BufferLife::Frame);
            }
        };
    }),
    ("a parameter that changes passes and says so", |d| {
        d.params[0].replan = true;
        d.record = |values, pass| {
            plain(values, pass);
            if values.0[0] == Value::Float(1.0) {
                pass.add_buffer("more", 16, BufferLife::Frame);
            }
        };
    }),
    ("a choice that panics", |d| {
        d.params.push(choice(CHOICES, "One"));
        d.record = |values, pass| {
            assert!(values.0[1] == Value::Choice("One"), "the second is missing");
            plain(values, pass);
        };
    }),
    ("nothing but fallbacks", |d| d.identity = |_, _, _| true),
    ("a fallback at the default alone", |d| d.identity = |values, _, _| values.0[0] == Value::Float(0.5)),
    ("an identity by no input", |d| d.identity = |_, _, inputs| inputs.is_absent("elsewhere")),
    ("one fallback of two outputs, and a buffer that is too large", |d| {
        with_buffer(d, value(OutputState::Nothing));
        d.identity = |_, output, _| output == "result";
        d.record = |values, pass| {
            plain(values, pass);
            let buffer = pass.add_buffer("large", (128 << 20) + 1, BufferLife::Frame);
            pass.set_output("other", InputValue::Buffer(buffer));
        };
    }),
    ("a buffer of the largest size", |d| {
        d.record = |values, pass| {
            plain(values, pass);
            pass.add_buffer("large", 128 << 20, BufferLife::Frame);
        };
    }),
    ("a buffer that is too large", |d| {
        d.record = |values, pass| {
            plain(values, pass);
            pass.add_buffer("large", (128 << 20) + 1, BufferLife::Frame);
        };
    }),
    ("workgroups in one direction up to the limit", |d| {
        d.record = |_, pass| {
            let result = pass.output("result", ImageDesc::new(pass.frame_size));
            pass.compute(&SHADER, "mist_fill").image("result", result).dispatch([1, 65_535, 1]);
        };
    }),
    ("too many workgroups in one direction", |d| {
        d.record = |_, pass| {
            let result = pass.output("result", ImageDesc::new(pass.frame_size));
            pass.compute(&SHADER, "mist_fill").image("result", result).dispatch([1, 65_536, 1]);
        };
    }),
    ("a workgroup that is too deep", |d| {
        d.record = |_, pass| {
            let result = pass.output("result", ImageDesc::new(pass.frame_size));
            pass.compute(&SHADER, "mist_deep").image("result", result).dispatch([1, 1, 1]);
        };
    }),
];

#[test]
fn each_broken_promise_is_reported_and_nothing_else() {
    let mut told = String::new();
    for (name, change) in DECLARED.iter().chain(RECORDED) {
        let mut draft = good();
        change(&mut draft);
        ROUND.store(0, Ordering::Relaxed);
        writeln!(told, "{name}:").expect("a string grows");
        let lines = match contract(&[NodeKind::new(Arc::new(draft))]) {
            Ok(skipped) => skipped.into_iter().map(|line| format!("  skipped: {line}")).collect::<Vec<_>>(),
            Err(complaints) => complaints.into_iter().map(|line| format!("  {line}")).collect(),
        };
        lines.iter().for_each(|line| writeln!(told, "{line}").expect("a string grows"));
    }
    let path = super::folder().join("promises.told");
    if std::env::var_os("AFTERIMAGE_BLESS").is_some() {
        std::fs::write(&path, &told).expect("the folder of cases can be written");
    }
    let known = std::fs::read_to_string(&path).unwrap_or_default();
    for (old, new) in known.lines().zip(told.lines()) {
        assert_eq!(old, new, "if this is meant, set AFTERIMAGE_BLESS=1");
    }
    assert_eq!(known, told);
}
