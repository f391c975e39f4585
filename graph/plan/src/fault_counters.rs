//! Fault counters: untrusted functions run once more, into images that mark the pixels where they return numbers that
//! are not finite, and those where their loops are ended. Other passes read limited results, so they do not see these
//! faults.

use afterimage_base::image::{Format, ImageDesc, Signedness};
use afterimage_graph::node::{Arg, ImageId, KernelCall, Origin, Pass, PassResult, Recording, VirtualImage};
use afterimage_wgsl::Shader;

use crate::builder::PlanBuilder;
use crate::plan::{Plan, PlanOutput};

#[allow(unsafe_code, reason = "the shader was unchecked")]
// SAFETY: it reads nothing.
static FAULTS: Shader = unsafe {
    Shader::unchecked("faults.wgsl", "fn faults(faults: vec2f) -> vec4f { return vec4f(faults, 0.0, 1.0); }")
};

/// An untrusted function whose faults a plan counts.
#[derive(Clone, Copy, Debug)]
pub struct FaultCounter<'p> {
    /// The call of the function.
    pub kernel: &'p KernelCall,
    /// The name of the output whose red is 1 where the function gives a number that is not finite, and whose green is 1
    /// where one of its loops was ended.
    pub output: &'p str,
}

/// Adds a fault counter after each pass around an untrusted function.
pub(crate) fn add_fault_counters(builder: &mut PlanBuilder) {
    for pass in std::mem::take(&mut builder.recording.passes) {
        let counter = fault_counter(&pass, &mut builder.recording);
        builder.recording.passes.push(pass);
        let Some((counter, image)) = counter else { continue };
        builder.recording.passes.push(counter);
        let name = builder.recording.image(image).label.clone();
        builder.outputs.push(PlanOutput::of_data(name, image));
    }
}

fn fault_counter(pass: &Pass, recording: &mut Recording) -> Option<(Pass, ImageId)> {
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
    let faults = KernelCall::function(&kernel.node, &FAULTS, "faults", &[("faults", Arg::Faults(0))]);
    let (kernels, results) = (vec![unlimited, faults], vec![PassResult { kernel: 1, image }]);
    Some((Pass { label: format!("{} faults", pass.label), kernels, results, ..pass.clone() }, image))
}

impl Plan {
    /// Returns whether it calls a function of a kind in a folder.
    pub fn has_untrusted_kernels(&self) -> bool {
        let mut kernels = self.passes.iter().flat_map(|planned| &planned.pass.kernels);
        kernels.any(|kernel| kernel.shader.is_untrusted())
    }

    /// Its fault counters, if it was made with [`Options::count_faults`](crate::Options::count_faults).
    pub fn fault_counters(&self) -> impl Iterator<Item = FaultCounter<'_>> {
        let kernels = self.passes.iter().flat_map(|planned| {
            let results = &planned.pass.results;
            let of_result = |at: usize| results.iter().find(|result| result.kernel == at).map(|result| result.image);
            planned.pass.kernels.iter().enumerate().filter_map(move |(at, kernel)| match kernel.arg("faults")? {
                Arg::Faults(counted) => Some((&planned.pass.kernels[counted], of_result(at)?)),
                _ => None,
            })
        });
        kernels.filter_map(|(kernel, image)| {
            let output = self.outputs.iter().find(|output| output.image == image)?;
            Some(FaultCounter { kernel, output: &output.name })
        })
    }
}
