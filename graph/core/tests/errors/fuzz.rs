//! No text makes the check panic, and every refusal says where.

use proptest::prelude::*;
use proptest::sample::Index;

use super::accepted::LYNX;
use super::checked;

/// Whatever the text, the answer is a graph or errors with words, and both renderings work.
fn survives(text: &str) {
    if let Err(reported) = checked("fuzz.ron", text) {
        assert!(reported.has_errors());
        assert!(reported.iter().all(|one| !one.message.is_empty() && !one.labels.is_empty()), "{reported}");
        assert!(
            reported.to_string().starts_with("error[") || reported.to_string().starts_with("warning["),
            "{reported}"
        );
        assert_eq!(reported.to_json().as_array().map(Vec::len), Some(reported.len()));
    }
}

#[test]
fn every_beginning_and_every_end_of_a_file() {
    for cut in (0..=LYNX.len()).filter(|cut| LYNX.is_char_boundary(*cut)) {
        survives(&LYNX[..cut]);
        survives(&LYNX[cut..]);
    }
}

proptest! {
    #[test]
    fn characters_changed_moved_and_removed(
        changes in proptest::collection::vec((any::<Index>(), any::<Index>(), 0..4_u8), 1..6),
    ) {
        const SIGNS: &str = "(){}[]\"',:.@/#\\*r b0-9eE+_ANß\u{7}\n!&|<>=$%é\u{1F600}\0";
        let signs: Vec<char> = SIGNS.chars().collect();
        let mut text: Vec<char> = LYNX.chars().collect();
        for (at, other, what) in changes {
            let at = at.index(text.len());
            match what {
                0 => text[at] = signs[other.index(signs.len())],
                1 => text.insert(at, signs[other.index(signs.len())]),
                2 => drop(text.remove(at)),
                _ => text.swap(at, other.index(LYNX.len().min(at + 1))),
            }
        }
        survives(&text.into_iter().collect::<String>());
    }

    #[test]
    fn arbitrary_text(text in "\\PC*") {
        survives(&text);
        survives(&format!("Pipeline(nodes: {{ \"a\": {text} }}, outputs: {{ \"b\": \"a\" }})"));
    }
}
