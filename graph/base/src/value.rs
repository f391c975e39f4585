//! Parameters and their values. Each parameter is declared once, and everything else is derived from the declaration.

use std::fmt::Write;
use std::ops::RangeInclusive;
use std::sync::Arc;

use crate::Shared;
pub use crate::file::{FileBytes, FileValue};

/// A value of a parameter, from a pipeline file or a control.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// True or false.
    Bool(bool),
    /// An integer.
    Int(i64),
    /// A floating-point number.
    Float(f64),
    /// Two to four numbers and their count. Unused ones are 0.
    Vector([f64; 4], usize),
    /// One of a parameter's choices.
    Choice(&'static str),
    /// A text.
    Text(Arc<str>),
    /// A file: its path, and its bytes once loaded.
    File(FileValue),
}

impl std::fmt::Display for Value {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Bool(v) => write!(f, "{v}"),
            Self::Int(v) => write!(f, "{v}"),
            Self::Float(v) => write!(f, "{v:?}"),
            Self::Vector(v, n) => {
                let parts: Vec<String> = v[..*n].iter().map(|x| format!("{x:?}")).collect();
                write!(f, "({})", parts.join(", "))
            }
            Self::Choice(name) => write!(f, "{name}"),
            Self::Text(text) => write!(f, "{text:?}"),
            Self::File(file) => write!(f, "{:?}", file.path),
        }
    }
}

/// One value of a choice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ChoiceName {
    /// The name in pipeline files.
    pub name: &'static str,
    /// Its meaning.
    pub doc: &'static str,
}

/// The type of a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Type {
    /// `true` or `false`.
    Bool,
    /// An integer.
    Int,
    /// A floating-point number.
    Float,
    /// A vector of this many numbers, two to four.
    Vector(usize),
    /// One of these names.
    Choice(&'static [ChoiceName]),
    /// A text, such as a name in a file.
    Text,
    /// The path of a file, relative to the pipeline file.
    File,
}

impl Type {
    /// The type in words, for error messages.
    pub fn describe(self) -> String {
        match self {
            Self::Bool => "`true` or `false`".into(),
            Self::Int => "a whole number".into(),
            Self::Float => "a number".into(),
            Self::Vector(n) => format!("{n} numbers in parentheses"),
            Self::Choice(choices) => {
                let names: Vec<String> = choices.iter().map(|c| format!("`{}`", c.name)).collect();
                format!("one of {}", names.join(", "))
            }
            Self::Text => "a text in quotes".into(),
            Self::File => "a file's path in quotes".into(),
        }
    }
}

/// The declaration of a parameter.
#[derive(Clone, Debug)]
pub struct Param {
    /// The name in files, shaders and messages.
    pub name: Shared<str>,
    /// Its meaning, with the neutral value if there is one.
    pub doc: String,
    /// Its type.
    pub ty: Type,
    /// The value if a file sets none.
    pub default: Value,
    /// The smallest and the largest allowed number of each component.
    pub domain: Option<(f64, f64)>,
    /// The range of a slider. It lies within the domain.
    pub usual: Option<(f64, f64)>,
    /// True for a slider in steps of equal ratio: the range spans decades.
    pub logarithmic: bool,
    /// The unit of its numbers. Empty for pure numbers.
    pub unit: Shared<str>,
    /// True if a change needs a new plan. Otherwise a new uniform is enough.
    pub replan: bool,
    /// The value at which the parameter changes nothing, if there is one.
    pub neutral: Option<Value>,
    /// For an accuracy switch: its most accurate value and the alternatives.
    pub quality: Option<Quality>,
    /// Unless all of these hold, the parameter has no effect.
    pub when: Vec<When>,
}

/// A condition under which a parameter has an effect.
#[derive(Clone, Debug, PartialEq)]
pub enum When {
    /// The parameter of that name has one of these values.
    OneOf(Shared<str>, Vec<Value>),
    /// The parameter of that name has another value.
    NoneOf(Shared<str>, Vec<Value>),
    /// The optional input of that name is wired, or is not.
    Wired(Shared<str>, bool),
}

