//! Baking: runs of point functions of one color become a baked LUT, which the same functions fill.
//!
//! A run is replaced by one function that looks a color up. A pass fills the table that it reads, in the first frame of
//! a plan and when its uniforms have changed; in every frame if the run depends on a value that passes make.

mod run;
mod table;

use std::collections::BTreeSet;

use afterimage_graph::check::Graph;
use afterimage_graph::node::{Arg, ImageId, KernelCall, Pass};

use crate::builder::PlanBuilder;
use crate::plan::{Baked, Fused, PlanOutput};
use crate::request::PlanRequest;
use run::{Run, part, runs};
use table::Table;

/// Puts tables in the place of the runs that ask for one.
pub(crate) fn bake(builder: &mut PlanBuilder, graph: &Graph, request: &PlanRequest<'_>) {
    if request.options.exact {
        return;
    }
    let copies = part(builder, graph, &request.options);
    let runs = runs(builder, graph, &request.options);
    let passes = std::mem::take(&mut builder.recording.passes);
    let mut passes: Vec<Vec<Pass>> = passes.into_iter().map(|pass| vec![pass]).collect();
    for run in runs {
        let table = Table::new(run.size);
        if table.side() <= request.caps.max_side {
            let of_run = run.passes.iter().flat_map(|pass| std::mem::take(&mut passes[*pass])).collect();
            passes[run.last()] = replace(builder, &run, of_run, &copies, table, request.options.count_faults);
        }
    }
    builder.recording.passes = passes.into_iter().flatten().collect();
}

/// The passes that take the place of a run. No node describes the images `copies`.
fn replace(
    builder: &mut PlanBuilder,
    run: &Run,
    passes: Vec<Pass>,
    copies: &BTreeSet<ImageId>,
    table: Table,
    measures_error: bool,
) -> Vec<Pass> {
    let (mut kernels, mut nodes, mut intermediates): (Vec<KernelCall>, Vec<String>, Vec<_>) = Default::default();
    // The first kernel of the passes that fill the table makes the colors.
    let mut source = run.source;
    for pass in passes {
        let Pass { nodes: of_pass, kernels: of_kernel, results, .. } = pass;
        let before = kernels.len();
        let chained =
            of_kernel.into_iter().map(|kernel| kernel.moved(1, Some(Arg::Pixel(source)), Arg::Kernel(before)));
        kernels.extend(chained);
        nodes.extend(of_pass);
        source = results[0].image;
        intermediates.push(source);
    }
    nodes.dedup();
    intermediates.pop();
    for image in intermediates.into_iter().filter(|image| !copies.contains(image)) {
        builder.savings.fused.push(Fused::new(builder.recording.image(image), &nodes));
    }
    let passes = table.passes(&mut builder.recording, run, &nodes, kernels, measures_error);
    let bytes = builder.recording.image(written(&passes[0])).desc.bytes();
    let error = measures_error.then(|| {
        let image = written(&passes[1]);
        let name = builder.recording.image(image).label.clone();
        builder.outputs.push(PlanOutput::of_data(name.clone(), image));
        name
    });
    builder.savings.baked.push(Baked { nodes, size: run.size, bytes, in_every_frame: run.reads_value, error });
    passes
}

fn written(pass: &Pass) -> ImageId {
    pass.results[0].image
}
