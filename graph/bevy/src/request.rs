//! Request of the main world to the render world for a camera.

use std::sync::Arc;

use bevy::prelude::*;
use bevy::render::RenderApp;
use bevy::render::extract_component::ExtractComponent;

use crate::asset::Pipeline;
use crate::camera::Afterimage;
use crate::status::Report;

/// The request of a camera. A new `Arc` of settings means that something has changed.
#[derive(Component, Clone, Default, ExtractComponent)]
#[extract_app(RenderApp)]
pub(crate) struct CameraRequest {
    pub(crate) settings: Option<Arc<Settings>>,
    pub(crate) report: Report,
}

/// The pipeline of a camera and everything that is set for it. The tiers are those of the pipeline.
pub(crate) struct Settings {
    pub(crate) pipeline: Pipeline,
    pub(crate) look: Afterimage,
}
