//! The boxes of an AVIF: ISO/IEC 14496-12 and 23008-12, and the AV1 Image File Format.

use super::boxes::Bytes;
use crate::codec::orientation::Orientation;
use crate::codec::{CodecError, ErrorKind};

/// Most pictures and parts of pictures in a file. Grids of tiles have some hundred.
const MOST_ITEMS: usize = 1024;

const ALPHA: [&[u8]; 2] = [b"urn:mpeg:mpegB:cicp:systems:auxiliary:alpha\0", b"urn:mpeg:hevc:2015:auxid:1\0"];

/// The picture of a file.
pub(super) struct Container<'a> {
    /// Width and height of the coded frame.
    pub(super) size: (u32, u32),
    /// Bits of a sample.
    pub(super) bits: u32,
    /// AV1 data of the color.
    pub(super) color: Vec<u8>,
    /// AV1 data of the alpha.
    pub(super) alpha: Option<Vec<u8>>,
    /// True if the codes of the color are multiplied by the alpha.
    pub(super) is_premultiplied: bool,
    /// Code points of H.273, if the file states them.
    pub(super) cicp: Option<Coding>,
    pub(super) profile: Option<&'a [u8]>,
    /// The peak of the mastering display in cd/m2.
    pub(super) peak: Option<f64>,
    /// The orientation by which the picture is turned upright.
    pub(super) orientation: Option<Orientation>,
    pub(super) notes: Vec<String>,
}

/// Code points of H.273.
#[derive(Clone, Copy)]
pub(super) struct Coding {
    pub(super) primaries: u8,
    pub(super) transfer: u8,
    pub(super) matrix: u8,
    pub(super) is_full: bool,
}

/// An item: a picture or a part of one.
#[derive(Default)]
struct Item<'a> {
    id: u64,
    kind: [u8; 4],
    /// True if `extents` count within the box of small data, and not within the file.
    is_inside: bool,
    extents: Vec<(u64, u64)>,
    /// Boxes that describe it, each with true if readers must know it.
    properties: Vec<([u8; 4], Bytes<'a>, bool)>,
}

/// The items of a file.
struct Items<'a> {
    file: &'a [u8],
    /// The box of small data.
    data: &'a [u8],
    primary: u64,
    all: Vec<Item<'a>>,
    /// References between items: the kind, the one that refers, and the other one.
    references: Vec<([u8; 4], u64, u64)>,
}

impl<'a> Container<'a> {
    pub(super) fn read(file: &'a [u8]) -> Result<Self, CodecError> {
        let items = Items::read(file)?;
        let item = items.get(items.primary).ok_or_else(|| CodecError::broken("it has no main picture"))?;
        match &item.kind {
            b"av01" => {}
            b"grid" | b"iovl" | b"iden" | b"tmap" => {
                return Err(unsupported("this AVIF is put together of several pictures"));
            }
            _ => return Err(unsupported("this file holds no AV1 picture")),
        }
        let size = item.property(b"ispe").map(|mut size| {
            size.skip(4)?;
            Ok((size.number(4)? as u32, size.number(4)? as u32))
        });
        let size = size.unwrap_or_else(|| Err(CodecError::broken("it states no size")))?;
        let mut configuration = item.property(b"av1C").ok_or_else(|| CodecError::broken("it states no bits"))?;
        configuration.skip(2)?;
        let bits = match configuration.number(1)? & 0b0110_0000 {
            0b0110_0000 => 12,
            0b0100_0000 => 10,
            _ => 8,
        };
        let mut notes = Vec::new();
        let orientation = item.orientation(&mut notes)?;
        let (mut cicp, mut profile) = (None, None);
        for mut colors in item.all_properties(b"colr") {
            match &colors.name()? {
                b"nclx" => {
                    let [primaries, transfer, matrix] = [colors.number(2)?, colors.number(2)?, colors.number(2)?]
                        .map(|code| u8::try_from(code).unwrap_or(u8::MAX));
                    cicp = Some(Coding { primaries, transfer, matrix, is_full: colors.number(1)? >= 128 });
                }
                b"prof" | b"rICC" => profile = Some(colors.rest()),
                _ => {}
            }
        }
        // Eight coordinates, and the peak in steps of 0.0001 cd/m2.
        let peak = item.property(b"mdcv").map(|mut display| display.skip(16).and_then(|()| display.number(4)));
        let peak = peak.transpose()?.map(|peak| peak as f64 / 1e4).filter(|peak| *peak > 0.0);
        let alpha = items.alpha()?;
        let is_premultiplied = items.references.iter().any(|(kind, from, _)| kind == b"prem" && *from == item.id);
        let (color, alpha) = (items.bytes(item)?, alpha.map(|alpha| items.bytes(alpha)).transpose()?);
        if file.get(8..12) == Some(b"avis") {
            notes.push("it is an animation; only its first picture is read".to_owned());
        }
        Ok(Self { size, bits, color, alpha, is_premultiplied, cicp, profile, peak, orientation, notes })
    }
}

