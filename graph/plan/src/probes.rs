//! Probes: functions that are not trusted run once more, into images that state where they make numbers that are
//! not finite, and where their loops are ended. What such functions make for other passes is limited, so nobody else
//! sees it.

use afterimage_base::image::{ColorState, Format, ImageDesc, Signedness};
use afterimage_graph::node::{Arg, ImageColor, ImageId, KernelCall, Origin, Pass, PassResult, Recording, VirtualImage};
use afterimage_wgsl::Shader;

use crate::builder::PlanBuilder;
use crate::plan::{Plan, PlanOutput};

#[allow(unsafe_code, reason = "the shader was unchecked")]
// SAFETY: it reads nothing.
static PROBE: Shader =
    unsafe { Shader::unchecked("probe.wgsl", "fn probe(faults: vec2f) -> vec4f { return vec4f(faults, 0.0, 1.0); }") };

/// A function that a plan probes.
#[derive(Clone, Copy, Debug)]
pub struct Probe<'p> {
    /// The call of the function.
    pub kernel: &'p KernelCall,
    /// The name of the output whose red is 1 where the function gives a number that is not finite, and whose green is 1
    /// where one of its loops was ended.
    pub output: &'p str,
}

/// Adds a probe after each pass around a function that is not trusted.
pub(crate) fn probes(builder: &mut PlanBuilder) {
    for pass in std::mem::take(&mut builder.recording.passes) {
        let probe = probe(&pass, &mut builder.recording);
        builder.recording.passes.push(pass);
        let Some((probe, image)) = probe else { continue };
        builder.recording.passes.push(probe);
        let ImageColor { state, colorimetry } = ImageColor::of(ColorState::Data);
        let name = builder.recording.image(image).label.clone();
        builder.outputs.push(PlanOutput { name, image, state, colorimetry, in_rectangle: false });
    }
}

fn probe(pass: &Pass, recording: &mut Recording) -> Option<(Pass, ImageId)> {
    let ([kernel], [result]) = (pass.kernels.as_slice(), pass.results.as_slice()) else { return None };
    if !kernel.shader.is_untrusted() {
        return None;
    }
    let made = recording.image(result.image);
    let image = VirtualImage {
        label: format!("{}.faults", made.label),
        desc: ImageDesc::new(made.desc.size).format(Format::Rgba8Unorm),
        origin: Origin::Transient,
        finite: true,
        signedness: Signedness::Unsigned,
    };
    let image = recording.add_image(image);
    let unlimited = KernelCall { limited: None, ..kernel.clone() };
    let faults = KernelCall::function(&kernel.node, &PROBE, "probe", &[("faults", Arg::Faults(0))]);
    let (kernels, results) = (vec![unlimited, faults], vec![PassResult { kernel: 1, image }]);
    Some((Pass { label: format!("{} probe", pass.label), kernels, results, ..pass.clone() }, image))
}

impl Plan {
    /// Returns whether it calls a function of a kind in a folder.
    pub fn has_untrusted_kernels(&self) -> bool {
        let mut kernels = self.passes.iter().flat_map(|planned| &planned.pass.kernels);
        kernels.any(|kernel| kernel.shader.is_untrusted())
    }

    /// The functions that it probes, if it was made with [`Options::probes`](crate::Options::probes).
    pub fn probes(&self) -> impl Iterator<Item = Probe<'_>> {
        let kernels = self.passes.iter().flat_map(|planned| {
            let results = &planned.pass.results;
            let of_result = |at: usize| results.iter().find(|result| result.kernel == at).map(|result| result.image);
            planned.pass.kernels.iter().enumerate().filter_map(move |(at, kernel)| match kernel.arg("faults")? {
                Arg::Faults(probed) => Some((&planned.pass.kernels[probed], of_result(at)?)),
                _ => None,
            })
        });
        kernels.filter_map(|(kernel, image)| {
            let output = self.outputs.iter().find(|output| output.image == image)?;
            Some(Probe { kernel, output: &output.name })
        })
    }
}
