//! How long frames take: by the GPU's own clock where it can be trusted, by the host's otherwise.

use std::cell::Cell;
use std::time::{Duration, Instant};

use afterimage_gpu::{Gpu, GpuError};
use wgpu::{BufferUsages, CommandEncoder, Features};

use crate::failure::Failure;

/// A GPU sleeps until there is work: so long is it kept busy before anything is measured.
const WARMING: Duration = Duration::from_millis(60);
/// After so long without work it may have fallen asleep, and its clock rises by steps: it is awake once so long nothing has become faster.
const DOZING: Duration = Duration::from_millis(80);
const STEADY: Duration = Duration::from_millis(300);
/// A clock that has not risen by then will not.
const LONGEST: Duration = Duration::from_secs(3);
/// Frames at once while it is woken: one that waits for the host after each frame sleeps on.
const CROWD: u32 = 16;

/// Measures work on one GPU.
pub(crate) struct Stopwatch<'g> {
    gpu: &'g Gpu,
    stamps: Option<Stamps>,
    /// When the last measurement ended.
    last: Cell<Option<Instant>>,
}

/// The two timestamps around a frame. Nothing is written between them, so that the passes may overlap as they always do.
struct Stamps {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    readable: wgpu::Buffer,
    milliseconds: f64,
}

impl Stamps {
    fn new(gpu: &Gpu) -> Option<Self> {
        let needed = Features::TIMESTAMP_QUERY | Features::TIMESTAMP_QUERY_INSIDE_ENCODERS;
        // A driver on the processor stamps the time of recording, not of execution.
        if gpu.is_processor() || !gpu.device.features().contains(needed) {
            return None;
        }
        let queries = gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
            label: Some("frame"),
            ty: wgpu::QueryType::Timestamp,
            count: 2,
        });
        let buffer = |usage| {
            gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("frame"),
                size: 16,
                usage,
                mapped_at_creation: false,
            })
        };
        Some(Self {
            queries,
            resolved: buffer(BufferUsages::QUERY_RESOLVE | BufferUsages::COPY_SRC),
            readable: buffer(BufferUsages::MAP_READ | BufferUsages::COPY_DST),
            milliseconds: f64::from(gpu.queue.get_timestamp_period()) * 1e-6,
        })
    }

    fn resolve(&self, encoder: &mut CommandEncoder) {
        encoder.resolve_query_set(&self.queries, 0..2, &self.resolved, 0);
        encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.readable, 0, 16);
    }

    fn read(&self, gpu: &Gpu) -> Result<f64, Failure> {
        self.readable.slice(..).map_async(wgpu::MapMode::Read, |_| {});
        wait(gpu)?;
        let words: [u64; 2] = {
            let mapped = self.readable.slice(..).get_mapped_range().map_err(|error| lost(&error))?;
            bytemuck::pod_read_unaligned(&mapped)
        };
        self.readable.unmap();
        Ok(words[1].saturating_sub(words[0]) as f64 * self.milliseconds)
    }
}

/// Waits until the GPU has nothing more to do.
pub(crate) fn wait(gpu: &Gpu) -> Result<(), Failure> {
    wait_for(gpu, None)
}

/// Waits for the end of a submission; of the last one if none is named.
pub(crate) fn wait_for(gpu: &Gpu, submission_index: Option<wgpu::SubmissionIndex>) -> Result<(), Failure> {
    let wait = wgpu::PollType::Wait { submission_index, timeout: None };
    gpu.device.poll(wait).map(drop).map_err(|error| lost(&error))
}

fn lost(error: &dyn std::fmt::Display) -> Failure {
    GpuError::DeviceLost { why: error.to_string() }.into()
}

/// The middle value; the mean of the two middle ones of an even number.
pub(crate) fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    match values.len() {
        0 => 0.0,
        n if n % 2 == 1 => values[middle],
        _ => 0.5 * (values[middle - 1] + values[middle]),
    }
}

/// Work that is recorded again for every measurement.
pub(crate) type Record<'r> = Box<dyn FnMut(&mut CommandEncoder) -> Result<(), Failure> + 'r>;

impl<'g> Stopwatch<'g> {
    pub(crate) fn new(gpu: &'g Gpu) -> Self {
        Self { gpu, stamps: Stamps::new(gpu), last: Cell::new(None) }
    }

    /// Whether it is the GPU's clock.
    pub(crate) fn is_gpu(&self) -> bool {
        self.stamps.is_some()
    }

    /// The median of `frames` frames in milliseconds, each alone on the GPU, after a warm-up.
    pub(crate) fn median(
        &self,
        frames: u32,
        mut record: impl FnMut(&mut CommandEncoder) -> Result<(), Failure>,
    ) -> Result<f64, Failure> {
        if self.is_gpu() && self.last.get().is_none_or(|last| last.elapsed() > DOZING) {
            self.wake(&mut record)?;
        }
        let start = Instant::now();
        self.once(&mut record)?;
        while self.is_gpu() && start.elapsed() < WARMING {
            self.once(&mut record)?;
        }
        let times = (0..frames).map(|_| self.once(&mut record)).collect::<Result<_, _>>()?;
        self.last.set(Some(Instant::now()));
        Ok(median(times))
    }

    /// Keeps the GPU busy until frames no longer become faster.
    fn wake(&self, record: &mut impl FnMut(&mut CommandEncoder) -> Result<(), Failure>) -> Result<(), Failure> {
        let start = Instant::now();
        let (mut fastest, mut since) = (Duration::MAX, start);
        while since.elapsed() < STEADY && start.elapsed() < LONGEST {
            let begin = Instant::now();
            for _ in 0..CROWD {
                let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
                record(&mut encoder)?;
                self.gpu.queue.submit([encoder.finish()]);
            }
            wait(self.gpu)?;
            if begin.elapsed() < fastest.saturating_sub(fastest / 20) {
                (fastest, since) = (begin.elapsed(), Instant::now());
            }
        }
        Ok(())
    }

    /// The medians of several works that are compared. By the host's clock they take turns, so that whatever else the processor does in the
    /// meantime slows all of them alike; the GPU is ours alone, and there one comes after the other, as in a program that does nothing else.
    pub(crate) fn medians(&self, frames: u32, works: &mut [Record<'_>]) -> Result<Vec<f64>, Failure> {
        if self.is_gpu() {
            return works.iter_mut().map(|record| self.median(frames, record)).collect();
        }
        let mut times = vec![Vec::new(); works.len()];
        for round in 0..=frames {
            for (record, times) in works.iter_mut().zip(&mut times) {
                let time = self.once(record)?;
                // The first round warms up.
                if round > 0 {
                    times.push(time);
                }
            }
        }
        Ok(times.into_iter().map(median).collect())
    }

    fn once(&self, record: &mut impl FnMut(&mut CommandEncoder) -> Result<(), Failure>) -> Result<f64, Failure> {
        let start = Instant::now();
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        if let Some(stamps) = &self.stamps {
            encoder.write_timestamp(&stamps.queries, 0);
        }
        record(&mut encoder)?;
        if let Some(stamps) = &self.stamps {
            encoder.write_timestamp(&stamps.queries, 1);
            stamps.resolve(&mut encoder);
        }
        self.gpu.queue.submit([encoder.finish()]);
        wait(self.gpu)?;
        match &self.stamps {
            Some(stamps) => stamps.read(self.gpu),
            None => Ok(start.elapsed().as_secs_f64() * 1e3),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::median;

    #[test]
    fn medians() {
        assert_eq!(median(vec![3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(vec![4.0, 1.0, 3.0, 2.0]), 2.5);
    }
}
