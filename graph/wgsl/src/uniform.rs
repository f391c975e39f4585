//! Uniform bytes, packed by name: no padding by hand, no struct to keep equal on both sides.

use crate::reflect::{Member, Reflection, ScalarKind};
use afterimage_base::value::Value;

/// A value on its way into a uniform.
#[derive(Clone, Debug, PartialEq)]
pub enum UniformValue {
    /// One or more numbers; an array's elements one after the other.
    Floats(Vec<f32>),
    /// One or more whole numbers.
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

uniform_from!(f32, me => Self::Floats(vec![me]));
uniform_from!(f64, me => Self::Floats(vec![me as f32]));
uniform_from!(u32, me => Self::Ints(vec![i64::from(me)]));
uniform_from!(i32, me => Self::Ints(vec![i64::from(me)]));
uniform_from!(bool, me => Self::Ints(vec![i64::from(me)]));

impl<const N: usize> From<[f32; N]> for UniformValue {
    fn from(me: [f32; N]) -> Self {
        Self::Floats(me.to_vec())
    }
}

impl<const N: usize> From<[f64; N]> for UniformValue {
    fn from(me: [f64; N]) -> Self {
        Self::Floats(me.iter().map(|x| *x as f32).collect())
    }
}

impl<const N: usize> From<[u32; N]> for UniformValue {
    fn from(me: [u32; N]) -> Self {
        Self::Ints(me.iter().map(|x| i64::from(*x)).collect())
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
            Value::Bool(v) => Self::Ints(vec![i64::from(*v)]),
            Value::Int(v) => Self::Ints(vec![*v]),
            Value::Float(v) => Self::Floats(vec![*v as f32]),
            Value::Vector(v, n) => Self::Floats(v[..*n].iter().map(|x| *x as f32).collect()),
            // Choices pick functions, texts pick parts of files, and files become images: none is a number.
            Value::Choice(_) | Value::Text(_) | Value::File(_) => Self::Floats(Vec::new()),
        }
    }
}

impl UniformValue {
    fn len(&self) -> usize {
        match self {
            Self::Floats(v) => v.len(),
            Self::Ints(v) => v.len(),
        }
    }

    fn word(&self, index: usize, scalar: ScalarKind) -> [u8; 4] {
        match (self, scalar) {
            (Self::Floats(v), ScalarKind::Float) => v[index].to_le_bytes(),
            (Self::Floats(v), ScalarKind::Int) => (v[index] as i32).to_le_bytes(),
            (Self::Floats(v), ScalarKind::Uint) => (v[index] as u32).to_le_bytes(),
            (Self::Ints(v), ScalarKind::Float) => (v[index] as f32).to_le_bytes(),
            (Self::Ints(v), ScalarKind::Int) => (v[index] as i32).to_le_bytes(),
            (Self::Ints(v), ScalarKind::Uint) => (v[index] as u32).to_le_bytes(),
        }
    }
}

impl Reflection {
    /// The bytes of the uniform struct `ty`, where the last of several values of one name counts. Values without a
    /// member are left out.
    ///
    /// # Errors
    /// A struct that does not exist, and a member without a value or with too many numbers.
    pub fn pack(&self, ty: &str, values: &[(&str, UniformValue)]) -> Result<Vec<u8>, String> {
        let layout = self.layout(ty).ok_or_else(|| format!("there is no struct `{ty}`"))?;
        let mut bytes = vec![0; layout.size as usize];
        for member in &layout.members {
            let error = |why: String| format!("`{ty}.{}` {why}", member.name);
            let value = values.iter().rev().find(|(name, _)| *name == member.name);
            let (_, value) = value.ok_or_else(|| error("has no value".into()))?;
            write_member(&mut bytes, member, value).map_err(error)?;
        }
        Ok(bytes)
    }
}

fn write_member(bytes: &mut [u8], member: &Member, value: &UniformValue) -> Result<(), String> {
    let (width, count) = (member.width as usize, member.count as usize);
    if value.len() > width * count || !value.len().is_multiple_of(width) {
        return Err(format!("takes {} numbers, not {}", width * count, value.len()));
    }
    for index in 0..value.len() {
        let at = member.offset as usize + (index / width) * member.stride as usize + (index % width) * 4;
        bytes[at..at + 4].copy_from_slice(&value.word(index, member.scalar));
    }
    Ok(())
}
