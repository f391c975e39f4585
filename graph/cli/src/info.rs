//! `afterimage info`: what files state about their pictures, from their headers alone.

use afterimage_graph::color::Colorimetry;
use afterimage_media::{ChannelDescription, Description, PartDescription, Source, Window, read_description, sequence};
use serde_json::{Value, json};

use crate::args::InfoArgs;
use crate::failure::Failure;
use crate::terminal::say;

/// Describes all files; one that cannot be read is reported, and the others are described.
pub(crate) fn run(args: &InfoArgs) -> Result<(), Failure> {
    let mut sources = Vec::new();
    for file in &args.files {
        sources.extend(sequence::Input::find(file, None)?.sources().into_iter().map(|(_, source)| source));
    }
    let (mut objects, mut failed) = (Vec::new(), 0);
    for source in &sources {
        match read_description(source) {
            Ok(description) if args.json => objects.push(as_json(source, &description)),
            Ok(description) => say(&text(source, &description)),
            Err(error) => {
                failed += 1;
                Failure::from(error).print();
            }
        }
    }
    if args.json {
        say(&format!("{:#}", Value::from(objects)));
    }
    if failed > 0 { Err(Failure::Printed { status: 1 }) } else { Ok(()) }
}

/// One line for the file, one for each part, and one for each note.
fn text(source: &Source, description: &Description) -> String {
    let Description { format, parts, picture, color, stated_by, notes } = description;
    let mut lines = vec![format!("{}: {format}", source.path.display())];
    for (index, part) in parts.iter().enumerate() {
        let name = part.name.as_ref().map_or(String::new(), |name| format!(" `{name}`"));
        let number = if parts.len() > 1 { format!("part {index}{name}: ") } else { String::new() };
        lines.push(format!("  {number}{}", part_text(part)));
    }
    lines.push(match picture {
        Some(picture) if parts.len() > 1 => format!("  read: {} of part {}", picture.channels.join(", "), picture.part),
        Some(picture) => format!("  read: {}", picture.channels.join(", ")),
        None => "  read: nothing, unless a channel is named after `#`".to_owned(),
    });
    let why = stated_by.map_or_else(|| "assumed, because nothing states it".to_owned(), |what| format!("by `{what}`"));
    lines.push(match color {
        Some(color) => format!("  color: {}, {why}", color_text(color)),
        None => "  color: none, plain numbers".to_owned(),
    });
    lines.extend(notes.iter().map(|note| format!("  note: {note}")));
    lines.join("\n")
}

fn part_text(part: &PartDescription) -> String {
    let PartDescription { display, data, channels, compression, tiles, .. } = part;
    let mut words = vec![format!("{}x{}", display.width, display.height)];
    if data != display {
        words.push(format!("data {}", window_text(data)));
        words.push(format!("display {}", window_text(display)));
    }
    words.push(channels_text(channels));
    words.push(compression.clone());
    words.push(tiles.map_or("rows".to_owned(), |[width, height]| format!("tiles of {width}x{height}")));
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

fn as_json(source: &Source, description: &Description) -> Value {
    let Description { format, parts, picture, color, stated_by, notes } = description;
    let window = |window: &Window| json!([window.x, window.y, window.width, window.height]);
    let channel = |channel: &ChannelDescription| json!({ "name": channel.name, "samples": channel.samples });
    let part = |part: &PartDescription| {
        json!({
            "channels": part.channels.iter().map(channel).collect::<Value>(),
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
        "notes": notes,
        "parts": parts.iter().map(part).collect::<Value>(),
        "picture": picture.as_ref().map(|picture| json!({ "channels": picture.channels, "part": picture.part })),
        "stated_by": stated_by,
    })
}
