//! The attributes of an EXR file as they are stored: names, types and bytes.
//!
//! The `exr` crate turns them into values and back, which changes some of them: it writes 24 of the 28 bytes of a key
//! code, sorts the corners of boxes, refuses time codes of 60 frames, and forgets what it cannot parse.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::io::{self, ErrorKind, Read};

use exr::meta::attribute::{AttributeValue, ChannelDescription, KeyCode, SampleType, Text, TextSlice};
use exr::meta::header::{Header, ImageAttributes, LayerAttributes, standard_names};
use exr::meta::magic_number;

/// The most bytes of a name (OpenEXR, "File Layout").
pub(super) const LONGEST_NAME: usize = 255;
const SHORT_NAME: usize = 31;
/// The flag of a file with long names, beside the version.
pub(super) const LONG_NAMES: u32 = 0x400;
/// The flag of a file of several parts.
const PARTS: u32 = 0x1000;

/// The attributes that the encoder makes for each part.
const STRUCTURE: [&[u8]; 15] = [
    standard_names::TILES,
    standard_names::BLOCK_TYPE,
    standard_names::DEEP_DATA_VERSION,
    standard_names::CHUNKS,
    standard_names::MAX_SAMPLES,
    standard_names::CHANNELS,
    standard_names::COMPRESSION,
    standard_names::DWA_COMPRESSION_LEVEL,
    standard_names::DATA_WINDOW,
    standard_names::DISPLAY_WINDOW,
    standard_names::LINE_ORDER,
    standard_names::PIXEL_ASPECT,
    standard_names::WINDOW_CENTER,
    standard_names::WINDOW_WIDTH,
    standard_names::NAME,
];

/// An attribute as it is stored.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Attribute {
    pub(super) name: Vec<u8>,
    pub(super) kind: Vec<u8>,
    pub(super) value: Vec<u8>,
}

/// The headers of a file, which end where the table of offsets begins.
#[derive(Clone, Debug)]
pub(super) struct Head {
    pub(super) version: u32,
    /// The attributes of each part.
    pub(super) parts: Vec<Vec<Attribute>>,
}

impl Head {
    /// Reads the attributes of all parts.
    ///
    /// # Errors
    /// Errors of reading, and an early end of the file.
    pub(super) fn read(mut from: impl Read) -> io::Result<Self> {
        let [_, version] = [read_word(&mut from)?, read_word(&mut from)?];
        let mut parts = Vec::new();
        loop {
            let mut attributes = Vec::new();
            while let Some(attribute) = Attribute::read(&mut from)? {
                attributes.push(attribute);
            }
            // Several parts end with an empty one.
            let is_last = attributes.is_empty() || version & PARTS == 0;
            parts.extend((!attributes.is_empty()).then_some(attributes));
            if is_last {
                return Ok(Self { version, parts });
            }
        }
    }

    /// The bytes of the headers, from the start of the file.
    pub(super) fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = [magic_number::BYTES, self.version.to_le_bytes()].concat();
        for part in &self.parts {
            for Attribute { name, kind, value } in part {
                bytes.extend([name, &[0][..], kind, &[0], &(value.len() as u32).to_le_bytes(), value].concat());
            }
            bytes.push(0);
        }
        bytes.extend((self.version & PARTS != 0).then_some(0));
        bytes
    }

    /// The value of an attribute of a part.
    pub(super) fn value(&self, part: usize, name: &[u8]) -> Option<&[u8]> {
        let found = self.parts.get(part)?.iter().find(|attribute| attribute.name == name)?;
        Some(&found.value)
    }

    /// The channels of a part that are stored for some pixels only, and for every how many across and down.
    pub(super) fn subsampled(&self) -> Vec<(String, [i32; 2])> {
        let lists = (0..self.parts.len()).filter_map(|part| channels(self.value(part, standard_names::CHANNELS)?));
        let sampled = lists.flatten().filter(|(_, steps)| *steps != [1, 1]);
        sampled.map(|(name, steps)| (String::from_utf8_lossy(name).into_owned(), steps)).collect()
    }

    /// True if a name of an attribute, a type or a channel needs [`LONG_NAMES`].
    pub(super) fn has_long_names(&self) -> bool {
        self.parts.iter().flatten().any(|Attribute { name, kind, value }| {
            let listed = || channels(value).into_iter().flatten().any(|(name, _)| name.len() > SHORT_NAME);
            name.len() > SHORT_NAME || kind.len() > SHORT_NAME || kind == b"chlist" && listed()
        })
    }

    /// The first fault that another reader would refuse.
    pub(super) fn fault(&self) -> Option<String> {
        let mut all = self.parts.iter().flatten();
        if let Some(wrong) = all.find(|attribute| !attribute.is_well_formed()) {
            return Some(format!("the value of attribute `{}` does not fit its type", wrong.shown()));
        }
        for part in &self.parts {
            let mut names = BTreeSet::new();
            if let Some(twice) = part.iter().find(|attribute| !names.insert(&attribute.name)) {
                return Some(format!("attribute `{}` is there twice", twice.shown()));
            }
        }
        (self.has_long_names() && self.version & LONG_NAMES == 0).then(|| "long names are not announced".to_owned())
    }
}

