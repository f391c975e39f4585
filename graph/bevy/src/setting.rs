//! Values of facts and parameters, and the target of the result, as a game sets them.

use afterimage::host::{Fact, Type, Value};
use bevy::prelude::*;

/// A value of a fact or of a parameter.
#[derive(Clone, Debug, PartialEq, Reflect)]
#[reflect(Clone, Debug, PartialEq)]
#[type_path = "bevy_afterimage"]
pub enum Setting {
    /// On or off.
    Flag(bool),
    /// A number.
    Number(f64),
    /// A color or another vector.
    Vector(Vec<f32>),
    /// One of the names that the parameter declares.
    Choice(String),
}

/// The target of the result.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Clone, Debug, Default, PartialEq)]
#[type_path = "bevy_afterimage"]
pub enum Target {
    /// The camera's main texture, in linear light: what Bevy draws after it, such as its UI, comes on top.
    #[default]
    MainTexture,
    /// The window or image that the camera renders to, without a copy. Nothing is drawn on top.
    Output,
}

/// A time to hold, and the tiers among which a governor chooses.
#[derive(Clone, Debug, Default, PartialEq, Reflect)]
#[reflect(Clone, Debug, Default, PartialEq)]
#[type_path = "bevy_afterimage"]
pub struct Budget {
    /// Milliseconds on the device for the passes of the pipeline. A number that is not above zero keeps the cheapest.
    pub ms: f64,
    /// Names of tiers, from the worst picture to the best.
    pub tiers: Vec<String>,
    /// The least claim in JOD of a tier that may be chosen, if any.
    pub min_jod: Option<f64>,
}

impl From<bool> for Setting {
    fn from(flag: bool) -> Self {
        Self::Flag(flag)
    }
}

impl From<f32> for Setting {
    fn from(number: f32) -> Self {
        Self::Number(number.into())
    }
}

impl From<f64> for Setting {
    fn from(number: f64) -> Self {
        Self::Number(number)
    }
}

impl From<i32> for Setting {
    fn from(number: i32) -> Self {
        Self::Number(number.into())
    }
}

impl From<&str> for Setting {
    fn from(name: &str) -> Self {
        Self::Choice(name.to_owned())
    }
}

impl<const N: usize> From<[f32; N]> for Setting {
    fn from(vector: [f32; N]) -> Self {
        Self::Vector(vector.to_vec())
    }
}

impl Setting {
    /// The fact, which is a flag or a number.
    pub(crate) fn fact(&self) -> Option<Fact> {
        match self {
            Self::Flag(flag) => Some(Fact::Flag(*flag)),
            Self::Number(number) => Some(Fact::Number(*number)),
            Self::Vector(_) | Self::Choice(_) => None,
        }
    }

    /// The value for a parameter of that type, which the parameter itself checks. `None` for a choice that it has not,
    /// and for more numbers than a vector has.
    pub(crate) fn value(&self, ty: Type) -> Option<Value> {
        Some(match (self, ty) {
            (Self::Flag(flag), _) => Value::Bool(*flag),
            (Self::Number(number), Type::Int) if number.fract() == 0.0 => Value::Int(*number as i64),
            (Self::Number(number), _) => Value::Float(*number),
            (Self::Vector(numbers), _) => {
                let mut vector = [0.0; 4];
                vector.get_mut(..numbers.len())?.iter_mut().zip(numbers).for_each(|(to, from)| *to = f64::from(*from));
                Value::Vector(vector, numbers.len())
            }
            (Self::Choice(name), Type::Choice(choices)) => {
                Value::Choice(choices.iter().find(|choice| choice.name == name)?.name)
            }
            (Self::Choice(name), _) => Value::Text(name.as_str().into()),
        })
    }
}
