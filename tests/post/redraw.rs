//! A redraw with other values of parameters has the bits of a frame that had them from the start, whichever passes run.

use afterimage::Post;
use afterimage::offline::Session;
use afterimage_generators::Recipe;
use afterimage_gpu::{FrameKind, FrameStep, InputImage, LoadedPlan, upload};
use afterimage_graph::check::{Facts, Graph};
use afterimage_graph::image::Size;
use afterimage_graph::value::Value;
use afterimage_plan::{Alias, Options};

use super::scene_texels;
use crate::support::gpu::{Shared, built_in, gpu};
use crate::support::sweep;

const SIZE: Size = Size { width: 96, height: 54, depth: 1 };
/// A first frame, and two that follow it.
const STEPS: [FrameStep; 3] = [
    FrameStep { time: 0.0, dt: 0.0, kind: FrameKind::Cut },
    FrameStep { time: 0.1, dt: 0.1, kind: FrameKind::Next },
    FrameStep { time: 0.3, dt: 0.2, kind: FrameKind::Next },
];

fn redraw(step: FrameStep) -> FrameStep {
    FrameStep { kind: FrameKind::Redraw, ..step }
}

fn options(repeatable: bool) -> Options {
    Options { repeatable, ..Options::default() }
}

/// A pipeline whose frames can be redrawn in part, or not.
struct Film {
    session: Session,
    images: Vec<InputImage>,
    _gpu: Shared,
}

impl Film {
    fn new<'p>(graph: &Graph, parameters: impl IntoIterator<Item = &'p str>, options: Options) -> Self {
        let gpu = gpu();
        let mut session = Session::new(&gpu, graph.clone(), Facts::default(), options);
        for parameter in parameters {
            session.post().control(parameter).expect("the graph has it");
        }
        let texels = scene_texels(SIZE);
        let needed = graph.inputs.iter().filter(|input| !input.optional);
        let images = needed.map(|input| session.feed(&input.name, texels.desc, &texels.bytes).expect("it is fed"));
        let images = images.collect();
        Self { session, images, _gpu: gpu }
    }

    fn set(&mut self, parameter: &str, value: &Value) {
        let control = self.session.post().control(parameter).expect("the graph has it");
        self.session.post().set_value(control, value.clone()).expect("the node accepts it");
    }

    fn frame(&mut self, step: FrameStep) {
        self.session.render(SIZE, &self.images, step).unwrap_or_else(|error| panic!("{error}"));
    }

    fn shown(&mut self) -> Vec<Vec<u8>> {
        let names: Vec<String> = self.session.plan().outputs.iter().map(|output| output.name.clone()).collect();
        names.iter().map(|name| self.session.output(name).expect("the device works").bytes).collect()
    }
}

/// The numbers of a graph that nodes accept at another value, with both values.
fn changeable(graph: &Graph) -> Vec<(String, [Value; 2])> {
    let mut post = Post::with_executor(gpu().executor(), graph.clone());
    let mut found = Vec::new();
    for id in graph.parameters() {
        let (name, Value::Float(value)) = (graph.parameter_name(id), graph.value(id)) else { continue };
        let control = post.control(&name).expect("the graph has it");
        let others = [0.75 * value + 0.05, 0.5 * value + 0.01].map(Value::Float);
        let accepted = others.into_iter().find(|other| post.set_value(control, other.clone()).is_ok());
        found.extend(accepted.map(|other| (name, [Value::Float(*value), other])));
    }
    found
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_redraw_has_the_bits_of_a_whole_frame_and_runs_what_depends_on_a_value() {
    let named = sweep::some(["lynx.ron", "matinee.ron", "tsushima.ron", "cinematic.ron", "hdr.ron"], 3);
    let random = (1..3).map(|seed| Recipe { seed, nodes: 14, histories: 3, off: 8 }.graph());
    let graphs = named.into_iter().map(|name| built_in(name, None)).chain(random);
    let mut telling = 0;
    for graph in graphs {
        let parameters = sweep::some(changeable(&graph), 8);
        let names = || parameters.iter().map(|(name, _)| name.as_str());
        let [mut kept, mut whole] = [true, false].map(|repeatable| Film::new(&graph, names(), options(repeatable)));
        for (name, [old, new]) in &parameters {
            for film in [&mut kept, &mut whole] {
                film.session.restart();
                film.frame(STEPS[0]);
            }
            whole.set(name, new);
            whole.frame(STEPS[1]);
            kept.frame(STEPS[1]);
            let before = kept.shown();
            kept.set(name, new);
            kept.frame(redraw(STEPS[1]));
            let shown = kept.shown();
            assert!(shown == whole.shown(), "{name} at {new:?}");
            let passes = kept.session.plan().passes.len();
            let is_partial = kept
                .session
                .post()
                .executor()
                .loaded()
                .and_then(LoadedPlan::passes_redrawn)
                .is_some_and(|run| run < passes);
            telling += usize::from(is_partial && shown != before);
            // The next frame begins with the state of this one.
            for film in [&mut kept, &mut whole] {
                film.frame(STEPS[2]);
                film.set(name, old);
            }
            assert!(kept.shown() == whole.shown(), "{name} at {new:?}, and the next frame");
        }
    }
    assert!(telling >= 10, "{telling} frames differ from those before and were made in part");
}

/// A redraw of a cut resets, also where all passes run.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_redraw_of_a_cut_has_the_bits_of_a_cut() {
    let graph = built_in("exposure.ron", None);
    // The exposure adapts to it in time, and at once in a cut.
    let parameter = "meter.compensation";
    let value = Value::Float(0.2);
    for repeatable in [true, false] {
        let [mut film, mut changed] = [(); 2].map(|()| Film::new(&graph, [parameter], options(repeatable)));
        film.frame(STEPS[0]);
        for film in [&mut film, &mut changed] {
            film.set(parameter, &value);
        }
        film.frame(redraw(STEPS[0]));
        changed.frame(STEPS[0]);
        assert!(film.shown() == changed.shown(), "repeatable: {repeatable}");
    }
}

/// What the host changes otherwise needs a whole frame, and so does a plan that is not repeatable.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_redraw_is_whole_where_more_than_values_has_changed() {
    let graph = built_in("lynx.ron", None);
    let strength = "lit.strength";
    let redrawn = |options, change: &dyn Fn(&mut Film)| {
        let mut film = Film::new(&graph, [strength], options);
        film.frame(STEPS[0]);
        film.frame(STEPS[1]);
        change(&mut film);
        film.frame(redraw(STEPS[1]));
        film.session.post().executor().loaded().and_then(LoadedPlan::passes_redrawn)
    };
    assert_eq!(redrawn(options(true), &|_| {}), Some(0), "nothing has changed");
    assert_eq!(redrawn(options(false), &|_| {}), None);
    let unshared = Options { alias: Alias::None, ..options(false) };
    assert_eq!(redrawn(unshared, &|_| {}), None, "nothing is kept for a host that has not asked for it");
    let other_image = |film: &mut Film| {
        let gpu = gpu();
        let texels = scene_texels(SIZE);
        let view = upload(&gpu.device, &gpu.queue, &texels).expect("it fits");
        film.images[0].view = view.create_view(&Default::default());
    };
    assert_eq!(redrawn(options(true), &other_image), None);
    assert_eq!(redrawn(options(true), &|film| film.session.post().executor().reset()), None);
}
