//! PlanCache as a picture: the passes along x, batch by batch; below them what each moves, and the images as bars at their places in memory.

mod canvas;
mod chart;
mod lanes;

use canvas::{Anchor, Canvas, Paint};

use crate::names::Names;
use crate::print::{count, mebibytes};
use crate::{Alias, Plan};

const LEFT: f64 = 112.0;
/// Slanted names of the last passes reach so far to the right.
const RIGHT: f64 = 150.0;
const TITLE: f64 = 74.0;

const INK: &str = "#1f2933";
const GREY: &str = "#7b8794";
const LINE: &str = "#cbd2d9";
const BAND: &str = "#f3f5f8";
const BOUND: &str = "#c62828";
const HAND_OVER: &str = "#ef6c00";
const BARRIER: &str = "#52606d";

impl Plan {
    /// The plan as an SVG picture that needs nothing but itself.
    pub fn to_svg(&self) -> String {
        let picture = Picture::new(self);
        let mut canvas = Canvas::default();
        let passes = lanes::height_of_names(&picture) + TITLE;
        let barriers = passes + 30.0;
        let moved = barriers + 46.0;
        let kept = moved + 72.0;
        let memory = kept + lanes::height_of_kept(&picture) + 34.0;
        let alive = memory + chart::HEIGHT + 40.0;
        let bottom = alive + chart::ALIVE_HEIGHT + 24.0;
        lanes::bands(&picture, &mut canvas, passes - 8.0..bottom - 14.0);
        heading(&picture, &mut canvas);
        lanes::passes(&picture, &mut canvas, passes);
        lanes::barriers(&picture, &mut canvas, barriers);
        lanes::moved(&picture, &mut canvas, moved);
        lanes::kept(&picture, &mut canvas, kept);
        chart::memory(&picture, &mut canvas, memory);
        chart::alive(&picture, &mut canvas, alive);
        canvas.finish(picture.width(), bottom)
    }
}

/// A plan and its measures on paper.
struct Picture<'a> {
    plan: &'a Plan,
    names: Names,
    /// The width of a pass.
    column: f64,
    colors: Vec<(String, String)>,
}

impl<'a> Picture<'a> {
    fn new(plan: &'a Plan) -> Self {
        let count = plan.recording.passes.len().max(1);
        let column = (1500.0 / count as f64).clamp(20.0, 90.0);
        let mut nodes: Vec<String> = Vec::new();
        for node in plan.recording.passes.iter().flat_map(|pass| &pass.nodes) {
            if !nodes.contains(node) {
                nodes.push(node.clone());
            }
        }
        // Steps of the golden angle keep the colours of neighbours apart, however many there are.
        let color = |index: usize| canvas::color(205.0 + 137.508 * index as f64);
        let colors = nodes.into_iter().enumerate().map(|(index, node)| (node, color(index))).collect();
        Self { plan, names: Names::new(plan), column, colors }
    }

    fn width(&self) -> f64 {
        LEFT + self.column * self.plan.recording.passes.len() as f64 + RIGHT
    }

    fn right(&self) -> f64 {
        self.width() - RIGHT
    }

    /// The left edge of a pass.
    fn x(&self, pass: usize) -> f64 {
        LEFT + self.column * pass as f64
    }

    /// The left and the right edge of a life; what leaves the frame ends a little beyond the last pass.
    fn life(&self, image: usize) -> Option<(f64, f64)> {
        let lifetime = self.plan.lifetimes[image]?;
        let end = self.plan.batches.get(lifetime.last).map_or(self.right() + 8.0, |batch| self.x(batch.end));
        Some((self.x(self.plan.batches[lifetime.first].start), end))
    }

    /// The colour of a node; images have that of the node in front of the point in their names.
    fn color(&self, name: &str) -> &str {
        let node = name.split('.').next().unwrap_or(name);
        self.colors.iter().find(|(known, _)| known == node || known == name).map_or("#b0bac5", |(_, color)| color)
    }
}

fn heading(picture: &Picture<'_>, canvas: &mut Canvas) {
    let plan = picture.plan;
    let (passes, batches) = (count(plan.recording.passes.len(), "pass"), count(plan.batches.len(), "batch"));
    canvas.text(LEFT, 30.0, 18.0, Anchor::Start, Paint::bold(INK), &format!("{passes} in {batches} at {}", plan.size));
    let memory = &plan.memory;
    let used = memory.bytes(plan.options.alias);
    let share = if memory.unaliased == 0 { 100.0 } else { 100.0 * used as f64 / memory.unaliased as f64 };
    let how = match plan.options.alias {
        Alias::Placed => "placed in one heap",
        Alias::Pool => "in a pool",
        Alias::None => "each with its own memory",
    };
    let line = format!(
        "transient images: {} {how}, {share:.1} % of the {} that the nodes describe; lower bound {}; {} moved a frame",
        mebibytes(used),
        mebibytes(memory.unaliased),
        mebibytes(memory.lower_bound),
        mebibytes(plan.bytes_moved())
    );
    canvas.text(LEFT, 50.0, 12.0, Anchor::Start, Paint::plain(GREY), &line);
    canvas.text(LEFT, 66.0, 9.0, Anchor::Start, Paint::plain(GREY), &format!("plan {}", plan.hash()));
}
