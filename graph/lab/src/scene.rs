//! The built-in scene as images for the inputs of a pipeline.

use afterimage::offline::Session;
use afterimage_gpu::{FrameStep, Gpu, InputImage, input_image};
use afterimage_graph::check::{CheckOptions, Facts, Graph, GraphInput, check};
use afterimage_graph::document::parse;
use afterimage_graph::image::{ColorState, Size};
use afterimage_graph::node::Registry;
use afterimage_graph::value::Value;
use afterimage_plan::Options;

use crate::LabError;

const SCENE: &str = r#"Pipeline(
    inputs: {},
    nodes: { "scene": DemoScene() },
    outputs: { "result": "scene", "depth": "scene.depth", "normal": "scene.normal", "albedo": "scene.albedo" },
)"#;
/// The outputs of the scene that are data.
const DATA: [&str; 3] = ["depth", "normal", "albedo"];
/// The fraction of its path that the camera moves in a second.
const SPEED: f64 = 0.2;

/// A graph from the text of a pipeline that names no files.
///
/// # Errors
/// The text is not a valid pipeline.
pub fn graph(registry: &Registry, name: &str, text: &str) -> Result<Graph, LabError> {
    Ok(check(&parse(name, text)?, registry, &CheckOptions::default())?.0)
}

/// Images of the scene for all required inputs.
pub fn still(gpu: &Gpu, registry: &Registry, graph: &Graph, size: Size) -> Result<Vec<InputImage>, LabError> {
    let outputs = outputs(&graph.inputs)?;
    if outputs.is_empty() {
        return Ok(Vec::new());
    }
    let mut scene = session(gpu, registry)?;
    scene.render(size, &[], FrameStep::FIRST)?;
    outputs.iter().map(|(input, output)| copy(&mut scene, input, output)).collect()
}

/// Images of the scene for `frames` frames of a walk through it, at `fps` frames per second.
pub(crate) fn walk(
    gpu: &Gpu,
    registry: &Registry,
    inputs: &[GraphInput],
    size: Size,
    frames: u32,
    fps: f32,
) -> Result<Vec<Vec<InputImage>>, LabError> {
    let outputs = outputs(inputs)?;
    if outputs.is_empty() {
        return Ok(vec![Vec::new()]);
    }
    let mut scene = graph(registry, "scene.ron", SCENE)?;
    let mut session = session(gpu, registry)?;
    let mut images = Vec::new();
    for frame in 0..frames {
        let seconds = f64::from(frame) / f64::from(fps);
        set(&mut scene, "time", seconds);
        set(&mut scene, "walk", (seconds * SPEED).min(1.0));
        session.change(scene.clone(), Options::default());
        session.render(size, &[], FrameStep::FIRST)?;
        let copied: Result<_, LabError> =
            outputs.iter().map(|(input, output)| copy(&mut session, input, output)).collect();
        images.push(copied?);
    }
    Ok(images)
}

fn session(gpu: &Gpu, registry: &Registry) -> Result<Session, LabError> {
    let scene = graph(registry, "scene.ron", SCENE)?;
    Ok(Session::new(gpu, scene, Facts::default(), Options::default()))
}

/// A copy of an output that the next frame does not overwrite, in a texture as that of a file.
fn copy(session: &mut Session, input: &str, output: &str) -> Result<InputImage, LabError> {
    let texels = session.output(output)?;
    Ok(input_image(session.gpu(), input, texels.desc, &texels.bytes)?)
}

fn set(scene: &mut Graph, parameter: &str, value: f64) {
    let node = &mut scene.nodes[0];
    let (at, _) = node.kind().param(parameter).expect("the scene has a time and a walk");
    node.instance.set(at, Value::Float(value));
}

/// The output of the scene for each required input: data by name, color for color inputs. Optional inputs
/// get no image, so that `bench` and `measure` measure the same frame.
fn outputs(inputs: &[GraphInput]) -> Result<Vec<(String, &'static str)>, LabError> {
    let mut outputs = Vec::new();
    for input in inputs.iter().filter(|input| !input.optional) {
        let data = DATA.into_iter().find(|output| input.name.contains(output));
        let is_color = matches!(input.state, ColorState::Scene | ColorState::Exposed | ColorState::DisplayLinear);
        match data.or(is_color.then_some("result")) {
            Some(output) => outputs.push((input.name.clone(), output)),
            None => {
                let message = format!("the built-in scene has no output for the input `{}`", input.name);
                return Err(LabError::request(message).hint("give images, and this one by `--input`"));
            }
        }
    }
    Ok(outputs)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn optional_inputs_get_no_image_and_required_ones_the_output_of_their_name() {
        let registry = Registry::new(&[afterimage_nodes::ALL]).expect("the built-in kinds are valid");
        let text = r#"Pipeline(
            inputs: { "scene": Color, "albedo": Data(optional: true), "depth": Data },
            nodes: { "lit": Exposure(source: "scene", stops: 1.0) },
            outputs: { "result": "lit", "depth": "depth" },
        )"#;
        let graph = graph(&registry, "test.ron", text).expect("the pipeline is valid");
        let expected = [("scene", "result"), ("depth", "depth")].map(|(input, output)| (input.to_owned(), output));
        assert_eq!(outputs(&graph.inputs).expect("the scene has both outputs"), expected);
    }
}
