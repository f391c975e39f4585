//! Files of tables that are made here.

use std::fmt::Write as _;
use std::path::Path;

use super::{MAX_CURVE, Table};
use crate::shaper::Shape;

/// A 3-D table as it is written, with what its file says about itself.
#[derive(Clone, Debug)]
pub struct WrittenLut {
    /// The name of the table.
    pub title: String,
    /// Lines about it.
    pub notes: Vec<String>,
    /// The function of its inputs before the table, and the input that it maps to 1. It maps 0 to 0.
    pub shape: Option<(Shape, f64)>,
    /// The entries, over 0 to 1.
    pub cube: Table,
}

/// A format of tables that are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WrittenFormat {
    /// `.cube`, in Resolve's form with a 1-D table where there is a shape.
    Cube,
    /// Common LUT Format, version 3, with a logarithm where there is a shape.
    Clf,
}

impl WrittenFormat {
    /// The format of a file, by the ending of its name.
    pub fn of_name(path: &Path) -> Option<Self> {
        let ending = path.extension()?.to_string_lossy().to_lowercase();
        [(Self::Cube, "cube"), (Self::Clf, "clf")].into_iter().find(|(_, own)| *own == ending).map(|(format, _)| format)
    }

    /// The text of a file.
    pub fn text(self, lut: &WrittenLut) -> String {
        match self {
            Self::Cube => cube(lut),
            Self::Clf => clf(lut),
        }
    }
}

/// Red varies fastest.
fn cube(lut: &WrittenLut) -> String {
    let mut text = match lut.shape {
        // Quotes cannot be escaped.
        None => format!("TITLE \"{}\"\n", one_line(&lut.title).replace('"', "'")),
        // Resolve's form has no titles, and OpenColorIO refuses them there.
        Some(_) => format!("# {}\n", one_line(&lut.title)),
    };
    lut.notes.iter().for_each(|note| text += &format!("# {}\n", one_line(note)));
    if let Some((_, high)) = lut.shape {
        text += &format!("LUT_1D_SIZE {MAX_CURVE}\nLUT_1D_INPUT_RANGE 0 {high}\n");
    }
    text += &format!("LUT_3D_SIZE {}\n", lut.cube.size);
    if let Some((shape, high)) = lut.shape {
        text += "LUT_3D_INPUT_RANGE 0 1\n";
        for index in 0..MAX_CURVE {
            let x = shape.apply(high * index as f64 / (MAX_CURVE - 1) as f64) as f32;
            line(&mut text, [x; 3]);
        }
    }
    lut.cube.entries.iter().for_each(|entry| line(&mut text, *entry));
    text
}

/// Blue varies fastest.
fn clf(lut: &WrittenLut) -> String {
    let title = escaped(&one_line(&lut.title));
    let mut text = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<ProcessList compCLFversion=\"3.0\" id=\"afterimage\" \
         name=\"{title}\">\n"
    );
    let notes = [&lut.title].into_iter().chain(&lut.notes);
    notes.for_each(|note| text += &format!("  <Description>{}</Description>\n", escaped(&one_line(note))));
    if let Some((Shape { line: [slope, _, end, _], curve: [a, b, c, d] }, _)) = lut.shape {
        text += &format!(
            "  <Log inBitDepth=\"32f\" outBitDepth=\"32f\" style=\"cameraLinToLog\">\n    <LogParams base=\"2\" \
             logSideSlope=\"{c}\" logSideOffset=\"{d}\" linSideSlope=\"{a}\" linSideOffset=\"{b}\" \
             linSideBreak=\"{end}\" linearSlope=\"{slope}\"/>\n  </Log>\n"
        );
    }
    let size = lut.cube.size;
    text += &format!(
        "  <LUT3D inBitDepth=\"32f\" outBitDepth=\"32f\" interpolation=\"tetrahedral\">\n    <Array dim=\"{size} \
         {size} {size} 3\">\n"
    );
    for index in 0..size.pow(3) {
        let (red, green, blue) = (index / size / size, index / size % size, index % size);
        line(&mut text, lut.cube.entries[red + size * (green + size * blue)]);
    }
    text + "    </Array>\n  </LUT3D>\n</ProcessList>\n"
}

/// The shortest numbers that are read as these in 32 bits.
fn line(text: &mut String, [r, g, b]: [f32; 3]) {
    writeln!(text, "{r} {g} {b}").expect("texts grow");
}

fn one_line(text: &str) -> String {
    text.replace(char::is_control, " ")
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
