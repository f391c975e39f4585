//! Huffman codes of a JPEG (ITU-T T.81, annexes C and F.2.2).

use super::segments::damaged;
use crate::codec::CodecError;

/// Bits of a code that are looked up at once.
const FAST: u32 = 9;

/// The codes of a table.
pub(super) struct Table {
    /// Length and value for the next [`FAST`] bits; length 0 for a longer code.
    fast: Vec<[u8; 2]>,
    /// For each length the first number, aligned to 16 bits, that is no code of it or of a shorter one; and the index
    /// of the first value less the first code.
    lengths: [(u32, i32); 17],
    values: Vec<u8>,
}

impl Table {
    /// The table with that many codes of 1 to 16 bits; `None` if there are no such codes.
    pub(super) fn new(counts: &[u8; 16], values: &[u8]) -> Option<Self> {
        let mut fast = vec![[0; 2]; 1 << FAST];
        let mut lengths = [(0, 0); 17];
        let (mut code, mut index) = (0_u32, 0_usize);
        for (length, count) in (1_u32..).zip(counts) {
            let first = code;
            code += u32::from(*count);
            if code > 1 << length {
                return None;
            }
            lengths[length as usize] = (code << (16 - length), index as i32 - first as i32);
            for code in first..code {
                if length <= FAST {
                    let shift = FAST - length;
                    fast[(code << shift) as usize..((code + 1) << shift) as usize].fill([length as u8, values[index]]);
                }
                index += 1;
            }
            code <<= 1;
        }
        Some(Self { fast, lengths, values: values.to_owned() })
    }
}

/// The bits of entropy-coded data, up to the next marker.
pub(super) struct Bits<'a> {
    data: &'a [u8],
    at: usize,
    /// The next bits, from the highest on.
    waiting: u64,
    count: u32,
    /// The last waiting bits, which follow the end of the data.
    beyond: u32,
}

impl<'a> Bits<'a> {
    pub(super) fn new(data: &'a [u8]) -> Self {
        Self { data, at: 0, waiting: 0, count: 0, beyond: 0 }
    }

    /// Refills the buffer to at least 57 bits.
    fn fill(&mut self) {
        while self.count <= 56 {
            let byte = match self.data.get(self.at..) {
                Some([0xff, 0, ..]) => {
                    self.at += 2;
                    0xff
                }
                Some([0xff, ..]) | Some([]) | None => {
                    self.beyond += 8;
                    0
                }
                Some([byte, ..]) => {
                    self.at += 1;
                    *byte
                }
            };
            self.waiting |= u64::from(byte) << (56 - self.count);
            self.count += 8;
        }
    }

    fn skip(&mut self, count: u32) {
        self.waiting <<= count;
        self.count -= count;
    }

    /// The next bits as a number; at most 16.
    pub(super) fn bits(&mut self, count: u32) -> u32 {
        if count == 0 {
            return 0;
        }
        if self.count < count {
            self.fill();
        }
        let bits = (self.waiting >> (64 - count)) as u32;
        self.skip(count);
        bits
    }

    pub(super) fn bit(&mut self) -> bool {
        self.bits(1) == 1
    }

    /// A number of `size` bits, whose first is its sign (table F.1); at most 15.
    pub(super) fn number(&mut self, size: u8) -> i16 {
        let bits = self.bits(size.into()) as i32;
        let is_negative = size > 0 && bits >> (size - 1) == 0;
        (if is_negative { bits - (1 << size) + 1 } else { bits }) as i16
    }

    /// The value of the next code.
    pub(super) fn code(&mut self, table: &Table) -> Result<u8, CodecError> {
        if self.count < 16 {
            self.fill();
        }
        let [length, value] = table.fast[(self.waiting >> (64 - FAST)) as usize];
        if length > 0 {
            self.skip(length.into());
            return Ok(value);
        }
        let next = (self.waiting >> 48) as u32;
        let longer = (FAST + 1..=16).find(|length| next < table.lengths[*length as usize].0);
        let length = longer.ok_or_else(|| damaged("a Huffman code is unknown"))?;
        let index = (next >> (16 - length)) as i32 + table.lengths[length as usize].1;
        self.skip(length);
        Ok(table.values[index as usize])
    }

    /// Refuses bits that follow the end of the data.
    pub(super) fn check(&self) -> Result<(), CodecError> {
        if self.count >= self.beyond {
            Ok(())
        } else if self.at >= self.data.len() {
            Err(CodecError::cut_short())
        } else {
            Err(damaged("the data of a scan end early"))
        }
    }

    /// Skips the restart marker of that number.
    pub(super) fn restart(&mut self, number: u8) -> Result<(), CodecError> {
        let fill = self.data[self.at..].iter().take_while(|byte| **byte == 0xff).count();
        let is_there = fill > 0 && self.data.get(self.at + fill) == Some(&(0xd0 + number));
        if !is_there {
            return Err(damaged("a restart marker is not where it must be"));
        }
        *self = Self { at: self.at + fill + 1, ..Self::new(self.data) };
        Ok(())
    }
}
