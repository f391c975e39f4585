//! Time codes of frames (SMPTE ST 12-1).

/// The time code of a number of frames after that of `text`, such as `01:00:00:00`, at a rate. After `;` or `.`, the
/// first numbers of each minute are dropped, but for each tenth minute. `None` for what is no time code.
pub(super) fn after(text: &str, frames: u64, fps: f64) -> Option<String> {
    let rate = fps.round() as u64;
    let is_dropping = text.contains([';', '.']);
    let fields = text.split([':', ';', '.']).map(str::parse).collect::<Result<Vec<u64>, _>>().ok()?;
    let &[hours, minutes, seconds, frame] = fields.as_slice() else { return None };
    let is_valid =
        hours < 24 && minutes < 60 && seconds < 60 && frame < rate && (!is_dropping || rate.is_multiple_of(30));
    if !is_valid {
        return None;
    }
    let dropped = if is_dropping { rate / 15 } else { 0 };
    let (minutes, minute) = (hours * 60 + minutes, rate * 60 - dropped);
    let ten_minutes = minute * 10 + dropped;
    let number = (minutes * 60 + seconds) * rate + frame - dropped * (minutes - minutes / 10) + frames;
    let number = number % (ten_minutes * 6 * 24);
    let (tens, rest) = (number / ten_minutes, number % ten_minutes);
    let number = number + dropped * (9 * tens + rest.saturating_sub(dropped) / minute);
    let (frame, seconds) = (number % rate, number / rate);
    let mark = if is_dropping { ';' } else { ':' };
    Some(format!("{:02}:{:02}:{:02}{mark}{frame:02}", seconds / 3600, seconds / 60 % 60, seconds % 60))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The examples for 29.97 are those of SMPTE EG 40: an hour has 107,892 frames.
    #[test]
    fn time_codes_count_the_frames_of_their_rate() {
        for (text, frames, fps, expected) in [
            ("01:00:00:00", 0, 23.976, Some("01:00:00:00")),
            ("01:00:00:00", 25, 23.976, Some("01:00:01:01")),
            ("23:59:59:24", 1, 25.0, Some("00:00:00:00")),
            ("00:00:59;29", 1, 29.97, Some("00:01:00;02")),
            ("00:00:59.28", 1, 29.97, Some("00:00:59;29")),
            ("00:09:59;29", 1, 29.97, Some("00:10:00;00")),
            ("00:00:00;00", 107_892, 29.97, Some("01:00:00;00")),
            ("00:00:59;59", 1, 59.94, Some("00:01:00;04")),
            ("23:59:59;29", 1, 29.97, Some("00:00:00;00")),
            ("00:00:00;00", 1, 24.0, None),
            ("00:00:00:24", 1, 24.0, None),
            ("1:2:3", 1, 24.0, None),
            ("", 1, 24.0, None),
        ] {
            assert_eq!(after(text, frames, fps).as_deref(), expected, "{text} and {frames} at {fps}");
        }
    }
}
