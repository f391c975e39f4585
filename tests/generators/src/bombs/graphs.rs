//! Graphs that are expensive to plan.

use std::fmt::Write as _;

use super::bomb::{Bomb, before, last, lines, pipeline};

/// Nodes that each change single pixels of the one before.
pub(super) fn points(count: usize) -> Bomb {
    let node = |at| format!("\"n{at}\": Saturation(source: \"{}\", amount: 0.5)", before(at));
    Bomb::of(pipeline(&lines(count, node), &last(count)))
}

/// Nodes that each read the one before as a pixel and as a texture.
pub(super) fn stencils(count: usize) -> Bomb {
    let node = |at| format!("\"n{at}\": Composite(base: \"{0}\", bloom: \"{0}\")", before(at));
    Bomb::of(pipeline(&lines(count, node), &last(count)))
}

/// Blurs of blurs.
pub(super) fn blurs(count: usize) -> Bomb {
    let node = |at| format!("\"n{at}\": Gaussian(source: \"{}\")", before(at));
    Bomb::of(pipeline(&lines(count, node), &last(count)))
}

/// Pyramids of the largest depth, each blurred, collapsed again and added to the one before.
pub(super) fn pyramids(count: usize) -> Bomb {
    let node = |at: usize| match at % 4 {
        0 => format!("\"n{at}\": Downsample(source: \"scene\", levels: 16)"),
        1 => format!("\"n{at}\": GaussianPyramid(source: \"{}\")", before(at)),
        2 => format!("\"n{at}\": Upsample(source: \"{}\")", before(at)),
        _ => {
            let base = if at == 3 { before(0) } else { before(at - 3) };
            format!("\"n{at}\": Composite(base: \"{base}\", bloom: \"{}\")", before(at))
        }
    };
    let count = count.next_multiple_of(4);
    Bomb::of(pipeline(&lines(count, node), &last(count)))
}

/// Exposures by meters of the image before.
pub(super) fn meters(count: usize) -> Bomb {
    let node = |at: usize| match at % 3 {
        0 => format!("\"n{at}\": MeanLuminance(source: \"{}\")", before(at)),
        1 => format!("\"n{at}\": Adapt(mean: \"{}\")", before(at)),
        _ => format!("\"n{at}\": Saturation(source: \"{}\", amount: 0.5)", before(at - 2)),
    };
    let count = count.next_multiple_of(3);
    Bomb::of(pipeline(&lines(count, node), &last(count)))
}

/// Nodes that all read the input, joined two by two.
pub(super) fn fan_out(count: usize) -> Bomb {
    let mut nodes = lines(count, |at| format!("\"n{at}\": Gaussian(source: \"scene\", sigma: {}.5)", 1 + at % 32));
    let mut width: Vec<String> = (0..count).map(|at| format!("n{at}")).collect();
    let mut made = 0;
    while width.len() > 1 {
        let join = |pair: &[String]| match pair {
            [base, bloom] => {
                let name = format!("j{made}");
                made += 1;
                writeln!(nodes, "\"{name}\": Composite(base: \"{base}\", bloom: \"{bloom}\"),").expect("a string");
                name
            }
            alone => alone.concat(),
        };
        width = width.chunks(2).map(join).collect();
    }
    Bomb::of(pipeline(&nodes, &width.concat()))
}

/// Nodes that all read the input, joined one after the other.
pub(super) fn fan_in(count: usize) -> Bomb {
    let wide = lines(count, |at| format!("\"w{at}\": Saturation(source: \"scene\", amount: 0.5)"));
    let joined = lines(count, |at| format!("\"n{at}\": Composite(base: \"{}\", bloom: \"w{at}\")", before(at)));
    Bomb::of(pipeline(&format!("{wide}{joined}"), &last(count)))
}

/// The same with blurs.
pub(super) fn blurred_fan_in(count: usize) -> Bomb {
    let wide = lines(count, |at| format!("\"w{at}\": Gaussian(source: \"scene\")"));
    let joined = lines(count, |at| format!("\"n{at}\": Composite(base: \"{}\", bloom: \"w{at}\")", before(at)));
    Bomb::of(pipeline(&format!("{wide}{joined}"), &last(count)))
}

/// A chain of blurs that is joined from its end to its beginning, so that all of its images live at once.
pub(super) fn lives(count: usize) -> Bomb {
    let blurred = |at: usize| if at == 0 { before(0) } else { format!("w{}", at - 1) };
    let blur = |at| format!("\"w{at}\": Gaussian(source: \"{}\")", blurred(at));
    let join = |at| format!("\"n{at}\": Composite(base: \"{}\", bloom: \"w{}\")", before(at), count - 1 - at);
    Bomb::of(pipeline(&format!("{}{}", lines(count, blur), lines(count, join)), &last(count)))
}

