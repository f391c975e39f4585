//! The difference between the two pictures of a comparison in figures, as the program measures them.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

use afterimage_gpu::{Texels, wgpu};
use afterimage_graph::check::Graph;
use egui::{Button, Context, Ui};

use crate::model::{Changes, CompareWith, Model, PipelineInstance};
use crate::render::ImageCopy;

/// A picture with the graph and the output that it comes from.
pub struct MeasuredPicture {
    pub graph: Graph,
    pub output: String,
    pub texels: Texels,
}

/// States the difference of a picture from a reference, for people; or the reason why there is no figure.
pub type MeasureDifference = Arc<dyn Fn(&MeasuredPicture, &MeasuredPicture) -> Result<String, String> + Send + Sync>;

/// Measures a comparison on request, on a thread of its own.
#[derive(Default)]
pub(super) struct Measurement {
    /// `None` where nothing measures: there is no button.
    pub(super) measure: Option<MeasureDifference>,
    is_requested: bool,
    copies: Option<(Subject, [(MeasuredSource, ImageCopy); 2])>,
    running: Option<(Subject, Receiver<String>)>,
    done: Option<(Subject, String)>,
}

/// The comparison that is measured.
struct Subject {
    other: CompareWith,
    changes: Changes,
    frame: u32,
}

/// The graph and the output of a picture that is being copied.
type MeasuredSource = (Graph, String);

impl Measurement {
    /// The button next to those of a comparison.
    pub(super) fn button(&mut self, ui: &mut Ui) {
        let hint = "E: the largest difference of 99.9 % of the pixels, FLIP and JOD of this frame";
        if self.measure.is_some() && ui.add(Button::new("Measure")).on_hover_text(hint).clicked() {
            self.request();
        }
    }

    pub(super) fn request(&mut self) {
        self.is_requested = self.measure.is_some() && self.copies.is_none() && self.running.is_none();
    }

    /// Records the copies of both pictures, once both are those of the present values.
    pub(super) fn record(&mut self, encoder: &mut wgpu::CommandEncoder, model: &Model) {
        let Some((other, compared)) = model.comparison() else { return self.is_requested = false };
        let Some(shown) = model.shown() else { return };
        if !self.is_requested || [shown, compared].iter().any(|one| one.plan().is_none() || one.is_changing()) {
            return;
        }
        let mut copy = |instance: &PipelineInstance| {
            let copy = ImageCopy::record(&model.gpu().device, encoder, instance.picture()?, 0)?;
            Some(((instance.graph().clone(), instance.output()?), copy))
        };
        let copies = copy(compared).zip(copy(shown));
        let (changes, frame) = (model.editor().changes().snapshot(), model.frame_number());
        let subject = Subject { other: other.clone(), changes, frame };
        self.is_requested = false;
        self.copies = copies.map(|(compared, shown)| (subject, [compared, shown]));
    }

    /// Begins to measure pictures that have arrived, and takes figures that are there.
    pub(super) fn finish(&mut self, ctx: &Context) {
        if let Some((_, copies)) = &mut self.copies {
            copies.iter_mut().for_each(|(_, copy)| copy.request());
            if copies.iter().all(|(_, copy)| copy.texels().is_some()) {
                self.begin(ctx);
            }
        }
        if let Some((_, figures)) = &self.running
            && let Ok(figures) = figures.try_recv()
        {
            self.done = self.running.take().map(|(subject, _)| (subject, figures));
        }
        if self.is_requested || self.copies.is_some() || self.running.is_some() {
            ctx.request_repaint_after(Duration::from_millis(50));
        }
    }

    fn begin(&mut self, ctx: &Context) {
        let (Some((subject, copies)), Some(measure)) = (self.copies.take(), self.measure.clone()) else { return };
        let pictures = copies.map(|((graph, output), copy)| {
            let texels = copy.texels()?;
            Some(MeasuredPicture { graph, output, texels })
        });
        let [Some(reference), Some(shown)] = pictures else { return };
        let (sender, receiver) = channel();
        let ctx = ctx.clone();
        let judge = move || {
            // Nobody listens once the window is closed.
            let _ = sender.send(measure(&reference, &shown).unwrap_or_else(|why| why));
            ctx.request_repaint();
        };
        match std::thread::Builder::new().spawn(judge) {
            Ok(_) => self.running = Some((subject, receiver)),
            Err(error) => self.done = Some((subject, format!("not measured: {error}"))),
        }
    }

    /// The figures of the present comparison, or that they are on their way.
    pub(super) fn figures(&self, model: &Model) -> Option<String> {
        let is_present = |subject: &Subject| {
            model.compared() == Some(&subject.other) && model.editor().changes().shows(&subject.changes)
        };
        let pending = self.copies.as_ref().map(|(subject, _)| subject).or(self.running.as_ref().map(|(of, _)| of));
        if self.is_requested || pending.is_some_and(is_present) {
            return Some("Measuring…".into());
        }
        let (subject, figures) = self.done.as_ref().filter(|(subject, _)| is_present(subject))?;
        Some(format!("{figures}  (frame {})", subject.frame))
    }
}