impl std::fmt::Display for When {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let any = |values: &[Value]| values.iter().map(Value::to_string).collect::<Vec<_>>().join(" or ");
        match self {
            Self::OneOf(name, values) => write!(f, "`{name}` is {}", any(values)),
            Self::NoneOf(name, values) => write!(f, "`{name}` is not {}", any(values)),
            Self::Wired(name, true) => write!(f, "`{name}` is wired"),
            Self::Wired(name, false) => write!(f, "`{name}` is not wired"),
        }
    }
}

/// An accuracy switch: its most accurate value, and cheaper ones from the most to the least accurate.
#[derive(Clone, Debug, PartialEq)]
pub struct Quality {
    /// The most accurate value.
    pub exact: Value,
    /// Cheaper values, the most accurate first.
    pub cheaper: Vec<Value>,
}

impl Param {
    /// A parameter without a domain. A change of a choice, an integer, a flag, a text or a file needs a new plan.
    pub fn new(name: impl Into<Shared<str>>, doc: &str, ty: Type, default: Value) -> Self {
        let doc = doc.trim().to_owned();
        let replan = matches!(ty, Type::Bool | Type::Int | Type::Choice(_) | Type::Text | Type::File);
        Self {
            name: name.into(),
            doc,
            ty,
            default,
            domain: None,
            usual: None,
            logarithmic: false,
            unit: Shared::of(""),
            replan,
            neutral: None,
            quality: None,
            when: Vec::new(),
        }
    }

    /// Sets the domain of each component. A value outside is an error in the file.
    pub fn within(mut self, domain: RangeInclusive<f64>) -> Self {
        self.domain = Some((*domain.start(), *domain.end()));
        self
    }

    /// Sets the range of a slider.
    pub fn usually(mut self, range: RangeInclusive<f64>) -> Self {
        self.usual = Some((*range.start(), *range.end()));
        self
    }

    /// Declares that a slider has steps of equal ratio, because the range spans decades. It must not be negative.
    pub fn logarithmic(mut self) -> Self {
        self.logarithmic = true;
        self
    }

    /// Sets the unit.
    pub fn unit(mut self, unit: impl Into<Shared<str>>) -> Self {
        self.unit = unit.into();
        self
    }

    /// Declares that a change needs a new plan although the type does not imply it.
    pub fn replans(mut self) -> Self {
        self.replan = true;
        self
    }

    /// Declares that a change needs only a new uniform although the type implies a new plan.
    pub fn live(mut self) -> Self {
        self.replan = false;
        self
    }

    /// Sets the value at which the parameter changes nothing.
    pub fn neutral<T: ParamType>(mut self, value: T) -> Self {
        self.neutral = Some(value.into_value());
        self
    }

    /// Declares an accuracy switch: the most accurate value, then cheaper ones, the most accurate first.
    pub fn quality<T: ParamType, const N: usize>(mut self, exact: T, cheaper: [T; N]) -> Self {
        let cheaper = cheaper.into_iter().map(ParamType::into_value).collect();
        self.quality = Some(Quality { exact: exact.into_value(), cheaper });
        self
    }

    /// Declares that the parameter has an effect only while another one has one of these values.
    pub fn when<T: ParamType>(self, name: impl Into<Shared<str>>, values: impl IntoIterator<Item = T>) -> Self {
        self.only(When::OneOf(name.into(), values.into_iter().map(ParamType::into_value).collect()))
    }

    /// Declares that the parameter has no effect while another one has one of these values.
    pub fn unless<T: ParamType>(self, name: impl Into<Shared<str>>, values: impl IntoIterator<Item = T>) -> Self {
        self.only(When::NoneOf(name.into(), values.into_iter().map(ParamType::into_value).collect()))
    }

    /// Declares that the parameter has an effect only while an optional input is wired, or while it is not.
    pub fn when_wired(self, input: impl Into<Shared<str>>, is_wired: bool) -> Self {
        self.only(When::Wired(input.into(), is_wired))
    }

    fn only(mut self, condition: When) -> Self {
        self.when.push(condition);
        self
    }

    /// The value at the lower end of the domain; `false`, or the first choice. `None` without a domain.
    pub fn lowest(&self) -> Option<Value> {
        self.at(|(low, _)| low, |choices| choices.first())
    }

