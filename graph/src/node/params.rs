//! `params!` and `choices!`: a parameter is declared once, here, and nowhere else.

use afterimage_base::value::{Param, Value};

/// The parameters of a node kind, as `params!` declares them.
pub trait Params: Sized + Clone + Send + Sync + 'static {
    /// The name of the kind, as pipeline files write it.
    const KIND: &'static str;
    /// What the kind does, for the manual.
    const DOC: &'static str;
    /// The declarations, in the order of the struct's fields.
    fn table() -> &'static [Param];
    /// The struct from values in the order of the table; `None` where a value has the wrong type.
    fn from_values(values: &[Value]) -> Option<Self>;
}

/// Declares the parameters of a node kind and, with them, the kind's name and manual text.
///
/// Each field has a doc comment, a type that implements [`ParamType`](crate::value::ParamType), a default, and, after
/// `=>`, calls of [`Param`](crate::value::Param)'s builder methods.
///
/// ```
/// use afterimage_graph::prelude::*;
/// params! {
///     /// Darkens the picture towards its corners.
///     pub struct Corners {
///         /// Share of the effect that is mixed in; 0 changes nothing.
///         pub amount: f32 = 1.0 => within(0.0..=1.0), neutral(0.0);
///         /// Middle of the bright part.
///         pub center: [f32; 2] = [0.5, 0.5] => within(-1.0..=2.0), unit("uv");
///     }
/// }
/// assert_eq!(Corners::table()[1].name, "center");
/// ```
#[macro_export]
macro_rules! params {
    (
        $(#[doc = $kind_doc:literal])*
        pub struct $kind:ident {
            $(
                $(#[doc = $doc:literal])*
                pub $field:ident : $ty:ty = $default:expr $(=> $($method:ident ( $($arg:expr),* $(,)? )),+ )? ;
            )*
        }
    ) => {
        $(#[doc = $kind_doc])*
        #[derive(Clone, Debug, PartialEq)]
        pub struct $kind {
            $( $(#[doc = $doc])* pub $field: $ty, )*
        }

        impl $crate::node::Params for $kind {
            const KIND: &'static str = stringify!($kind);
            const DOC: &'static str = concat!($($kind_doc, "\n"),*);

            fn table() -> &'static [$crate::value::Param] {
                static TABLE: std::sync::OnceLock<Vec<$crate::value::Param>> = std::sync::OnceLock::new();
                TABLE.get_or_init(|| vec![$(
                    $crate::value::Param::new(
                        stringify!($field),
                        concat!($($doc, "\n"),*),
                        <$ty as $crate::value::ParamType>::TYPE,
                        <$ty as $crate::value::ParamType>::into_value($default),
                    ) $( $( .$method($($arg),*) )+ )?,
                )*])
            }

            #[allow(unused_mut, unused_variables, reason = "a kind may have no parameters")]
            fn from_values(values: &[$crate::value::Value]) -> Option<Self> {
                let mut values = values.iter();
                Some(Self {
                    $( $field: <$ty as $crate::value::ParamType>::from_value(values.next()?)?, )*
                })
            }
        }

        impl Default for $kind {
            fn default() -> Self {
                Self { $( $field: $default, )* }
            }
        }
    };
}

/// Declares a parameter type whose values are names. A value that was renamed states its former name, as in `Groups
/// formerly Blocks`: a file that uses that one gets an error with the present name.
///
/// ```
/// use afterimage_graph::prelude::*;
/// choices! {
///     /// How fireflies are tamed.
///     pub enum Firefly {
///         /// Not at all.
///         Off,
///         /// Each tap is weighted by its own brightness.
///         Taps,
///     }
/// }
/// assert_eq!(Firefly::Taps.name(), "Taps");
/// ```
#[macro_export]
macro_rules! choices {
    (
        $(#[doc = $type_doc:literal])*
        pub enum $choice:ident {
            $( $(#[doc = $doc:literal])* $variant:ident $(formerly $former:ident)? ),+ $(,)?
        }
    ) => {
        $(#[doc = $type_doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum $choice {
            $( $(#[doc = $doc])* $variant, )+
        }

        impl $choice {
            /// All values, in the order of their declaration.
            pub const ALL: &'static [Self] = &[$( Self::$variant ),+];

            /// The name in pipeline files.
            pub fn name(self) -> &'static str {
                match self { $( Self::$variant => stringify!($variant) ),+ }
            }
        }

        impl $crate::value::ParamType for $choice {
            const TYPE: $crate::value::Type = $crate::value::Type::Choice(&[$(
                $crate::value::ChoiceName {
                    name: stringify!($variant),
                    doc: concat!($($doc),*),
                    former: concat!($(stringify!($former))?),
                }
            ),+]);

            fn into_value(self) -> $crate::value::Value {
                $crate::value::Value::Choice(self.name())
            }

            fn from_value(value: &$crate::value::Value) -> Option<Self> {
                let $crate::value::Value::Choice(name) = value else { return None };
                Self::ALL.iter().copied().find(|choice| choice.name() == *name)
            }
        }
    };
}
