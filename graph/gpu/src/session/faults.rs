//! What functions of kinds in folders do wrong in a frame, counted by a plan of its own.

use afterimage_graph::check::Graph;
use afterimage_graph::image::Size;
use afterimage_plan::{Options, Probe};

use super::{FrameStep, InputImage, Session};
use crate::post::PostError;
use crate::transfer::Texels;

/// What a function of a kind in a folder does wrong in a frame. The framework limits its numbers and ends its loops, so
/// pixels do not show it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct KernelFaults {
    /// The kind.
    pub kind: String,
    /// The node that calls it.
    pub node: String,
    /// The file of the function.
    pub file: String,
    /// The line at which it begins, from 1.
    pub line: u32,
    /// Its name.
    pub function: String,
    /// Pixels of its result.
    pub pixels: u64,
    /// Those for which it gives NaN or infinity.
    pub not_finite: u64,
    /// Those for which one of its loops has too many steps.
    pub cut_loops: u64,
}

impl KernelFaults {
    /// Counts what one function does wrong: `texels` are those of the output of its probe.
    pub fn count(texels: &Texels, probe: &Probe<'_>, graph: &Graph) -> Self {
        let kernel = probe.kernel;
        let node = graph.nodes.iter().find(|node| node.name == kernel.node);
        let mut faults = Self {
            kind: node.map_or(String::new(), |node| node.kind().name().to_owned()),
            node: kernel.node.clone(),
            file: kernel.shader.file().to_owned(),
            line: kernel.shader.error_at(&format!("fn {}", &*kernel.function), "").line,
            function: kernel.function.to_string(),
            pixels: 0,
            not_finite: 0,
            cut_loops: 0,
        };
        for [not_finite, cut, ..] in texels.to_floats() {
            faults.pixels += 1;
            faults.not_finite += u64::from(not_finite > 0.5);
            faults.cut_loops += u64::from(cut > 0.5);
        }
        faults
    }

    /// Whether it does anything wrong.
    pub fn is_any(&self) -> bool {
        (self.not_finite, self.cut_loops) != (0, 0)
    }

    /// Adds it to what is known of the same function.
    pub fn add_to(self, known: &mut Vec<Self>) {
        match known.iter_mut().find(|one| (&one.node, &one.function) == (&self.node, &self.function)) {
            Some(one) => {
                one.pixels += self.pixels;
                one.not_finite += self.not_finite;
                one.cut_loops += self.cut_loops;
            }
            None => known.push(self),
        }
    }
}

impl std::fmt::Display for KernelFaults {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { kind, node, file, line, function, pixels, not_finite, cut_loops } = self;
        let mut wrong = Vec::new();
        if *not_finite > 0 {
            wrong.push(format!("gives NaN or infinity for {not_finite} of {pixels} pixels, which is replaced"));
        }
        if *cut_loops > 0 {
            wrong.push(format!("has loops that take too long for {cut_loops} of {pixels} pixels, and are ended"));
        }
        write!(f, "{file}:{line}: `{function}` of the kind `{kind}` (node `{node}`) {}", wrong.join("; it "))
    }
}

impl Session {
    /// What functions of kinds in folders do wrong in a frame that starts histories; nothing if there are none. The
    /// frame is rendered once more, by a plan in which each such function runs twice; this session does not change.
    ///
    /// # Errors
    /// As [`render`](Session::render).
    pub fn kernel_faults(&mut self, size: Size, images: &[InputImage]) -> Result<Vec<KernelFaults>, PostError> {
        let plan = self.load(size, images)?.clone();
        if !plan.has_untrusted_kernels() {
            return Ok(Vec::new());
        }
        let mut probing = self.probing(size, images)?;
        let plan = probing.plan().clone();
        let mut found: Vec<KernelFaults> = Vec::new();
        for probe in plan.probes() {
            // A function may be called for each level of a pyramid.
            KernelFaults::count(&probing.output(probe.output)?, &probe, self.post.graph()).add_to(&mut found);
        }
        found.retain(KernelFaults::is_any);
        Ok(found)
    }

    /// The errors of each table of colors, in the order of [`Plan::baked`](afterimage_plan::Plan::baked): the largest
    /// difference from its nodes for each of 2^18 random colors, in ascending order. A frame is rendered once more, and
    /// this session does not change.
    ///
    /// # Errors
    /// As [`render`](Session::render).
    pub fn table_errors(&mut self, size: Size, images: &[InputImage]) -> Result<Vec<Vec<f32>>, PostError> {
        if self.load(size, images)?.baked.is_empty() {
            return Ok(Vec::new());
        }
        let mut probing = self.probing(size, images)?;
        let baked = probing.plan().baked.clone();
        let mut all = Vec::new();
        for output in baked.iter().filter_map(|baked| baked.error.as_deref()) {
            let pixels = probing.output(output)?.to_floats();
            let mut errors: Vec<f32> = pixels.iter().map(|pixel| pixel[0]).collect();
            errors.sort_by(f32::total_cmp);
            all.push(errors);
        }
        Ok(all)
    }

    /// A session that has rendered a first frame with probes.
    fn probing(&self, size: Size, images: &[InputImage]) -> Result<Self, PostError> {
        let (graph, facts) = (self.post.graph().clone(), self.post.facts().clone());
        let options = Options { probes: true, ..self.plan().options };
        let mut probing = Self::new(&self.gpu, graph, facts, options);
        probing.blocks.clone_from(&self.blocks);
        probing.render(size, images, FrameStep::FIRST)?;
        Ok(probing)
    }
}
