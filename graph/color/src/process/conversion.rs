//! The conversions around a table: from the image to the space that the table was made for, and to the result.

use afterimage_graph::color::{Chromaticities, Colorimetry};
use afterimage_graph::prelude::*;

use super::{Encoding, LIMIT, LutSpace, Parts, Process, Step};

choices! {
    /// The color state of a table's result.
    pub enum LutState {
        /// That of the image: the table is a look.
        Source,
        /// Display-linear light: the table contains a tone curve.
        DisplayLinear,
        /// Encoded: the table's numbers are the signal.
        Encoded,
    }
}

/// The color spaces of a table, and the linear color around it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conversion {
    /// The space of the table's entry; not `Same` in front of another space of the result.
    pub from: LutSpace,
    /// The space of the table's result.
    pub to: LutSpace,
    /// The state of the result.
    pub state: LutState,
    /// The luminance of a linear value of 1, for `Pq`.
    pub white_nits: f64,
    /// The colorimetry of the image.
    pub source: Colorimetry,
    /// The primaries of a linear result.
    pub result: Chromaticities,
}

impl Conversion {
    /// The space of the table's result, with that of its entry for `Same`.
    fn to(&self) -> LutSpace {
        if self.to == LutSpace::Same { self.from } else { self.to }
    }

    /// The table with the conversions around it.
    pub fn around(&self, table: Process) -> Parts {
        let enter = |space: LutSpace| match space {
            LutSpace::Same => Vec::new(),
            space => [self.wire().decode(), space.numbers_of(self.source.primaries, self.white_nits)].concat(),
        };
        let after = Process::new(self.leave());
        let keeps_source = self.state == LutState::Source && self.to() != LutSpace::Same;
        if self.from == self.to() {
            let before = Process::new(enter(self.from));
            return Parts { before, changed: table, after, keeps_source, ..Parts::default() };
        }
        let changed = Process::new(enter(self.from).into_iter().chain(table.steps));
        Parts { unchanged: Process::new(enter(self.to())), changed, after, keeps_source, ..Parts::default() }
    }

    /// The transfer function of the image.
    fn wire(&self) -> Encoding {
        Encoding::of(&self.source, self.white_nits)
    }

    fn leave(&self) -> Vec<Step> {
        let light = |primaries: Chromaticities| self.to().to_light(primaries, self.white_nits);
        match (self.state, self.to()) {
            (LutState::Source, LutSpace::Same) => Vec::new(),
            (LutState::Source, _) => [light(self.source.primaries), self.wire().encode()].concat(),
            (LutState::DisplayLinear, _) => [light(self.result), vec![Step::limits(0.0, LIMIT)]].concat(),
            (LutState::Encoded, _) => vec![Step::limits(0.0, 1.0)],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The space of the result may be that of the entry or another one.
    #[test]
    fn only_the_state_says_whether_the_state_of_the_source_stays() {
        for to in [LutSpace::Same, LutSpace::Srgb, LutSpace::AcesCct] {
            let keeps = |state| {
                let source = Colorimetry::SRGB;
                let from = LutSpace::Srgb;
                let conversion = Conversion { from, to, state, white_nits: 100.0, source, result: source.primaries };
                conversion.around(Process::default()).keeps_source
            };
            assert!(keeps(LutState::Source), "{to:?}");
            assert!(!keeps(LutState::DisplayLinear), "{to:?}");
        }
    }
}
