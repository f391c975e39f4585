//! `afterimage demo`: the built-in scene through every built-in pipeline.

mod graph;
mod page;

use afterimage::offline::Session;
use afterimage::offline::quantize::{EncodedFile, unquantized};
use afterimage_gpu::{FrameStep, InputImage, Texels};
use afterimage_graph::check::{Facts, Graph, GraphOutput};
use afterimage_graph::image::Size;
use afterimage_graph::node::{BlockData, NodeKind};
use afterimage_media::{ImageFormat, rewrite, run_files};
use afterimage_pipelines::PIPELINES;
use afterimage_plan::Options;

use crate::args::{DemoArgs, KindOptions};
use crate::cameras::{is_eye, scene, scene_camera};
use crate::device::{keep_pipelines, open, session};
use crate::failure::Failure;
use crate::files::registry;
use crate::render::choose_output;
use crate::save::{ImageInfo, SaveOptions, save};
use crate::terminal::{note, say};
use graph::{RENDERER, graph};

pub(crate) fn run(args: &DemoArgs, tables: &[&[NodeKind]]) -> Result<(), Failure> {
    let registry = registry(tables, &KindOptions::default(), None)?;
    let size = Size::new(args.size.0, args.size.1);
    std::fs::create_dir_all(&args.out)
        .map_err(|error| Failure::machine(format!("cannot make the folder `{}`: {error}", args.out.display())))?;
    let pictures = PIPELINES.iter().map(|(name, _)| format!("{name}.png"));
    for name in pictures.chain(["scene.exr".to_owned(), page::FILE.to_owned()]) {
        run_files::writes(&args.out.join(name))?;
    }
    let gpu = open(&args.device)?;
    let saved = |name: &str, texels: &Texels, stated: ImageInfo, format: ImageFormat| {
        let path = args.out.join(format!("{name}.{}", format.endings()[0]));
        save(&path, texels, &stated, &SaveOptions::plain(format))?;
        say(&path.display().to_string());
        Ok::<_, Failure>(())
    };
    let options = Options { one_frame: true, ..Options::default() };
    let time = vec![format!("scene.time={:?}", args.time)];
    let renderer = graph(&registry, "scene", RENDERER, time)?;
    let camera = scene(&renderer).map(|scene| scene_camera(&scene, size));
    let mut scene = session(&gpu, renderer, Facts::default(), options);
    scene.render(size, &[], FrameStep::FIRST)?;
    let texels = scene.output("scene")?;
    saved("scene", &texels, stated(&scene, "scene"), ImageFormat::Exr)?;
    let images = ["scene", "depth", "normal", "motion"].map(|name| scene.output_image(name, name));
    for (name, text) in PIPELINES {
        let graph = graph(&registry, name, text, Vec::new())?;
        let GraphOutput { name: output, source, .. } = choose_output(&graph, None, true)?.clone();
        let graph = unquantized(graph, &[EncodedFile { source, bits: 8 }], true).graph;
        let mut demo = session(&gpu, graph.clone(), Facts::default(), options);
        render(&mut demo, &graph, &images, camera.as_ref())?;
        keep_pipelines(&mut demo);
        let texels = demo.output(&output)?;
        saved(name, &texels, stated(&demo, &output), ImageFormat::Png)?;
    }
    let page = args.out.join(page::FILE);
    rewrite(&page, page::page(&args.out).as_bytes())?;
    say(&page.display().to_string());
    page::commands(&args.out).iter().for_each(|line| note(line));
    Ok(())
}

/// Properties of an output besides its texels.
fn stated(session: &Session, output: &str) -> ImageInfo {
    ImageInfo::of(session.plan().output(Some(output)).expect("the graph has this output"))
}

/// Renders the first frame with the images that the graph has inputs for, and with the camera.
fn render(
    session: &mut Session,
    graph: &Graph,
    images: &[InputImage],
    camera: Option<&BlockData>,
) -> Result<(), Failure> {
    let takes = |image: &&InputImage| graph.inputs.iter().any(|input| input.name == image.input);
    let images: Vec<InputImage> = images.iter().filter(takes).cloned().collect();
    for (input, camera) in graph.inputs.iter().filter(|input| is_eye(input)).zip(camera.into_iter().cycle()) {
        session.set_block(&input.name, camera.clone());
    }
    Ok(session.render(images[0].desc.size, &images, FrameStep::FIRST)?)
}
