//! `afterimage view`: the viewer on files of this machine.

mod open;
mod project;
mod recent;

use std::path::Path;
use std::sync::Arc;

use afterimage_graph::image::Size;
use afterimage_graph::node::NodeKind;
use afterimage_lab::LabError;
use afterimage_lab::measure::{PictureErrors, ShownOutput};
use afterimage_media::sequence::split_layer;
use afterimage_view::{Desktop, MeasuredPicture, Problem, Project, TextProject};

use crate::args::PipelineOptions;
use crate::args::view::ViewArgs;
use crate::built_in::{self, hint, is_pipeline};
use crate::failure::Failure;
use crate::files::{Files, is_image_name, read_document, registry};
use crate::pipeline::{PipelineFile, assignments};
use crate::render::check_input_names;
use open::Opener;
use recent::recent_files;

/// The pipeline that is shown if none is named.
const FIRST: &str = "tsushima";

pub(crate) fn run(args: &ViewArgs, tables: &[&[NodeKind]]) -> Result<(), Failure> {
    let named = assignments(&args.inputs, "--input")?;
    check_names(args, &named, tables)?;
    let opener = Opener::new(args, tables);
    let named = named.into_iter().map(|(input, file)| (Some(input), file));
    let files = args.input.clone().map(|file| (None, file)).into_iter().chain(named);
    let inputs = files.map(|(input, file)| Ok((input, opener.input(&file)?))).collect::<Result<_, Failure>>()?;
    let desktop = Desktop {
        adapter: args.adapter.clone(),
        size: [args.window.0.into(), args.window.1.into()],
        project: project(args, &opener)?,
        wake: opener.wake.clone(),
        scene: Size::new(args.size.0, args.size.1),
        inputs,
        new_file: Box::new({
            let opener = opener.clone();
            move |path, named| opener.new_file(path, named)
        }),
        open: Box::new(move |path| opener.open(path)),
        measure: Arc::new(|reference, shown| difference(reference, shown).map_err(|error| error.to_string())),
        recent: recent_files(),
        tier: args.tier.clone(),
        facts: crate::pipeline::fact_list(&args.facts)?,
    };
    Ok(desktop.run()?)
}

/// The figures of a claim for two pictures.
fn difference(reference: &MeasuredPicture, shown: &MeasuredPicture) -> Result<String, LabError> {
    Ok(PictureErrors::between(as_shown(reference), as_shown(shown))?.to_string())
}

fn as_shown(picture: &MeasuredPicture) -> ShownOutput<'_> {
    ShownOutput { graph: &picture.graph, output: &picture.output, texels: &picture.texels }
}

/// Exchanges the pipeline and the image if they stand the other way round. An image alone is shown through the first
/// pipeline.
pub(crate) fn put_in_order(args: &mut ViewArgs) {
    let Some(pipeline) = &mut args.pipeline else { return };
    built_in::put_in_order(pipeline, &mut args.input);
    let name = pipeline.to_string_lossy().into_owned();
    let is_image = is_image_name(Path::new(split_layer(&name).0));
    if args.input.is_none() && is_image && !is_pipeline(pipeline) {
        (args.pipeline, args.input) = (None, Some(name));
    }
}

/// A fact or an input that the pipeline does not know is a typing error. A pipeline with errors is shown with them.
fn check_names(args: &ViewArgs, inputs: &[(String, String)], tables: &[&[NodeKind]]) -> Result<(), Failure> {
    if args.facts.is_empty() && inputs.is_empty() {
        return Ok(());
    }
    let path = args.pipeline.as_deref().unwrap_or(Path::new(FIRST));
    let Ok(document) = read_document(path) else { return Ok(()) };
    let registry = registry(tables, &args.kinds, Some(path))?;
    let files = Files::of(path, &args.kinds);
    let (tier, facts, kinds) = (args.tier.clone(), args.facts.clone(), args.kinds.clone());
    let options = PipelineOptions { sets: Vec::new(), facts, tier, kinds };
    match PipelineFile::new(&document, &registry, &files).check(&options) {
        Ok((graph, _)) => check_input_names(&graph, inputs),
        Err(Failure::Pipeline(_)) => Ok(()),
        Err(failure) => Err(failure),
    }
}

/// The named file, a built-in pipeline of that name, or the first one.
fn project(args: &ViewArgs, opener: &Opener) -> Result<Box<dyn Project>, Failure> {
    let Some(path) = &args.pipeline else {
        return Ok(Box::new(TextProject::built_in(FIRST).expect("it is built in")));
    };
    // Also a link in a circle, which the project reports.
    if path.symlink_metadata().is_ok() {
        return Ok(Box::new(opener.project(path)));
    }
    let name = path.to_string_lossy();
    if let Some(project) = TextProject::built_in(name.trim_end_matches(".ron")) {
        return Ok(Box::new(project));
    }
    Err(Failure::unreadable(format!("there is no file `{name}`")).hint(hint(&name)))
}

