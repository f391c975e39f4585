//! Boxes of ISO/IEC 14496-12.

use crate::codec::CodecError;

/// The bytes that are left of a box or a file.
#[derive(Clone)]
pub(super) struct Bytes<'a>(pub(super) &'a [u8]);

impl<'a> Bytes<'a> {
    fn take(&mut self, length: usize) -> Result<&'a [u8], CodecError> {
        let (taken, rest) = self.0.split_at_checked(length).ok_or_else(CodecError::cut_short)?;
        self.0 = rest;
        Ok(taken)
    }

    pub(super) fn skip(&mut self, length: usize) -> Result<(), CodecError> {
        self.take(length).map(drop)
    }

    /// A number of so many bytes, the highest one first: 0 of no bytes.
    pub(super) fn number(&mut self, size: usize) -> Result<u64, CodecError> {
        if size > 8 {
            return Err(CodecError::broken("a number has more than eight bytes"));
        }
        Ok(self.take(size)?.iter().fold(0, |number, byte| number << 8 | u64::from(*byte)))
    }

    pub(super) fn name(&mut self) -> Result<[u8; 4], CodecError> {
        Ok(self.take(4)?.try_into().expect("four bytes were taken"))
    }

    /// The version of a box, whose flags are skipped.
    pub(super) fn version(&mut self) -> Result<u64, CodecError> {
        Ok(self.number(4)? >> 24)
    }

    /// All that is left.
    pub(super) fn rest(&self) -> &'a [u8] {
        self.0
    }

    /// The next box: its name and what is in it.
    pub(super) fn next_box(&mut self) -> Result<Option<([u8; 4], Self)>, CodecError> {
        if self.0.is_empty() {
            return Ok(None);
        }
        let (length, name) = (self.number(4)?, self.name()?);
        let inside = match length {
            0 => self.0.len() as u64,
            1 => self.number(8)?.checked_sub(16).ok_or_else(CodecError::cut_short)?,
            length => length.checked_sub(8).ok_or_else(CodecError::cut_short)?,
        };
        let inside = usize::try_from(inside).map_err(|_| CodecError::cut_short())?;
        Ok(Some((name, Self(self.take(inside)?))))
    }
}
