//! Host blocks: structs of numbers that the host gives for each frame, such as its camera.

use afterimage_wgsl::{ScalarKind, StructLayout};

/// The declaration of a host block: its shader has a struct of the same name with the same members.
#[derive(Debug, PartialEq)]
pub struct HostBlock {
    /// The name of the struct, as pipeline files and shaders write it.
    pub name: &'static str,
    /// Description for the manual.
    pub doc: &'static str,
    /// The members, in the order of the struct.
    pub fields: &'static [BlockField],
}

/// A member of a host block.
#[derive(Debug, PartialEq)]
pub struct BlockField {
    /// Its name.
    pub name: &'static str,
    /// Its type.
    pub ty: FieldType,
    /// Description with the unit.
    pub doc: &'static str,
    /// Its numbers where the host sets none; columns of a matrix one after the other.
    pub default: &'static [f32],
}

/// The type of a member of a host block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FieldType {
    /// `f32`.
    Float,
    /// `vec2f`.
    Vector2,
    /// `vec3f`.
    Vector3,
    /// `vec4f`.
    Vector4,
    /// `mat4x4f`.
    Matrix4,
}

impl FieldType {
    /// Number of components.
    pub const fn numbers(self) -> usize {
        match self {
            Self::Float => 1,
            Self::Vector2 => 2,
            Self::Vector3 => 3,
            Self::Vector4 => 4,
            Self::Matrix4 => 16,
        }
    }

    /// Alignment in a uniform buffer, in bytes.
    const fn alignment(self) -> usize {
        match self {
            Self::Float => 4,
            Self::Vector2 => 8,
            Self::Vector3 | Self::Vector4 | Self::Matrix4 => 16,
        }
    }
}

impl HostBlock {
    /// The members, each with its offset in bytes.
    pub fn layout(&self) -> impl Iterator<Item = (usize, &'static BlockField)> + '_ {
        self.fields.iter().scan(0_usize, |end, field| {
            let offset = end.next_multiple_of(field.ty.alignment());
            *end = offset + 4 * field.ty.numbers();
            Some((offset, field))
        })
    }

    /// Returns whether a struct of a shader has these members at these places.
    pub fn fits(&self, layout: &StructLayout) -> bool {
        layout.members.len() == self.fields.len()
            && self.layout().zip(&layout.members).all(|((offset, field), member)| {
                member.name == field.name
                    && member.offset as usize == offset
                    && member.scalar == ScalarKind::Float
                    && (member.width * member.count) as usize == field.ty.numbers()
                    && (member.count > 1) == (field.ty == FieldType::Matrix4)
            })
    }

    /// Bytes of the struct in a uniform buffer.
    pub fn bytes(&self) -> usize {
        let end = self.layout().last().map_or(0, |(offset, field)| offset + 4 * field.ty.numbers());
        end.next_multiple_of(16)
    }
}

/// The numbers of a host block for one frame.
#[derive(Clone, Debug, PartialEq)]
pub struct BlockData {
    block: &'static HostBlock,
    bytes: Vec<u8>,
}

impl BlockData {
    /// The block with the defaults of its members.
    pub fn new(block: &'static HostBlock) -> Self {
        let mut data = Self { block, bytes: vec![0; block.bytes()] };
        block.layout().for_each(|(offset, field)| data.write(offset, field.default));
        data
    }

    /// The declaration.
    pub fn block(&self) -> &'static HostBlock {
        self.block
    }

    /// The bytes of the struct, as uniform buffers hold them.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Sets a member; columns of a matrix one after the other.
    ///
    /// # Errors
    /// There is no such member, it has another number of numbers, or one of them is not finite: a sentence.
    pub fn set(&mut self, name: &str, numbers: &[f32]) -> Result<(), String> {
        let Some((offset, field)) = self.block.layout().find(|(_, field)| field.name == name) else {
            let names: Vec<_> = self.block.fields.iter().map(|field| field.name).collect();
            return Err(format!("`{}` has no member `{name}`: its members are {}", self.block.name, names.join(", ")));
        };
        if numbers.len() != field.ty.numbers() {
            let expected = field.ty.numbers();
            return Err(format!("`{}.{name}` takes {expected} numbers, not {}", self.block.name, numbers.len()));
        }
        if let Some(wrong) = numbers.iter().find(|number| !number.is_finite()) {
            return Err(format!("`{}.{name}` takes finite numbers, not {wrong}", self.block.name));
        }
        self.write(offset, numbers);
        Ok(())
    }

    /// The numbers of a member.
    pub fn get(&self, name: &str) -> Option<Vec<f32>> {
        let (offset, field) = self.block.layout().find(|(_, field)| field.name == name)?;
        let words = self.bytes[offset..][..4 * field.ty.numbers()].as_chunks::<4>().0;
        Some(words.iter().map(|word| f32::from_le_bytes(*word)).collect())
    }

    fn write(&mut self, offset: usize, numbers: &[f32]) {
        for (word, number) in self.bytes[offset..].as_chunks_mut::<4>().0.iter_mut().zip(numbers) {
            *word = number.to_le_bytes();
        }
    }
}