impl From<Problem> for Failure {
    fn from(problem: Problem) -> Self {
        match problem {
            Problem::Pipeline(errors) => Self::Pipeline(errors),
            Problem::Message { message, hint: Some(hint) } => Self::machine(message).hint(hint),
            other => Self::machine(other),
        }
    }
}

#[cfg(test)]
mod tests {
    use afterimage_media::{Encoding, Picture, Pixels, write_image};
    use afterimage_view::InputData;
    use clap::Parser as _;

    use super::*;
    use crate::args::{Arguments, Command, KindOptions};

    #[test]
    fn an_image_to_look_at_may_stand_before_the_pipeline_or_alone() {
        for (words, pipeline, image) in [
            (&["lynx", "photo.exr"][..], Some("lynx"), Some("photo.exr")),
            (&["photo.exr", "lynx"], Some("lynx"), Some("photo.exr")),
            (&["photo.exr"], None, Some("photo.exr")),
            (&["shot.####.EXR#diffuse"], None, Some("shot.####.EXR#diffuse")),
            (&["lynx"], Some("lynx"), None),
            (&[], None, None),
        ] {
            let arguments = Arguments::try_parse_from([&["afterimage", "view"], words].concat()).expect("it is valid");
            let Command::View(mut args) = arguments.command else { panic!("it is another command") };
            put_in_order(&mut args);
            let found = (args.pipeline.as_deref(), args.input.as_deref());
            assert_eq!(found, (pipeline.map(Path::new), image), "{words:?}");
        }
    }

    fn view(words: &[&str]) -> ViewArgs {
        let arguments = Arguments::try_parse_from([&["afterimage", "view"], words].concat()).expect("it is valid");
        let Command::View(args) = arguments.command else { panic!("it is another command") };
        args
    }

    /// Frames 3, 4 and 5 of a sequence, of a red that is brighter in each.
    #[test]
    fn a_sequence_has_its_numbers_and_the_options_of_the_command_line() {
        let folder = std::env::temp_dir().join(format!("afterimage-view-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder for temporary files");
        for number in [3_u8, 4, 5] {
            let pixels = Pixels::Float([f32::from(number), 0.0, 0.0, 1.0].repeat(6));
            let path = folder.join(format!("shot.{number}.exr"));
            write_image(&path, &Picture::new(3, 2, pixels), &Encoding::EXR).expect("it is written");
        }
        let name = folder.join("shot.#.exr").to_string_lossy().into_owned();
        let scene = read_document(Path::new("exposure")).expect("it is built in");
        let registry = registry(&[afterimage_nodes::ALL], &KindOptions::default(), None).expect("the built-in kinds");
        let files = Files::of(Path::new("exposure"), &KindOptions::default());
        let options = PipelineOptions::default();
        let (graph, _) = PipelineFile::new(&scene, &registry, &files).check(&options).expect("it is good");
        // Red of ACEScg in Rec.709, from D60 to D65 (S-2014-004 and Rec.709 by Bradford's cones).
        for (words, fps, red) in [
            (&[][..], 24.0, [1.0, 0.0, 0.0]),
            (&["--fps", "12.5"], 12.5, [1.0, 0.0, 0.0]),
            (&["--fps", "59.94", "--input-space", "ACEScg"], f64::from(59.94_f32), [1.7051, -0.1303, -0.0240]),
        ] {
            let mut file = Opener::new(&view(words), &[afterimage_nodes::ALL]).input(&name).expect("it is there");
            assert_eq!((&*file.name, &*file.numbers, file.fps), (&*name, &[3, 4, 5][..], fps));
            for (index, number) in [3.0, 4.0, 5.0].into_iter().enumerate() {
                let data = (file.read)(&graph.inputs[0], index).unwrap_or_else(|_| panic!("frame {number} is read"));
                let InputData::Image(picture, desc) = data else { panic!("it is an image") };
                assert_eq!((desc.size.width, desc.size.height), (3, 2));
                let found = picture.pixel(1, 1);
                let is_close = red.iter().zip(found).all(|(red, found)| (number * red - found).abs() < 0.01);
                assert!(is_close, "{words:?}, frame {number}: {found:?}");
            }
            assert!(!(file.have_changed)());
        }
        std::fs::remove_dir_all(&folder).expect("it is ours");
    }
}
