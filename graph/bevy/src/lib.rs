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
//!     let look = assets.load("embedded://afterimage/tsushima.ron");
//!     commands.spawn((Camera3d::default(), Afterimage::new(look).tier("low").fact("emissive", true)));
//! }
//! ```
//!
//! # Files
//!
//! Pipelines are assets: the built-in ones below `embedded://afterimage`, and files of the game. Files that a pipeline
//! names (`extends`, nested pipelines, `.cube`) are of the same source of assets; node folders are those of
//! [`AfterimagePlugin::node_folders`]. With Bevy's feature `file_watcher` all of them are read again when they change.
//! A file that is wrong is a `LoadState::Failed` with an [`afterimage::Error`] and is logged with an excerpt, and the
//! pipeline before renders on.
//!
//! # Changes
//!
//! All fields of [`Afterimage`] may change at any time. Tiers, facts and a few parameters (`afterimage nodes KIND` names
//! them) are planned in the background, and come in with a cross-fade of [`Afterimage::fade`] frames. A change that
//! cannot fade comes at once: the log says it once, and [`AfterimageStatus::fade_skip_reason`] has the reason until the
//! next change. With a [`Budget`] the tier follows the time of the pipeline's passes on the device, if that has
//! timestamps inside passes.
//!
//! # Cameras
//!
//! * 3-D and 2-D cameras work. The component adds `Hdr`; a `CompositingSpace` other than linear, which 2-D cameras can
//!   have, is an error.
//! * The pipeline replaces the camera's `Tonemapping` and `DebandDither`, and restores them when it is removed. It runs
//!   after Bevy's bloom and before its tone mapping, so Bevy's other effects on light come first. `Bloom`,
//!   `AutoExposure`, and a tone curve or dither that is set later, are warned about.
//! * [`Target::MainTexture`] leaves linear light for what Bevy draws later, such as UI: the last pass decodes what the
//!   pipeline has encoded. [`Target::Output`] writes the window or image without Bevy's copy, and nothing comes on top.
//! * A camera with a `viewport` writes nothing around it. A viewport may move without a plan; another size needs one.
//!   With `Target::MainTexture` the result is copied back.
//! * Each camera has its own histories and adaptation. Cameras with one pipeline share plans and compiled passes.
//!   Cameras that draw on one another (`ClearColorConfig::None`) share a main texture only with equal
//!   `CameraMainTextureUsages`: the component adds `STORAGE_BINDING`, `COPY_SRC` and `COPY_DST`.
//! * After Bevy recovers from a lost device, pipelines are made again, with new histories.
//!
//! # Inputs
//!
//! | input of the pipeline | content |
//! |---|---|
//! | the first image | the camera's image, resolved if it is multisampled, multiplied by Bevy's `Exposure` |
//! | `"depth": Depth(optional: true)`, `"motion": Motion(optional: true)` | Bevy's prepasses, if the camera has them. With MSAA they are multisampled: declare them so, with a `Resolve` |
//! | `"camera": Camera` | the camera, with its previous frame and jitter |
//! | `"normals": Normals(optional: true)` | Bevy's normals, in the world's space from 0 to 1; `PrepassNormals(normals: "normals", camera: "camera")` converts them for other kinds |

/// The README's program compiles.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

mod asset;
mod camera;
mod folder;
mod follow;
mod images;
mod render;
mod request;
mod running;
mod setting;
mod status;
mod systems;

pub use afterimage;
use afterimage::host::NodeKind;
use bevy::asset::io::embedded::EmbeddedAssetRegistry;
use bevy::prelude::*;
use bevy::render::RenderApp;
use bevy::render::extract_component::ExtractComponentPlugin;

pub use asset::{Pipeline, PipelineLoader};
pub use camera::Afterimage;
use follow::{follow_assets, replace_others, request, restore_others, take_reports, warn_of_others};
pub use setting::{Budget, Setting, Target};
pub use status::{AfterimageReadings, AfterimageStatus};
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
            .register_type::<AfterimageReadings>()
            .add_plugins(ExtractComponentPlugin::<request::CameraRequest>::default())
            .add_systems(PreUpdate, take_reports)
            .add_systems(
                PostUpdate,
                (restore_others, replace_others, warn_of_others, follow_assets, request)
                    .chain()
                    .in_set(AfterimageSystems::Follow),
            );
        if let Some(registry) = app.world().get_resource::<EmbeddedAssetRegistry>() {
            asset::embed(registry);
        }
        if let Some(render) = app.get_sub_app_mut(RenderApp) {
            render::build(render);
        }
    }
}