impl<'a> Item<'a> {
    fn all_properties(&self, name: &[u8; 4]) -> impl Iterator<Item = Bytes<'a>> {
        self.properties.iter().filter(move |(kind, _, _)| kind == name).map(|(_, bytes, _)| bytes.clone())
    }

    fn property(&self, name: &[u8; 4]) -> Option<Bytes<'a>> {
        self.all_properties(name).next()
    }

    /// The orientation of the rotation and the mirror of a picture. Notes what is not applied.
    ///
    /// # Errors
    /// A property that readers must know is not known here.
    fn orientation(&self, notes: &mut Vec<String>) -> Result<Option<Orientation>, CodecError> {
        const KNOWN: [&[u8; 4]; 13] = [
            b"ispe", b"pixi", b"av1C", b"colr", b"auxC", b"irot", b"imir", b"clap", b"pasp", b"mdcv", b"clli", b"lsel",
            b"a1op",
        ];
        if let Some((kind, _, _)) = self.properties.iter().find(|(kind, _, must)| *must && !KNOWN.contains(&kind)) {
            let kind = String::from_utf8_lossy(kind);
            return Err(unsupported(format!("this AVIF has the property `{kind}`, which readers must know")));
        }
        if self.property(b"clap").is_some() {
            notes.push("it is not cut to its clean aperture".to_owned());
        }
        let number = |name| self.property(name).map(|mut bytes| bytes.number(1)).transpose();
        let (turns, axis) = (number(b"irot")?.map_or(0, |turns| turns & 3), number(b"imir")?.map(|axis| axis & 1));
        // Quarter turns against the clock, and then a mirror: 0 swaps the top and the bottom, 1 the sides.
        let code = match (turns, axis) {
            (0, None) => 1,
            (1, None) => 8,
            (2, None) => 3,
            (_, None) => 6,
            (0, Some(1)) | (2, Some(0)) => 2,
            (0, Some(_)) | (2, Some(_)) => 4,
            (1, Some(1)) | (3, Some(0)) => 7,
            (_, Some(_)) => 5,
        };
        Ok(Orientation::of_code(code))
    }
}

impl<'a> Items<'a> {
    fn read(file: &'a [u8]) -> Result<Self, CodecError> {
        let mut boxes = Bytes(file);
        let mut meta = loop {
            match boxes.next_box()? {
                Some((kind, inside)) if kind == *b"meta" => break inside,
                Some(_) => {}
                None => return Err(CodecError::broken("it has no pictures")),
            }
        };
        meta.skip(4)?;
        let mut items = Self { file, data: &[], primary: 0, all: Vec::new(), references: Vec::new() };
        let (mut locations, mut properties) = (None, None);
        while let Some((kind, mut inside)) = meta.next_box()? {
            match &kind {
                b"pitm" => {
                    let version = inside.version()?;
                    items.primary = inside.number(if version == 0 { 2 } else { 4 })?;
                }
                b"iinf" => items.read_kinds(inside)?,
                b"iloc" => locations = Some(inside),
                b"iprp" => properties = Some(inside),
                b"iref" => items.read_references(inside)?,
                b"idat" => items.data = inside.rest(),
                _ => {}
            }
        }
        if let Some(locations) = locations {
            items.read_locations(locations)?;
        }
        if let Some(properties) = properties {
            items.read_properties(properties)?;
        }
        Ok(items)
    }

