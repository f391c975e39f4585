//! Plans for Graphviz: passes as boxes, batch by batch, and the images between them as edges.

use std::collections::BTreeMap;
use std::fmt::Write;

use super::names::Names;
use crate::plan::{Plan, PlannedPass, Stage};
use afterimage_graph::node::{BufferId, ImageId, Resource};

impl Plan {
    /// The plan in Graphviz's language: `dot -Tsvg` draws it.
    pub fn to_dot(&self) -> String {
        let names = Names::new(self);
        let mut dot =
            String::from("digraph plan {\n  rankdir=LR;\n  node [shape=box, fontname=\"sans-serif\", fontsize=10];\n");
        dot += "  edge [fontname=\"sans-serif\", fontsize=8];\n";
        for (number, batch) in self.batches.iter().enumerate() {
            let _ = writeln!(dot, "  subgraph cluster_batch_{number} {{\n    label=\"batch {number}\"; color=gray80;");
            batch.passes.clone().for_each(|pass| dot += &self.dot_pass(pass));
            dot += "  }\n";
        }
        dot += &self.dot_edges(&names);
        dot + "}\n"
    }

    fn dot_pass(&self, at: usize) -> String {
        let PlannedPass { pass, stage, .. } = &self.passes[at];
        let style = if *stage != Stage::Compute { ", style=rounded" } else { "" };
        format!("    pass{at} [label=\"{}\\n{}\"{style}];\n", escaped(&pass.nodes.join(" + ")), escaped(&pass.label))
    }

    fn dot_edges(&self, names: &Names) -> String {
        let mut dot = String::new();
        let mut made_by: BTreeMap<Resource, String> = BTreeMap::new();
        for (at, pass) in self.work().enumerate() {
            for resource in pass.reads() {
                let maker = made_by.entry(resource).or_insert_with(|| {
                    let (node, declaration) = given(resource, names);
                    dot += &declaration;
                    node
                });
                let _ = writeln!(dot, "  {maker} -> pass{at} [label=\"{}\"];", self.dot_label(resource, names));
            }
            made_by.extend(pass.writes().into_iter().map(|resource| (resource, format!("pass{at}"))));
        }
        for (index, output) in self.outputs.iter().enumerate() {
            let _ = writeln!(dot, "  output{index} [label=\"{}\", shape=ellipse];", escaped(&output.name));
            if let Some(maker) = made_by.get(&Resource::Image(output.image)) {
                let _ = writeln!(dot, "  {maker} -> output{index};");
            }
        }
        dot
    }

    fn dot_label(&self, resource: Resource, names: &Names) -> String {
        let name = escaped(names.of(resource));
        let Some(image) = resource.image() else { return name };
        let desc = self.image(image).desc;
        format!("{name}\\n{} {}", desc.size, desc.format.name())
    }
}

/// Something that no pass before has written: given by the host, constant, or from an earlier frame.
fn given(resource: Resource, names: &Names) -> (String, String) {
    let node = match resource {
        Resource::Image(ImageId(image)) => format!("image{image}"),
        Resource::Buffer(BufferId(buffer)) => format!("buffer{buffer}"),
    };
    let declaration = format!("  {node} [label=\"{}\", shape=ellipse];\n", escaped(names.of(resource)));
    (node, declaration)
}

fn escaped(text: &str) -> String {
    text.replace('\\', "\\\\").replace('"', "\\\"")
}
