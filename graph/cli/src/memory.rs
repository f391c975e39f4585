//! `afterimage plan --memory`: the memory that aliasing saves, for pipelines at the usual sizes.

use afterimage_graph::image::Size;
use afterimage_graph::node::Registry;
use afterimage_plan::{Memory, Plan};

use crate::args::PlanArgs;
use crate::failure::Failure;
use crate::pipeline::{facts, load_graph, plan_options, plan_without_device};

/// Full HD, 4K and 8K.
const SIZES: [Size; 3] = [
    Size { width: 1920, height: 1080, depth: 1 },
    Size { width: 3840, height: 2160, depth: 1 },
    Size { width: 7680, height: 4320, depth: 1 },
];

const HEADING: &str = "\
# Memory of transient images

Made by `afterimage plan --memory pipelines/*.ron`, in MiB, for a device whose allocations are multiples of 64 KiB.

* described: every image that the nodes describe has its own texture: no fusion and no aliasing
* stored: every image that the plan stores has its own texture; fusion has removed the others
* pooled: images with equal descriptors share a pooled texture
* placed: all images lie in one heap, at offsets
* bound: the lower bound, the most bytes that live at once in this order of passes

Outputs and histories have their own memory in all columns and are not counted.

| pipeline | size | described | stored | pooled | placed | bound | placed of described | above the bound |
|---|---|--:|--:|--:|--:|--:|--:|--:|
";

/// The table, as Markdown.
pub(crate) fn table(args: &PlanArgs, registry: &Registry) -> Result<String, Failure> {
    let mut text = HEADING.to_owned();
    let options = args.arithmetic.over(plan_options(&args.plan));
    for path in &args.pipelines {
        let graph = load_graph(path, registry, &args.options)?;
        for size in SIZES {
            let plan = plan_without_device(&graph, size, facts(&args.options)?, options)?;
            let name = path.file_stem().unwrap_or_default().to_string_lossy();
            text += &row(&name, &plan);
        }
    }
    Ok(text)
}

fn row(name: &str, plan: &Plan) -> String {
    let Memory { unaliased, unshared, pooled, placed, lower_bound, .. } = plan.memory;
    let mebibytes = |bytes: u64| format!("{:.1}", bytes as f64 / f64::from(1 << 20));
    let share = |part: u64, whole: u64| match whole {
        0 => "-".to_owned(),
        _ => format!("{:.2} %", 100.0 * part as f64 / whole as f64),
    };
    let bytes = [unaliased, unshared, pooled, placed, lower_bound].map(mebibytes).join(" | ");
    let size = format!("{}x{}", plan.size.width, plan.size.height);
    let above = share(placed - lower_bound, lower_bound);
    format!("| {name} | {size} | {bytes} | {} | {above} |\n", share(placed, unaliased))
}