    fn get(&self, id: u64) -> Option<&Item<'a>> {
        self.all.iter().find(|item| item.id == id)
    }

    fn get_mut(&mut self, id: u64) -> Option<&mut Item<'a>> {
        self.all.iter_mut().find(|item| item.id == id)
    }

    /// The alpha of the main picture.
    fn alpha(&self) -> Result<Option<&Item<'a>>, CodecError> {
        for (kind, from, to) in &self.references {
            let Some(item) = self.get(*from).filter(|_| kind == b"auxl" && *to == self.primary) else { continue };
            let Some(mut auxiliary) = item.property(b"auxC") else { continue };
            auxiliary.skip(4)?;
            let name = auxiliary.rest();
            if ALPHA.iter().any(|alpha| name.starts_with(alpha)) {
                return Ok(Some(item));
            }
        }
        Ok(None)
    }

    /// The data of an item, which are not more than those of the file.
    fn bytes(&self, item: &Item<'_>) -> Result<Vec<u8>, CodecError> {
        let from = if item.is_inside { self.data } else { self.file };
        let mut bytes = Vec::new();
        for (start, length) in &item.extents {
            let start = usize::try_from(*start).map_err(|_| CodecError::cut_short())?;
            let rest = from.get(start..).ok_or_else(CodecError::cut_short)?;
            // 0 is the whole rest.
            let length = if *length == 0 { rest.len() } else { usize::try_from(*length).unwrap_or(usize::MAX) };
            bytes.extend(rest.get(..length).ok_or_else(CodecError::cut_short)?);
            if bytes.len() > self.file.len() {
                return Err(CodecError::broken("its pictures are longer than the file"));
            }
        }
        if bytes.is_empty() { Err(CodecError::broken("its picture has no data")) } else { Ok(bytes) }
    }

    fn read_kinds(&mut self, mut bytes: Bytes<'a>) -> Result<(), CodecError> {
        let version = bytes.version()?;
        bytes.number(if version == 0 { 2 } else { 4 })?;
        while let Some((kind, mut entry)) = bytes.next_box()? {
            let version = entry.version()?;
            if kind != *b"infe" || version < 2 {
                continue;
            }
            if self.all.len() == MOST_ITEMS {
                return Err(unsupported(format!("this AVIF has more than {MOST_ITEMS} pictures and parts")));
            }
            let id = entry.number(if version == 2 { 2 } else { 4 })?;
            entry.skip(2)?;
            self.all.push(Item { id, kind: entry.name()?, ..Item::default() });
        }
        Ok(())
    }

    fn read_locations(&mut self, mut bytes: Bytes<'a>) -> Result<(), CodecError> {
        let version = bytes.version()?;
        let sizes = bytes.number(2)? as usize;
        let [offset, length, base, index] = [12, 8, 4, 0].map(|shift| sizes >> shift & 15);
        let index = if version == 0 { 0 } else { index };
        let count = bytes.number(if version < 2 { 2 } else { 4 })?;
        for _ in 0..count {
            let id = bytes.number(if version < 2 { 2 } else { 4 })?;
            let method = if version == 0 { 0 } else { bytes.number(2)? & 15 };
            let file = bytes.number(2)?;
            let base = bytes.number(base)?;
            let mut extents = Vec::new();
            for _ in 0..bytes.number(2)? {
                bytes.number(index)?;
                let start = base.checked_add(bytes.number(offset)?).ok_or_else(CodecError::cut_short)?;
                extents.push((start, bytes.number(length)?));
            }
            let Some(item) = self.get_mut(id) else { continue };
            if file != 0 || method > 1 {
                return Err(unsupported("this AVIF has pictures in other files or items"));
            }
            (item.is_inside, item.extents) = (method == 1, extents);
        }
        Ok(())
    }

    fn read_properties(&mut self, mut bytes: Bytes<'a>) -> Result<(), CodecError> {
        let mut all = Vec::new();
        while let Some((kind, mut inside)) = bytes.next_box()? {
            if kind == *b"ipco" {
                while let Some(property) = inside.next_box()? {
                    all.push(property);
                }
            } else if kind == *b"ipma" {
                let flags = inside.number(4)?;
                for _ in 0..inside.number(4)? {
                    let id = inside.number(if flags >> 24 == 0 { 2 } else { 4 })?;
                    let count = inside.number(1)?;
                    let mut properties = Vec::new();
                    for _ in 0..count {
                        let size = if flags & 1 == 1 { 2 } else { 1 };
                        let entry = inside.number(size)?;
                        let must = 1 << (8 * size - 1);
                        let index = (entry & (must - 1)) as usize;
                        if let Some((kind, property)) = index.checked_sub(1).and_then(|index| all.get(index)) {
                            properties.push((*kind, property.clone(), entry & must != 0));
                        }
                    }
                    if let Some(item) = self.get_mut(id) {
                        item.properties = properties;
                    }
                }
            }
        }
        Ok(())
    }

    fn read_references(&mut self, mut bytes: Bytes<'a>) -> Result<(), CodecError> {
        let size = if bytes.version()? == 0 { 2 } else { 4 };
        while let Some((kind, mut inside)) = bytes.next_box()? {
            let from = inside.number(size)?;
            for _ in 0..inside.number(2)? {
                let to = inside.number(size)?;
                if matches!(&kind, b"auxl" | b"prem") && self.references.len() < MOST_ITEMS {
                    self.references.push((kind, from, to));
                }
            }
        }
        Ok(())
    }
}

pub(super) fn unsupported(what: impl Into<String>) -> CodecError {
    CodecError::new(ErrorKind::Unsupported, what).hint("convert it: `avifdec --depth 16 IN.avif OUT.png`")
}
