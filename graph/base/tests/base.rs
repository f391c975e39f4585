//! Sizes, formats and parameters.
#![allow(missing_docs, reason = "a test binary exports nothing")]

use std::cell::Cell;
use std::sync::Arc;

use afterimage_base::diagnostic::{
    Diagnostic, Diagnostics, Location, Sources, apply, did_you_mean, is_control, list, nearest, quote, shown,
};
use afterimage_base::image::{Format, ImageDesc, Size};
use afterimage_base::value::{FileBytes, FileValue, Param, Type, Value, When};

#[test]
fn no_side_of_a_size_is_zero() {
    for size in [Size::new(0, 0), Size::new(1, 1).half(), Size::volume(0, 1, 0), Size::new(1, 1).div_up(16)] {
        assert_eq!(size.texels(), 1, "{size}");
    }
}

#[test]
fn a_pyramid_ends_where_both_sides_are_one() {
    for (width, height) in [(1, 1), (2, 1), (3, 7), (640, 359), (641, 1024)] {
        let mut size = Size::new(width, height);
        let levels = size.levels();
        (0..levels).for_each(|_| size = size.half());
        assert_eq!(size, Size::new(1, 1), "{width}x{height}: {levels} levels");
        assert!(levels == 0 || width.max(height) >> levels == 1, "{width}x{height}: {levels} levels are too many");
    }
}

#[test]
fn the_aspect_of_a_size_is_its_width_over_its_height() {
    assert_eq!(
        [(16, 9), (9, 16), (640, 640), (1, 8192)].map(|(w, h)| Size::new(w, h).aspect()),
        [16.0 / 9.0, 0.5625, 1.0, 1.0 / 8192.0]
    );
}

#[test]
fn a_condition_says_in_words_when_it_holds() {
    let values = vec![Value::Choice("One"), Value::Int(2), Value::Bool(true)];
    for (condition, words) in [
        (When::OneOf("a".into(), values.clone()), "`a` is One or 2 or true"),
        (When::NoneOf("a".into(), values), "`a` is not One or 2 or true"),
        (When::Wired("b".into(), true), "`b` is wired"),
        (When::Wired("b".into(), false), "`b` is not wired"),
    ] {
        assert_eq!(condition.to_string(), words);
    }
}

/// Each type takes its own values within its domain, up to both ends, and nothing else.
#[test]
fn a_parameter_accepts_the_values_of_its_type_and_domain() {
    use afterimage_base::value::ChoiceName;
    const CHOICES: &[ChoiceName] = &[ChoiceName { name: "One", doc: "1" }, ChoiceName { name: "Two", doc: "2" }];
    let vector = |x: f64, n: usize| Value::Vector(std::array::from_fn(|at| if at < n { x } else { 0.0 }), n);
    let kinds = [
        (Type::Bool, vec![Value::Bool(true), Value::Bool(false)]),
        (Type::Int, vec![Value::Int(-2), Value::Int(0), Value::Int(5)]),
        (Type::Float, vec![Value::Float(-2.0), Value::Float(0.5), Value::Float(5.0)]),
        (Type::Vector(2), vec![vector(-2.0, 2), vector(5.0, 2)]),
        (Type::Vector(3), vec![vector(1.0, 3)]),
        (Type::Choice(CHOICES), vec![Value::Choice("One"), Value::Choice("Two")]),
        (Type::Text, vec![Value::Text("a".into())]),
        (Type::File, vec![Value::File(FileValue::default())]),
    ];
    let refused = [
        Value::Int(-3),
        Value::Int(6),
        Value::Float(-2.000_1),
        Value::Float(5.000_1),
        Value::Float(f64::NAN),
        Value::Float(f64::INFINITY),
        vector(5.1, 2),
        vector(f64::NAN, 3),
        Value::Vector([0.0, 6.0, 0.0, 0.0], 2),
        vector(0.0, 4),
        Value::Choice("Three"),
        Value::Choice("one"),
    ];
    for (ty, good) in &kinds {
        let mut param = Param::new("p", "A parameter.", *ty, good[0].clone());
        param.domain = Some((-2.0, 5.0));
        for value in kinds.iter().flat_map(|(_, values)| values).chain(&refused) {
            let is_good = good.contains(value);
            assert_eq!(param.accepts(value).is_ok(), is_good, "{ty:?} and {value}: {:?}", param.accepts(value));
        }
    }
}

