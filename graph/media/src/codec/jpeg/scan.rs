//! The scans of a JPEG: entropy-coded data to coefficients (ITU-T T.81, annexes F and G).
//!
//! A scan only fills in coefficients, so their number, their order and the components that they hold together make no
//! difference to what follows.

use super::huffman::{Bits, Table};
use super::segments::{ComponentHeader, Frame, Segment, damaged, not_supported};
use crate::codec::CodecError;
use crate::codec::limits::zeroed;

/// Positions of coefficients in a block, in the order of the file (figure A.6).
const ZIGZAG: [u8; 64] = [
    0, 1, 8, 16, 9, 2, 3, 10, 17, 24, 32, 25, 18, 11, 4, 5, 12, 19, 26, 33, 40, 48, 41, 34, 27, 20, 13, 6, 7, 14, 21,
    28, 35, 42, 49, 56, 57, 50, 43, 36, 29, 22, 15, 23, 30, 37, 44, 51, 58, 59, 52, 45, 38, 31, 39, 46, 53, 60, 61, 54,
    47, 55, 62, 63,
];

type Block = [i16; 64];

/// A component: its size, and the coefficients of all of its blocks.
pub(super) struct Component {
    id: u8,
    pub(super) sampling: [usize; 2],
    /// Columns and rows of samples.
    pub(super) size: [usize; 2],
    /// Blocks in a row and rows of them, as many as whole MCUs have.
    pub(super) blocks: [usize; 2],
    pub(super) coefficients: Vec<Block>,
    /// The quantization table at the beginning of the component's first scan, in the order of a block.
    pub(super) quantization: Option<[u16; 64]>,
    table: usize,
}

impl Component {
    /// The components of a frame, without memory for coefficients.
    ///
    /// # Errors
    /// Samples that are not a whole number of pixels wide or high.
    pub(super) fn all(frame: &Frame) -> Result<Vec<Self>, CodecError> {
        let most = max_sampling(frame);
        let pixels = [usize::from(frame.width), usize::from(frame.height)];
        let component = |header: &ComponentHeader| {
            let sampling = [header.horizontal, header.vertical];
            if (0..2).any(|axis| !most[axis].is_multiple_of(sampling[axis])) {
                return Err(not_supported("samples of one and a half pixels"));
            }
            Ok(Self {
                id: header.id,
                sampling,
                size: [0, 1].map(|axis| (pixels[axis] * sampling[axis]).div_ceil(most[axis])),
                blocks: [0, 1].map(|axis| pixels[axis].div_ceil(8 * most[axis]) * sampling[axis]),
                coefficients: Vec::new(),
                quantization: None,
                table: header.table,
            })
        };
        frame.components.iter().map(component).collect()
    }

    pub(super) fn number_of_blocks(&self) -> usize {
        self.blocks[0] * self.blocks[1]
    }
}

pub(super) fn max_sampling(frame: &Frame) -> [usize; 2] {
    let most = |of: fn(&ComponentHeader) -> usize| frame.components.iter().map(of).max().unwrap_or(1);
    [most(|component| component.horizontal), most(|component| component.vertical)]
}

/// Fills in the coefficients of all components.
///
/// # Errors
/// Damaged data, data that end early, and no memory.
pub(super) fn decode(frame: &Frame, segments: &[Segment<'_>], components: &mut [Component]) -> Result<(), CodecError> {
    for component in &mut *components {
        component.coefficients = zeroed(component.number_of_blocks())?;
    }
    let mut tables = Tables::default();
    for segment in segments {
        match segment {
            Segment::Quantization(body) => tables.take_quantization(body)?,
            Segment::Huffman(body) => tables.take_huffman(body)?,
            Segment::RestartInterval(interval) => tables.restart_interval = *interval,
            Segment::Scan(header, data) => Scan::new(header, frame, components, &tables)?.decode(data, components)?,
        }
    }
    match components.iter().find(|component| component.quantization.is_none()) {
        Some(component) => Err(damaged(&format!("no scan has its component {}", component.id))),
        None => Ok(()),
    }
}

/// Tables for the scans that follow.
#[derive(Default)]
struct Tables {
    quantization: [Option<[u16; 64]>; 4],
    /// Of differences, and of the other coefficients.
    huffman: [[Option<Table>; 4]; 2],
    restart_interval: usize,
}

impl Tables {
    fn take_quantization(&mut self, mut body: &[u8]) -> Result<(), CodecError> {
        let short = || damaged("a quantization table is short");
        while let Some((&head, rest)) = body.split_first() {
            let wide = usize::from(head >> 4).min(1) + 1;
            let (numbers, rest) = rest.split_at_checked(64 * wide).ok_or_else(short)?;
            let slot = self.quantization.get_mut(usize::from(head & 15)).ok_or_else(short)?;
            let table = slot.insert([0; 64]);
            for (number, at) in numbers.chunks_exact(wide).zip(ZIGZAG) {
                table[usize::from(at)] = number.iter().fold(0, |sum, byte| sum << 8 | u16::from(*byte));
            }
            body = rest;
        }
        Ok(())
    }

    fn take_huffman(&mut self, mut body: &[u8]) -> Result<(), CodecError> {
        let bad = || damaged("a Huffman table cannot be");
        while let Some((&head, rest)) = body.split_first() {
            let (counts, rest) = rest.split_first_chunk::<16>().ok_or_else(bad)?;
            let number: usize = counts.iter().map(|count| usize::from(*count)).sum();
            let (values, rest) = rest.split_at_checked(number).ok_or_else(bad)?;
            let of_class = self.huffman.get_mut(usize::from(head >> 4)).ok_or_else(bad)?;
            let slot = of_class.get_mut(usize::from(head & 15)).ok_or_else(bad)?;
            *slot = Some(Table::new(counts, values).ok_or_else(bad)?);
            body = rest;
        }
        Ok(())
    }
}

/// A component in a scan.
struct Member<'t> {
    /// Its place in the frame.
    component: usize,
    differences: Option<&'t Table>,
    others: Option<&'t Table>,
    /// The last coefficient 0.
    predictor: i16,
}

