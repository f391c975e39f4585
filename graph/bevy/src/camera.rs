//! The component of cameras, and what the main world makes of it for the render world.

use std::collections::BTreeMap;
use std::sync::Arc;

use afterimage_graph::check::{Fact, Facts, Graph};
use afterimage_graph::value::{Type, Value};
use bevy::camera::CameraMainTextureUsages;
use bevy::camera::Hdr;
use bevy::core_pipeline::tonemapping::{DebandDither, Tonemapping};
use bevy::post_process::bloom::Bloom;
use bevy::prelude::*;
use bevy::render::RenderApp;
use bevy::render::extract_component::ExtractComponent;
use bevy::render::render_resource::TextureUsages;

use crate::asset::Pipeline;

/// Runs a pipeline on the camera's image.
#[derive(Component, Clone, Debug, Reflect)]
#[reflect(Component)]
#[require(Hdr, Wanted)]
pub struct Afterimage {
    /// The pipeline.
    pub pipeline: Handle<Pipeline>,
    /// The tier; the file as it is written if there is none.
    pub tier: Option<String>,
    /// What is known of the scene, for the conditions of the pipeline.
    pub facts: BTreeMap<String, Setting>,
    /// Values of parameters, `node.parameter`, in place of those of the file.
    pub parameters: BTreeMap<String, Setting>,
    /// Where the result goes.
    pub target: Target,
}

/// A value of a fact or of a parameter.
#[derive(Clone, Debug, PartialEq, Reflect)]
pub enum Setting {
    /// On or off.
    Flag(bool),
    /// A number.
    Number(f64),
    /// A colour or another vector.
    Vector(Vec<f32>),
    /// One of the names that the parameter declares.
    Choice(String),
}

/// Where the result goes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
pub enum Target {
    /// The camera's main texture, in linear light: what Bevy draws after it, such as its UI, comes on top.
    #[default]
    MainTexture,
    /// The window or image that the camera renders to, without a copy. Nothing is drawn on top.
    Output,
}

impl Afterimage {
    /// The pipeline as it is written.
    pub fn new(pipeline: Handle<Pipeline>) -> Self {
        let (facts, parameters) = (BTreeMap::new(), BTreeMap::new());
        Self { pipeline, tier: None, facts, parameters, target: Target::default() }
    }

    /// The same at a tier.
    pub fn tier(mut self, tier: impl Into<String>) -> Self {
        self.tier = Some(tier.into());
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
}

impl From<bool> for Setting {
    fn from(flag: bool) -> Self {
        Self::Flag(flag)
    }
}

impl From<f32> for Setting {
    fn from(number: f32) -> Self {
        Self::Number(number.into())
    }
}

impl From<f64> for Setting {
    fn from(number: f64) -> Self {
        Self::Number(number)
    }
}

impl From<&str> for Setting {
    fn from(name: &str) -> Self {
        Self::Choice(name.to_owned())
    }
}

impl<const N: usize> From<[f32; N]> for Setting {
    fn from(vector: [f32; N]) -> Self {
        Self::Vector(vector.to_vec())
    }
}

impl Setting {
    fn fact(&self) -> Option<Fact> {
        match self {
            Self::Flag(flag) => Some(Fact::Flag(*flag)),
            Self::Number(number) => Some(Fact::Number(*number)),
            Self::Vector(_) | Self::Choice(_) => None,
        }
    }

    /// The value for a parameter of that type, which the parameter itself checks.
    pub(crate) fn value(&self, ty: Type) -> Option<Value> {
        Some(match (self, ty) {
            (Self::Flag(flag), _) => Value::Bool(*flag),
            (Self::Number(number), Type::Int) => Value::Int(number.round() as i64),
            (Self::Number(number), _) => Value::Float(*number),
            (Self::Vector(numbers), _) => {
                let mut vector = [0.0; 4];
                vector.iter_mut().zip(numbers).for_each(|(to, number)| *to = f64::from(*number));
                Value::Vector(vector, numbers.len().min(4))
            }
            (Self::Choice(name), Type::Choice(choices)) => {
                Value::Choice(choices.iter().find(|choice| choice.name == name)?.name)
            }
            (Self::Choice(name), _) => Value::Text(name.as_str().into()),
        })
    }
}

/// What the render world does for a camera. A new one only where something has changed.
#[derive(Component, Clone, Default, ExtractComponent)]
#[extract_app(RenderApp)]
pub(crate) struct Wanted(pub(crate) Option<Arc<Settings>>);

/// What is wanted of the pipeline on a camera.
#[derive(Clone)]
pub(crate) struct Settings {
    pub(crate) graph: Arc<Graph>,
    pub(crate) facts: Facts,
    pub(crate) parameters: BTreeMap<String, Setting>,
    pub(crate) target: Target,
}

/// What a camera has of Bevy's that the pipeline replaces or changes.
type Others = (Entity, Option<&'static Bloom>, Option<&'static CameraMainTextureUsages>);

/// The graphs that have been made, by pipeline and tier.
type Graphs = BTreeMap<(AssetId<Pipeline>, Option<String>), Arc<Graph>>;

/// Bevy's own effects that the pipeline replaces are switched off, or named.
pub(crate) fn replace_others(mut commands: Commands, cameras: Query<Others, Added<Afterimage>>) {
    for (camera, bloom, usages) in &cameras {
        // With this usage the last pass can be a dispatch, which is faster than a draw on most devices.
        let usages = usages.copied().unwrap_or_default().with(TextureUsages::STORAGE_BINDING);
        commands.entity(camera).insert((Tonemapping::None, DebandDither::Disabled, usages));
        if bloom.is_some() {
            warn!("camera {camera} has Bevy's `Bloom` and an `Afterimage` pipeline: its light is spread by both");
        }
    }
}

/// A pipeline that has been loaded again is checked again.
pub(crate) fn follow_assets(mut events: MessageReader<AssetEvent<Pipeline>>, mut cameras: Query<&mut Afterimage>) {
    for event in events.read() {
        let (AssetEvent::Added { id } | AssetEvent::Modified { id }) = event else { continue };
        cameras.iter_mut().filter(|camera| camera.pipeline.id() == *id).for_each(|mut camera| camera.set_changed());
    }
}

/// Makes the graphs of changed cameras. The graph before stays in use where the new one has errors.
pub(crate) fn check_graphs(
    pipelines: Res<Assets<Pipeline>>,
    mut cameras: Query<(Entity, &Afterimage, &mut Wanted), Changed<Afterimage>>,
    mut known: Local<Graphs>,
    mut reloaded: MessageReader<AssetEvent<Pipeline>>,
) {
    for event in reloaded.read() {
        if let AssetEvent::Modified { id } | AssetEvent::Removed { id } = event {
            known.retain(|(pipeline, _), _| pipeline != id);
        }
    }
    for (camera, wish, mut wanted) in &mut cameras {
        let Some(pipeline) = pipelines.get(&wish.pipeline) else { continue };
        let key = (wish.pipeline.id(), wish.tier.clone());
        let graph = match known.get(&key) {
            Some(graph) => graph.clone(),
            None => match pipeline.graph(wish.tier.as_deref()) {
                Ok(graph) => known.entry(key).or_insert(Arc::new(graph)).clone(),
                Err(errors) => {
                    error!("camera {camera}:\n{errors}");
                    continue;
                }
            },
        };
        let facts = wish.facts.iter().filter_map(|(name, fact)| Some((name.clone(), fact.fact()?))).collect();
        let (parameters, target) = (wish.parameters.clone(), wish.target);
        wanted.0 = Some(Arc::new(Settings { graph, facts, parameters, target }));
    }
}
