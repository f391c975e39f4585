//! Shaders to pipelines, each compiled once while plans ask for it.

use std::sync::Mutex;

use afterimage_plan::Stage;
use afterimage_plan::codegen::Composed;
use rustc_hash::FxHashMap;

use crate::GpuError;
use crate::layout::Pipeline;

/// What makes two pipelines the same.
#[derive(Clone, PartialEq, Eq, Hash)]
pub(crate) struct PipelineKey {
    pub(crate) source: String,
    pub(crate) entry: &'static str,
    pub(crate) constants: Vec<(&'static str, u64)>,
    /// The attachment's format of a draw.
    pub(crate) attachment: Option<wgpu::TextureFormat>,
    /// How the layout reads its textures: two passes with one text may differ in what is filterable.
    pub(crate) layout: String,
    /// Whether the driver adds checks of indices and loops.
    pub(crate) checked: bool,
}

/// A pipeline and the layout of its bind group.
#[derive(Clone)]
pub(crate) struct Built {
    pub(crate) pipeline: Pipeline,
    pub(crate) layout: wgpu::BindGroupLayout,
}

/// Pipelines that none of so many calls of [`Pipelines::build`] asked for are dropped: who edits a shader for hours keeps the last versions. PlanCache
/// that are loaded hold their own.
const KEPT: u64 = 64;

/// What was compiled, by whichever thread.
#[derive(Default)]
pub(crate) struct Pipelines {
    shelf: Mutex<Shelf<Built>>,
    pub(crate) cache: Option<wgpu::PipelineCache>,
}

/// Pipelines, with the number of the call that last asked for each.
struct Shelf<T> {
    calls: u64,
    built: FxHashMap<PipelineKey, (T, u64)>,
}

impl<T> Default for Shelf<T> {
    fn default() -> Self {
        Self { calls: 0, built: FxHashMap::default() }
    }
}

impl<T: Clone> Shelf<T> {
    /// Notes one more call, and drops what was not asked for in a long time.
    fn begin<'k>(&mut self, asked: impl Iterator<Item = &'k PipelineKey>) {
        self.calls += 1;
        for key in asked {
            if let Some((_, call)) = self.built.get_mut(key) {
                *call = self.calls;
            }
        }
        self.built.retain(|_, (_, call)| *call + KEPT > self.calls);
    }

    fn put(&mut self, key: PipelineKey, built: T) {
        self.built.insert(key, (built, self.calls));
    }

    fn get(&self, key: &PipelineKey) -> Option<T> {
        self.built.get(key).map(|(built, _)| built.clone())
    }
}

/// A pipeline to be built.
pub(crate) struct Order<'a> {
    pub(crate) key: PipelineKey,
    pub(crate) composed: &'a Composed,
    pub(crate) stage: Stage,
    pub(crate) layout: wgpu::BindGroupLayout,
    /// Bytes of immediates that the shader reads.
    pub(crate) immediate_bytes: u32,
    pub(crate) label: String,
    /// Whether the shader may read workgroup memory that it has not written.
    pub(crate) zero_workgroup_memory: bool,
}

impl Pipelines {
    /// With the driver's cache.
    pub(crate) fn with_cache(cache: Option<wgpu::PipelineCache>) -> Self {
        Self { shelf: Mutex::default(), cache }
    }

    pub(crate) fn get(&self, key: &PipelineKey) -> Option<Built> {
        self.shelf.lock().expect(UNBROKEN).get(key)
    }

    /// Compiles what is missing, on so many threads; the first refusal of the device, if there is one.
    pub(crate) fn build(&self, device: &wgpu::Device, orders: Vec<Order<'_>>, threads: usize) -> Result<(), GpuError> {
        self.shelf.lock().expect(UNBROKEN).begin(orders.iter().map(|order| &order.key));
        let mut missing: Vec<Order<'_>> = Vec::new();
        for order in orders {
            if self.get(&order.key).is_none() && missing.iter().all(|known| known.key != order.key) {
                missing.push(order);
            }
        }
        let threads = threads.min(missing.len());
        let (queue, refused) = (Mutex::new(missing), Mutex::new(None));
        std::thread::scope(|scope| {
            for _ in 0..threads {
                scope.spawn(|| {
                    while let Some(order) = pop(&queue) {
                        if let Err(error) = self.build_one(device, order) {
                            refused.lock().expect(UNBROKEN).get_or_insert(error);
                        }
                    }
                });
            }
        });
        refused.into_inner().expect(UNBROKEN).map_or(Ok(()), Err)
    }