#[test]
fn tiles_cover_a_size() {
    assert_eq!(Size::new(641, 359).div_up(16), Size::new(41, 23));
    assert_eq!(Size::new(640, 352).div_up(16), Size::new(40, 22));
}

#[test]
fn the_bytes_of_an_image_are_texels_times_bytes() {
    for format in Format::ALL {
        let desc = ImageDesc::new(Size::new(7, 5)).format(format);
        assert_eq!(desc.bytes(), 35 * format.bytes(), "{}", format.name());
    }
}

#[test]
fn a_format_is_found_by_its_name_and_widens_to_one_that_stays() {
    for format in Format::ALL {
        assert_eq!(Format::named(format.name()), Some(format));
        assert_eq!(format.wider().wider(), format.wider(), "{}", format.name());
        assert!(format.exact().is_32_bit() && format.wider().bytes() >= format.bytes(), "{}", format.name());
    }
    assert_eq!(Format::named("rgba16float"), None);
}

#[test]
fn a_parameter_accepts_its_type_within_its_domain_only() {
    let radius = Param::new("radius", "", Type::Float, Value::Float(1.0)).within(0.0..=4.0).unit("px");
    for good in [0.0, 4.0] {
        assert_eq!(radius.accepts(&Value::Float(good)), Ok(()));
    }
    assert_eq!(radius.accepts(&Value::Float(4.5)), Err("`radius` must be within 0 and 4 px".into()));
    assert_eq!(radius.accepts(&Value::Float(f64::NAN)), Err("`radius` must be finite".into()));
    assert!(radius.accepts(&Value::Int(1)).is_err(), "a whole number is another type");
    let tint = Param::new("tint", "", Type::Vector(2), Value::Vector([0.0; 4], 2)).within(0.0..=1.0);
    assert_eq!(tint.accepts(&Value::Vector([0.5, 1.0, 9.0, 9.0], 2)), Ok(()), "unused components do not count");
    assert!(tint.accepts(&Value::Vector([0.5, 1.5, 0.0, 0.0], 2)).is_err());
    assert!(tint.accepts(&Value::Vector([0.5; 4], 3)).is_err(), "another number of components");
}

#[test]
fn a_size_is_written_with_its_depth_where_it_has_one() {
    let written = [Size::new(640, 360), Size::volume(33, 32, 17), Size::volume(4, 3, 1)].map(|size| size.to_string());
    assert_eq!(written, ["640x360", "33x32x17", "4x3"]);
}

/// Compilers of shaders count lines from 1, and columns from 1 in bytes.
#[test]
fn a_line_and_a_column_are_the_word_that_is_there() {
    let text = "first line\n  let größe = wert;\nend";
    let mut sources = Sources::default();
    sources.insert("a.wgsl", "another file");
    sources.insert("b.wgsl", text);
    let word = |line, column| sources.line("b.wgsl", line, column).map(|at| (at.start, &text[at.span()]));
    for (line, column, start, expected) in [
        (1, 1, 0, "first"),
        (1, 0, 0, "first"),
        (1, 7, 6, "line"),
        (1, 99, 10, ""),
        (2, 0, 13, "let"),
        (2, 7, 17, "größe"),
        (2, 10, 19, "öße"),
        (2, 15, 25, "="),
        (2, 17, 27, "wert"),
        (2, 21, 31, ";"),
        (3, 1, 33, "end"),
    ] {
        assert_eq!(word(line, column), Some((start, expected)), "{line}:{column}");
    }
    assert_eq!((word(0, 1), word(4, 1)), (None, None));
    assert_eq!(sources.line("c.wgsl", 1, 1), None);
}

#[test]
fn a_description_with_another_size_keeps_its_format() {
    let desc = ImageDesc::new(Size::new(7, 5)).format(Format::Rg11b10Ufloat);
    let wide = desc.sized(Size::new(640, 360));
    assert_eq!((wide.size, wide.format), (Size::new(640, 360), Format::Rg11b10Ufloat));
    assert_eq!(desc.half(), desc.sized(Size::new(7, 5).half()));
}

