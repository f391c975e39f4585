//! Words of commands that are printed, to be pasted into a shell.

/// A word as a shell reads it: quoted if it has characters that mean something there.
pub fn shell_word(word: &str) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "_-./=:,+@%".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        return word.to_owned();
    }
    // No character but the quote ends a word in quotes.
    format!("'{}'", word.replace('\'', r"'\''"))
}

#[cfg(all(test, unix))]
mod tests {
    use super::shell_word;

    #[test]
    fn a_word_is_one_word_in_a_shell() {
        let words =
            ["a.ron", "a b.ron", "it's", "$HOME", "a\"b", "", "*", "~", "scene.time=0.5", "x;y", "ü.ron", "(1, 2)"];
        for word in words {
            let command = format!("printf %s {}", shell_word(word));
            let output = std::process::Command::new("sh").args(["-c", &command]).output().expect("a shell starts");
            assert_eq!(String::from_utf8_lossy(&output.stdout), word, "{command}");
        }
        assert_eq!(["a.ron", "ü=1", "a b"].map(shell_word), ["a.ron", "ü=1", "'a b'"]);
    }
}
