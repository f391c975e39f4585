//! `afterimage demo`: the built-in scene through every shipped pipeline.

mod chart;
mod walk;

use std::path::Path;

use afterimage_gpu::{Gpu, Texels};
use afterimage_graph::image::{ColorState, ImageDesc, Size};
use afterimage_graph::node::{NodeKind, Registry};

use crate::args::{DemoArgs, PipelineOptions};
use crate::failure::Failure;
use crate::pipeline::{check_with, registry};
use crate::save::{Saving, save};
use crate::session::{Clock, Given, Session, choose_output, open};
use crate::shipped::{PIPELINES, SCENE, Shipped};
use crate::terminal::say;
use afterimage_media::write_atomic;

pub(crate) fn run(args: &DemoArgs, tables: &[&[NodeKind]]) -> Result<(), Failure> {
    let registry = registry(tables, &[])?;
    if let Some(file) = &args.walk {
        return plot_walk(args, &registry, file);
    }
    let gpu = open(&args.device)?;
    let size = Size::new(args.size.0, args.size.1);
    std::fs::create_dir_all(&args.out)
        .map_err(|error| Failure::machine(format!("cannot make the folder `{}`: {error}", args.out.display())))?;
    let mut scene = session(&gpu, &registry, "scene", SCENE, &[format!("scene.time={:?}", args.time)])?;
    scene.render(size, &[], Clock { reset: true, ..Clock::default() })?;
    let saved = |name: &str, texels: &Texels, state: ColorState, ending: &str| {
        let path = args.out.join(format!("{name}.{ending}"));
        save(&path, texels, state, None, &Saving::default())?;
        say(&path.display().to_string());
        Ok::<_, Failure>(())
    };
    saved("scene", &scene.output("scene")?, ColorState::Scene, "exr")?;
    let view = scene.output_texture("scene").create_view(&Default::default());
    let scene = [Given { input: "scene".into(), view, desc: ImageDesc::new(size) }];
    let mut tiles = Vec::new();
    for (name, text) in PIPELINES {
        let mut pipeline = session(&gpu, &registry, name, text, &[])?;
        pipeline.render(size, &scene, Clock { reset: true, ..Clock::default() })?;
        let output = choose_output(pipeline.plan(), None, true)?;
        let texels = pipeline.output(&output.name)?;
        saved(name, &texels, ColorState::Encoded, "png")?;
        tiles.push(texels);
    }
    saved("contact-sheet", &contact_sheet(&tiles), ColorState::Encoded, "png")
}

fn plot_walk(args: &DemoArgs, registry: &Registry, file: &Path) -> Result<(), Failure> {
    if !file.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("svg")) {
        return Err(Failure::user(format!("`--walk {}` does not end in `.svg`", file.display())));
    }
    let walk = walk::measure(&open(&args.device)?, registry)?;
    write_atomic(file, chart::svg(&walk).as_bytes())?;
    say(&walk.summary());
    Ok(())
}

fn session<'g>(
    gpu: &'g Gpu,
    registry: &Registry,
    name: &str,
    text: &str,
    sets: &[String],
) -> Result<Session<'g>, Failure> {
    let options = PipelineOptions { sets: sets.to_vec(), facts: Vec::new(), tier: None, nodes: Vec::new() };
    let (graph, _) = check_with(&Shipped, &format!("{name}.ron"), text, registry, &options)?;
    Ok(Session::new(gpu, graph, Default::default(), Default::default()))
}

/// Pixels between two pictures of the sheet.
const GAP: usize = 8;

/// All pictures at half size, two in a row.
fn contact_sheet(tiles: &[Texels]) -> Texels {
    let size = tiles.first().map_or(Size::new(1, 1), |tile| tile.desc.size);
    let (width, height) = ((size.width as usize / 2).max(1), (size.height as usize / 2).max(1));
    let columns = 2;
    let rows = tiles.len().div_ceil(columns);
    let sheet_width = GAP + columns * (width + GAP);
    let sheet_height = GAP + rows * (height + GAP);
    let mut sheet = vec![[0.12, 0.12, 0.12, 1.0]; sheet_width * sheet_height];
    for (index, tile) in tiles.iter().enumerate() {
        let (left, top) = (GAP + index % columns * (width + GAP), GAP + index / columns * (height + GAP));
        let pixels = tile.to_floats();
        for y in 0..height {
            for x in 0..width {
                sheet[(top + y) * sheet_width + left + x] = half_size(&pixels, size, x, y);
            }
        }
    }
    Texels::from_floats(sheet_width as u32, sheet_height as u32, &sheet)
}

/// The mean of the pixels that one pixel of the smaller picture covers. Means of encoded values are good enough for an overview.
fn half_size(pixels: &[[f32; 4]], size: Size, x: usize, y: usize) -> [f32; 4] {
    let (last_x, last_y) = (size.width as usize - 1, size.height as usize - 1);
    let at = |dx: usize, dy: usize| pixels[(2 * y + dy).min(last_y) * size.width as usize + (2 * x + dx).min(last_x)];
    std::array::from_fn(|c| (at(0, 0)[c] + at(1, 0)[c] + at(0, 1)[c] + at(1, 1)[c]) / 4.0)
}
