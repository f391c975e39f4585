//! AVIF to linear Rec.709, with the feature `avif`.

mod boxes;
mod container;
mod frame;

use std::io::{BufRead, Seek};

use afterimage_base::color::{Chromaticities, Transfer};

use self::container::{Coding, Container};
use self::frame::Frame;
use crate::codec::cicp::Cicp;
use crate::codec::codes::{Alpha, Colors};
use crate::codec::limits::{MAX_BYTES, read_all, zeroed};
use crate::codec::signals::Weights;
use crate::codec::{CodecError, ColorSpace, Description, Picture, ReadOptions, icc};

/// Decodes the main picture to linear color. Straight alpha is multiplied into it, unless `options` keep it apart.
pub(crate) fn decode(reader: impl BufRead + Seek, options: &ReadOptions) -> Result<Picture, CodecError> {
    let bytes = read_all(reader, options.budget.0)?;
    let file = Container::read(&bytes)?;
    let (width, height) = file.size;
    // The decoder has the frame, a copy for its filters and the state of its blocks.
    let pixels = u64::from(width) * u64::from(height);
    let turned = if file.orientation.is_some() { 16 * pixels } else { 0 };
    let extra = 2 * bytes.len() as u64 + 16 * pixels + turned;
    options.budget.check((width.into(), height.into()), 4, extra)?;
    let frame = Frame::decode(&file.color, file.size)?;
    let coding = file.cicp.unwrap_or_else(|| frame.coding());
    let colors = colors(&file, coding, frame.is_gray(), options.space);
    let mut values: Vec<f32> = zeroed(4 * pixels as usize)?;
    frame.write_signals(coding, &mut values)?;
    let alpha = match (file.alpha.is_some(), options.premultiplied) {
        (false, _) => Alpha::None,
        (true, true) => Alpha::Premultiply,
        (true, false) => Alpha::Apart,
    };
    if let Some(alpha) = &file.alpha {
        Frame::decode(alpha, file.size)?.write_alpha(&mut values);
        if file.is_premultiplied {
            for [red, green, blue, alpha] in values.as_chunks_mut::<4>().0 {
                // What shows nothing has any color.
                let alpha = if *alpha > 0.0 { *alpha } else { 1.0 };
                [red, green, blue].into_iter().for_each(|signal| *signal = (*signal / alpha).min(1.0));
            }
        }
    }
    colors.into_picture(values, [width, height], alpha, file.orientation)
}

/// Describes a file by its boxes, and by its picture where they state no colors.
pub(crate) fn describe(reader: impl BufRead + Seek) -> Result<Description, CodecError> {
    let bytes = read_all(reader, MAX_BYTES)?;
    let file = Container::read(&bytes)?;
    let coding = match file.cicp {
        Some(coding) => coding,
        None => Frame::decode(&file.color, file.size)?.coding(),
    };
    let mut colors = colors(&file, coding, false, None);
    let names: &[&str] = if file.alpha.is_some() { &["R", "G", "B", "A"] } else { &["R", "G", "B"] };
    let samples = match file.bits {
        8 => "8 bits",
        10 => "10 bits",
        _ => "12 bits",
    };
    colors.notes.extend(file.orientation.map(|_| "it is turned upright, as it states".to_owned()));
    let size = file.orientation.map_or(file.size, |orientation| orientation.size(file.size.0, file.size.1));
    Ok(colors.describe(Description::of_picture("AVIF", size, names, samples, "AV1")))
}

/// The colors of a file: those of its profile, or of its code points. Notes what it does not state.
fn colors(file: &Container<'_>, coding: Coding, is_gray: bool, space: Option<ColorSpace>) -> Colors {
    let mut notes = file.notes.clone();
    let of_profile = |notes: &mut Vec<String>| {
        let found = icc::read(file.profile?, if is_gray { 1 } else { 3 });
        found.map_err(|why| notes.push(format!("its ICC profile is not applied: {why}"))).ok()
    };
    let mut colors = if let Some(space) = space {
        Colors::new(Some((space.primaries, space.transfer)), file.peak)
    } else if let Some(profile) = of_profile(&mut notes) {
        Colors::of_profile(profile).stated_by("ICC profile")
    } else {
        let stated = meaning(coding);
        if stated.is_none() && (coding.primaries, coding.transfer) != (2, 2) {
            notes.push("its colors are of a kind that is not known, and are taken as those of sRGB".to_owned());
        }
        let colors = Colors::new(stated, file.peak);
        if stated.is_some() { colors.stated_by("nclx") } else { colors }
    };
    colors.notes = notes;
    colors
}

/// The meaning of code points; what is not stated is that of sRGB.
fn meaning(coding: Coding) -> Option<(Chromaticities, Transfer)> {
    if (coding.primaries, coding.transfer) == (2, 2) {
        return None;
    }
    let stated = |code, default| if code == 2 { default } else { code };
    Cicp { primaries: stated(coding.primaries, 1), transfer: stated(coding.transfer, 13) }.meaning()
}

impl Coding {
    /// The weights of its matrix; `None` for planes of RGB.
    ///
    /// # Errors
    /// A matrix of another kind.
    fn weights(self) -> Result<Option<Weights>, CodecError> {
        let of_primaries = || {
            let (primaries, _) = meaning(self).unwrap_or((Chromaticities::REC709, Transfer::Srgb));
            let luminance = primaries.to_xyz().row(1);
            Weights { red: luminance.x as f32, blue: luminance.z as f32 }
        };
        Ok(Some(match self.matrix {
            0 => return Ok(None),
            1 => Weights::BT709,
            // Of what is not stated, as libavif takes it.
            2 | 5 | 6 => Weights::BT601,
            7 => Weights::SMPTE240,
            9 => Weights::BT2020,
            12 => of_primaries(),
            other => return Err(container::unsupported(format!("its matrix of colors has the code {other}"))),
        }))
    }
}