/// A scan and where it stands.
struct Scan<'t> {
    members: Vec<Member<'t>>,
    is_progressive: bool,
    /// The first and the last coefficient, in the order of the file.
    band: [usize; 2],
    /// True if it adds a bit to what earlier scans gave, and the place of its lowest bit.
    refines: bool,
    low_bit: u8,
    restart_interval: usize,
    /// MCUs across and down.
    mcus: [usize; 2],
    /// Further blocks without a coefficient in the band.
    empty_blocks: u32,
}

impl<'t> Scan<'t> {
    fn new(header: &[u8], frame: &Frame, components: &mut [Component], tables: &'t Tables) -> Result<Self, CodecError> {
        let bad = || damaged("the header of a scan contradicts the frame");
        let (&count, rest) = header.split_first().ok_or_else(bad)?;
        let (names, rest) = rest.split_at_checked(2 * usize::from(count)).ok_or_else(bad)?;
        let &[first, last, bits] = rest.first_chunk().ok_or_else(bad)?;
        let mut members: Vec<Member<'_>> = Vec::new();
        for [id, slots] in names.as_chunks::<2>().0 {
            let component = components.iter().position(|component| component.id == *id).ok_or_else(bad)?;
            if members.iter().any(|before| before.component == component) {
                return Err(bad());
            }
            let table = |class: usize, slot: u8| tables.huffman[class].get(usize::from(slot)).and_then(Option::as_ref);
            let (differences, others) = (table(0, slots >> 4), table(1, slots & 15));
            members.push(Member { component, differences, others, predictor: 0 });
            let component = &mut components[component];
            if component.quantization.is_none() {
                let table = tables.quantization[component.table];
                component.quantization = Some(table.ok_or_else(|| damaged("a quantization table is missing"))?);
            }
        }
        let (band, [high, low]) = if frame.is_progressive {
            ([first, last].map(usize::from), [bits >> 4, bits & 15])
        } else {
            ([0, 63], [0, 0])
        };
        let is_possible = match band {
            [0, 0] => true,
            [0, last] => !frame.is_progressive && last == 63,
            [first, last] => first <= last && last < 64 && members.len() == 1,
        };
        if members.is_empty() || !is_possible || low > 13 || (high != 0 && high != low + 1) {
            return Err(bad());
        }
        let mcus = match *members {
            [Member { component, .. }] => components[component].size.map(|side| side.div_ceil(8)),
            _ => {
                let of = members.iter().map(|member| components[member.component].sampling);
                if of.map(|[across, down]| across * down).sum::<usize>() > 10 {
                    return Err(bad());
                }
                let most = max_sampling(frame);
                [0, 1].map(|axis| [frame.width, frame.height].map(usize::from)[axis].div_ceil(8 * most[axis]))
            }
        };
        let (is_progressive, restart_interval) = (frame.is_progressive, tables.restart_interval);
        let (refines, low_bit) = (high != 0, low);
        Ok(Self { members, is_progressive, band, refines, low_bit, restart_interval, mcus, empty_blocks: 0 })
    }

