//! The color nodes of a pipeline as a table for other programs, compared with the nodes.
//!
//! On the way from an output back to an input, nodes whose result is a function of one color are in the table. All
//! others are switched off: readers of their results get their source. The nodes color the entries of the table on the
//! device, in 32 bits; then the text of the file is read back, and its table is compared with the nodes on other
//! colors, and around those where they differ most.

use afterimage::offline::Session;
use afterimage_color::lut::{Interpolation, PngLayout, Table, WrittenFormat, WrittenLut};
use afterimage_color::lut_file::{LutFile, parse_lut_file};
use afterimage_color::process::{LutSpace, Process};
use afterimage_color::shaper::Shape;
use afterimage_gpu::{FrameStep, Gpu};
use afterimage_graph::check::{Facts, Graph, Source};
use afterimage_graph::color::{Colorimetry, GRAPHICS_WHITE};
use afterimage_graph::image::{ColorState, Format, ImageDesc, Size};
use afterimage_graph::node::{Fallback, ImageColor, PortType};
use afterimage_plan::{Options, Plan};

use crate::LabError;
use crate::measure::reference::output;
use crate::metrics::percentile;

/// Colors for which a table is compared with its nodes, which fill it evenly; as many again in each round of a search.
const COLORS: usize = 1 << 18;
/// Grays, likewise.
const GRAYS: usize = 1 << 12;
/// Colors with the largest errors, around which a round looks for larger ones.
const WORST: usize = 1 << 12;
/// Distance in cells of the table that each round looks.
const REACHES: [f64; 4] = [1.0, 0.3, 0.1, 0.03];
/// Pixels in a row of the images of colors.
const WIDTH: usize = 4096;

#[derive(Clone, Debug)]
pub struct LutOptions {
    /// The space of the colors that come to the table.
    pub from: LutSpace,
    /// Entries of each side.
    pub size: usize,
    /// The brightest light of a logarithm before the table, in stops from 1.
    pub shaper: Option<u32>,
    pub format: WrittenFormat,
    /// The title in the file.
    pub title: String,
    pub facts: Facts,
}

/// The nodes between an input and an output that a table can hold.
#[derive(Debug)]
pub struct ColorRun {
    /// The pipeline with these nodes alone.
    graph: Graph,
    /// The name of the input.
    pub input: String,
    /// The name of the output.
    pub output: String,
    /// Names of the nodes, in order.
    pub nodes: Vec<String>,
    /// The meaning of the images of both.
    colors: [ImageColor; 2],
}

/// A table, and its error.
pub struct LutExport {
    /// The content of the file.
    pub text: String,
    /// The space of its results, if a table for it can be named.
    pub to: Option<LutSpace>,
    /// The color state of its results.
    pub state: ColorState,
    pub errors: LutErrors,
}

/// Errors of a table next to its nodes.
#[derive(Clone, Copy, Debug)]
pub struct LutErrors {
    /// The largest of grays.
    pub grays: f64,
    /// The 99th percentile of colors that fill the table evenly.
    pub p99: f64,
    /// The 99.9th.
    pub p999: f64,
    /// The largest that a search from those colors finds.
    pub max: f64,
}

impl ColorRun {
    /// The nodes before an output: the named one, the first encoded one, or the first.
    ///
    /// # Errors
    /// There is no such output, or a node before it makes its colors from several images, or from none.
    pub fn before(graph: &Graph, name: Option<&str>) -> Result<Self, LabError> {
        let mut graph = graph.clone();
        let wanted = output(&graph, name)?.clone();
        let (mut source, mut nodes) = (wanted.source, Vec::new());
        let input = loop {
            source = match source {
                Source::Input(input) => break input,
                Source::Node { previous: 0, node, output } => match color_source(&graph, node) {
                    Some(before) => {
                        nodes.insert(0, node);
                        before
                    }
                    None => around(&graph, node, output)?,
                },
                Source::Node { node, .. } => return Err(no_source(&graph, node)),
            };
        };
        for (index, node) in graph.nodes.iter_mut().enumerate() {
            node.off |= !nodes.contains(&index);
            node.format = Some(Format::Rgba32Float);
        }
        for (index, other) in graph.inputs.iter_mut().enumerate() {
            other.optional = index != input;
        }
        let name = graph.inputs[input].name.clone();
        let state = graph.inputs[input].state;
        if !ImageColor::of(state).is_picture() {
            return Err(LabError::request(format!(
                "the output `{}` is made from `{name}`, which is data",
                wanted.name
            )));
        }
        let nodes: Vec<String> = nodes.iter().map(|node| graph.nodes[*node].name.clone()).collect();
        if nodes.is_empty() {
            let message = format!("no node between `{name}` and the output `{}` is a function of a color", wanted.name);
            return Err(LabError::request(message).hint("a table holds no others; `--output NAME` chooses an output"));
        }
        graph.outputs = vec![wanted.clone()];
        let at_output = graph.colors().at(wanted.source).unwrap_or(ImageColor::of(wanted.state));
        Ok(Self { graph, input: name, output: wanted.name, nodes, colors: [ImageColor::of(state), at_output] })
    }

