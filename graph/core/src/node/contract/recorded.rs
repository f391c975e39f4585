//! A recording of a kind: at values of its parameters, with something at its inputs.

use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use super::violations::Violations;
use crate::node::{
    BlockId, BufferLife, ImageColor, Input, InputValue, InputValues, NodeColors, NodeInstance, Origin, OutputUse,
    PortType, Recorder, RecorderContext, Recording, VirtualBuffer, VirtualImage,
};
use afterimage_base::caps::Caps;
use afterimage_base::color::{Chromaticities, Colorimetry};
use afterimage_base::image::{ColorState, ImageDesc, Signedness, Size};
use afterimage_base::panics::{catch_panic, message_of};
use afterimage_wgsl::ShaderError;

/// A use of a node.
#[derive(Clone, Copy)]
pub(super) struct Use<'a> {
    pub(super) node: &'a NodeInstance,
    pub(super) wiring: Wiring,
    pub(super) size: Size,
    /// The parameters that the host may set while a plan runs.
    pub(super) dynamic: &'a [usize],
    pub(super) is_exact: bool,
}

#[derive(Clone, Copy, PartialEq)]
pub(super) enum Wiring {
    /// Each to something as large as the frame, of unknown primaries.
    All,
    /// All but the optional ones.
    Required,
    /// All but this one, if it is optional.
    AllBut(usize),
    /// Each, and all images but the first are half as large.
    SmallOthers,
    /// Each, with the primaries of Rec.2020.
    WideColors,
}

/// A recording with its inputs and outputs.
#[derive(PartialEq)]
pub(super) struct Recorded {
    pub(super) inputs: Vec<InputValue>,
    pub(super) outputs: Vec<InputValue>,
    pub(super) recording: Recording,
    /// The number of images of the inputs, which are the first ones.
    pub(super) input_images: usize,
}

const FAILS: &str = "recording fails";

/// Tables that a recording has computed.
pub(super) type Tables = BTreeMap<String, Arc<[u8]>>;

impl Use<'_> {
    fn is_wired(&self, index: usize, port: &Input) -> bool {
        let is_left_out = self.wiring == Wiring::Required || self.wiring == Wiring::AllBut(index);
        !(port.optional && is_left_out)
    }

    /// Records the node; `None` where it refuses its values, such as a missing file, where its fallbacks replace
    /// it, and where recording fails, which is a violation.
    pub(super) fn record(&self, computed: Tables, violations: &mut Violations) -> Option<Recorded> {
        let work =
            || if self.is_replaced() || self.node.verify().is_err() { Ok(None) } else { self.recorded(computed) };
        // The first panic of a kind is printed with its place, and not again for each size and value.
        let has_failed = violations.0.iter().any(|violation| violation.starts_with(FAILS));
        let recorded = match has_failed {
            true => catch_panic(work),
            false => catch_unwind(AssertUnwindSafe(work)).map_err(|panic| message_of(&*panic)),
        };
        match recorded {
            Ok(Ok(recorded)) => return recorded,
            Ok(Err(errors)) => errors.iter().for_each(|error| violations.add(format!("{FAILS}: {error}"))),
            Err(panic) => violations.add(format!("{FAILS}: {panic}")),
        }
        None
    }

    fn is_replaced(&self) -> bool {
        let kind = self.node.kind();
        let ports = kind.inputs().iter().enumerate();
        let absent = ports.filter(|(index, port)| !self.is_wired(*index, port)).map(|(index, _)| index);
        let inputs = InputValues::new(kind.clone(), Vec::new(), absent.collect());
        kind.outputs().iter().all(|port| self.node.identity_of(&port.name, &inputs))
    }

    fn recorded(&self, computed: Tables) -> Result<Option<Recorded>, Vec<ShaderError>> {
        let kind = self.node.kind();
        let mut recording = Recording { computed, ..Recording::default() };
        let first_image = kind.inputs().iter().position(|port| port.ty == PortType::Image);
        let mut inputs = Vec::new();
        for (index, port) in kind.inputs().iter().enumerate() {
            let is_small = self.wiring == Wiring::SmallOthers && first_image.is_some_and(|first| first < index);
            let size = if is_small { self.size.half() } else { self.size };
            inputs.push(match self.is_wired(index, port) {
                true => sample_input(port, size, &mut recording),
                false => InputValue::Absent,
            });
        }
        let wide = |port: &Input| {
            let state = port.states.first().copied().unwrap_or(ColorState::Scene);
            Some(ImageColor { state, colorimetry: Colorimetry::linear(Chromaticities::REC2020) })
        };
        let has_wide_colors = self.wiring == Wiring::WideColors;
        let colors: Vec<_> = kind.inputs().iter().filter(|_| has_wide_colors).map(wide).collect();
        let input_images = recording.images.len();
        let context = RecorderContext {
            node: "node",
            kind: kind.signature(),
            parameters: self.node.uniform_values(),
            dynamic: self.dynamic,
            inputs: &inputs,
            format: None,
            frame_size: self.size,
            caps: &Caps::default(),
            exact: self.is_exact,
            used_outputs: &vec![OutputUse::Whole; kind.outputs().len()],
            colors: NodeColors { inputs: &colors, outputs: &[] },
        };
        let mut recorder = Recorder::new(context, &mut recording);
        self.node.record(&mut recorder);
        let (outputs, errors) = recorder.finish();
        if errors.is_empty() { Ok(Some(Recorded { inputs, outputs, recording, input_images })) } else { Err(errors) }
    }
}

impl Recorded {
    pub(super) fn without_uniforms(mut self) -> Self {
        let kernels = self.recording.passes.iter_mut().flat_map(|pass| &mut pass.kernels);
        kernels.for_each(|kernel| kernel.uniform.fill(0));
        self
    }
}

/// Something plausible for an input.
fn sample_input(port: &Input, size: Size, recording: &mut Recording) -> InputValue {
    let (label, origin) = (port.name.to_string(), Origin::Input(port.name.to_string()));
    let mut image = |desc: ImageDesc| {
        let (label, origin) = (label.clone(), origin.clone());
        recording.add_image(VirtualImage { label, desc, origin, finite: false, signedness: Signedness::Unsigned })
    };
    match port.ty {
        PortType::Image => InputValue::Image(image(ImageDesc::new(size))),
        PortType::Multisampled => InputValue::Image(image(ImageDesc::new(size).multisampled(4))),
        PortType::Volume => InputValue::Image(image(ImageDesc::volume(Size::volume(16, 9, 8)))),
        PortType::Pyramid => {
            let levels = size.levels().clamp(1, 4);
            let sizes = std::iter::successors(Some(size.half()), |size| Some(size.half()));
            InputValue::Pyramid(sizes.take(levels as usize).map(|size| image(ImageDesc::new(size))).collect())
        }
        PortType::Table | PortType::Value => {
            let bytes = if port.ty == PortType::Value { 16 } else { 64 << 10 };
            let buffer = VirtualBuffer { label, bytes, life: BufferLife::Frame };
            InputValue::Buffer(recording.add_buffer(buffer))
        }
        PortType::Block => InputValue::Block(BlockId(0)),
    }
}
