//! Uniform bytes, packed by name: no padding by hand, no struct to keep equal on both sides.

use std::borrow::Cow;

use crate::reflect::{Member, Reflection, ScalarKind};
use afterimage_base::value::Value;

/// A value on its way into a uniform.
#[derive(Clone, Debug, PartialEq)]
pub enum UniformValue {
    /// The first of these are one to four numbers.
    Few([f32; 4], usize),
    /// Any number of numbers; an array's elements one after the other.
    Floats(Vec<f32>),
    /// The first of these are one to four whole numbers.
    FewInts([i64; 4], usize),
    /// Any number of whole numbers.
    Ints(Vec<i64>),
}

macro_rules! uniform_from {
    ($ty:ty, $me:ident => $value:expr) => {
        impl From<$ty> for UniformValue {
            fn from($me: $ty) -> Self {
                $value
            }
        }
    };
}

uniform_from!(f32, me => Self::Few([me, 0.0, 0.0, 0.0], 1));
uniform_from!(f64, me => Self::from(me as f32));
uniform_from!(u32, me => Self::FewInts([i64::from(me), 0, 0, 0], 1));
uniform_from!(i32, me => Self::FewInts([i64::from(me), 0, 0, 0], 1));
uniform_from!(bool, me => Self::FewInts([i64::from(me), 0, 0, 0], 1));

impl<const N: usize> From<[f32; N]> for UniformValue {
    fn from(me: [f32; N]) -> Self {
        if N > 4 {
            return Self::Floats(me.to_vec());
        }
        Self::Few(std::array::from_fn(|at| me.get(at).copied().unwrap_or(0.0)), N)
    }
}

impl<const N: usize> From<[f64; N]> for UniformValue {
    fn from(me: [f64; N]) -> Self {
        Self::from(me.map(|x| x as f32))
    }
}

impl<const N: usize> From<[u32; N]> for UniformValue {
    fn from(me: [u32; N]) -> Self {
        if N > 4 {
            return Self::Ints(me.iter().map(|x| i64::from(*x)).collect());
        }
        Self::FewInts(std::array::from_fn(|at| me.get(at).map_or(0, |x| i64::from(*x))), N)
    }
}

impl<const N: usize> From<&[[f32; N]]> for UniformValue {
    fn from(me: &[[f32; N]]) -> Self {
        Self::Floats(me.as_flattened().to_vec())
    }
}

impl From<&Value> for UniformValue {
    fn from(me: &Value) -> Self {
        match me {
            Value::Bool(v) => Self::from(*v),
            Value::Int(v) => Self::FewInts([*v, 0, 0, 0], 1),
            Value::Float(v) => Self::from(*v),
            Value::Vector(v, n) => Self::Few(v.map(|x| x as f32), *n),
            // Choices pick functions, texts pick parts of files, and files become images: none is a number.
            Value::Choice(_) | Value::Text(_) | Value::File(_) => Self::Floats(Vec::new()),
        }
    }
}

impl UniformValue {
    fn len(&self) -> usize {
        match self {
            Self::Few(_, length) | Self::FewInts(_, length) => *length,
            Self::Floats(v) => v.len(),
            Self::Ints(v) => v.len(),
        }
    }

    fn word(&self, index: usize, scalar: ScalarKind) -> [u8; 4] {
        match self {
            Self::Few(v, _) => of_float(v[index], scalar),
            Self::Floats(v) => of_float(v[index], scalar),
            Self::FewInts(v, _) => of_int(v[index], scalar),
            Self::Ints(v) => of_int(v[index], scalar),
        }
    }
}

fn of_float(value: f32, scalar: ScalarKind) -> [u8; 4] {
    match scalar {
        ScalarKind::Float => value.to_le_bytes(),
        ScalarKind::Int => (value as i32).to_le_bytes(),
        ScalarKind::Uint => (value as u32).to_le_bytes(),
    }
}

fn of_int(value: i64, scalar: ScalarKind) -> [u8; 4] {
    match scalar {
        ScalarKind::Float => (value as f32).to_le_bytes(),
        ScalarKind::Int => (value as i32).to_le_bytes(),
        ScalarKind::Uint => (value as u32).to_le_bytes(),
    }
}

impl Reflection {
    /// The bytes of the uniform struct `ty`, where the last of several values of one name counts. Values without a
    /// member are left out.
    ///
    /// # Errors
    /// A struct that does not exist, and a member without a value or with too many numbers.
    pub fn pack(&self, ty: &str, values: &[(&str, UniformValue)]) -> Result<Vec<u8>, String> {
        self.pack_with(ty, |name| {
            let value = values.iter().rev().find(|(known, _)| *known == name);
            value.map(|(_, value)| Cow::Borrowed(value))
        })
    }

    /// The same for values that are found by their names.
    ///
    /// # Errors
    /// As [`pack`](Self::pack).
    pub fn pack_with<'v>(
        &self,
        ty: &str,
        value_of: impl Fn(&str) -> Option<Cow<'v, UniformValue>>,
    ) -> Result<Vec<u8>, String> {
        let mut bytes = vec![0; self.size(ty).unwrap_or(0)];
        self.pack_into(ty, value_of, &mut bytes)?;
        Ok(bytes)
    }

    /// The bytes of the uniform struct `ty`, if there is one.
    pub fn size(&self, ty: &str) -> Option<usize> {
        self.layout(ty).map(|layout| layout.size as usize)
    }

    /// The same over bytes of that [`size`](Self::size).
    ///
    /// # Errors
    /// As [`pack`](Self::pack).
    pub fn pack_into<'v>(
        &self,
        ty: &str,
        value_of: impl Fn(&str) -> Option<Cow<'v, UniformValue>>,
        bytes: &mut [u8],
    ) -> Result<(), String> {
        let layout = self.layout(ty).ok_or_else(|| format!("there is no struct `{ty}`"))?;
        bytes.fill(0);
        for member in &layout.members {
            let error = |why: String| format!("`{ty}.{}` {why}", member.name);
            let value = value_of(&member.name).ok_or_else(|| error("has no value".into()))?;
            member.write(&value, bytes).map_err(error)?;
        }
        Ok(())
    }
}

impl Member {
    /// Writes a value over the bytes of the struct.
    ///
    /// # Errors
    /// It has too many numbers: a sentence without its subject.
    pub fn write(&self, value: &UniformValue, bytes: &mut [u8]) -> Result<(), String> {
        let (width, count) = (self.width as usize, self.count as usize);
        if value.len() > width * count || !value.len().is_multiple_of(width) {
            return Err(format!("takes {} numbers, not {}", width * count, value.len()));
        }
        for index in 0..value.len() {
            let at = self.offset as usize + (index / width) * self.stride as usize + (index % width) * 4;
            bytes[at..at + 4].copy_from_slice(&value.word(index, self.scalar));
        }
        Ok(())
    }
}
