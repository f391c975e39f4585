//! The part of the page's address after `#`: what is shown, in parts that are separated by `&`.

use std::fmt;

/// The parts of an address, in their order. Parts that nobody knows are kept.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Address {
    parts: Vec<(String, Option<String>)>,
}

impl Address {
    /// The parts of a text such as `#pipeline=lynx&still`.
    pub(crate) fn parse(hash: &str) -> Self {
        let mut parts = Vec::new();
        for part in hash.trim_start_matches('#').split('&').filter(|part| !part.is_empty()) {
            parts.push(match part.split_once('=') {
                Some((name, value)) => (name.to_owned(), Some(decoded(value))),
                None => (part.to_owned(), None),
            });
        }
        Self { parts }
    }

    /// The value of a part.
    pub(crate) fn get(&self, name: &str) -> Option<&str> {
        self.parts.iter().find(|(known, _)| known == name)?.1.as_deref()
    }

    /// True if there is a part of that name, with or without a value.
    pub(crate) fn has(&self, name: &str) -> bool {
        self.parts.iter().any(|(known, _)| known == name)
    }

    /// Sets a part where it is, or as a new last one; `None` removes it.
    pub(crate) fn set(&mut self, name: &str, value: Option<&str>) {
        match (self.parts.iter_mut().find(|(known, _)| known == name), value) {
            (Some((_, known)), Some(value)) => *known = Some(value.to_owned()),
            (None, Some(value)) => self.parts.push((name.to_owned(), Some(value.to_owned()))),
            (_, None) => self.parts.retain(|(known, _)| known != name),
        }
    }

    /// The built-in pipeline or the text that is shown takes the place of the one before.
    pub(crate) fn show(&mut self, pipeline: Option<&str>, text: &str) {
        let (name, value) = pipeline.map_or(("text", text), |pipeline| ("pipeline", pipeline));
        let other = if name == "text" { "pipeline" } else { "text" };
        let has_it = self.has(name);
        match self.parts.iter_mut().find(|(known, _)| known == other) {
            Some(part) if !has_it => *part = (name.to_owned(), Some(value.to_owned())),
            _ => {
                self.set(other, None);
                self.set(name, Some(value));
            }
        }
    }

    /// The size of the scene: `size=640x360`.
    pub(crate) fn size(&self) -> Option<(u32, u32)> {
        let (width, height) = self.get("size")?.split_once('x')?;
        Some((width.parse().ok().filter(|side| *side > 0)?, height.parse().ok().filter(|side| *side > 0)?))
    }
}

impl fmt::Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, (name, value)) in self.parts.iter().enumerate() {
            f.write_str(if index == 0 { "#" } else { "&" })?;
            f.write_str(name)?;
            if let Some(value) = value {
                write!(f, "={}", encoded(value))?;
            }
        }
        Ok(())
    }
}

/// Letters that an address may have as they are: those of `encodeURIComponent`, and what file names are made of.
fn is_plain(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || b"-_.!~*'()/:".contains(&byte)
}

fn encoded(text: &str) -> String {
    let mut encoded = String::new();
    for byte in text.bytes() {
        match is_plain(byte) {
            true => encoded.push(byte as char),
            false => encoded += &format!("%{byte:02X}"),
        }
    }
    encoded
}

/// The text of a value. What is no code stays as it is.
fn decoded(value: &str) -> String {
    let mut bytes = Vec::new();
    let mut rest = value.as_bytes();
    while let [first, after @ ..] = rest {
        let code = after.get(..2).filter(|_| *first == b'%').and_then(|digits| std::str::from_utf8(digits).ok());
        match code.and_then(|digits| u8::from_str_radix(digits, 16).ok()) {
            Some(byte) => {
                bytes.push(byte);
                rest = &after[2..];
            }
            None => {
                bytes.push(*first);
                rest = after;
            }
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

#[cfg(test)]
mod tests {
    use super::Address;

    #[test]
    fn all_parts_are_kept_when_the_text_takes_the_place_of_the_pipeline() {
        let mut address = Address::parse("#image=a%20b.exr&pipeline=lynx&size=640x360&still&theme=dark");
        assert_eq!((address.get("image"), address.size()), (Some("a b.exr"), Some((640, 360))));
        assert!(address.has("still") && !address.has("bare"));
        address.show(None, "Pipeline(\n)&#");
        let text = "#image=a%20b.exr&text=Pipeline(%0A)%26%23&size=640x360&still&theme=dark";
        assert_eq!(address.to_string(), text);
        assert_eq!(Address::parse(text), address);
        address.show(Some("caracal"), "");
        assert_eq!(address.to_string(), "#image=a%20b.exr&pipeline=caracal&size=640x360&still&theme=dark");
        address.set("size", None);
        address.set("tier", Some("low"));
        assert_eq!(address.to_string(), "#image=a%20b.exr&pipeline=caracal&still&theme=dark&tier=low");
    }

    #[test]
    fn what_is_no_address_is_no_surprise() {
        assert_eq!(Address::parse("").to_string(), "");
        assert_eq!(Address::parse("#&&").to_string(), "");
        assert_eq!(Address::parse("#text=50%").get("text"), Some("50%"));
        assert_eq!(Address::parse("#text=%ff%é").get("text"), Some("\u{fffd}%é"));
        assert_eq!(["0x5", "5", "axb", "-1x2"].map(|size| Address::parse(&format!("size={size}")).size()), [None; 4]);
        let mut address = Address::default();
        address.show(None, "ü");
        assert_eq!(address.to_string(), "#text=%C3%BC");
    }
}
