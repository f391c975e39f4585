//! All figures of a measurement.

use afterimage_gpu::ClockSource;

use super::reference::Figures;
use super::variants::VariantKind;
use crate::metrics::{Display, Range};

/// The result of `measure`: figures, settings and images.
#[derive(Clone, Debug)]
pub struct MeasureReport {
    /// The name of the pipeline.
    pub pipeline: String,
    /// The output that was compared.
    pub output: String,
    /// SDR or HDR.
    pub range: Range,
    /// The display of the visible differences.
    pub display: Display,
    /// The name of the adapter.
    pub adapter: String,
    /// The clock of the times.
    pub clock: ClockSource,
    /// Samples of each time.
    pub samples: u32,
    pub sequences: Vec<SequenceInfo>,
    /// The variants; the first is the reference.
    pub rows: Vec<Row>,
    /// Switches that do not change the plan.
    pub without_effect: Vec<String>,
}

/// Name and size of a sequence.
#[derive(Clone, Debug)]
pub struct SequenceInfo {
    pub name: String,
    pub width: u32,
    pub height: u32,
    pub frames: usize,
    /// All frames have the same image.
    pub still: bool,
}

/// A variant and its figures.
#[derive(Clone, Debug)]
pub struct Row {
    /// The name of the variant.
    pub variant: String,
    pub kind: VariantKind,
    /// On each sequence, in the order of the report.
    pub sequences: Vec<Figures>,
    /// On each sequence the first row with the same plan, whose figures these are: this one if there is no earlier one.
    pub measured_as: Vec<usize>,
    /// No other variant is better in time and error (Pareto-optimal).
    pub pareto: bool,
}

impl Row {
    pub(crate) fn new(variant: &str, kind: VariantKind) -> Self {
        Self { variant: variant.to_owned(), kind, sequences: Vec::new(), measured_as: Vec::new(), pareto: false }
    }

    /// The worst over the sequences.
    pub fn worst(&self) -> Figures {
        let mut all = self.sequences.iter().copied();
        let first = all.next().expect("a variant is measured on at least one sequence");
        all.fold(first, Figures::worst)
    }

    /// Time in milliseconds and error in codes.
    pub(crate) fn point(&self) -> (f64, f64) {
        let worst = self.worst();
        (worst.cost.time.ms(), worst.errors.p999)
    }

    /// The 99.9th percentile of the error without the sequence where it is largest: what the others would have claimed.
    /// `None` if there is one sequence.
    pub fn p999_without_worst(&self) -> Option<f64> {
        let worst = self.worst_sequence();
        let others = self.sequences.iter().enumerate().filter(|(at, _)| *at != worst);
        others.map(|(_, figures)| figures.errors.p999).reduce(f64::max)
    }

    /// The index of the sequence with the largest error.
    pub(crate) fn worst_sequence(&self) -> usize {
        let error = |at: usize| self.sequences[at].errors.p999;
        (1..self.sequences.len()).fold(0, |worst, at| if error(at) > error(worst) { at } else { worst })
    }
}

impl MeasureReport {
    /// The name of the unit of errors.
    pub(crate) fn unit(&self) -> &'static str {
        match self.range {
            Range::Sdr => "8-bit codes",
            Range::Hdr => "PU21 codes",
        }
    }

    /// Adapter, images and output as a caption.
    pub(crate) fn caption(&self) -> String {
        let images = match self.sequences.as_slice() {
            [sequence] => format!("{}, {}x{}", sequence.name, sequence.width, sequence.height),
            sequences => format!("the worst of {}", images(sequences.iter().map(|sequence| sequence.still))),
        };
        format!("{}; {images}; output `{}`", self.adapter, self.output)
    }

    /// The place of the earlier row that has the same plan on all sequences.
    pub fn same_as(&self, row: usize) -> Option<usize> {
        let mut first = self.rows[row].measured_as.iter();
        let at = *first.next()?;
        (at < row && first.all(|other| *other == at)).then_some(at)
    }

    /// Marks the variants that no other one outdoes, the reference aside.
    pub(crate) fn mark_pareto(&mut self) {
        let figures: Vec<Option<Figures>> =
            self.rows.iter().map(|row| (row.kind != VariantKind::Reference).then(|| row.worst())).collect();
        for (row, own) in self.rows.iter_mut().zip(&figures) {
            row.pareto = own.is_some_and(|own| !figures.iter().flatten().any(|other| outdoes(other, &own)));
        }
    }
}

/// The number of stills and that of sequences, in words; each is true for a still.
pub(crate) fn images(stills: impl Iterator<Item = bool>) -> String {
    let (stills, moving): (Vec<bool>, Vec<bool>) = stills.partition(|still| *still);
    match (stills.len(), moving.len()) {
        (stills, 0) => format!("{stills} images"),
        (0, moving) => format!("{moving} sequences"),
        (stills, moving) => format!("{stills} images and {moving} sequences"),
    }
}

/// True if `a` is as good as `b` in time and error, and better in one. Times differ if their intervals do not overlap.
fn outdoes(a: &Figures, b: &Figures) -> bool {
    let ([a_least, a_most], [b_least, b_most]) = (a.cost.time.interval(), b.cost.time.interval());
    let (error, other) = (a.errors.p999, b.errors.p999);
    a_least <= b_most && error <= other && (a_most < b_least || error < other)
}

/// True if `a` is as good as `b` in both time and error, and better in one.
pub(crate) fn beats(a: (f64, f64), b: (f64, f64)) -> bool {
    a.0 <= b.0 && a.1 <= b.1 && a != b
}