    /// The value at the upper end of the domain; `true`, or the last choice. `None` without a domain.
    pub fn highest(&self) -> Option<Value> {
        self.at(|(_, high)| high, |choices| choices.last())
    }

    /// The value in the middle of the domain. `None` without a domain.
    pub fn middle(&self) -> Option<Value> {
        self.at(|(low, high)| low + 0.5 * (high - low), |choices| choices.get(choices.len() / 2))
    }

    fn at(
        &self,
        number: impl Fn((f64, f64)) -> f64,
        choice: impl Fn(&'static [ChoiceName]) -> Option<&'static ChoiceName>,
    ) -> Option<Value> {
        let number = |domain: Option<(f64, f64)>| domain.map(&number);
        match self.ty {
            Type::Bool => number(Some((0.0, 1.0))).map(|side| Value::Bool(side > 0.5)),
            Type::Int => number(self.domain).map(|whole| Value::Int(whole.round() as i64)),
            Type::Float => number(self.domain).map(Value::Float),
            Type::Vector(n) => {
                number(self.domain).map(|x| Value::Vector(std::array::from_fn(|i| if i < n { x } else { 0.0 }), n))
            }
            Type::Choice(choices) => choice(choices).map(|choice| Value::Choice(choice.name)),
            Type::Text | Type::File => None,
        }
    }

    /// Checks that `value` has this type and is in the domain. The error is a message for the user.
    pub fn accepts(&self, value: &Value) -> Result<(), String> {
        let numbers: &[f64] = match (self.ty, value) {
            (Type::Bool, Value::Bool(_)) | (Type::Text, Value::Text(_)) | (Type::File, Value::File(_)) => return Ok(()),
            (Type::Choice(choices), Value::Choice(name)) if choices.iter().any(|c| c.name == *name) => return Ok(()),
            (Type::Int, Value::Int(v)) => &[*v as f64],
            (Type::Float, Value::Float(v)) => &[*v],
            (Type::Vector(n), Value::Vector(v, len)) if n == *len => &v[..n],
            _ => return Err(format!("`{}` must be {}", self.name, self.ty.describe())),
        };
        if !numbers.iter().all(|x| x.is_finite()) {
            return Err(format!("`{}` must be finite", self.name));
        }
        match self.domain {
            Some((low, high)) if !numbers.iter().all(|x| (low..=high).contains(x)) => {
                Err(format!("`{}` must be within {} and {}{}", self.name, low, high, self.unit_suffix()))
            }
            _ => Ok(()),
        }
    }

    fn unit_suffix(&self) -> String {
        if self.unit.is_empty() { String::new() } else { format!(" {}", self.unit) }
    }
}

/// A Rust type that a parameter can have.
pub trait ParamType: Sized {
    /// Its parameter type.
    const TYPE: Type;
    /// The value as written in files.
    fn into_value(self) -> Value;
    /// Converts a value of [`Self::TYPE`]. `None` for a value of another type.
    fn from_value(value: &Value) -> Option<Self>;
}

macro_rules! param_type {
    ($ty:ty, $type:expr, $pattern:pat => $read:expr, $me:ident => $write:expr) => {
        impl ParamType for $ty {
            const TYPE: Type = $type;
            fn into_value(self) -> Value {
                let $me = self;
                $write
            }
            fn from_value(value: &Value) -> Option<Self> {
                match value {
                    $pattern => $read,
                    _ => None,
                }
            }
        }
    };
}

// Floats are converted through their shortest decimal form, so that a default of 0.1f32 prints as 0.1.
fn widen(x: f32) -> f64 {
    decimal(x).unwrap_or_else(|| parsed(x))
}

/// The same for most numbers that people write, in a tenth of the time: hosts set parameters in every frame. `None`
/// where it takes more decimals, and where two forms are equally near.
fn decimal(x: f32) -> Option<f64> {
    const MOST: f64 = (1_u32 << 24) as f64;
    const DECIMALS: usize = 6;
    let wide = f64::from(x);
    // Below this limit no digit before the point can be left out, so the form with the least decimals is the shortest.
    // The products are exact, and quotients of whole numbers are rounded as the texts of these numbers are.
    if wide.abs() >= MOST || wide.is_nan() {
        return None;
    }
    let mut tens = 1.0;
    for _ in 0..=DECIMALS {
        let product = wide * tens;
        // The nearest whole number: `round` is a call where a processor is not known to have it.
        let whole = ((product.abs() + 0.5) as i64 as f64).copysign(product);
        if (whole / tens) as f32 == x {
            return ((product - whole).abs() != 0.5).then(|| whole / tens);
        }
        tens *= 10.0;
    }
    None
}

fn parsed(x: f32) -> f64 {
    let mut digits = Digits { bytes: [0; 24], length: 0 };
    write!(digits, "{x:e}").expect("a float has at most nine digits, a point, an exponent and two signs");
    let text = std::str::from_utf8(&digits.bytes[..digits.length]).expect("it is ASCII");
    text.parse().expect("a float's own text is a number")
}

/// The text of a number, without an allocation: hosts set parameters in every frame.
struct Digits {
    bytes: [u8; 24],
    length: usize,
}

impl Write for Digits {
    fn write_str(&mut self, text: &str) -> std::fmt::Result {
        let end = self.length + text.len();
        self.bytes.get_mut(self.length..end).ok_or(std::fmt::Error)?.copy_from_slice(text.as_bytes());
        self.length = end;
        Ok(())
    }
}

fn widen_all<const N: usize>(v: [f32; N]) -> Value {
    let mut all = [0.0; 4];
    all.iter_mut().zip(v).for_each(|(to, x)| *to = widen(x));
    Value::Vector(all, N)
}

fn narrow<const N: usize>(v: &[f64; 4]) -> [f32; N] {
    std::array::from_fn(|i| v[i] as f32)
}

param_type!(bool, Type::Bool, Value::Bool(v) => Some(*v), me => Value::Bool(me));
param_type!(u32, Type::Int, Value::Int(v) => u32::try_from(*v).ok(), me => Value::Int(i64::from(me)));
param_type!(i32, Type::Int, Value::Int(v) => i32::try_from(*v).ok(), me => Value::Int(i64::from(me)));
param_type!(f32, Type::Float, Value::Float(v) => Some(*v as f32), me => Value::Float(widen(me)));
param_type!([f32; 2], Type::Vector(2), Value::Vector(v, 2) => Some(narrow(v)), me => widen_all(me));
param_type!([f32; 3], Type::Vector(3), Value::Vector(v, 3) => Some(narrow(v)), me => widen_all(me));
param_type!([f32; 4], Type::Vector(4), Value::Vector(v, 4) => Some(narrow(v)), me => widen_all(me));
param_type!(Arc<str>, Type::Text, Value::Text(v) => Some(v.clone()), me => Value::Text(me));
param_type!(FileValue, Type::File, Value::File(v) => Some(v.clone()), me => Value::File(me));

#[cfg(test)]
mod tests {
    use super::{decimal, parsed};

