//! Stale contents of memory must not be seen in a frame.

use super::{bits, lively};
use crate::support::gpu::{Picture, Run, built_in};
use crate::support::player::Player;
use crate::support::sweep;

/// In shared memory each image finds what another one has left in this frame or the one before.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_frame_does_not_see_the_one_before() {
    let (bright, dim) = (lively(96, 54), super::flat(96, 54, 0.01));
    let all = ["tsushima.ron", "lynx.ron", "caracal.ron", "glare.ron", "exposure.ron", "grade.ron", "hdr.ron"];
    for name in sweep::some(all, 3) {
        let graph = built_in(name, None);
        let mut player = Player::new();
        let mut show = |scenes: &[&Picture]| {
            player.renew();
            player.load(&Run::new(&graph), &[("scene", &dim)]);
            for scene in scenes {
                player.frame(&[("scene", scene)], 0.0, true);
            }
            bits(&player.output(&graph.outputs[0].name))
        };
        assert_eq!(show(&[&bright, &dim]), show(&[&dim]), "{name}");
    }
}
