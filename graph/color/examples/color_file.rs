//! Evaluates a color file in double precision: `color_file FILE [tetrahedral]` reads three numbers a line and prints
//! the result of each line. `tests/color/compare_ocio.py` compares it with OpenColorIO.

use std::error::Error;
use std::io::{BufRead, Write};

use afterimage_color::lut::{Interpolation, PngLayout, parse_correction};
use afterimage_color::lut_file::{LutFile, parse_lut_file};
use afterimage_color::process::Process;

fn process(bytes: &[u8], interpolation: Interpolation) -> Result<Process, Box<dyn Error>> {
    let correction = std::str::from_utf8(bytes).ok().filter(|text| text.contains("<ColorCorrection"));
    if let Some(text) = correction {
        return Ok(parse_correction(text, "")?.into());
    }
    Ok(match parse_lut_file(bytes, PngLayout::Tiles)? {
        LutFile::Process(process) => process,
        LutFile::Table(lut) => Process::of_table(&lut, interpolation),
    })
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let path = arguments.first().ok_or("usage: color_file FILE [tetrahedral]")?;
    let is_tetrahedral = arguments.get(1).is_some_and(|word| word == "tetrahedral");
    let interpolation = if is_tetrahedral { Interpolation::Tetrahedral } else { Interpolation::Trilinear };
    let process = process(&std::fs::read(path)?, interpolation)?;
    let mut output = std::io::BufWriter::new(std::io::stdout().lock());
    for line in std::io::stdin().lock().lines() {
        let numbers: Vec<f64> = line?.split_whitespace().map(str::parse).collect::<Result<_, _>>()?;
        let rgb: [f64; 3] = numbers.try_into().map_err(|_| "a line has three numbers")?;
        let [r, g, b] = process.apply(rgb);
        writeln!(output, "{r:e} {g:e} {b:e}")?;
    }
    Ok(())
}
