//! What `ffprobe` says of a film.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use afterimage_base::color::{Chromaticities, Colorimetry, Decimal, Transfer};

use super::ffmpeg::probe;
use super::timeline::Timeline;
use crate::codec::cicp::Cicp;
use crate::codec::signals::{Layout, Weights};
use crate::codec::{CodecError, Description, ErrorKind, no_layers};
use crate::files::{FileError, Source};

/// A film, described by its headers.
#[derive(Clone, Debug)]
pub struct Film {
    pub(super) path: PathBuf,
    /// Width and height of its frames as they are shown.
    pub size: (u32, u32),
    /// The times of its frames.
    pub times: Timeline,
    /// Bits of its samples.
    pub bits: u32,
    codec: String,
    /// True if it states all of its colors.
    states_color: bool,
    /// The width of a pixel to its height, as `ffmpeg` writes it.
    pub(super) aspect: Option<String>,
    /// The time code of its first frame; empty for none.
    pub(super) timecode: String,
    pub(super) layout: Layout,
    pub(super) weights: Weights,
    pub(super) color: (Chromaticities, Transfer),
    /// Sentences about what is assumed or left out.
    pub(super) notes: Vec<String>,
}

/// Codes of H.273 by the names that `ffprobe` prints.
const PRIMARIES: [(&str, u8); 8] = [
    ("bt709", 1),
    ("bt470bg", 5),
    ("smpte170m", 6),
    ("smpte240m", 7),
    ("bt2020", 9),
    ("smpte431", 11),
    ("smpte432", 12),
    ("unknown", 2),
];
const TRANSFERS: [(&str, u8); 12] = [
    ("bt709", 1),
    ("bt470m", 4),
    ("bt470bg", 5),
    ("smpte170m", 6),
    ("smpte240m", 7),
    ("linear", 8),
    ("iec61966-2-1", 13),
    ("bt2020-10", 14),
    ("bt2020-12", 15),
    ("smpte2084", 16),
    ("arib-std-b67", 18),
    ("unknown", 2),
];

/// The function of a display for SDR video (ITU-R BT.1886 with a black of 0).
pub(super) const DISPLAY: Transfer = Transfer::Gamma(Decimal::new(2.4));

impl Film {
    /// Asks `ffprobe` for the headers of a film, and for the times of all frames.
    ///
    /// # Errors
    /// There is no such file or no such program, the file has no film, or one that cannot be converted; a layer is
    /// named.
    pub fn open(source: &Source) -> Result<Self, FileError> {
        source.open()?;
        let path = &*source.path;
        let at = |error: CodecError| FileError::at(path, error);
        if let Some(layer) = &source.layer {
            return Err(at(no_layers(layer)));
        }
        let entries = "stream=codec_name,width,height,pix_fmt,time_base,color_range,color_space,color_transfer,\
                       color_primaries,field_order,sample_aspect_ratio,r_frame_rate,avg_frame_rate:\
                       stream_side_data=rotation:stream_tags=timecode,TIMECODE:format_tags=timecode,TIMECODE:\
                       format=start_time";
        let text =
            probe(path, &["-select_streams", "v:0", "-show_entries", entries, "-of", "default=noprint_wrappers=1"])?;
        let stated = Stated::of(&text);
        let (width, height) = stated.size().ok_or_else(|| at(unsupported("it has no pictures")))?;
        if !matches!(stated.get("field_order"), "progressive" | "unknown" | "") {
            return Err(at(unsupported("its frames are made of two fields").hint(
                "make whole frames of them first: `ffmpeg -i IN -vf bwdif -c:v prores_ks -profile:v hq OUT.mov`",
            )));
        }
        let mut notes = Vec::new();
        let layout = stated.layout().map_err(at)?;
        let weights = stated.weights(height, layout, &mut notes).map_err(at)?;
        let assumed = notes.len();
        let color = stated.color(&mut notes).map_err(at)?;
        let states_color = notes.len() == assumed;
        if ["yuva", "rgba", "bgra", "argb", "abgr", "gbrap", "ya"]
            .iter()
            .any(|alpha| stated.get("pix_fmt").contains(alpha))
        {
            notes.push("the alpha of its frames is left out".to_owned());
        }
        let times = times(path, &stated)?;
        let turned = stated.get("rotation").parse().is_ok_and(|degrees: f64| (degrees / 90.0).round() % 2.0 != 0.0);
        let size = if turned { (height, width) } else { (width, height) };
        let aspect = Some(stated.get("sample_aspect_ratio")).filter(|aspect| !matches!(*aspect, "" | "N/A" | "0:1"));
        let timecodes = ["TAG:timecode", "TAG:TIMECODE"].map(|tag| stated.get(tag));
        let timecode = timecodes.into_iter().find(|text| !text.is_empty()).unwrap_or_default().to_owned();
        let (bits, aspect) = (layout.bits, aspect.map(|aspect| aspect.replace(':', "/")));
        let (path, codec) = (path.into(), stated.get("codec_name").to_owned());
        Ok(Self { path, size, times, bits, codec, states_color, aspect, timecode, layout, weights, color, notes })
    }