#[test]
fn files_are_equal_if_path_and_content_are() {
    let content = |bytes: &[u8]| FileBytes::from(Arc::<[u8]>::from(bytes));
    let file = |path: &str, bytes: Option<&[u8]>| FileValue { path: path.into(), bytes: bytes.map(content) };
    let film = file("film.cube", Some(b"1"));
    assert_eq!(film, film.clone());
    for other in [file("other.cube", Some(b"1")), file("film.cube", Some(b"2")), file("film.cube", None)] {
        assert_ne!(film, other);
    }
}

/// Copies share what was read; another type, other wishes and other bytes do not.
#[test]
fn files_keep_what_was_read_from_them() {
    let file = |text: &str| FileBytes::from(Arc::<[u8]>::from(text.as_bytes()));
    let calls = Cell::new(0);
    let length = |file: &FileBytes, factor: usize| {
        let read = |bytes: &[u8]| {
            calls.set(calls.get() + 1);
            (factor, factor * bytes.len())
        };
        file.read(|(known, _)| *known == factor, read).1
    };
    let (film, other) = (file("film"), file("other"));
    assert_eq!([length(&film, 1), length(&film.clone(), 1), length(&other, 1)], [4, 4, 5]);
    assert_eq!(calls.get(), 2);
    assert_eq!(*film.read(|_: &u8| true, |bytes| bytes[0]), b'f');
    // As many are kept as serve plans that are made by turns; then the oldest is read again.
    assert_eq!([2, 3, 2, 3, 1].map(|factor| length(&film, factor)), [8, 12, 8, 12, 4]);
    assert_eq!(calls.get(), 4);
    assert_eq!([length(&film, 4), length(&film, 1), length(&film, 4)], [16, 4, 16]);
    assert_eq!(calls.get(), 6);
    // The last copy frees it.
    let kept = film.read(|_: &Vec<u8>| true, <[u8]>::to_vec);
    let weak = Arc::downgrade(&kept);
    drop((kept, film));
    assert_eq!(weak.strong_count(), 0);
}

/// A name of up to 64 letters gets the nearest one, if at most a third of its letters differ.
#[test]
fn long_and_far_names_have_no_nearest_one() {
    let long = |letters: usize| "abcdefgh".repeat(10)[..letters].to_owned();
    for (wrong, is_near) in [(long(63), true), (long(64), true), (long(65), false)] {
        let known = &wrong[1..];
        assert_eq!(nearest(&wrong, ["other", known]), is_near.then_some(known), "{}", wrong.len());
    }
    // One letter of three differs, and two of three.
    assert_eq!(nearest("bla", ["glue", "blur", "ble"]), Some("ble"));
    assert_eq!(nearest("bla", ["glue", "bxx"]), None);
    assert_eq!(did_you_mean("bla", ["ble"]).as_deref(), Some("did you mean `ble`?"));
    assert_eq!(did_you_mean("bla", ["nothing"]), None);
}

/// A correction becomes a change where its wrong words occur once, and not within longer words.
#[test]
fn fixes_are_sure_and_do_not_overlap() {
    let text = "\"lit\": Mix(base: \"lit\", lit_by: sun)";
    let mut all = Diagnostics::default();
    all.add_source("a.ron", text);
    let at = |words: &str| {
        let start = text.find(words).expect("it is there");
        Location::new(&"a.ron".into(), start..start + words.len())
    };
    let error = |words: &str| Diagnostic::error("wrong", "it is wrong").at(&at(words), "");
    let fix = |all: &Diagnostics, error: &Diagnostic| all.fix(error).map(|fix| (fix.location.span(), fix.replacement));
    let name = error("\"lit\"").correct("lit", "dim");
    assert_eq!(fix(&all, &name), Some((1..4, "dim".to_owned())));
    assert_eq!(fix(&all, &error(text).correct("lit", "dim")), None, "it is there twice, and once within a word");
    assert_eq!(fix(&all, &error(text).correct("by", "on")), None);
    assert_eq!(fix(&all, &error("sun").rewrite("\"sun\"")), Some((32..35, "\"sun\"".to_owned())));
    let near = |names: &[&str]| error("sun").did_you_mean("sun", names.iter().copied()).correction.map(|one| one.right);
    assert_eq!(near(&["son"]).as_deref(), Some("son"));
    assert_eq!(near(&["son", "sin"]), None, "either may be meant");
    assert_eq!(near(&["s\"n"]), None, "it would need an escape");
    for error in [error("sun").rewrite("moon"), name, error(": Mix").rewrite(":"), error("Mix").rewrite("Max")] {
        all.push(error);
    }
    assert_eq!(apply(text, &all.fixes("a.ron")), "\"dim\":(base: \"lit\", lit_by: moon)");
    assert!(all.fixes("b.ron").is_empty());
    assert_eq!(all.to_json()[0]["fix"]["start"], 32);
}

