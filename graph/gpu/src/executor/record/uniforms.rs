//! The uniforms that a host states in each frame: blocks, rectangles of its images and factors of its inputs.

use afterimage_graph::image::Size;
use afterimage_plan::{Part, Plan, PlanOutput, RectangleInput};

use crate::error::GpuError;
use crate::executor::frame::{Frame, view_of};
use crate::executor::loaded::LoadedPlan;
use crate::executor::rectangle::Rectangle;

impl LoadedPlan {
    /// Sets the blocks, rectangles and factors of a frame.
    pub(crate) fn set_host_uniforms(&mut self, frame: &Frame<'_>) -> Result<(), GpuError> {
        self.set_blocks(frame)?;
        self.set_rectangles(frame)
    }

    fn set_blocks(&mut self, frame: &Frame<'_>) -> Result<(), GpuError> {
        for planned in &self.plan.blocks {
            let (port, declared) = (&planned.name, planned.block);
            let given = frame.blocks.iter().find(|(name, _)| name == port).map(|(_, data)| *data);
            let data = given.ok_or_else(|| GpuError::MissingBlock { port: port.clone(), ty: declared.name })?;
            if data.block() != declared {
                let (port, given) = (port.clone(), data.block().name);
                return Err(GpuError::WrongBlock { port, given, wanted: declared.name });
            }
            self.uniforms.set(planned.offset, data.bytes());
        }
        Ok(())
    }

    fn set_rectangles(&mut self, frame: &Frame<'_>) -> Result<(), GpuError> {
        let plan = &self.plan;
        check_stated(plan, frame)?;
        for input in &plan.rectangles {
            let uniform = input_uniform(plan, input, frame)?;
            for offset in &input.places {
                self.uniforms.set(*offset, &uniform);
                self.due.ignore_change(*offset, &uniform);
            }
        }
        for (output, known) in plan.outputs.iter().zip(&mut self.scissors) {
            if !output.in_rectangle {
                continue;
            }
            let rectangle = output_rectangle(plan, output, frame)?;
            let origin = [rectangle.x as f32, rectangle.y as f32].map(f32::to_le_bytes);
            for offset in plan.origin_places(output) {
                self.uniforms.set(offset, origin.as_flattened());
            }
            *known = Some(rectangle);
        }
        Ok(())
    }
}

/// Refuses values that the plan has no uniform for.
fn check_stated(plan: &Plan, frame: &Frame<'_>) -> Result<(), GpuError> {
    let stated = frame.rectangles.iter().map(|(name, _)| *name).chain(frame.factors.iter().map(|(name, _)| *name));
    for port in stated {
        let is_read = plan.inputs.iter().any(|(name, _)| name == port);
        let is_written = plan.outputs.iter().any(|output| output.name == port && !output.in_rectangle);
        let is_whole = is_read && !plan.rectangles.iter().any(|input| input.name == port);
        if is_whole || is_written && view_of(frame.outputs, port).is_some() {
            return Err(GpuError::unfit(port, "the plan was made for the whole image and no factor"));
        }
    }
    Ok(())
}

fn input_uniform(
    plan: &Plan,
    input: &RectangleInput,
    frame: &Frame<'_>,
) -> Result<[u8; RectangleInput::BYTES], GpuError> {
    let view = view_of(frame.inputs, &input.name).ok_or_else(|| GpuError::MissingInput(input.name.clone()))?;
    let size = frame.size_of(&input.name, view);
    let rectangle = frame.rectangle(&input.name).unwrap_or(Rectangle::whole(size));
    let planned = Some(plan.image(input.image).desc.size).filter(|_| input.part == Part::Rectangle);
    check(&input.name, rectangle, size, planned)?;
    let factor = frame.factors.iter().find(|(name, _)| *name == input.name).map_or(1.0, |(_, factor)| *factor);
    if !(factor.is_finite() && factor >= 0.0) {
        return Err(GpuError::unfit(
            &input.name,
            format!("its factor is {factor}, which must be a number of at least 0"),
        ));
    }
    Ok(input.uniform([rectangle.x, rectangle.y], [rectangle.width, rectangle.height], factor))
}

fn output_rectangle(plan: &Plan, output: &PlanOutput, frame: &Frame<'_>) -> Result<Rectangle, GpuError> {
    let planned = plan.image(output.image).desc.size;
    let Some(view) = view_of(frame.outputs, &output.name) else { return Ok(Rectangle::whole(planned)) };
    let size = frame.size_of(&output.name, view);
    let rectangle = frame.rectangle(&output.name).unwrap_or(Rectangle::whole(size));
    check(&output.name, rectangle, size, Some(planned))?;
    Ok(rectangle)
}

fn check(port: &str, rectangle: Rectangle, size: Size, planned: Option<Size>) -> Result<(), GpuError> {
    if !rectangle.lies_in(size) {
        let (width, height) = (size.width, size.height);
        return Err(GpuError::unfit(
            port,
            format!("its rectangle, {rectangle}, is no part of its {width}x{height} texels"),
        ));
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
