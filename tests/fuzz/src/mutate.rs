//! Mutation that knows what a text is made of.

use std::collections::BTreeMap;

use afterimage_generators::Rng;

use crate::corpus::Corpus;
use crate::tokens::{Class, Token, group, tokens};

/// Numbers that parsers and arithmetic stumble over.
const NUMBERS: &[&str] = &[
    "0",
    "-0.0",
    "1",
    "2",
    "-1",
    "3",
    "17",
    "0.5",
    "1e-45",
    "1e38",
    "1e39",
    "-1e308",
    "1e309",
    "NaN",
    "inf",
    "-inf",
    "255",
    "256",
    "257",
    "65504.0",
    "65536",
    "4294967295",
    "4294967296",
    "9223372036854775808",
    "18446744073709551616",
    "0x10",
    "1_000",
    "1.",
    ".5",
    "1e",
    "--1",
    "1..2",
    "0.1.2",
    "1e+400",
    "00",
    "1e-400",
];
/// Changes of one text.
const MAX_CHANGES: usize = 4;
/// The longest texts, from which most is learnt.
const MAX_TELLING: usize = 8;
/// A text that grows beyond this is cut.
const MAX_LENGTH: usize = 32 << 10;

/// Makes texts out of those of a corpus.
pub(crate) struct Mutator {
    seeds: Vec<Vec<Token>>,
    dictionary: BTreeMap<Class, Vec<Token>>,
}

impl Mutator {
    pub(crate) fn new(corpus: &Corpus) -> Self {
        let mut seeds: Vec<Vec<Token>> = corpus.texts.iter().map(|text| tokens(text)).collect();
        seeds.sort_by_key(|seed| std::cmp::Reverse(seed.len()));
        let mut dictionary: BTreeMap<Class, Vec<Token>> = BTreeMap::new();
        let others = corpus.words.iter().map(String::as_str).chain(NUMBERS.iter().copied()).map(Token::new);
        for token in seeds.iter().flatten().cloned().chain(others) {
            let class = dictionary.entry(token.class).or_default();
            if !class.contains(&token) {
                class.push(token);
            }
        }
        Self { seeds, dictionary }
    }

    /// A text with a few changes.
    pub(crate) fn text(&self, rng: &mut Rng) -> String {
        // Half of all texts begin with one of the longest, which are right in most places.
        let among = if rng.below(2) == 0 { &self.seeds[..self.seeds.len().min(MAX_TELLING)] } else { &self.seeds[..] };
        let mut tokens = rng.one_of(among).cloned().unwrap_or_default();
        for _ in 0..=rng.below(MAX_CHANGES) {
            self.change(&mut tokens, rng);
        }
        let mut text: String = tokens.iter().map(|token| token.text.as_str()).collect();
        if rng.below(8) == 0 {
            change_character(&mut text, rng);
        }
        while text.len() > MAX_LENGTH {
            text.pop();
        }
        text
    }

    fn change(&self, tokens: &mut Vec<Token>, rng: &mut Rng) {
        let at = rng.below(tokens.len().max(1));
        match rng.below(10) {
            0 if !tokens.is_empty() => drop(tokens.remove(at)),
            1 => drop(tokens.drain(group(tokens, at))),
            2 => self.repeat(tokens, at, rng),
            3 if !tokens.is_empty() => {
                let other = rng.below(tokens.len());
                tokens.swap(at, other);
            }
            4 => tokens.truncate(at),
            5 => tokens.splice(at..at, self.any(rng)).for_each(drop),
            6 => self.exchange_group(tokens, at, rng),
            _ => self.exchange(tokens, at, rng),
        }
    }

    /// A group once more, or very often.
    fn repeat(&self, tokens: &mut Vec<Token>, at: usize, rng: &mut Rng) {
        let again = tokens[group(tokens, at)].to_vec();
        let times = if rng.below(50) == 0 { 400 } else { 1 + rng.below(3) };
        for _ in 0..times.min(MAX_LENGTH / again.len().max(1)) {
            tokens.splice(at..at, again.iter().cloned());
        }
    }

    /// Another token of the same class: a name for a name, an extreme for a number.
    fn exchange(&self, tokens: &mut [Token], at: usize, rng: &mut Rng) {
        // Spaces matter least.
        let telling = (at..tokens.len()).find(|at| !matches!(tokens[*at].class, Class::Space | Class::LineEnd));
        let Some(token) = telling.map(|at| &mut tokens[at]) else { return };
        let others = self.dictionary.get(&token.class).map_or(&[][..], Vec::as_slice);
        *token = rng.one_of(others).cloned().unwrap_or_else(|| token.clone());
    }

    /// A group of another text in place of one of this.
    fn exchange_group(&self, tokens: &mut Vec<Token>, at: usize, rng: &mut Rng) {
        let Some(other) = rng.one_of(&self.seeds).filter(|other| !other.is_empty()) else { return };
        let taken = other[group(other, rng.below(other.len()))].iter().cloned();
        tokens.splice(group(tokens, at), taken);
    }

    fn any(&self, rng: &mut Rng) -> Option<Token> {
        let classes: Vec<&Vec<Token>> = self.dictionary.values().collect();
        let class = rng.one_of(&classes)?;
        rng.one_of(class).cloned()
    }
}

/// One character replaced by one that is special to some reader.
fn change_character(text: &mut String, rng: &mut Rng) {
    const SIGNS: [char; 20] = [
        '(',
        ')',
        '{',
        '}',
        '[',
        ']',
        '"',
        '\'',
        ',',
        ':',
        '\\',
        '/',
        '*',
        '#',
        '\0',
        '\r',
        '\u{b}',
        '\u{feff}',
        '\u{202e}',
        '\u{1F600}',
    ];
    let starts: Vec<usize> = text.char_indices().map(|(at, _)| at).collect();
    if let Some(at) = rng.one_of(&starts) {
        text.remove(*at);
        text.insert(*at, SIGNS[rng.below(SIGNS.len())]);
    }
}
