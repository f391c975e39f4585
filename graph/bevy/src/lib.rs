//! Afterimage post-processing for Bevy: a pipeline from a RON file on a camera.
//!
//! ```no_run
//! use bevy::prelude::*;
//! use bevy_afterimage::{Afterimage, AfterimagePlugin};
//!
//! fn main() {
//!     App::new().add_plugins((DefaultPlugins, AfterimagePlugin::default())).add_systems(Startup, camera).run();
//! }
//!
//! fn camera(mut commands: Commands, assets: Res<AssetServer>) {
//!     commands.spawn((Camera3d::default(), Afterimage::new(assets.load("tsushima.ron"))));
//! }
//! ```
//!
//! The component adds `Hdr` to its camera, and replaces Bevy's tone mapping and dither there. The first image of the
//! pipeline is the camera's; images called `depth`, `normals` and `motion` are those of the prepasses that the camera
//! has, and a `Camera` called `camera` is the camera. Optional ones that are not there are left out.
//!
//! Files are assets: a change of the pipeline, of a file that it names or of a node folder comes in while the program
//! runs, if Bevy's `file_watcher` is on. What is wrong with them is logged with an excerpt, and the pipeline before
//! renders on.

/// The README's program compiles.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

mod asset;
mod camera;
mod files;
mod folder;
mod follow;
mod images;
mod render;
mod request;
mod running;
mod setting;
mod status;
mod systems;

use afterimage_graph::node::NodeKind;
use bevy::prelude::*;
use bevy::render::RenderApp;
use bevy::render::extract_component::ExtractComponentPlugin;

pub use asset::{Pipeline, PipelineLoader};
pub use camera::Afterimage;
pub use files::PipelineError;
use follow::{check_graphs, follow_assets, replace_others, restore_others, take_reports, warn_of_others};
pub use setting::{Setting, Target};
pub use status::AfterimageStatus;
pub use systems::AfterimageSystems;

/// Loads pipelines and runs them on cameras with [`Afterimage`]. Add it after Bevy's own plugins.
#[derive(Default)]
pub struct AfterimagePlugin {
    /// Tables of kinds beside the built-in ones.
    pub kinds: Vec<&'static [NodeKind]>,
    /// Folders of assets with a `node.ron` and shaders: kinds without Rust.
    pub node_folders: Vec<String>,
}

impl Plugin for AfterimagePlugin {
    fn build(&self, app: &mut App) {
        let loader = PipelineLoader { kinds: self.kinds.clone(), node_folders: self.node_folders.clone() };
        app.init_asset::<Pipeline>()
            .register_asset_loader(loader)
            .register_type::<Afterimage>()
            .register_type::<AfterimageStatus>()
            .add_plugins(ExtractComponentPlugin::<request::CameraRequest>::default())
            .add_systems(PreUpdate, take_reports)
            .add_systems(
                PostUpdate,
                (restore_others, replace_others, warn_of_others, follow_assets, check_graphs)
                    .chain()
                    .in_set(AfterimageSystems::Follow),
            );
        if let Some(render) = app.get_sub_app_mut(RenderApp) {
            render::build(render);
        }
    }
}
