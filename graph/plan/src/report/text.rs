//! Plans as text: what runs, in which order, the memory of the images, and what was skipped and why.

use std::fmt::Write;

use super::colorimetry::described;
use super::names::Names;
use super::units::{count, mebibytes};
use crate::options::Alias;
use crate::plan::{CachedResults, Plan, PlannedPass, Refresh};
use afterimage_graph::node::Resource;

impl Plan {
    /// The plan as a table for people, with the memory that it needs and the nodes that it skips.
    pub fn to_text(&self) -> String {
        let (names, savings) = (Names::new(self), &self.savings);
        let outputs = self.outputs.iter().map(|output| vec![format!("  {}", output.name), described(output)]);
        let dynamic = self.dynamic.iter().map(|name| vec![format!("  {name}")]);
        let skipped = savings.skipped.iter().map(|skipped| vec![format!("  {}", skipped.node), skipped.why.clone()]);
        let fused = savings.fused.iter().map(|fused| (fused.image.as_str(), fused.bytes_saved));
        let shared = savings.shared_reads.iter().map(|read| (read.image.as_str(), read.bytes_saved));
        let baked = savings.baked.iter().map(|baked| {
            let when = if baked.in_every_frame { ", evaluated in every frame" } else { "" };
            let size = format!("size {}{when}", baked.size);
            vec![format!("  {}", baked.nodes.join(" + ")), size, mebibytes(baked.bytes)]
        });
        let cached = savings.cached.iter().map(|cached| {
            let CachedResults { node, refresh, results } = cached;
            let when = match refresh {
                Refresh::Every { every, phase } if !results.is_empty() => {
                    format!("runs in one of {every} frames: those with number % {every} == {phase}")
                }
                Refresh::Once if !results.is_empty() => {
                    "runs in the first frame of a sequence, because its state stays".to_owned()
                }
                _ => "runs in every frame, because it keeps a state".to_owned(),
            };
            vec![format!("  {node}"), when]
        });
        let state = self.state().into_iter().map(|item| {
            let reach = match item.reach {
                Some(1) => "made from 1 frame".to_owned(),
                Some(frames) => format!("made from {frames} frames"),
                None => "made from all frames before".to_owned(),
            };
            vec![format!("  {}", item.name), item.described(), reach]
        });
        let sections = [
            self.heading(),
            table(&self.pass_table(&names)),
            section("outputs", outputs.collect()),
            section("parameters that change without a new plan", dynamic.collect()),
            section("skipped", skipped.collect()),
            section("baked LUTs in place of nodes", baked.collect()),
            section("cached between the frames that compute them", cached.collect()),
            saved_bytes("never stored, because their passes are fused", fused.collect()),
            saved_bytes("read once by passes that are joined", shared.collect()),
            section("state that the next frame reads", state.collect()),
            self.memory_text(),
            format!("\nhash {}\n", self.hash()),
        ];
        sections.concat()
    }

    fn heading(&self) -> String {
        let passes = count(self.passes.len(), "pass");
        let batches = count(self.batches.len(), "batch");
        let transitions: usize = self.batches.iter().map(|batch| batch.transitions.len()).sum();
        let aliasing: usize = self.batches.iter().map(|batch| batch.aliasing.len()).sum();
        format!(
            "{passes} in {batches} at {}; {}, {}; {} moved a frame\n\n",
            self.size,
            count(transitions, "transition"),
            count(aliasing, "aliasing barrier"),
            mebibytes(self.bytes_moved())
        )
    }

    fn pass_table(&self, names: &Names) -> Vec<Vec<String>> {
        let heading = ["batch", "node", "does", "stage", "size", "format", "reads -> writes"];
        let mut rows = vec![heading.map(str::to_owned).to_vec()];
        for (number, batch) in self.batches.iter().enumerate() {
            for at in batch.passes.clone() {
                let number = if at == batch.passes.start { number.to_string() } else { String::new() };
                rows.extend(self.pass_rows(names, number, at));
            }
        }
        rows
    }