/// The same with all levels of blurred pyramids.
pub(super) fn live_pyramids(count: usize) -> Bomb {
    let blurred = |at: usize| if at == 0 { "mips".to_owned() } else { format!("w{}", at - 1) };
    let blur = |at| format!("\"w{at}\": GaussianPyramid(source: \"{}\")", blurred(at));
    let up = |at| format!("\"u{at}\": Upsample(source: \"w{at}\")");
    let join = |at| format!("\"n{at}\": Composite(base: \"{}\", bloom: \"u{}\")", before(at), count - 1 - at);
    let nodes = [lines(count, blur), lines(count, up), lines(count, join)].concat();
    Bomb::of(pipeline(&format!("\"mips\": Downsample(source: \"scene\", levels: 16),\n{nodes}"), &last(count)))
}

/// Output transforms, each with tables of its own.
pub(super) fn transforms(count: usize) -> Bomb {
    let node = |at| format!("\"n{at}\": Aces2Output(source: \"scene\", peak: {:.3})", 1.0 + at as f64 / 1000.0);
    let outputs = lines(count, |at| format!("\"o{at}\": \"n{at}\""));
    let nodes = lines(count, node);
    Bomb::of(format!("Pipeline(inputs: {{\"scene\": Exposed}}, nodes: {{\n{nodes}}}, outputs: {{\n{outputs}}})"))
}

/// Nodes that each read the table of colors in one file.
pub(super) fn tables(count: usize) -> Bomb {
    const SIDE: usize = 65;
    let entry = |at: usize| format!("{:.6} {:.6} {:.6}\n", (at % 97) as f64 / 97.0, (at % 89) as f64 / 89.0, 0.125);
    let entries: String = (0..SIDE.pow(3)).map(entry).collect();
    let nodes = lines(count, |at| format!("\"n{at}\": ColorLut(source: \"{}\", file: \"a.cube\")", before(at)));
    let text = pipeline(&nodes, &last(count)).replacen("Color", "Encoded", 1);
    Bomb { text, files: [("a.cube".to_owned(), format!("LUT_3D_SIZE {SIDE}\n{entries}"))].into() }
}

/// One image that every node of a chain reads.
pub(super) fn readers(count: usize) -> Bomb {
    let node = |at| format!("\"n{at}\": Composite(base: \"{}\", bloom: \"shared\")", before(at));
    let nodes = format!("\"shared\": Gaussian(source: \"scene\"),\n{}", lines(count, node));
    Bomb::of(pipeline(&nodes, &last(count)))
}

/// Each node reads the two before it.
pub(super) fn ladder(count: usize) -> Bomb {
    let node = |at: usize| {
        format!("\"n{at}\": Composite(base: \"{}\", bloom: \"{}\")", before(at), before(at.saturating_sub(1)))
    };
    Bomb::of(pipeline(&lines(count, node), &last(count)))
}

/// Each node reads what the one before was in the previous frame.
pub(super) fn previous(count: usize) -> Bomb {
    let node = |at: usize| match at {
        0 => "\"n0\": Saturation(source: \"scene\", amount: 0.5)".to_owned(),
        _ => format!("\"n{at}\": Saturation(source: \"{}@previous\", amount: 0.5)", before(at)),
    };
    Bomb::of(pipeline(&lines(count, node), &last(count)))
}

/// The same, in the order of the file against the wires.
pub(super) fn previous_backwards(count: usize) -> Bomb {
    let node = |at: usize| match count - 1 - at {
        0 => "\"n0\": Saturation(source: \"scene\", amount: 0.5)".to_owned(),
        at => format!("\"n{at}\": Saturation(source: \"{}@previous\", amount: 0.5)", before(at)),
    };
    Bomb::of(pipeline(&lines(count, node), &last(count)))
}

/// Each node reads the one before and what that was as long ago as can be.
pub(super) fn previous_far(count: usize) -> Bomb {
    let node = |at: usize| match at {
        0 => "\"n0\": Saturation(source: \"scene\", amount: 0.5)".to_owned(),
        _ => format!("\"n{at}\": Composite(base: \"{0}\", bloom: \"{0}@previous:{1}\")", before(at), 1 + at % 16),
    };
    Bomb::of(pipeline(&lines(count, node), &last(count)))
}
