//! Views of the depth in textures that have a stencil, too: a shader reads one aspect.

use wgpu::{Device, TextureAspect, TextureFormat, TextureView, TextureViewDescriptor, TextureViewDimension};

/// True if a texture of the format has a depth and a stencil.
pub(crate) fn has_stencil(format: TextureFormat) -> bool {
    format.has_depth_aspect() && format.has_stencil_aspect()
}

/// A view of the depth alone: the host's, if it is one, or else one of that level of the first layer of its texture.
pub(crate) fn depth_view(device: &Device, view: &TextureView, base_mip_level: u32) -> TextureView {
    if is_depth_alone(device, view) {
        return view.clone();
    }
    view.texture().create_view(&TextureViewDescriptor {
        label: Some("depth"),
        dimension: Some(TextureViewDimension::D2),
        aspect: TextureAspect::DepthOnly,
        base_mip_level,
        mip_level_count: Some(1),
        array_layer_count: Some(1),
        ..Default::default()
    })
}

/// True if a shader can read the view. wgpu has no query for its aspect, so it is bound by trial.
#[cfg(not(target_family = "wasm"))]
fn is_depth_alone(device: &Device, view: &TextureView) -> bool {
    let bound = crate::platform::watched(device, "a view of a depth", || {
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("depth"),
            entries: &[wgpu::BindGroupLayoutEntry {
                binding: 0,
                visibility: wgpu::ShaderStages::COMPUTE,
                ty: wgpu::BindingType::Texture {
                    sample_type: wgpu::TextureSampleType::Float { filterable: false },
                    view_dimension: TextureViewDimension::D2,
                    multisampled: view.texture().sample_count() > 1,
                },
                count: None,
            }],
        });
        Ok(device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("depth"),
            layout: &layout,
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: wgpu::BindingResource::TextureView(view) }],
        }))
    });
    bound.is_ok()
}

/// The web reports no error in time.
#[cfg(target_family = "wasm")]
fn is_depth_alone(_device: &Device, _view: &TextureView) -> bool {
    false
}