    /// A tenth of the numbers, or all of them for `tests/sweeps.sh`.
    #[test]
    fn numbers_widen_as_their_shortest_texts_read() {
        let step = if std::env::var("AFTERIMAGE_SWEEPS").is_ok_and(|asked| asked == "all") { 1 } else { 10 };
        let any = (0..300_000_u32).step_by(step).map(|at| f32::from_bits(at.wrapping_mul(0x9e37_79b9)));
        let halves = (0..60_000).step_by(step).map(|at| 16.0 + at as f32 / 128.0);
        let large = (0..60_000).step_by(step).map(|at| 2_097_152.0 + at as f32 / 4.0);
        // Of 1000 successive numbers not only those with two decimals.
        let written =
            (-90_000..90_000).step_by(step).map(|at| (f64::from(at + at / 1000 % step as i32) / 1000.0) as f32);
        let mut found = 0;
        for x in any.chain(halves).chain(large).chain(written.clone()).chain([0.0, -0.0, f32::MIN_POSITIVE]) {
            if let Some(wide) = decimal(x) {
                assert_eq!(wide.to_bits(), parsed(x).to_bits(), "{x:e}");
                found += 1;
            }
        }
        assert!(found > 200_000 / step, "{found} numbers have a few decimals");
        assert!(written.into_iter().all(|x| decimal(x).is_some()));
        assert_eq!(decimal(f32::NAN), None);
    }
}
