//! A plan on paper: columns, lives and colors.

use super::text::color;
use crate::plan::Plan;
use crate::report::names::Names;

pub(super) const LEFT: f64 = 112.0;
/// Slanted names of the last passes reach so far to the right.
pub(super) const RIGHT: f64 = 150.0;
pub(super) const TITLE: f64 = 74.0;

pub(super) const INK: &str = "#1f2933";
pub(super) const GRAY: &str = "#7b8794";
pub(super) const LINE: &str = "#cbd2d9";
pub(super) const BAND: &str = "#f3f5f8";
pub(super) const BOUND: &str = "#c62828";
pub(super) const ALIASING: &str = "#ef6c00";
pub(super) const BARRIER: &str = "#52606d";

/// A plan and its measures on paper.
pub(super) struct Picture<'a> {
    pub(super) plan: &'a Plan,
    pub(super) names: Names,
    /// The width of a pass.
    pub(super) column: f64,
    colors: Vec<(String, String)>,
}

impl<'a> Picture<'a> {
    pub(super) fn new(plan: &'a Plan) -> Self {
        let count = plan.passes.len().max(1);
        let column = (1500.0 / count as f64).clamp(20.0, 90.0);
        let mut nodes: Vec<String> = Vec::new();
        for node in plan.work().flat_map(|pass| &pass.nodes) {
            if !nodes.contains(node) {
                nodes.push(node.clone());
            }
        }
        // Steps of the golden angle keep the colors of neighbors apart, however many there are.
        let color = |index: usize| color(205.0 + 137.508 * index as f64);
        let colors = nodes.into_iter().enumerate().map(|(index, node)| (node, color(index))).collect();
        Self { plan, names: Names::new(plan), column, colors }
    }

    pub(super) fn width(&self) -> f64 {
        LEFT + self.column * self.plan.passes.len() as f64 + RIGHT
    }

    pub(super) fn right(&self) -> f64 {
        self.width() - RIGHT
    }

    /// The left edge of a pass.
    pub(super) fn x(&self, pass: usize) -> f64 {
        LEFT + self.column * pass as f64
    }

    /// The left and the right edge of a life; what leaves the frame ends a little beyond the last pass.
    pub(super) fn life(&self, image: usize) -> Option<(f64, f64)> {
        let lifetime = self.plan.images[image].lifetime?;
        let end = self.plan.batches.get(lifetime.last).map_or(self.right() + 8.0, |batch| self.x(batch.passes.end));
        Some((self.x(self.plan.batches[lifetime.first].passes.start), end))
    }

    /// The color of a node; images have that of the node in front of the point in their names.
    pub(super) fn color(&self, name: &str) -> &str {
        let node = name.split('.').next().unwrap_or(name);
        self.colors.iter().find(|(known, _)| known == node || known == name).map_or("#b0bac5", |(_, color)| color)
    }
}