    /// The color state of the input.
    pub fn state(&self) -> ColorState {
        self.colors[0].state
    }

    /// Names and kinds of the nodes that a plan of the whole pipeline runs and the table does not hold.
    pub fn left_out(&self, plan: &Plan) -> Vec<(&str, &str)> {
        let runs = |name: &str| plan.passes.iter().any(|planned| planned.pass.nodes.iter().any(|node| node == name));
        let others = self.graph.nodes.iter().filter(|node| !self.nodes.contains(&node.name) && runs(&node.name));
        others.map(|node| (node.name.as_str(), node.kind().name())).collect()
    }

    /// Makes the table.
    ///
    /// # Errors
    /// Results that are not finite, or errors of the device.
    pub fn export(&self, gpu: &Gpu, options: &LutOptions) -> Result<LutExport, LabError> {
        let planning = Options { exact: true, ..Options::default() };
        let mut session = Session::new(gpu, self.graph.clone(), options.facts.clone(), planning);
        let axes = Axes::new(options, self.colors[0].colorimetry);
        let size = options.size;
        let step = |index: usize| (index % size) as f64 / (size - 1) as f64;
        let lattice = (0..size.pow(3)).map(|index| [index, index / size, index / size / size].map(step));
        let entries = self.results(&mut session, &axes, lattice)?;
        let to = self.colors[1];
        let notes = vec![
            format!("from {} to {}", options.from.name(), described(to)),
            format!("the nodes {} of an Afterimage pipeline", self.nodes.join(", ")),
        ];
        let lut = WrittenLut {
            title: options.title.clone(),
            notes,
            shape: axes.shape,
            cube: Table { size, entries, low: [0.0; 3], high: [1.0; 3] },
        };
        let text = options.format.text(&lut);
        let errors = self.errors(&mut session, &axes, &text)?;
        Ok(LutExport { text, to: space_of(to), state: to.state, errors })
    }

    /// The table of a file, next to the nodes.
    fn errors(&self, session: &mut Session, axes: &Axes, text: &str) -> Result<LutErrors, LabError> {
        let read = parse_lut_file(text.as_bytes(), PngLayout::Tiles).expect("the file is as its reader wants it");
        let table = match read {
            LutFile::Table(lut) => Process::of_table(&lut, Interpolation::Tetrahedral),
            LutFile::Process(process) => process,
        };
        let mut compared = |places: &[[f64; 3]]| -> Result<Vec<f32>, LabError> {
            let exact = self.results(session, axes, places.iter().copied())?;
            let error = |(place, exact): (&[f64; 3], &[f32; 3])| {
                let shown = table.apply(axes.numbers(*place));
                (0..3).map(|channel| (shown[channel] - f64::from(exact[channel])).abs()).fold(0.0, f64::max) as f32
            };
            Ok(places.iter().zip(&exact).map(error).collect())
        };
        let mut places: Vec<[f64; 3]> = (0..GRAYS).map(|index| [index as f64 / (GRAYS - 1) as f64; 3]).collect();
        let grays = compared(&places)?;
        let even: Vec<[f64; 3]> = (0..COLORS).map(scattered).collect();
        let colors = compared(&even)?;
        let mut errors = [grays.as_slice(), &colors].concat();
        places.extend(even);
        for reach in REACHES {
            let mut order: Vec<usize> = (0..places.len()).collect();
            order.select_nth_unstable_by(WORST, |a, b| errors[*b].total_cmp(&errors[*a]));
            let around = |index: usize| {
                let (worst, offset) = (places[order[index % WORST]], scattered(index));
                let cell = 2.0 * reach / (axes.size - 1) as f64;
                [0, 1, 2].map(|channel| (worst[channel] + cell * (offset[channel] - 0.5)).clamp(0.0, 1.0))
            };
            let near: Vec<[f64; 3]> = (0..COLORS).map(around).collect();
            errors.extend(compared(&near)?);
            places.extend(near);
        }
        Ok(LutErrors {
            grays: percentile(&grays, 1.0),
            p99: percentile(&colors, 0.99),
            p999: percentile(&colors, 0.999),
            max: percentile(&errors, 1.0),
        })
    }

