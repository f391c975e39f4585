//! Descriptions of EXR files, from their headers.

use std::io::{Read, Seek};

use afterimage_base::color::{Chromaticities, Colorimetry};
use exr::meta::BlockDescription;
use exr::meta::attribute::{IntegerBounds, SampleType};
use exr::meta::header::Header;

use super::colors::{color_note, stated_color, stated_colors};
use super::label::{is_data, named_colors};
use super::read::{Opened, notes, open};
use super::select::{Choice, choose, names};
use super::text;
use crate::codec::codes::Colors;
use crate::codec::exr_compression::compression_name;
use crate::codec::{ChannelDescription, CodecError, Description, PartDescription, PictureChannels, Window};

/// Reads the headers of all parts. A file without a picture that could be chosen is described, too.
pub(crate) fn describe(reader: impl Read + Seek, layer: Option<&str>) -> Result<Description, CodecError> {
    let Opened { headers, .. } = open(reader)?;
    let headers = headers.as_slice();
    let parts = headers.iter().map(part).collect();
    let mut description = Description {
        format: "EXR",
        parts,
        picture: None,
        layers: names(headers),
        color: None,
        stated_by: None,
        notes: Vec::new(),
        film: None,
    };
    let choice = match choose(headers, layer) {
        Ok(choice) => choice,
        Err(error) if layer.is_some() => return Err(error),
        Err(_) => return Ok(description),
    };
    let header = &headers[choice.part];
    description.picture = Some(picture(header, &choice));
    description.notes = notes(headers, &choice, layer, header.shared_attributes.display_window);
    description.notes.extend(color_note(header, &choice));
    if choice.is_color && !is_data(header) {
        let stated = stated_colors(header, &choice)?;
        let color = stated.map(|stated| Colors::new(Some(stated), None));
        let color = color.and_then(|color| color.stated).map(|color| stated_color(header, color));
        description.color = Some(color.unwrap_or(Colorimetry::linear(Chromaticities::REC709)));
        let attribute = header.shared_attributes.chromaticities.map(|_| "chromaticities");
        let attribute = attribute.or_else(|| named_colors(header).map(|(.., attribute)| attribute));
        description.stated_by = attribute.filter(|_| stated.is_some());
    }
    Ok(description)
}

fn part(header: &Header) -> PartDescription {
    let name = header.own_attributes.layer_name.as_ref().map(text);
    let channels = header.channels.list.iter().map(|channel| ChannelDescription {
        name: text(&channel.name),
        samples: match channel.sample_type {
            SampleType::F16 => "half",
            SampleType::F32 => "float",
            SampleType::U32 => "uint",
        },
    });
    PartDescription {
        name: name.filter(|name| !name.is_empty()),
        display: window(header.shared_attributes.display_window),
        data: window(header.data_window()),
        channels: channels.collect(),
        compression: compression_name(header.compression).to_owned(),
        tiles: match header.blocks {
            BlockDescription::Tiles(tiles) => Some([tiles.tile_size.0 as u64, tiles.tile_size.1 as u64]),
            BlockDescription::ScanLines => None,
        },
    }
}

fn window(bounds: IntegerBounds) -> Window {
    let (at, size) = (bounds.position, bounds.size);
    Window { x: at.0, y: at.1, width: size.0 as u64, height: size.1 as u64 }
}

fn picture(header: &Header, choice: &Choice) -> PictureChannels {
    let mut channels: Vec<String> = Vec::new();
    for &slot in choice.slots.iter().flatten() {
        let name = text(&header.channels.list[slot].name);
        // Gray is one channel three times.
        if !channels.contains(&name) {
            channels.push(name);
        }
    }
    PictureChannels { part: choice.part, channels }
}