    fn build_one(&self, device: &wgpu::Device, order: Order<'_>) -> Result<(), GpuError> {
        let what = format!("the shader of `{}`", order.label);
        let pipeline = watched(device, &what, || Ok(compile(device, self.cache.as_ref(), &order)))?;
        let built = Built { pipeline, layout: order.layout };
        self.shelf.lock().expect(UNBROKEN).put(order.key, built);
        Ok(())
    }
}

const UNBROKEN: &str = "no thread panics with the lock";

/// What `make` gives, unless the device has something against it. Errors of a device belong to the thread that causes them.
pub(crate) fn watched<T>(
    device: &wgpu::Device,
    what: &str,
    make: impl FnOnce() -> Result<T, GpuError>,
) -> Result<T, GpuError> {
    let memory = device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
    let validation = device.push_error_scope(wgpu::ErrorFilter::Validation);
    let made = make();
    let refused = pollster::block_on(validation.pop());
    if let Some(error) = pollster::block_on(memory.pop()) {
        return Err(GpuError::OutOfMemory { what: format!("{what} ({error})") });
    }
    match refused {
        Some(error) => Err(GpuError::Refused { what: what.to_owned(), why: error.to_string() }),
        None => made,
    }
}

fn pop<'a>(queue: &Mutex<Vec<Order<'a>>>) -> Option<Order<'a>> {
    queue.lock().expect(UNBROKEN).pop()
}

/// A module without checks of indices and loops: on an H200 kernels with loops take up to two fifths less time.
#[allow(unsafe_code, reason = "the promise of unchecked shaders is what the checks would enforce")]
fn trusted(device: &wgpu::Device, descriptor: wgpu::ShaderModuleDescriptor<'_>) -> wgpu::ShaderModule {
    // SAFETY: every part of the module was made by `Shader::unchecked`, whose callers promise that all accesses lie inside and all loops
    // end, or by the composer, which loads texels only within the result's size.
    unsafe { device.create_shader_module_trusted(descriptor, wgpu::ShaderRuntimeChecks::unchecked()) }
}

fn compile(device: &wgpu::Device, cache: Option<&wgpu::PipelineCache>, order: &Order<'_>) -> Pipeline {
    let descriptor = wgpu::ShaderModuleDescriptor {
        label: Some(&order.label),
        source: wgpu::ShaderSource::Wgsl(order.composed.source.as_str().into()),
    };
    let module = if order.key.checked { device.create_shader_module(descriptor) } else { trusted(device, descriptor) };
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(&order.label),
        bind_group_layouts: &[Some(&order.layout)],
        immediate_size: order.immediate_bytes,
    });
    let constants: Vec<(&str, f64)> =
        order.key.constants.iter().map(|(name, bits)| (*name, f64::from_bits(*bits))).collect();
    let compilation_options = wgpu::PipelineCompilationOptions {
        constants: &constants,
        zero_initialize_workgroup_memory: order.zero_workgroup_memory,
    };
    match order.stage {
        Stage::Compute => Pipeline::Compute(device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(&order.label),
            layout: Some(&layout),
            module: &module,
            entry_point: Some(order.composed.compute),
            compilation_options,
            cache,
        })),
        Stage::Fragment => {
            let format = order.key.attachment.expect("a draw has an attachment");
            Pipeline::Render(device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some(&order.label),
                layout: Some(&layout),
                vertex: wgpu::VertexState {
                    module: &module,
                    entry_point: Some("vertex"),
                    compilation_options: Default::default(),
                    buffers: &[],
                },
                primitive: Default::default(),
                depth_stencil: None,
                multisample: Default::default(),
                fragment: Some(wgpu::FragmentState {
                    module: &module,
                    entry_point: order.composed.fragment,
                    compilation_options,
                    targets: &[Some(format.into())],
                }),
                multiview_mask: None,
                cache,
            }))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{KEPT, PipelineKey, Shelf};

    fn key(source: &str) -> PipelineKey {
        PipelineKey {
            source: source.to_owned(),
            entry: "compute",
            constants: Vec::new(),
            attachment: None,
            layout: String::new(),
            checked: true,
        }
    }

    #[test]
    fn what_plans_still_ask_for_stays_and_old_versions_go() {
        let mut shelf = Shelf::default();
        let asked = key("asked for by every plan");
        shelf.begin([&asked].into_iter());
        shelf.put(asked.clone(), "asked");
        for version in 0..3 * KEPT {
            let edited = key(&version.to_string());
            shelf.begin([&asked, &edited].into_iter());
            shelf.put(edited, "edited");
        }
        assert_eq!(shelf.get(&asked), Some("asked"));
        assert_eq!(shelf.built.len() as u64, KEPT + 1);
        assert_eq!(shelf.get(&key(&(2 * KEPT).to_string())), Some("edited"));
        assert_eq!(shelf.get(&key("0")), None);
    }
}