    /// One row for a pass, and one more for each further pass that fusion has put into it.
    fn pass_rows(&self, names: &Names, batch: String, at: usize) -> Vec<Vec<String>> {
        let PlannedPass { pass, stage, .. } = &self.passes[at];
        let list = |resources: Vec<Resource>| {
            let named: Vec<&str> = resources.into_iter().map(|resource| names.of(resource)).collect();
            named.join(", ")
        };
        let target = pass.written_image().map(|image| self.image(image).desc);
        let labels: Vec<&str> = pass.label.split(" + ").collect();
        let nodes: Vec<&str> = pass.nodes.iter().map(String::as_str).collect();
        let one_each = labels.len() == nodes.len();
        let (node, label) =
            if one_each { (nodes[0].to_owned(), labels[0]) } else { (nodes.join(" + "), pass.label.as_str()) };
        let mut rows = vec![vec![
            batch,
            node,
            label.to_owned(),
            format!("{stage:?}").to_lowercase(),
            target.map_or(String::new(), |desc| desc.size.to_string()),
            target.map_or(String::new(), |desc| desc.format.name().to_owned()),
            format!("{} -> {}", list(pass.reads()), list(pass.writes())).trim_start().to_owned(),
        ]];
        let further = nodes.iter().zip(&labels).skip(1).filter(|_| one_each);
        rows.extend(further.map(|(node, label)| vec![String::new(), format!("+ {node}"), (*label).to_owned()]));
        rows
    }

    fn memory_text(&self) -> String {
        let memory = &self.memory;
        let share = |bytes: u64| match memory.unaliased {
            0 => String::new(),
            all => format!("{:.1} %", 100.0 * bytes as f64 / all as f64),
        };
        let row = |name: &str, bytes: u64, alias: Option<Alias>| {
            let used = if alias == Some(self.options.alias) { "in use" } else { "" };
            vec![format!("  {name}"), mebibytes(bytes), share(bytes), used.to_owned()]
        };
        let rows = [
            row("all that nodes describe", memory.unaliased, None),
            row("stored, without sharing", memory.unshared, Some(Alias::None)),
            row("stored, pooled", memory.pooled, Some(Alias::Pool)),
            row("stored, placed", memory.placed, Some(Alias::Placed)),
            row("lower bound", memory.lower_bound, None),
        ];
        let mut text = format!("\nmemory of transient images\n{}", right(&rows, &[1, 2]));
        let _ = writeln!(text, "  {}", self.verdict());
        if memory.kept > 0 {
            let _ =
                writeln!(text, "  outputs, histories, baked LUTs and cached results keep {}", mebibytes(memory.kept));
        }
        text
    }

    fn verdict(&self) -> String {
        let (placed, bound) = (self.memory.placed, self.memory.lower_bound);
        match 100.0 * (placed - bound) as f64 / bound as f64 {
            _ if placed == bound => "the placement is the best there is for this order".to_owned(),
            gap => format!("the placement is within {gap:.2} % of the best that this order allows"),
        }
    }
}

/// Images and the bytes that each of them saves, under a heading with their sum; nothing if there are none.
fn saved_bytes(why: &str, saved: Vec<(&str, u64)>) -> String {
    let sum = saved.iter().map(|(_, bytes)| bytes).sum();
    let rows = saved.iter().map(|(image, bytes)| vec![format!("  {image}"), format!("{} less", mebibytes(*bytes))]);
    section(&format!("{why}: {} less moved a frame", mebibytes(sum)), rows.collect())
}

/// Rows under a heading; nothing if there are none.
fn section(heading: &str, rows: Vec<Vec<String>>) -> String {
    if rows.is_empty() { String::new() } else { format!("\n{heading}\n{}", table(&rows)) }
}

/// Columns two spaces apart, without spaces at the ends of lines.
fn table(rows: &[Vec<String>]) -> String {
    right(rows, &[])
}

/// The same with some columns aligned to the right.
fn right(rows: &[Vec<String>], right: &[usize]) -> String {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |column: usize| rows.iter().filter_map(|row| row.get(column)).map(|cell| cell.chars().count()).max();
    let widths: Vec<usize> = (0..columns).map(|column| width(column).unwrap_or(0)).collect();
    let mut text = String::new();
    for row in rows {
        let cells = row.iter().zip(&widths).enumerate().map(|(column, (cell, width))| {
            if right.contains(&column) { format!("{cell:>width$}") } else { format!("{cell:<width$}") }
        });
        let line = cells.collect::<Vec<String>>().join("  ");
        let _ = writeln!(text, "{}", line.trim_end());
    }
    text
}
