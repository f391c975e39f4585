//! All that was measured, and which of it is worth having.

use super::judge::Figures;
use super::runner::Watch;
use super::variants::VariantKind;
use afterimage_lab::metrics::Range;

/// What was measured, how, and on what.
#[derive(Clone, Debug)]
pub(crate) struct Report {
    /// The pipeline's file.
    pub(crate) pipeline: String,
    /// The output that was judged.
    pub(crate) output: String,
    pub(crate) range: Range,
    pub(crate) adapter: String,
    pub(crate) watch: Watch,
    pub(crate) repeats: u32,
    pub(crate) clips: Vec<ClipInfo>,
    pub(crate) rows: Vec<Row>,
    /// Switches that leave the plan as it is.
    pub(crate) without_effect: Vec<String>,
}

/// A clip, in words and numbers.
#[derive(Clone, Debug)]
pub(crate) struct ClipInfo {
    pub(crate) name: String,
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) frames: usize,
}

/// A variant and its figures.
#[derive(Clone, Debug)]
pub(crate) struct Row {
    pub(crate) variant: String,
    pub(crate) kind: VariantKind,
    /// On each clip, in the order of the report.
    pub(crate) clips: Vec<Figures>,
    /// Whether no other variant is both as fast and as accurate.
    pub(crate) pareto: bool,
}

impl Row {
    pub(crate) fn new(variant: &str, kind: VariantKind) -> Self {
        Self { variant: variant.to_owned(), kind, clips: Vec::new(), pareto: false }
    }

    /// The worst over the clips.
    pub(crate) fn worst(&self) -> Figures {
        let mut all = self.clips.iter().copied();
        let first = all.next().expect("a variant is measured on at least one clip");
        all.fold(first, Figures::worst)
    }

    /// Time and error: what is weighed.
    pub(crate) fn point(&self) -> (f64, f64) {
        let worst = self.worst();
        (worst.cost.ms, worst.errors.p999)
    }

    /// The place of the clip with the largest error.
    pub(crate) fn worst_clip(&self) -> usize {
        let error = |at: usize| self.clips[at].errors.p999;
        (1..self.clips.len()).fold(0, |worst, at| if error(at) > error(worst) { at } else { worst })
    }
}

impl Report {
    /// The name of the unit of errors.
    pub(crate) fn unit(&self) -> &'static str {
        match self.range {
            Range::Sdr => "8-bit codes",
            Range::Hdr => "PU21 codes",
        }
    }

    /// The images, as a caption says it.
    pub(crate) fn caption(&self) -> String {
        let images = match self.clips.as_slice() {
            [clip] => format!("{}, {}x{}", clip.name, clip.width, clip.height),
            clips => format!("the worst of {} images", clips.len()),
        };
        format!("{}; {images}; output `{}`", self.adapter, self.output)
    }

    /// Marks the variants that no other one beats. The truth takes no part: no file can ask for it.
    pub(crate) fn mark_pareto(&mut self) {
        let points: Vec<Option<(f64, f64)>> =
            self.rows.iter().map(|row| (row.kind != VariantKind::Truth).then(|| row.point())).collect();
        for (row, own) in self.rows.iter_mut().zip(&points) {
            row.pareto = own.is_some_and(|own| !points.iter().flatten().any(|other| beats(*other, own)));
        }
    }
}

/// Whether a point is as good as another in both time and error, and better in one.
pub(crate) fn beats(a: (f64, f64), b: (f64, f64)) -> bool {
    a.0 <= b.0 && a.1 <= b.1 && a != b
}
