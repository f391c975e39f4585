//! Faults of functions of kinds in folders in a frame.

use afterimage_graph::check::Graph;
use afterimage_plan::FaultCounter;

use crate::transfer::Texels;

/// Faults of a function of a kind in a folder in a frame. The framework limits its numbers and ends its loops, so
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
    /// Counts what one function does wrong: `texels` are those of the output of its counter.
    pub fn count(texels: &Texels, counter: &FaultCounter<'_>, graph: &Graph) -> Self {
        let kernel = counter.kernel;
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

    /// True if there is any fault.
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
