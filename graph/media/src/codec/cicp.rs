//! Code points of ITU-T H.273, which PNG uses.

use afterimage_base::color::{Chromaticities, Decimal, Transfer};

/// `ColorPrimaries` of the spaces that have a code.
const PRIMARIES: [(u8, Chromaticities); 3] =
    [(1, Chromaticities::REC709), (9, Chromaticities::REC2020), (12, Chromaticities::DISPLAY_P3)];

/// `TransferCharacteristics`. 4 and 5 are defined by the gamma of the display.
const TRANSFERS: [(u8, Transfer); 6] = [
    (4, Transfer::Gamma(Decimal::new(2.2))),
    (5, Transfer::Gamma(Decimal::new(2.8))),
    (8, Transfer::Linear),
    (13, Transfer::Srgb),
    (16, Transfer::Pq),
    (18, Transfer::Hlg),
];

/// Primaries and transfer function as code points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Cicp {
    pub(crate) primaries: u8,
    pub(crate) transfer: u8,
}

impl Cicp {
    /// The exact code points; `None` if one of the two has none.
    pub(crate) fn of(primaries: &Chromaticities, transfer: Transfer) -> Option<Self> {
        let primaries = PRIMARIES.iter().find(|(_, known)| known == primaries)?.0;
        let transfer = TRANSFERS.iter().find(|(_, known)| *known == transfer)?.0;
        Some(Self { primaries, transfer })
    }

    /// What the code points mean; `None` if one of the two is not supported.
    pub(crate) fn meaning(self) -> Option<(Chromaticities, Transfer)> {
        let primaries = PRIMARIES.iter().find(|(code, _)| *code == self.primaries)?.1;
        let transfer = TRANSFERS.iter().find(|(code, _)| *code == self.transfer)?.1;
        Some((primaries, transfer))
    }
}