#[test]
fn fixes_that_touch_are_all_made_and_of_those_that_overlap_the_first() {
    let text = "a: b(c)";
    let fixed = |parts: &[(std::ops::Range<usize>, &str)]| {
        let mut all = Diagnostics::default();
        all.add_source("a.ron", text);
        for (part, right) in parts {
            let location = Location::new(&"a.ron".into(), part.clone());
            all.push(Diagnostic::error("wrong", "it is wrong").at(&location, "").rewrite(*right));
        }
        apply(text, &all.fixes("a.ron"))
    };
    assert_eq!(fixed(&[(0..1, "x")]), "x: b(c)", "the text begins with what is wrong");
    assert_eq!(fixed(&[(4..7, "()"), (3..4, "y"), (0..1, "x")]), "x: y()", "one begins where the other ends");
    assert_eq!(fixed(&[(3..5, "y["), (4..7, "()")]), "a: y[c)", "they share the bracket");
}

/// Names of files hold any character: none begins a line, changes a terminal or the order of letters.
#[test]
fn texts_of_diagnostics_are_of_one_line() {
    const NAME: &str = "a\nopenjd_fail: x\r\t\u{1b}[8m\u{7f}\u{9b}\u{61c}\u{200f}\u{202e}\u{2029}\u{2066}é";
    let escaped = "a\\nopenjd_fail: x\\r\\t\\u001b[8m\\u007f\\u009b\\u061c\\u200f\\u202e\\u2029\\u2066é";
    assert_eq!(shown(NAME), escaped);
    assert_eq!(shown("plain `é` \u{200d}"), "plain `é` \u{200d}");
    let mut diagnostics = Diagnostics::default();
    let location = Location::new(&Arc::from(NAME), 0..3);
    diagnostics.add_source(NAME, "a \u{202e}b\u{85}c\n");
    diagnostics.push(Diagnostic::error("code", NAME).at(&location, NAME).help(NAME));
    let text = diagnostics.to_string();
    assert!(text.lines().all(|line| !line.starts_with("openjd_fail")), "{text}");
    assert!(text.chars().all(|c| c == '\n' || !is_control(c)), "{text:?}");
    assert_eq!(text.matches(escaped).count(), 4, "{text}");
    let json = diagnostics.to_json();
    assert_eq!((&json[0]["message"], &json[0]["labels"][0]["file"]), (&escaped.into(), &NAME.into()));
}

#[test]
fn names_in_messages_have_a_length_and_one_line() {
    for (name, quoted) in [
        ("a".repeat(48), format!("`{}`", "a".repeat(48))),
        ("a".repeat(49), format!("`{}…`", "a".repeat(48))),
        ("é".repeat(50), format!("`{}…`", "é".repeat(48))),
        (String::new(), "``".to_owned()),
        ("it's \"so\"\n".to_owned(), "`it's \"so\"\\n`".to_owned()),
    ] {
        assert_eq!(quote(&name), quoted);
    }
    let names = ["a", "b", "c", "d"];
    for (count, most, listed) in [
        (0, 3, ""),
        (1, 3, "`a`"),
        (2, 3, "`a` and `b`"),
        (3, 3, "`a`, `b` and `c`"),
        (4, 3, "`a`, `b`, `c` and 1 more"),
        (4, 1, "`a` and 3 more"),
    ] {
        assert_eq!(list(names[..count].iter().copied(), most), listed);
    }
    // A reader of JSON reads any text as it was.
    let text: String = ('\0'..'\u{2100}').filter(|c| !"\"\\".contains(*c)).collect();
    let line = shown(&text);
    assert!(!line.contains(is_control), "{line}");
    let read: serde_json::Value = format!("\"{line}\"").parse().expect("a text of JSON");
    assert_eq!(read, serde_json::Value::String(text));
}