    /// Its headers, described as those of images are.
    pub fn description(&self) -> Description {
        let samples = match self.bits {
            8 => "8 bits",
            10 => "10 bits",
            12 => "12 bits",
            _ => "16 bits",
        };
        let (primaries, transfer) = self.color;
        let seconds = self.times.frame_seconds() * self.times.frames() as f64;
        Description {
            color: Some(Colorimetry::new(primaries, transfer)),
            stated_by: self.states_color.then_some("color_primaries"),
            notes: self.notes.clone(),
            film: Some((self.times.frames(), seconds)),
            ..Description::of_picture("film", self.size, &["R", "G", "B"], samples, &self.codec)
        }
    }
}

/// Names and values, one a line.
struct Stated<'a>(BTreeMap<&'a str, &'a str>);

impl<'a> Stated<'a> {
    fn of(text: &'a str) -> Self {
        Self(text.lines().filter_map(|line| line.trim().split_once('=')).collect())
    }

    /// An empty text for what is not stated.
    fn get(&self, name: &str) -> &'a str {
        self.0.get(name).copied().unwrap_or_default()
    }

    /// Two numbers above 0.
    fn fraction(&self, name: &str) -> Option<(u64, u64)> {
        let (above, below) = self.get(name).split_once('/')?;
        let (above, below) = (above.parse().ok()?, below.parse().ok()?);
        (above > 0 && below > 0).then_some((above, below))
    }

    fn size(&self) -> Option<(u32, u32)> {
        let side = |name| self.get(name).parse().ok().filter(|side| *side > 0);
        Some((side("width")?, side("height")?))
    }

    /// The samples in which frames are asked for: those of the film, in planes of full size.
    fn layout(&self) -> Result<Layout, CodecError> {
        let samples = self.get("pix_fmt");
        if samples.starts_with("xyz") || ["bayer", "f32", "f16"].iter().any(|other| samples.contains(other)) {
            return Err(unsupported(format!("its samples are `{samples}`")));
        }
        let is_rgb = ["rgb", "bgr", "gbr", "argb", "abgr", "0rgb", "0bgr", "x2rgb", "x2bgr", "pal8"]
            .iter()
            .any(|start| samples.starts_with(start));
        let digits: String = samples.chars().rev().skip_while(|c| !c.is_ascii_digit()).collect();
        let digits: String = digits.chars().take_while(char::is_ascii_digit).collect();
        let number: u32 = digits.chars().rev().collect::<String>().parse().unwrap_or(8);
        let bits = match number {
            // Of all channels together.
            30 => 10,
            48 | 64 => 16,
            _ if samples.starts_with("nv") => 8 + 2 * u32::from(samples.starts_with("nv20")),
            9..=10 | 210 | 410 => 10,
            11..=12 | 212 | 412 | 36 => 12,
            13..=16 | 216 | 416 => 16,
            _ => 8,
        };
        Ok(Layout { bits, is_rgb, is_narrow: !is_rgb && self.get("color_range") != "pc" && !samples.contains("yuvj") })
    }

    fn weights(&self, height: u32, layout: Layout, notes: &mut Vec<String>) -> Result<Weights, CodecError> {
        match self.get("color_space") {
            _ if layout.is_rgb => Ok(Weights::BT709),
            "bt709" => Ok(Weights::BT709),
            "smpte170m" | "bt470bg" => Ok(Weights::BT601),
            "smpte240m" => Ok(Weights::SMPTE240),
            "bt2020nc" => Ok(Weights::BT2020),
            "unknown" | "" | "unspecified" => {
                let (weights, name) =
                    if height < 720 { (Weights::BT601, "BT.601") } else { (Weights::BT709, "BT.709") };
                notes.push(format!("it states no matrix of colors; that of {name} is taken"));
                Ok(weights)
            }
            other => Err(unsupported(format!("its matrix of colors is `{other}`"))),
        }
    }

    fn color(&self, notes: &mut Vec<String>) -> Result<(Chromaticities, Transfer), CodecError> {
        let code = |name: &str, known: &[(&str, u8)]| {
            let stated = self.get(name);
            let code = known.iter().find(|(name, _)| *name == stated || stated.is_empty() && *name == "unknown");
            code.map(|(_, code)| *code)
                .ok_or_else(|| unsupported(format!("its {} is `{stated}`", name.replace('_', " "))))
        };
        let (primaries, transfer) = (code("color_primaries", &PRIMARIES)?, code("color_transfer", &TRANSFERS)?);
        if primaries == 2 || transfer == 2 {
            notes.push(
                "it does not state all of its colors; the rest is taken as BT.709; `--input-space` states them".into(),
            );
        }
        // Of what is not stated, and of cameras for SDR, the display decides.
        let is_of_display = matches!(transfer, 1 | 2 | 6 | 7 | 14 | 15);
        let known = Cicp {
            primaries: if primaries == 2 { 1 } else { primaries },
            transfer: if is_of_display { 13 } else { transfer },
        };
        let (primaries, transfer) = known.meaning().ok_or_else(|| unsupported("its colors are not known"))?;
        Ok((primaries, if is_of_display { DISPLAY } else { transfer }))
    }
}

