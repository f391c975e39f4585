//! Names of images and buffers for people: labels, made unique.

use std::collections::BTreeMap;

use crate::Plan;
use afterimage_graph::node::Resource;

impl Plan {
    /// The name of each image: its label, with `#2` and so on after it where several have the same.
    pub fn image_names(&self) -> Vec<String> {
        unique(self.recording.images.iter().map(|image| image.label.as_str()))
    }

    /// The name of each buffer, likewise.
    pub fn buffer_names(&self) -> Vec<String> {
        unique(self.recording.buffers.iter().map(|buffer| buffer.label.as_str()))
    }

    /// The name of each pass: its node and what it does, made unique likewise.
    pub fn pass_names(&self) -> Vec<String> {
        let names: Vec<String> =
            self.recording.passes.iter().map(|pass| format!("{}: {}", pass.nodes.join("+"), pass.label)).collect();
        unique(names.iter().map(String::as_str))
    }
}

/// The names of all images and buffers of a plan.
pub(crate) struct Names {
    pub(crate) images: Vec<String>,
    pub(crate) buffers: Vec<String>,
}

impl Names {
    pub(crate) fn new(plan: &Plan) -> Self {
        Self { images: plan.image_names(), buffers: plan.buffer_names() }
    }

    pub(crate) fn of(&self, resource: Resource) -> &str {
        match resource {
            Resource::Image(image) => &self.images[image.0 as usize],
            Resource::Buffer(buffer) => &self.buffers[buffer.0 as usize],
        }
    }
}

fn unique<'a>(labels: impl Iterator<Item = &'a str>) -> Vec<String> {
    let mut seen: BTreeMap<&str, usize> = BTreeMap::new();
    let mut name = |label: &'a str| {
        let count = seen.entry(label).or_default();
        *count += 1;
        if *count == 1 { label.to_owned() } else { format!("{label}#{count}") }
    };
    labels.map(&mut name).collect()
}
