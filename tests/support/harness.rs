//! The harness of node tests: nodes and images in, images out on the GPU, and one comparison with the image of a CPU
//! reference.

use afterimage_graph::check::{CheckOptions, Graph, Loader, NoFiles, check};
use afterimage_graph::document::parse;
use afterimage_graph::node::{Camera, Registry};

use super::gpu::{Picture, Run};
use super::probes;
use crate::reference::image::Image;

/// Nodes of a pipeline, as a file has them.
#[derive(Clone, Copy)]
pub struct Nodes<'a> {
    text: &'a str,
    inputs: &'a [(&'a str, &'a str)],
    files: &'a dyn Loader,
    camera: Option<&'a Camera>,
}

impl<'a> Nodes<'a> {
    /// The text of the nodes, and the names and color states of the inputs. The node `result` is the output; an
    /// arrow at the end of the text names another, as in `"mips": ... -> mips.coarsest`.
    pub fn new(text: &'a str, inputs: &'a [(&'a str, &'a str)]) -> Self {
        Self { text, inputs, files: &NoFiles, camera: None }
    }

    /// With a camera for an input `camera`.
    pub fn camera(self, camera: Option<&'a Camera>) -> Self {
        Self { camera, ..self }
    }

    /// With the files that parameters name.
    pub fn files(self, files: &'a dyn Loader) -> Self {
        Self { files, ..self }
    }

    /// The graph of the built-in kinds and the probes.
    pub fn graph(&self) -> Graph {
        let (nodes, output) = self.text.split_once(" -> ").unwrap_or((self.text, "result"));
        let camera = self.camera.map(|_| ("camera", "Camera"));
        let inputs = self.inputs.iter().copied().chain(camera);
        let inputs: String = inputs.map(|(name, state)| format!("\"{name}\": {state}, ")).collect();
        checked(
            &format!("Pipeline(inputs: {{ {inputs} }}, nodes: {{ {nodes} }}, outputs: {{ \"out\": \"{output}\" }})"),
            self.files,
        )
    }

    /// The output in the first frame, with 32 bits between all passes. Pictures are in the order of the inputs.
    pub fn exact(&self, pictures: &[&Picture]) -> Picture {
        Run::new(&self.graph()).camera(self.camera).exact().frame(&self.named(pictures)).remove(0)
    }

    /// The output in the first frame, with half floats between the passes.
    pub fn half(&self, pictures: &[&Picture]) -> Picture {
        Run::new(&self.graph()).camera(self.camera).frame(&self.named(pictures)).remove(0)
    }

    /// The pictures with the names of the inputs.
    pub fn named<'p>(&self, pictures: &[&'p Picture]) -> Vec<(&'a str, &'p Picture)> {
        assert_eq!(self.inputs.len(), pictures.len(), "each input has a picture");
        self.inputs.iter().map(|(name, _)| *name).zip(pictures.iter().copied()).collect()
    }
}

/// The graph of a text of built-in kinds and probes.
pub fn checked(text: &str, files: &dyn Loader) -> Graph {
    let document = parse("test.ron", text).unwrap_or_else(|errors| panic!("{errors}"));
    let registry = Registry::new(&[afterimage_nodes::ALL, probes::ALL]).expect("no two kinds share a name");
    let options = CheckOptions { loader: files, ..CheckOptions::default() };
    check(&document, &registry, &options).unwrap_or_else(|errors| panic!("{errors}")).0
}

/// The quantity that a relative tolerance refers to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Scale {
    Channel,
    /// The largest expected color channel of the pixel. Alpha is equal.
    Pixel,
    /// The largest expected number of the channel within four pixels, and at least 0.001. The larger of both
    /// tolerances counts.
    Neighborhood,
}

/// The greatest error of a result.
#[derive(Clone, Copy, Debug)]
pub struct Tolerance {
    pub absolute: f64,
    pub relative: f64,
    pub of: Scale,
    /// The source of the error.
    pub reason: &'static str,
}

impl Tolerance {
    fn allowed(&self, expected: &Image, x: i64, y: i64, channel: usize) -> f64 {
        let at = |x, y| expected.texel(x, y)[channel].abs();
        match self.of {
            Scale::Channel => self.absolute + self.relative * at(x, y),
            Scale::Pixel if channel == 3 => 0.0,
            Scale::Pixel => {
                let [r, g, b, _] = expected.texel(x, y).map(f64::abs);
                self.absolute + self.relative * r.max(g).max(b)
            }
            Scale::Neighborhood => {
                let around = (-4..=4).flat_map(|j| (-4..=4).map(move |i| (x + i, y + j)));
                let near = around.map(|(x, y)| at(x, y)).fold(1e-3, f64::max);
                self.absolute.max(self.relative * near)
            }
        }
    }
}

/// The pixels whose error is above the tolerance, one line each.
pub fn differences(found: &Picture, expected: &Image, tolerance: &Tolerance) -> Vec<String> {
    assert_eq!([found.width as usize, found.height as usize], [expected.width, expected.height]);
    let differs = |(index, (found, expected_pixel)): (usize, (&[f32; 4], &[f64; 4]))| {
        let (x, y) = ((index % expected.width) as i64, (index / expected.width) as i64);
        let is_close = |channel: usize| {
            let error = (f64::from(found[channel]) - expected_pixel[channel]).abs();
            // The neighborhood includes the pixel. It is slow to search, and the pixel alone is mostly enough.
            let own = tolerance.relative * expected_pixel[channel].abs();
            let is_enough = tolerance.of == Scale::Neighborhood && error <= own;
            error == 0.0 || is_enough || error <= tolerance.allowed(expected, x, y, channel)
        };
        (!(0..4).all(is_close)).then(|| format!("({x}, {y}): {found:?} instead of {expected_pixel:?}"))
    };
    found.pixels.iter().zip(&expected.pixels).enumerate().filter_map(differs).collect()
}

/// Fails with the first pixels whose error is above the tolerance.
#[track_caller]
pub fn assert_close(what: &str, found: &Picture, expected: &Image, tolerance: &Tolerance) {
    let all = differences(found, expected, tolerance);
    let first = all.iter().take(8).map(String::as_str).collect::<Vec<_>>().join("\n");
    let Tolerance { absolute, relative, of, reason } = tolerance;
    let allowed = format!("{absolute:e}, {relative:e} of the {of:?} ({reason})");
    assert!(all.is_empty(), "{what}: {} pixels differ by more than {allowed}\n{first}", all.len());
}

/// A picture in f64.
pub fn image(picture: &Picture) -> Image {
    let pixel = |x: usize, y: usize| picture.at(x as u32, y as u32).map(f64::from);
    Image::new(picture.width as usize, picture.height as usize, pixel)
}
