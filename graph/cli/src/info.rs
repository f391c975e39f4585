//! `afterimage info`: what files state about their pictures, from their headers, and the range of their numbers.

use afterimage_graph::color::Colorimetry;
use afterimage_media::film::{Film, is_film};
use afterimage_media::{
    ChannelDescription, ChannelStatistics, Description, PartDescription, Source, Window, read_description,
    read_statistics, sequence,
};
use serde_json::{Value, json};

use crate::args::InfoArgs;
use crate::failure::Failure;
use crate::render::tell_other_numbers;
use crate::terminal::{say, say_text};

/// The numbers of the channels of each part; nothing if they were not asked for.
type Numbers = [Vec<ChannelStatistics>];

/// Describes all files; one that cannot be read is reported, and the others are described.
pub(crate) fn run(args: &InfoArgs) -> Result<(), Failure> {
    let mut sources = Vec::new();
    for file in &args.files {
        sources.extend(sequence::Input::find(file, None)?.sources().into_iter().map(|(_, source)| source));
        tell_other_numbers(file);
    }
    let (mut objects, mut status) = (Vec::new(), 0);
    for source in &sources {
        let described = match is_film(&source.path) {
            true => Film::open(source).map(|film| film.description()),
            false => read_description(source),
        };
        let described = described.and_then(|description| {
            let read = || read_statistics(source, &description, args.images.budget());
            let numbers = if args.pixels { read()? } else { Vec::new() };
            Ok((description, numbers))
        });
        match described {
            Ok((description, numbers)) if args.json => objects.push(as_json(source, &description, &numbers)),
            Ok((description, numbers)) => lines(source, &description, &numbers).iter().for_each(|line| say(line)),
            Err(error) => {
                let failure = Failure::from(error);
                failure.print();
                status = status.max(failure.status());
            }
        }
    }
    if args.json {
        say_text(&format!("{:#}", Value::from(objects)));
    }
    if status > 0 { Err(Failure::Printed { status }) } else { Ok(()) }
}

/// One line for the file, one for each part, and one for each note.
fn lines(source: &Source, description: &Description, numbers: &Numbers) -> Vec<String> {
    let Description { format, parts, picture, color, stated_by, notes, film, layers: _ } = description;
    let mut lines = vec![format!("{}: {format}", source.path.display())];
    for (index, part) in parts.iter().enumerate() {
        let name = part.name.as_ref().map_or(String::new(), |name| format!(" `{name}`"));
        let number = if parts.len() > 1 { format!("part {index}{name}: ") } else { String::new() };
        lines.push(format!("  {number}{}", part_text(part, *film)));
        let numbers = numbers.get(index).into_iter().flatten();
        lines.extend(part.channels.iter().zip(numbers).map(|(channel, of)| numbers_text(&channel.name, of)));
    }
    lines.push(match picture {
        Some(picture) if parts.len() > 1 => format!("  read: {} of part {}", picture.channels.join(", "), picture.part),
        Some(picture) => format!("  read: {}", picture.channels.join(", ")),
        None => "  read: nothing, unless a channel is named after `#`".to_owned(),
    });
    let why = stated_by.map_or_else(|| "assumed, because nothing states it".to_owned(), |what| format!("by `{what}`"));
    lines.push(match color {
        Some(color) => format!("  color: {}, {why}", color_text(color)),
        None if stated_by.is_some() => format!("  color: as in its profile, {why}"),
        None => "  color: none, plain numbers".to_owned(),
    });
    lines.extend(notes.iter().map(|note| format!("  note: {note}")));
    lines
}

/// `    Z: 0.1 to 20, 3 NaN, 2 infinite`.
fn numbers_text(name: &str, numbers: &ChannelStatistics) -> String {
    let range = numbers.range.map(|[least, most]| format!("{} to {}", number(least), number(most)));
    let mut words = vec![range.unwrap_or_else(|| "no finite number".to_owned())];
    words.extend((numbers.nan > 0).then(|| format!("{} NaN", numbers.nan)));
    words.extend((numbers.infinite > 0).then(|| format!("{} infinite", numbers.infinite)));
    format!("    {name}: {}", words.join(", "))
}

