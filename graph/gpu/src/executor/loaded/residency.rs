//! Residency: the textures and buffers that a plan runs on.

use afterimage_graph::node::ImageId;
use afterimage_plan::HeapPlacement;
use wgpu::{Buffer, TextureView};

use crate::heap::Placed;
use crate::store::Stored;

/// The texture of an image of the plan.
pub(crate) enum ImageBinding {
    /// No pass uses it.
    Unused,
    /// The host's image for this input.
    Input(usize),
    /// The host's image for this output, or else ours.
    Output(usize, Stored),
    /// Always the same texture.
    Fixed(Stored),
    /// A ring of textures, and how many frames before the newest one the image is.
    Ring(Vec<Stored>, u32),
}

/// The memory of a plan. It stays as it is while the plan runs, so that the next plan takes what it can use of it on
/// another thread.
pub struct Residency {
    /// The offsets of images in the heap.
    pub(crate) placement: HeapPlacement,
    /// The images in the heap, if the device can place them.
    pub(crate) placed: Option<Placed>,
    pub(crate) bindings: Vec<ImageBinding>,
    pub(crate) buffers: Vec<Buffer>,
    /// Textures in each ring: one for this frame and one for each that is remembered. It is the same for all rings, so
    /// that one ring index is valid for all.
    pub(crate) ring_length: u32,
    /// The number of the plan's inputs.
    pub(crate) inputs: usize,
}

impl Residency {
    /// The view of an image in that ring index; `views` are those of the host.
    pub(crate) fn view<'a>(&'a self, image: ImageId, views: &'a [TextureView], ring_index: u32) -> &'a TextureView {
        match &self.bindings[image.0 as usize] {
            ImageBinding::Input(_) | ImageBinding::Output(..) => {
                &views[self.host_view(image).expect("it is the host's")]
            }
            ImageBinding::Fixed(stored) => &stored.view,
            ImageBinding::Ring(ring, behind) => &ring[ring_place(ring.len(), ring_index, *behind)].view,
            ImageBinding::Unused => panic!("image {image:?} is bound but no pass uses it"),
        }
    }

    /// The index of an image among the host's views, if it is the host's: inputs, then outputs.
    pub(crate) fn host_view(&self, image: ImageId) -> Option<usize> {
        match &self.bindings[image.0 as usize] {
            ImageBinding::Input(index) => Some(*index),
            ImageBinding::Output(index, _) => Some(self.inputs + index),
            ImageBinding::Unused | ImageBinding::Fixed(_) | ImageBinding::Ring(..) => None,
        }
    }

    /// Our view of an output, for frames in which the host gives none.
    pub(crate) fn own_output(&self, image: ImageId) -> Option<&TextureView> {
        match &self.bindings[image.0 as usize] {
            ImageBinding::Output(_, stored) => Some(&stored.view),
            _ => None,
        }
    }

    /// True if the image is a history image, whose texture rotates every frame.
    pub(crate) fn is_in_ring(&self, image: ImageId) -> bool {
        matches!(self.bindings[image.0 as usize], ImageBinding::Ring(..))
    }

    /// True if the textures of rings of this length keep their ring indices, whichever frame is next.
    pub(crate) fn keeps_places(&self, ring_length: u32) -> bool {
        self.ring_length == ring_length || self.ring_length == 1 || ring_length == 1
    }

    /// The textures of the heap.
    pub(crate) fn heap_textures(&self) -> impl Iterator<Item = &wgpu::Texture> {
        self.placed.iter().flat_map(|placed| placed.images.iter().map(|(_, stored)| &stored.texture))
    }
}

/// The index in a ring of `length` textures of the image that was made `behind` frames before `frame`.
pub(crate) fn ring_place(length: usize, frame: u32, behind: u32) -> usize {
    let length = length as u32;
    ((frame % length + length - behind % length) % length) as usize
}
