//! Texts with a few changes.

/// Words, numbers and texts in quotes as wholes, and every other character by itself.
fn tokens(text: &str) -> Vec<&str> {
    let kind = |c: char| {
        if c.is_alphanumeric() || c == '_' {
            'w'
        } else if c == ' ' {
            ' '
        } else {
            's'
        }
    };
    let mut tokens = Vec::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let same = rest.find(|c| kind(c) != kind(first)).unwrap_or(rest.len());
        let (token, after) = rest.split_at(if kind(first) == 's' { first.len_utf8() } else { same });
        tokens.push(token);
        rest = after;
    }
    tokens
}

/// The finalizer of splitmix64.
fn mixed(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// The text with one to three changes, which depend on the seed: words and signs are removed, doubled, exchanged, and
/// replaced by each other and by `others`.
pub fn mutated(text: &str, seed: u64, others: &[&str]) -> String {
    let mut tokens = tokens(text);
    for change in 0..1 + seed % 3 {
        let at = |salt: u64, count: usize| (mixed(seed * 97 + change * 7 + salt) % count.max(1) as u64) as usize;
        let (first, second) = (at(1, tokens.len()), at(2, tokens.len()));
        match at(3, 5) {
            _ if tokens.is_empty() => tokens.push(others[at(4, others.len())]),
            0 => drop(tokens.remove(first)),
            1 => tokens.insert(first, tokens[first]),
            2 => tokens.swap(first, second),
            3 => tokens[first] = tokens[second],
            _ => tokens.insert(first, others[at(4, others.len())]),
        }
    }
    tokens.concat()
}