    fn decode(mut self, data: &[u8], components: &mut [Component]) -> Result<(), CodecError> {
        let mut bits = Bits::new(data);
        let mut members = std::mem::take(&mut self.members);
        for mcu in 0..self.mcus[0] * self.mcus[1] {
            if self.restart_interval > 0 && mcu > 0 && mcu.is_multiple_of(self.restart_interval) {
                bits.restart((mcu / self.restart_interval - 1) as u8 % 8)?;
                self.empty_blocks = 0;
                members.iter_mut().for_each(|member| member.predictor = 0);
            }
            let at = [mcu % self.mcus[0], mcu / self.mcus[0]];
            if let [member] = &mut *members {
                let component = &mut components[member.component];
                let block = at[1] * component.blocks[0] + at[0];
                self.block(&mut bits, member, &mut component.coefficients[block])?;
                continue;
            }
            for member in &mut members {
                let component = &mut components[member.component];
                let [across, down] = component.sampling;
                for block in 0..across * down {
                    let [x, y] = [at[0] * across + block % across, at[1] * down + block / across];
                    self.block(&mut bits, member, &mut component.coefficients[y * component.blocks[0] + x])?;
                }
            }
        }
        Ok(())
    }

    fn block(&mut self, bits: &mut Bits<'_>, member: &mut Member<'_>, block: &mut Block) -> Result<(), CodecError> {
        match (self.band[0], self.refines) {
            (0, true) => block[0] |= i16::from(bits.bit()) << self.low_bit,
            (0, false) => {
                let table = member.differences.ok_or_else(no_table)?;
                let size = bits.code(table)?;
                member.predictor = member.predictor.wrapping_add(bits.number(size.min(15)));
                block[0] = member.predictor << self.low_bit;
                if !self.is_progressive {
                    self.first_bits(bits, member, 1, block)?;
                }
            }
            (first, false) => self.first_bits(bits, member, first, block)?,
            (_, true) => self.further_bit(bits, member, block)?,
        }
        bits.check()
    }

    /// Coefficients from `at` on that no scan gave before (F.2.2.2 and G.1.2.2).
    fn first_bits(
        &mut self,
        bits: &mut Bits<'_>,
        member: &Member<'_>,
        mut at: usize,
        block: &mut Block,
    ) -> Result<(), CodecError> {
        if self.empty_blocks > 0 {
            self.empty_blocks -= 1;
            return Ok(());
        }
        let table = member.others.ok_or_else(no_table)?;
        while at <= self.band[1] {
            let code = bits.code(table)?;
            let (run, size) = (code >> 4, code & 15);
            if size > 0 {
                at += usize::from(run);
                let position = ZIGZAG.get(at).ok_or_else(too_many)?;
                block[usize::from(*position)] = bits.number(size) << self.low_bit;
                at += 1;
            } else if run == 15 {
                at += 16;
            } else {
                self.end_band(bits, run);
                break;
            }
        }
        Ok(())
    }

    /// One more bit of coefficients that earlier scans gave, and new ones of one bit (G.1.2.3).
    fn further_bit(&mut self, bits: &mut Bits<'_>, member: &Member<'_>, block: &mut Block) -> Result<(), CodecError> {
        let table = member.others.ok_or_else(no_table)?;
        let bit = 1_i16 << self.low_bit;
        let [mut at, last] = self.band;
        if self.empty_blocks == 0 {
            while at <= last {
                let code = bits.code(table)?;
                let (mut run, mut value) = (code >> 4, 0);
                if code & 15 > 0 {
                    value = if bits.bit() { bit } else { -bit };
                } else if run < 15 {
                    self.end_band(bits, run);
                    // This block counts, too, once its coefficients have their bits.
                    self.empty_blocks += 1;
                    break;
                }
                while at <= last {
                    let coefficient = &mut block[usize::from(ZIGZAG[at])];
                    at += 1;
                    if *coefficient != 0 {
                        refine(bits, bit, coefficient);
                    } else if run == 0 {
                        *coefficient = value;
                        break;
                    } else {
                        run -= 1;
                    }
                }
            }
        }
        if self.empty_blocks > 0 {
            for position in &ZIGZAG[at..=last] {
                let coefficient = &mut block[usize::from(*position)];
                if *coefficient != 0 {
                    refine(bits, bit, coefficient);
                }
            }
            self.empty_blocks -= 1;
        }
        Ok(())
    }

    /// The end of the band in this block and, in a progressive file, in a number of further ones.
    fn end_band(&mut self, bits: &mut Bits<'_>, size: u8) {
        if self.is_progressive {
            self.empty_blocks = (1 << size) - 1 + bits.bits(size.into());
        }
    }
}

fn refine(bits: &mut Bits<'_>, bit: i16, coefficient: &mut i16) {
    if bits.bit() && *coefficient & bit == 0 {
        *coefficient = coefficient.wrapping_add(bit * coefficient.signum());
    }
}

fn no_table() -> CodecError {
    damaged("a Huffman table is missing")
}

fn too_many() -> CodecError {
    damaged("a block has more than 64 coefficients")
}
