//! Plans as a picture: the passes along x, batch by batch; below them what each moves, and the images as bars at their
//! places in memory.

mod chart;
mod lanes;
mod picture;
mod text;

use afterimage_base::svg::{Anchor, Canvas, Paint};

use picture::{GRAY, INK, LEFT, Picture, TITLE};

use super::units::{count, mebibytes};
use crate::options::Alias;
use crate::plan::Plan;

impl Plan {
    /// The plan as an SVG picture that needs nothing but itself.
    pub fn to_svg(&self) -> String {
        let picture = Picture::new(self);
        let passes = lanes::height_of_names(&picture) + TITLE;
        let barriers = passes + 30.0;
        let moved = barriers + 46.0;
        let kept = moved + 72.0;
        let memory = kept + lanes::height_of_kept(&picture) + 34.0;
        let alive = memory + chart::HEIGHT + 40.0;
        let bottom = alive + chart::ALIVE_HEIGHT + 24.0;
        let mut canvas = Canvas::new(picture.width(), bottom);
        lanes::bands(&picture, &mut canvas, passes - 8.0..bottom - 14.0);
        heading(&picture, &mut canvas);
        lanes::passes(&picture, &mut canvas, passes);
        lanes::barriers(&picture, &mut canvas, barriers);
        lanes::moved(&picture, &mut canvas, moved);
        lanes::kept(&picture, &mut canvas, kept);
        chart::memory(&picture, &mut canvas, memory);
        chart::alive(&picture, &mut canvas, alive);
        canvas.finish()
    }
}

fn heading(picture: &Picture<'_>, canvas: &mut Canvas) {
    let plan = picture.plan;
    let (passes, batches) = (count(plan.passes.len(), "pass"), count(plan.batches.len(), "batch"));
    canvas.text(
        (LEFT, 30.0),
        18.0,
        Anchor::Start,
        Paint::bold(INK),
        &format!("{passes} in {batches} at {}", plan.size),
    );
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
    canvas.text((LEFT, 50.0), 12.0, Anchor::Start, GRAY, &line);
    canvas.text((LEFT, 66.0), 9.0, Anchor::Start, GRAY, &format!("plan {}", plan.hash()));
}