impl Attribute {
    /// The next attribute; `None` at the end of a part.
    fn read(from: &mut impl Read) -> io::Result<Option<Self>> {
        let [first] = read_bytes(from)?;
        if first == 0 {
            return Ok(None);
        }
        let name = read_text(first, from)?;
        let [first] = read_bytes(from)?;
        let kind = read_text(first, from)?;
        let length = u64::from(read_word(from)?);
        let mut value = Vec::new();
        from.take(length).read_to_end(&mut value)?;
        match value.len() as u64 == length {
            true => Ok(Some(Self { name, kind, value })),
            false => Err(ErrorKind::UnexpectedEof.into()),
        }
    }

    /// The attribute that a value of the `exr` crate is stored as; `None` if it cannot be.
    fn of(name: &TextSlice, value: &AttributeValue) -> Option<Self> {
        let mut bytes = Vec::new();
        value.write(&mut bytes).ok()?;
        Some(Self { name: name.to_vec(), kind: value.kind_name().to_vec(), value: bytes })
    }

    fn shown(&self) -> String {
        String::from_utf8_lossy(&self.name).into_owned()
    }

    /// True if the name and the type have an end, which is a zero, and the value is one of the type, as OpenEXR reads
    /// it.
    fn is_well_formed(&self) -> bool {
        let Self { name, kind, value } = self;
        let is_name = |name: &[u8]| (1..=LONGEST_NAME).contains(&name.len()) && !name.contains(&0);
        let length = value.len();
        let fits = match kind.as_slice() {
            b"compression" => matches!(value[..], [0..=11]),
            b"envmap" => matches!(value[..], [0..=1]),
            b"lineOrder" => matches!(value[..], [0..=2]),
            b"deepImageState" => matches!(value[..], [0..=3]),
            b"float" | b"int" => length == 4,
            b"double" | b"rational" | b"timecode" | b"v2i" | b"v2f" => length == 8,
            b"v3i" | b"v3f" => length == 12,
            b"box2i" | b"box2f" | b"v2d" => length == 16,
            b"v3d" => length == 24,
            b"keycode" => length == 28,
            b"chromaticities" => length == 32,
            b"m33f" => length == 36,
            b"m44f" => length == 64,
            b"m33d" => length == 72,
            b"m44d" => length == 128,
            b"floatvector" => length.is_multiple_of(4),
            b"tiledesc" => length == 9 && value[8] & 15 <= 2 && value[8] >> 4 <= 1,
            b"stringvector" => texts(value).is_some(),
            b"chlist" => channels(value).is_some(),
            b"preview" => preview_bytes(value) == Some(length as u64),
            b"bytes" => word(value).is_some_and(|hint| length as u64 - 4 >= u64::from(hint)),
            _ => true,
        };
        is_name(name) && is_name(kind) && fits
    }
}

fn read_bytes<const N: usize>(from: &mut impl Read) -> io::Result<[u8; N]> {
    let mut bytes = [0; N];
    from.read_exact(&mut bytes)?;
    Ok(bytes)
}

fn read_word(from: &mut impl Read) -> io::Result<u32> {
    read_bytes(from).map(u32::from_le_bytes)
}

/// The rest of a text after its first letter, which is a letter even if it is 0, as the `exr` crate reads it.
fn read_text(first: u8, from: &mut impl Read) -> io::Result<Vec<u8>> {
    let mut text = vec![first];
    loop {
        match read_bytes(from)? {
            [0] => return Ok(text),
            [letter] => text.push(letter),
        }
    }
}

fn word(bytes: &[u8]) -> Option<u32> {
    Some(u32::from_le_bytes(*bytes.first_chunk()?))
}

/// The names of a list of channels, and for every how many pixels they are stored.
fn channels(mut list: &[u8]) -> Option<Vec<(&[u8], [i32; 2])>> {
    let mut found = Vec::new();
    while *list.first()? != 0 {
        let end = list.iter().position(|byte| *byte == 0).filter(|end| *end <= LONGEST_NAME)?;
        let (name, rest) = (&list[..end], list.get(end + 1..end + 17)?);
        let steps = [8, 12].map(|at| i32::from_le_bytes(std::array::from_fn(|byte| rest[at + byte])));
        found.push((name, steps));
        list = &list[end + 17..];
    }
    (list.len() == 1).then_some(found)
}

/// The texts of a vector, each after its length.
fn texts(mut vector: &[u8]) -> Option<Vec<&[u8]>> {
    let mut found = Vec::new();
    while !vector.is_empty() {
        let length = usize::try_from(word(vector)?).ok()?;
        found.push(vector.get(4..4 + length)?);
        vector = &vector[4 + length..];
    }
    Some(found)
}

