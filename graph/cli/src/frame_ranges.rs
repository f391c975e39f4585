//! Numbers of frames as `--frames` takes them.

/// Frames as ranges: `1-20`, `1-19:2`, `7`, with commas between them.
pub(crate) fn ranges(frames: &[u32]) -> String {
    let mut texts = Vec::new();
    let mut rest = frames;
    while let [first, after @ ..] = rest {
        let step = after.first().map_or(1, |second| second.wrapping_sub(*first));
        let even = rest.windows(2).take_while(|pair| step > 0 && pair[1].wrapping_sub(pair[0]) == step).count();
        let (last, is_run) = (rest[even], even > 0 && rest[even] > *first);
        texts.push(match step {
            _ if !is_run => first.to_string(),
            1 => format!("{first}-{last}"),
            step => format!("{first}-{last}:{step}"),
        });
        rest = &rest[if is_run { even + 1 } else { 1 }..];
    }
    texts.join(",")
}

#[cfg(test)]
mod tests {
    use super::ranges;

    #[test]
    fn frames_become_ranges_that_name_them() {
        let table: [(&[u32], &str); 6] = [
            (&[1, 2, 3], "1-3"),
            (&[7], "7"),
            (&[1, 3, 5, 7], "1-7:2"),
            (&[1, 2, 3, 10, 20, 30], "1-3,10-30:10"),
            (&[4, 2], "4,2"),
            (&[5, 6, 2, 3], "5-6,2-3"),
        ];
        for (frames, text) in table {
            assert_eq!(ranges(frames), text);
            assert_eq!(afterimage_media::sequence::parse_frames("--frames", text).expect("ranges"), frames);
        }
    }
}