    /// The colors of the nodes at these places of a table.
    fn results(
        &self,
        session: &mut Session,
        axes: &Axes,
        places: impl Iterator<Item = [f64; 3]>,
    ) -> Result<Vec<[f32; 3]>, LabError> {
        let mut colors: Vec<[f32; 4]> = places
            .map(|place| {
                let [r, g, b] = axes.color(place).map(|x| x as f32);
                [r, g, b, 1.0]
            })
            .collect();
        let count = colors.len();
        let size = Size::new(WIDTH as u32, count.div_ceil(WIDTH) as u32);
        colors.resize(WIDTH * size.height as usize, [0.0, 0.0, 0.0, 1.0]);
        let desc = ImageDesc::new(size).format(Format::Rgba32Float);
        let image = session.feed(&self.input, desc, bytemuck::cast_slice(&colors))?;
        session.render(size, &[image], FrameStep::FIRST)?;
        let texels = session.output(&self.output)?.to_floats();
        let results: Vec<[f32; 3]> = texels.iter().take(count).map(|[r, g, b, _]| [*r, *g, *b]).collect();
        match results.iter().flatten().all(|x| x.is_finite()) && results.len() == count {
            true => Ok(results),
            false => Err(LabError::request(format!("the output `{}` has values that are not finite", self.output))
                .hint("`afterimage stress` finds the node that lets them through")),
        }
    }
}

/// From the places of a table, 0 to 1 in each channel, to colors.
struct Axes {
    /// Entries of each.
    size: usize,
    shape: Option<(Shape, f64)>,
    /// From the numbers that come to the file to those of the image.
    to_image: Process,
    colorimetry: Colorimetry,
}

impl Axes {
    fn new(options: &LutOptions, colorimetry: Colorimetry) -> Self {
        let shape = options.shaper.map(|stops| (Shape::log_c(f64::from(stops)), f64::from(stops).exp2()));
        let to_image = Process::new(options.from.to_light(colorimetry.primaries, GRAPHICS_WHITE.get()));
        Self { size: options.size, shape, to_image, colorimetry }
    }

    /// The numbers that come to the file.
    fn numbers(&self, place: [f64; 3]) -> [f64; 3] {
        place.map(|t| self.shape.map_or(t, |(shape, _)| shape.light(t)))
    }

    /// Those of the image.
    fn color(&self, place: [f64; 3]) -> [f64; 3] {
        self.to_image.apply(self.numbers(place)).map(|x| self.colorimetry.transfer.to_signal(x))
    }
}

/// The image whose color a node makes into another one, if it reads no other image.
fn color_source(graph: &Graph, node: usize) -> Option<Source> {
    let node = &graph.nodes[node];
    let is_color = !node.off && node.instance.invariants().of_color;
    let wired = node.kind().inputs().iter().zip(&node.wires);
    let mut images = wired.filter_map(|(port, wire)| wire.filter(|_| port.ty != PortType::Value));
    let source = images.next().filter(|_| is_color)?;
    images.next().is_none().then_some(source)
}

/// The value of an output when its node is off.
fn around(graph: &Graph, node: usize, output: usize) -> Result<Source, LabError> {
    let kind = graph.nodes[node].kind();
    let Fallback::Input(name) = &kind.outputs()[output].fallback else { return Err(no_source(graph, node)) };
    let port = kind.inputs().iter().position(|port| port.name == **name);
    port.and_then(|port| graph.nodes[node].wires[port]).ok_or_else(|| no_source(graph, node))
}

fn no_source(graph: &Graph, node: usize) -> LabError {
    let node = &graph.nodes[node];
    let message = format!("`{}` ({}) makes an image of its own, which no table holds", node.name, node.kind().name());
    LabError::request(message).hint("a table can hold what follows it: make a pipeline of that, with an input")
}

/// Places that fill the unit cube evenly (Roberts, "The Unreasonable Effectiveness of Quasirandom Sequences").
fn scattered(index: usize) -> [f64; 3] {
    const ROOT: f64 = 1.2207440846057596;
    [1, 2, 3].map(|power| (0.5 + (index + 1) as f64 / ROOT.powi(power)).fract())
}

/// The space of a table with such results.
fn space_of(color: ImageColor) -> Option<LutSpace> {
    let is_same = |space: &&LutSpace| {
        let white = color.colorimetry.white_nits.unwrap_or(GRAPHICS_WHITE).get();
        let own = space.colorimetry(white);
        own.is_some_and(|own| {
            own.primaries == color.colorimetry.primaries && own.transfer == color.colorimetry.transfer
        })
    };
    LutSpace::ALL.iter().filter(|space| **space != LutSpace::Same).find(is_same).copied()
}

fn described(color: ImageColor) -> String {
    space_of(color).map_or_else(|| color.state.name().to_owned(), |space| space.name().to_owned())
}
