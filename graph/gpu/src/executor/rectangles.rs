//! Rectangles of the host's images, and factors of its inputs: what a frame states, written where it differs from the
//! frame before.

use afterimage_graph::image::Size;
use afterimage_plan::{Part, Plan, PlanOutput, RectangleInput};
use wgpu::{Queue, Texture};

use super::Executor;
use super::frame::Frame;
use super::loaded::Loaded;
use super::rectangle::Rectangle;
use super::sets::named;
use crate::GpuError;
use crate::platform::{caught, scoped};

impl Executor {
    /// Writes the rectangles and factors of a frame that have changed.
    pub(super) fn write_rectangles(&mut self, frame: &Frame<'_>) -> Result<(), GpuError> {
        let Some(loaded) = &mut self.loaded else { return Ok(()) };
        check_stated(&loaded.plan, frame)?;
        let Loaded { plan, uniforms, rectangles, .. } = loaded;
        let write = |place: u64, bytes: &[u8]| write(&self.compiler.device, &self.queue, uniforms, (place, bytes));
        for (input, held) in plan.rectangles.iter().zip(&mut rectangles.inputs) {
            let wanted = input_uniform(plan, input, frame)?;
            if *held != Some(wanted) {
                input.places.iter().try_for_each(|place| write(*place, &wanted))?;
                *held = Some(wanted);
            }
        }
        let outputs = plan.outputs.iter().zip(&mut rectangles.outputs);
        for (output, held) in outputs.filter(|(output, _)| output.in_rectangle) {
            let wanted = output_rectangle(plan, output, frame)?;
            if *held != Some(wanted) {
                let first = [wanted.x as f32, wanted.y as f32].map(f32::to_le_bytes);
                plan.origin_places(output).try_for_each(|place| write(place, first.as_flattened()))?;
                *held = Some(wanted);
            }
        }
        Ok(())
    }
}

fn write(
    device: &wgpu::Device,
    queue: &Queue,
    uniforms: &wgpu::Buffer,
    (place, bytes): (u64, &[u8]),
) -> Result<(), GpuError> {
    let what = "the rectangles of a frame";
    scoped(device, what, || caught(what, || queue.write_buffer(uniforms, place, bytes)))
}

/// What the plan has no uniform for would have no effect.
fn check_stated(plan: &Plan, frame: &Frame<'_>) -> Result<(), GpuError> {
    let stated = frame.rectangles.iter().map(|(name, _)| *name).chain(frame.factors.iter().map(|(name, _)| *name));
    for port in stated {
        let is_read = plan.inputs.iter().any(|(name, _)| name == port);
        let is_written = plan.outputs.iter().any(|output| output.name == port && !output.in_rectangle);
        let is_whole = is_read && !plan.rectangles.iter().any(|input| input.name == port);
        if is_whole || is_written && named(frame.outputs, port).is_some() {
            return Err(unfit(port, "the plan was made for the whole image and no factor".into()));
        }
    }
    Ok(())
}

fn input_uniform(
    plan: &Plan,
    input: &RectangleInput,
    frame: &Frame<'_>,
) -> Result<[u8; RectangleInput::BYTES], GpuError> {
    let view = named(frame.inputs, &input.name).ok_or_else(|| GpuError::MissingInput(input.name.clone()))?;
    let rectangle = frame.rectangle(&input.name).unwrap_or(Rectangle::of_texture(view.texture()));
    let planned = Some(plan.image(input.image).desc.size).filter(|_| input.part == Part::Rectangle);
    check(&input.name, rectangle, view.texture(), planned)?;
    let factor = frame.factors.iter().find(|(name, _)| *name == input.name).map_or(1.0, |(_, factor)| *factor);
    if !(factor.is_finite() && factor >= 0.0) {
        return Err(unfit(&input.name, format!("its factor is {factor}, which must be a number of at least 0")));
    }
    Ok(input.uniform([rectangle.x, rectangle.y], [rectangle.width, rectangle.height], factor))
}

fn output_rectangle(plan: &Plan, output: &PlanOutput, frame: &Frame<'_>) -> Result<Rectangle, GpuError> {
    let planned = plan.image(output.image).desc.size;
    let Some(view) = named(frame.outputs, &output.name) else { return Ok(Rectangle::whole(planned)) };
    let rectangle = frame.rectangle(&output.name).unwrap_or(Rectangle::of_texture(view.texture()));
    check(&output.name, rectangle, view.texture(), Some(planned))?;
    Ok(rectangle)
}

fn check(port: &str, rectangle: Rectangle, texture: &Texture, planned: Option<Size>) -> Result<(), GpuError> {
    if !rectangle.lies_in(texture) {
        let (width, height) = (texture.width(), texture.height());
        return Err(unfit(port, format!("its rectangle, {rectangle}, is no part of its {width}x{height} texels")));
    }
    match planned.filter(|planned| *planned != rectangle.size()) {
        None => Ok(()),
        Some(planned) => Err(GpuError::WrongImage {
            port: port.to_owned(),
            given: format!("a rectangle of {}", rectangle.size()),
            planned: planned.to_string(),
        }),
    }
}

fn unfit(port: &str, why: String) -> GpuError {
    GpuError::UnfitImage { port: port.to_owned(), why }
}