/// The number of frames that a film has and shows.
pub(super) fn count_frames(path: &Path) -> Result<usize, FileError> {
    Ok(frame_times(path)?.len())
}

/// The time of each frame that is shown, as `ffprobe` writes it.
fn frame_times(path: &Path) -> Result<Vec<String>, FileError> {
    let text = probe(path, &["-select_streams", "v:0", "-show_entries", "packet=pts,flags", "-of", "csv=p=0"])?;
    // A packet with D is decoded and not shown.
    let shown = text.lines().filter_map(|line| line.split_once(',')).filter(|(_, flags)| !flags.contains('D'));
    Ok(shown.map(|(time, _)| time.to_owned()).collect())
}

/// The times of all frames that are shown.
fn times(path: &Path, stated: &Stated<'_>) -> Result<Timeline, FileError> {
    let broken = |what: &str| FileError::new(path, ErrorKind::Broken, what);
    let tick = stated.fraction("time_base").ok_or_else(|| broken("it has no times"))?;
    let ticks = frame_times(path)?.iter().map(|time| time.parse().ok()).collect::<Option<Vec<i64>>>();
    let mut ticks = ticks.filter(|ticks| !ticks.is_empty()).ok_or_else(|| broken("its frames have no times"))?;
    ticks.sort_unstable();
    let start = stated.get("start_time").parse().unwrap_or(0.0);
    let rates: Vec<_> = ["r_frame_rate", "avg_frame_rate"].iter().filter_map(|name| stated.fraction(name)).collect();
    Ok(Timeline::of_film(tick, ticks, start, &rates))
}

fn unsupported(what: impl Into<String>) -> CodecError {
    CodecError::new(ErrorKind::Unsupported, what)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_are_asked_for_in_the_bits_of_the_film() {
        for (samples, name) in [
            ("yuv420p", "yuv444p"),
            ("yuvj420p", "yuv444p"),
            ("nv12", "yuv444p"),
            ("yuv422p10le", "yuv444p10le"),
            ("yuva444p12le", "yuv444p12le"),
            ("p010le", "yuv444p10le"),
            ("yuv444p16le", "yuv444p16le"),
            ("gray", "yuv444p"),
            ("gray10le", "yuv444p10le"),
            ("rgb24", "gbrp"),
            ("bgra", "gbrp"),
            ("rgb48le", "gbrp16le"),
            ("rgba64be", "gbrp16le"),
            ("gbrp12le", "gbrp12le"),
            ("x2rgb10le", "gbrp10le"),
        ] {
            let text = format!("pix_fmt={samples}\n");
            assert_eq!(Stated::of(&text).layout().expect("it is known").name(), name, "{samples}");
        }
        assert!(Stated::of("pix_fmt=gbrpf32le").layout().is_err());
    }

    #[test]
    fn colors_are_those_that_are_stated() {
        let color = |text: &str| {
            let mut notes = Vec::new();
            (Stated::of(text).color(&mut notes).expect("they are known"), notes.len())
        };
        let all = |primaries: &str, transfer: &str| format!("color_primaries={primaries}\ncolor_transfer={transfer}");
        assert_eq!(color(&all("bt709", "bt709")), ((Chromaticities::REC709, DISPLAY), 0));
        assert_eq!(color(&all("bt2020", "smpte2084")), ((Chromaticities::REC2020, Transfer::Pq), 0));
        assert_eq!(color(&all("bt2020", "arib-std-b67")), ((Chromaticities::REC2020, Transfer::Hlg), 0));
        assert_eq!(color(&all("smpte432", "iec61966-2-1")), ((Chromaticities::DISPLAY_P3, Transfer::Srgb), 0));
        assert_eq!(color(&all("unknown", "unknown")), ((Chromaticities::REC709, DISPLAY), 1));
        assert_eq!(color(""), ((Chromaticities::REC709, DISPLAY), 1));
        assert!(Stated::of(&all("film", "bt709")).color(&mut Vec::new()).is_err());
    }
}
