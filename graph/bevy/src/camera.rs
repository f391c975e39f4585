//! The component of cameras.

use std::collections::BTreeMap;

use bevy::camera::Hdr;
use bevy::prelude::*;

use crate::asset::Pipeline;
use crate::request::CameraRequest;
use crate::setting::{Budget, Setting, Target};
use crate::status::{AfterimageReadings, AfterimageStatus};

/// Runs a pipeline on the camera's image.
///
/// While it is there, it replaces the camera's tone mapping and dither, which come back when it is removed.
#[derive(Component, Clone, Debug, Default, Reflect)]
#[reflect(Component, Clone, Debug, Default)]
#[type_path = "bevy_afterimage"]
#[require(Hdr, CameraRequest, AfterimageStatus, AfterimageReadings)]
pub struct Afterimage {
    /// The pipeline.
    pub pipeline: Handle<Pipeline>,
    /// The tier; the file as it is written if there is none.
    pub tier: Option<String>,
    /// A time to hold: the tier is then chosen by what the pipeline takes, and `tier` does not count.
    pub budget: Option<Budget>,
    /// Facts of the scene, for the conditions of the pipeline.
    pub facts: BTreeMap<String, Setting>,
    /// Values of parameters, `node.parameter`, in place of those of the file.
    pub parameters: BTreeMap<String, Setting>,
    /// The target of the result.
    pub target: Target,
    /// Cuts so far. Another number than in the frame before says that the view has changed at once, as after a cut or a
    /// teleport: histories and adaptation begin anew.
    pub cuts: u32,
    /// Frames over which changes of facts, tiers and pipelines fade in, with both pictures mixed; 0 changes at once.
    /// See [`Post::set_fade`](afterimage::Post::set_fade).
    pub fade: u16,
    /// Values of nodes, `node.port`, that [`AfterimageReadings`] has in each frame, such as the exposure of a meter:
    /// `meter.result`. One that is no longer named is still copied on the device.
    pub watched: Vec<String>,
}

impl Afterimage {
    /// The pipeline as it is written.
    pub fn new(pipeline: Handle<Pipeline>) -> Self {
        Self { pipeline, ..Self::default() }
    }

    /// The same at a tier.
    pub fn tier(mut self, tier: impl Into<String>) -> Self {
        self.tier = Some(tier.into());
        self
    }

    /// The same with a budget in milliseconds for the pipeline's passes, and the tiers that hold it, from the worst
    /// picture to the best.
    pub fn budget<T: Into<String>>(mut self, ms: f64, tiers: impl IntoIterator<Item = T>) -> Self {
        self.budget = Some(Budget { ms, tiers: tiers.into_iter().map(Into::into).collect(), min_jod: None });
        self
    }

    /// The same with a value, `node.port`, that is read back.
    pub fn watch(mut self, label: impl Into<String>) -> Self {
        self.watched.push(label.into());
        self
    }

    /// The same with a fact.
    pub fn fact(mut self, name: impl Into<String>, fact: impl Into<Setting>) -> Self {
        self.facts.insert(name.into(), fact.into());
        self
    }

    /// The same with the value of a parameter, `node.parameter`.
    pub fn set(mut self, name: impl Into<String>, value: impl Into<Setting>) -> Self {
        self.parameters.insert(name.into(), value.into());
        self
    }

    /// The same with changes that fade in over this many frames.
    pub fn fade(mut self, frames: u16) -> Self {
        self.fade = frames;
        self
    }

    /// The same with another target.
    pub fn target(mut self, target: Target) -> Self {
        self.target = target;
        self
    }
}
