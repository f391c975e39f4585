//! One picture of panels: two columns, in each the same part of a frame without a kind and with it.

use crate::reference::transfer::{srgb_decode, srgb_encode};
use crate::support::gpu::Picture;

/// The part of the picture that each half of a panel shows, in pixels.
const SHOWN: (u32, u32) = (320, 180);
/// Between the halves of a panel, and between panels.
const DIVIDER: u32 = 2;
const GAP: u32 = 16;
/// Darker than all that panels show.
const BACKGROUND: [f32; 4] = [0.05, 0.05, 0.06, 1.0];

/// A part of a frame of 16:9, in pixels from its upper left corner.
#[derive(Clone, Copy, Debug)]
pub(super) struct Crop {
    pub(super) left: u32,
    pub(super) top: u32,
    /// 320 pixels are shown as they are, fewer as squares, and more as means of light.
    pub(super) width: u32,
}

impl Crop {
    pub(super) const fn new(left: u32, top: u32, width: u32) -> Self {
        Self { left, top, width }
    }

    /// Its right and lower end.
    pub(super) fn end(self) -> (u32, u32) {
        (self.left + self.width, self.top + (self.width * SHOWN.1).div_ceil(SHOWN.0))
    }

    /// The part of an encoded picture, in the size of a half of a panel.
    pub(super) fn shown(self, picture: &Picture) -> Picture {
        let (right, bottom) = self.end();
        assert!(right <= picture.width && bottom <= picture.height, "{self:?} is not in the frame");
        let is_even = self.width.is_multiple_of(SHOWN.0) || SHOWN.0.is_multiple_of(self.width);
        assert!(is_even, "{self:?} has uneven squares");
        let side = (self.width / SHOWN.0).max(1);
        Picture::new(SHOWN.0, SHOWN.1, |x, y| {
            let (x, y) = (self.left + x * self.width / SHOWN.0, self.top + y * self.width / SHOWN.0);
            mean(picture, (x, y), side)
        })
    }
}

/// The mean of the light of a square.
fn mean(picture: &Picture, (left, top): (u32, u32), side: u32) -> [f32; 4] {
    if side == 1 {
        return picture.at(left, top);
    }
    let pixels = (0..side * side).map(|index| picture.at(left + index % side, top + index / side));
    let sum = pixels.fold([0.0; 3], |sum, pixel| [0, 1, 2].map(|c| sum[c] + srgb_decode(pixel[c].into())));
    let [r, g, b] = sum.map(|light| srgb_encode(light / f64::from(side * side)) as f32);
    [r, g, b, 1.0]
}

/// The picture of all panels, which are pairs of halves.
pub(super) fn sheet(panels: &[[Picture; 2]]) -> Picture {
    let (width, height) = (2 * SHOWN.0 + DIVIDER, SHOWN.1);
    let rows = (panels.len() as u32).div_ceil(2);
    Picture::new(2 * width + GAP, rows * (height + GAP) - GAP, |x, y| {
        let (column, row) = (x / (width + GAP), y / (height + GAP));
        let (x, y) = (x % (width + GAP), y % (height + GAP));
        let (half, within) = (x / (SHOWN.0 + DIVIDER), x % (SHOWN.0 + DIVIDER));
        match panels.get((2 * row + column) as usize) {
            Some(panel) if half < 2 && within < SHOWN.0 && y < SHOWN.1 => panel[half as usize].at(within, y),
            _ => BACKGROUND,
        }
    })
}

#[test]
fn a_crop_shows_squares_or_means_of_light() {
    let frame = Picture::new(640, 360, |x, y| [x as f32 / 640.0, y as f32 / 360.0, ((x + y) % 2) as f32, 1.0]);
    let large = Crop::new(600, 337, 40).shown(&frame);
    assert_eq!((large.width, large.height), SHOWN);
    assert!((0..4).all(|i| large.at(312 + i, 179 - i) == frame.at(639, 359)), "{:?}", large.at(319, 179));
    let small = Crop::new(0, 0, 640).shown(&frame);
    // Half of the light of white.
    assert!(small.pixels.iter().all(|pixel| (pixel[2] - 0.7354).abs() < 1e-3), "{:?}", small.at(9, 9));
    let sheet =
        sheet(&[[large.clone(), small.clone()], [small.clone(), large.clone()], [large.clone(), small.clone()]]);
    assert_eq!((sheet.width, sheet.height), (4 * 320 + 2 * 2 + 16, 2 * 180 + 16));
    let at =
        [sheet.at(319, 0), sheet.at(320, 0), sheet.at(322, 0), sheet.at(642, 0), sheet.at(658, 195), sheet.at(0, 196)];
    let wanted = [large.at(319, 0), BACKGROUND, small.at(0, 0), BACKGROUND, BACKGROUND, large.at(0, 0)];
    assert_eq!(at, wanted);
}