/// Integers as they are, others with the digits of a 32-bit float.
fn number(value: f64) -> String {
    match value.abs() {
        size if value.fract() == 0.0 && size < 1e10 => value.to_string(),
        1e-3..1e7 => (value as f32).to_string(),
        _ => format!("{:e}", value as f32),
    }
}

fn part_text(part: &PartDescription, film: Option<(usize, f64)>) -> String {
    let PartDescription { display, data, channels, compression, tiles, .. } = part;
    let mut words = vec![format!("{}x{}", display.width, display.height)];
    if data != display {
        words.push(format!("data {}", window_text(data)));
        words.push(format!("display {}", window_text(display)));
    }
    words.push(channels_text(channels));
    words.push(compression.clone());
    words.push(match (film, tiles) {
        (Some((frames, seconds)), _) => format!("{frames} frames in {seconds:.3} s"),
        (None, Some([width, height])) => format!("tiles of {width}x{height}"),
        (None, None) => "rows".to_owned(),
    });
    words.join(", ")
}

/// `96x54+8-4`: columns and rows, and the first of each.
fn window_text(window: &Window) -> String {
    format!("{}x{}{:+}{:+}", window.width, window.height, window.x, window.y)
}

/// Channels with equal samples together: `R G B (half)`.
fn channels_text(channels: &[ChannelDescription]) -> String {
    let mut groups = Vec::new();
    for group in channels.chunk_by(|a, b| a.samples == b.samples) {
        let names: Vec<&str> = group.iter().map(|channel| channel.name.as_str()).collect();
        groups.push(format!("{} ({})", names.join(" "), group[0].samples));
    }
    groups.join(" ")
}

fn color_text(color: &Colorimetry) -> String {
    let mut words = vec![color.transfer.to_string(), color.primaries.name().unwrap_or("other primaries").to_owned()];
    words.extend(color.white_nits.map(|nits| format!("white at {nits} cd/m2")));
    words.extend(color.peak_nits.map(|nits| format!("peak at {nits} cd/m2")));
    words.extend(color.adopted_white.map(|white| format!("adapted to x {} y {}", white.x, white.y)));
    words.join(", ")
}

fn as_json(source: &Source, description: &Description, numbers: &Numbers) -> Value {
    let Description { format, parts, picture, color, stated_by, notes, film, layers: _ } = description;
    let window = |window: &Window| json!([window.x, window.y, window.width, window.height]);
    let channel = |channel: &ChannelDescription, numbers: Option<&ChannelStatistics>| {
        let mut object = json!({ "name": channel.name, "samples": channel.samples });
        if let Some(ChannelStatistics { range, nan, infinite }) = numbers {
            (object["range"], object["nan"], object["infinite"]) = (json!(range), json!(nan), json!(infinite));
        }
        object
    };
    let part = |(index, part): (usize, &PartDescription)| {
        let of = |at: usize| numbers.get(index).and_then(|part| part.get(at));
        let channels = part.channels.iter().enumerate().map(|(at, known)| channel(known, of(at)));
        json!({
            "channels": channels.collect::<Value>(),
            "compression": part.compression,
            "data": window(&part.data),
            "display": window(&part.display),
            "name": part.name,
            "tiles": part.tiles,
        })
    };
    let color = color.map(|color| {
        json!({
            "adopted_white": color.adopted_white.map(|white| white.to_vec().to_array()),
            "chromaticities": color.primaries.points().map(|point| point.to_vec().to_array()),
            "peak_nits": color.peak_nits.map(|nits| nits.get()),
            "primaries": color.primaries.name(),
            "transfer": color.transfer.to_string(),
            "white_nits": color.white_nits.map(|nits| nits.get()),
        })
    });
    json!({
        "color": color,
        "file": source.path.display().to_string(),
        "format": format,
        "frames": film.map(|(frames, _)| frames),
        "notes": notes,
        "parts": parts.iter().enumerate().map(part).collect::<Value>(),
        "seconds": film.map(|(_, seconds)| seconds),
        "picture": picture.as_ref().map(|picture| json!({ "channels": picture.channels, "part": picture.part })),
        "stated_by": stated_by,
    })
}