/// The bytes that a preview of the stated size has.
fn preview_bytes(preview: &[u8]) -> Option<u64> {
    let (width, height) = (word(preview)?, word(&preview[4..])?);
    u64::from(width).checked_mul(height.into())?.checked_mul(4)?.checked_add(8)
}

/// Stores the bytes of the attributes that the `exr` crate would write differently.
pub(super) fn keep_bytes(header: &mut Header, stored: &[Attribute]) {
    let written: BTreeMap<Vec<u8>, Option<Attribute>> =
        header.all_named_attributes().map(|(name, value)| (name.to_vec(), Attribute::of(name, &value))).collect();
    for attribute in stored {
        let is_same = written.get(&attribute.name).is_some_and(|written| written.as_ref() == Some(attribute));
        if is_same || is_structure(&attribute.name) {
            continue;
        }
        let name = Text::from_slice_unchecked(&attribute.name);
        let (own, shared) = (&mut header.own_attributes, &mut header.shared_attributes);
        match attribute.name.as_slice() {
            standard_names::KEY_CODE => own.film_key_code = None,
            standard_names::TIME_CODE => shared.time_code = None,
            standard_names::ORIGINAL_DATA_WINDOW => own.original_data_window = None,
            _ => {}
        }
        shared.other.remove(&name);
        let kind = Text::from_slice_unchecked(&attribute.kind);
        own.other.insert(name, AttributeValue::Custom { kind, bytes: attribute.value.as_slice().into() });
    }
}

/// True for the name of an attribute that the encoder makes.
pub(super) fn is_structure(name: &[u8]) -> bool {
    STRUCTURE.contains(&name)
}

/// Removes attributes that other readers would refuse, and duplicates. Returns notes about the former.
pub(super) fn remove_unwritable(header: &mut Header) -> Vec<String> {
    let (own, shared) = (&mut header.own_attributes, &mut header.shared_attributes);
    if let Some(code) = own.film_key_code.take() {
        own.other.insert(Text::from_slice_unchecked(standard_names::KEY_CODE), key_code(&code));
    }
    let mut unwritable = BTreeSet::new();
    if shared.time_code.is_some_and(|code| code.validate(true).is_err()) {
        shared.time_code = None;
        unwritable.insert("`timeCode`".to_owned());
    }
    let image = ImageAttributes { other: HashMap::default(), ..shared.clone() };
    let fields = attribute_names(&image, &LayerAttributes { other: HashMap::default(), ..own.clone() });
    let mut is_writable = |name: &Text, value: &AttributeValue| {
        let attribute = Attribute::of(name.as_slice(), value);
        let is_well_formed = attribute.is_some_and(|attribute| attribute.is_well_formed());
        if !is_well_formed {
            unwritable.insert(format!("`{name}`"));
        }
        is_well_formed && !fields.contains(name.as_slice())
    };
    own.other.retain(|name, value| is_writable(name, value));
    shared.other.retain(|name, value| is_writable(name, value) && !own.other.contains_key(name));
    attributes_left_out(unwritable, "a value that is none of its type, or a name that is too long")
}

/// The numbers of a key code, of which the `exr` crate writes six.
fn key_code(code: &KeyCode) -> AttributeValue {
    let numbers = [
        code.film_manufacturer_code,
        code.film_type,
        code.film_roll_prefix,
        code.count,
        code.perforation_offset,
        code.perforations_per_frame,
        code.perforations_per_count,
    ];
    let bytes = numbers.map(i32::to_le_bytes).as_flattened().into();
    AttributeValue::Custom { kind: Text::from("keycode"), bytes }
}

/// The names of all attributes.
pub(super) fn attribute_names(image: &ImageAttributes, layer: &LayerAttributes) -> BTreeSet<Vec<u8>> {
    let channel = ChannelDescription::named("R", SampleType::F16);
    let header = Header::new(Text::default(), (1, 1), [channel].into_iter().collect());
    let header = header.with_shared_attributes(image.clone()).with_attributes(layer.clone());
    header.all_named_attributes().map(|(name, _)| name.to_vec()).collect()
}

/// The sentence about attributes that are left out, if there are any.
pub(super) fn attributes_left_out(names: impl IntoIterator<Item = String>, why: &str) -> Vec<String> {
    let names: Vec<String> = names.into_iter().collect();
    let attributes = if names.len() == 1 { "attribute" } else { "attributes" };
    let sentence = || format!("left out: {attributes} {}; {why}", names.join(", "));
    (!names.is_empty()).then(sentence).into_iter().collect()
}

/// True if the corners of a stored window are in order.
pub(super) fn is_window(value: &[u8]) -> bool {
    let corners: Vec<i32> = value.as_chunks::<4>().0.iter().map(|bytes| i32::from_le_bytes(*bytes)).collect();
    matches!(corners[..], [left, top, right, bottom] if left <= right && top <= bottom)
}
