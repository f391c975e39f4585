//! Code points of ITU-T H.273, which PNG uses.

use afterimage_base::color::{Chromaticities, Decimal, Transfer, Xy};

/// `ColorPrimaries` of the spaces that have a code. 5, 6 and 7 are those of standard definition, 11 is P3 with the
/// white of a cinema.
const PRIMARIES: [(u8, Chromaticities); 7] = [
    (1, Chromaticities::REC709),
    (5, with_d65([0.64, 0.33], [0.29, 0.60], [0.15, 0.06])),
    (6, with_d65([0.630, 0.340], [0.310, 0.595], [0.155, 0.070])),
    (7, with_d65([0.630, 0.340], [0.310, 0.595], [0.155, 0.070])),
    (9, Chromaticities::REC2020),
    (11, Chromaticities { white: Xy::new(0.314, 0.351), ..Chromaticities::DISPLAY_P3 }),
    (12, Chromaticities::DISPLAY_P3),
];

/// `TransferCharacteristics`. 4 and 5 are defined by the gamma of the display.
const TRANSFERS: [(u8, Transfer); 6] = [
    (4, Transfer::Gamma(Decimal::new(2.2))),
    (5, Transfer::Gamma(Decimal::new(2.8))),
    (8, Transfer::Linear),
    (13, Transfer::Srgb),
    (16, Transfer::Pq),
    (18, Transfer::Hlg),
];

/// Other codes of `TransferCharacteristics`: the curve of a camera for SDR video, whose pictures are meant for a
/// display. They are shown by the curve of sRGB, as browsers do.
const VIDEO: [u8; 4] = [1, 6, 14, 15];

const fn with_d65([rx, ry]: [f64; 2], [gx, gy]: [f64; 2], [bx, by]: [f64; 2]) -> Chromaticities {
    Chromaticities { red: Xy::new(rx, ry), green: Xy::new(gx, gy), blue: Xy::new(bx, by), white: Xy::D65 }
}

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

    /// The meaning of the code points; `None` if one of the two is not supported.
    pub(crate) fn meaning(self) -> Option<(Chromaticities, Transfer)> {
        let primaries = PRIMARIES.iter().find(|(code, _)| *code == self.primaries)?.1;
        if self.is_video() {
            return Some((primaries, Transfer::Srgb));
        }
        let transfer = TRANSFERS.iter().find(|(code, _)| *code == self.transfer)?.1;
        Some((primaries, transfer))
    }

    /// True if the transfer function is that of a camera for SDR video.
    pub(crate) fn is_video(self) -> bool {
        VIDEO.contains(&self.transfer)
    }
}
