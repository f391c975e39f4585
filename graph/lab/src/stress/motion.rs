//! The law that lines which move by a pixel do not make the image flicker.

use afterimage_graph::check::Graph;
use afterimage_graph::image::{ColorState, Size};

use super::case_runner::CaseRunner;
use super::images::MOVING;
use super::render::{OutputPixels, RenderRequest, StressFrame};
use super::target::Overrides;

/// The name of the case.
pub(crate) const LINES: &str = "moving-lines";
/// Sides that are even, and odd along x, along y and both: halvings differ.
const SIZES: [(u32, u32); 4] = [(96, 64), (97, 64), (96, 65), (97, 65)];
/// The columns whose mean is compared. Each row has two lines in them, wherever the lines are.
const COLUMNS: std::ops::Range<usize> = 16..80;
/// Rows at the border that are not compared: lights outside of the image are missing there.
const BORDER: usize = 8;
/// The most by which the mean may change: two codes of 8 bits.
const MOST: f64 = 2.0 / 255.0;

/// Compares the means of each encoded output of a pipeline.
pub(crate) fn moving_lines(runner: &mut CaseRunner<'_>, graph: &Graph) {
    if runner.target.is_kind || !runner.options.accepts(LINES) {
        return;
    }
    let sizes = match runner.options.size {
        Some(size) => vec![size],
        None if runner.is_heavy => SIZES[3..].to_vec(),
        None => SIZES.to_vec(),
    };
    let mut configuration = runner.renderer.configure(|_, _| {}, false);
    for (width, height) in sizes {
        let size = Size::new(width, height);
        if (width as usize) < COLUMNS.end || (height as usize) <= 2 * BORDER {
            continue;
        }
        let inputs = MOVING.map(StressFrame::still);
        let request = RenderRequest { target: runner.target, graph, size, inputs: &inputs, together: true };
        let frames = match runner.renderer.run(&mut configuration, request) {
            Ok(ran) => ran.frames,
            Err(why) => {
                runner.count(&Overrides::new(), size, LINES, vec![why]);
                continue;
            }
        };
        let wrong = (0..frames[0].len()).filter_map(|index| {
            let outputs: Vec<&OutputPixels> = frames.iter().map(|frame| &frame[index]).collect();
            flickers(&outputs, size)
        });
        let wrong = wrong.collect();
        runner.results.judged("no flicker");
        runner.count(&Overrides::new(), size, LINES, wrong);
    }
}

fn flickers(frames: &[&OutputPixels], size: Size) -> Option<String> {
    if frames[0].state != ColorState::Encoded || frames[0].size != size {
        return None;
    }
    let means: Vec<f64> = frames.iter().map(|shown| mean(shown)).collect();
    let least = means.iter().copied().fold(f64::INFINITY, f64::min);
    let most = means.iter().copied().fold(0.0, f64::max);
    let name = &frames[0].name;
    (most - least > MOST).then(|| format!("`{name}` flickers when lines move by a pixel: its mean is {means:.4?}"))
}

fn mean(shown: &OutputPixels) -> f64 {
    let rows: Vec<&[[f32; 4]]> = shown.pixels.chunks_exact(shown.size.width as usize).collect();
    let inside = &rows[BORDER..rows.len() - BORDER];
    let numbers = inside.iter().flat_map(|row| &row[COLUMNS]).flat_map(|pixel| &pixel[..3]);
    numbers.map(|x| f64::from(*x)).sum::<f64>() / (3 * COLUMNS.len() * inside.len()) as f64
}

#[cfg(test)]
mod tests {
    use afterimage_graph::image::{ColorState, Size};

    use super::super::render::OutputPixels;
    use super::flickers;

    #[test]
    fn a_brighter_frame_flickers() {
        let size = Size::new(97, 65);
        let frame = |code: f32| {
            let pixels = vec![[code / 255.0; 4]; 97 * 65];
            OutputPixels { name: "display".into(), state: ColorState::Encoded, limit: Some(1.0), size, pixels }
        };
        let flicker = |codes: [f32; 2]| {
            let frames = codes.map(frame);
            flickers(&frames.each_ref(), size)
        };
        assert_eq!(flicker([40.0, 41.5]), None);
        assert!(flicker([40.0, 43.0]).is_some_and(|what| what.starts_with("`display` flickers")));
    }
}
