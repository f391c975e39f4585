//! The one clock of all measurements.
//!
//! The quantity is the GPU time of a whole frame: a timestamp before its first command and one after its last, with
//! nothing in between, so that passes overlap as they do in a program. It is taken at full clock frequency, and the
//! median of the samples is reported.
//!
//! A GPU with little to do lowers its clock frequency (an H200 to a fifth) and raises it only under work without
//! gaps, in steps of up to 0.3 s. So the clock first keeps the GPU busy until frames no longer get faster, and each
//! sample is the last frame of a burst. Adapters on the processor have no usable timestamps: their drivers write them
//! while they record. There the time is that of the host, from recording to completion, of one frame at a time.

use std::cell::Cell;
use std::time::{Duration, Instant};

use wgpu::{CommandEncoder, Features};

use crate::Gpu;
use crate::error::GpuError;
use crate::median::MedianEstimate;
use crate::platform::watched;
use crate::timing::Timestamps;

/// The frequency is steady when no burst was faster for this long.
const STEADY: Duration = Duration::from_millis(500);
const MAX_WARM_UP: Duration = Duration::from_secs(4);
/// A burst is faster if it takes less than this share of the fastest one.
const FASTER: f64 = 0.97;
/// A GPU that was idle for longer is warmed up again.
const STAYS_WARM: Duration = Duration::from_millis(200);
/// Frames of a burst, and about how many milliseconds they may take together.
const BURST: f64 = 16.0;
const BURST_MS: f64 = 20.0;
/// Frames before the first sample on a processor: its caches fill.
const HOST_WARM_UP: u32 = 2;

/// The source of times.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ClockSource {
    /// Timestamps on the GPU.
    Gpu,
    /// The host, from recording to completion.
    Host,
}

impl ClockSource {
    /// The name in tables and files: `gpu` or `host`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Gpu => "gpu",
            Self::Host => "host",
        }
    }
}

/// The median time of a frame, or of other recorded work. Only [`Clock`] makes one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameTime {
    estimate: MedianEstimate,
    source: ClockSource,
    samples: u32,
}

impl FrameTime {
    /// Milliseconds.
    pub fn ms(&self) -> f64 {
        self.estimate.median
    }

    /// The interval that holds the true median with a confidence of 95 %, in milliseconds.
    pub fn interval(&self) -> [f64; 2] {
        self.estimate.interval
    }

    /// The time of one frame where several were timed together.
    #[doc(hidden)] // For the crate `afterimage`.
    pub fn divided(mut self, count: u32) -> Self {
        let MedianEstimate { median, interval } = &mut self.estimate;
        for number in interval.iter_mut().chain([median]) {
            *number /= f64::from(count);
        }
        self
    }

    /// The time of both measurements of the same work: the mean of the medians, and all that either interval holds. So
    /// a clock that drifts in between is seen.
    pub fn joined(mut self, other: Self) -> Self {
        let (a, b) = (self.estimate, other.estimate);
        self.estimate = MedianEstimate {
            median: 0.5 * (a.median + b.median),
            interval: [a.interval[0].min(b.interval[0]), a.interval[1].max(b.interval[1])],
        };
        self.samples += other.samples;
        self
    }

    /// The source of the time.
    pub fn source(&self) -> ClockSource {
        self.source
    }

    /// The number of samples of the median.
    pub fn samples(&self) -> u32 {
        self.samples
    }
}

/// Commands of which a [`Clock`] measures the time: they are recorded again for each sample.
pub type TimedCommands<'r> = Box<dyn FnMut(&mut CommandEncoder) -> Result<(), GpuError> + 'r>;

/// Measures work on one GPU.
pub struct Clock {
    gpu: Gpu,
    /// The two around a frame.
    stamps: Option<Timestamps>,
    /// The end of the last measurement: until then the GPU ran at full frequency.
    warm: Cell<Option<Instant>>,
}

impl Clock {
    /// A clock for work on this device. It is the host's on a processor and where the device has no timestamps.
    ///
    /// # Errors
    /// The device has timestamps and is lost, or has no memory for these.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let needed = Features::TIMESTAMP_QUERY | Features::TIMESTAMP_QUERY_INSIDE_ENCODERS;
        let has_stamps = !gpu.is_processor() && gpu.device.features().contains(needed);
        // A lost device is an error, and not a reason for the host's clock.
        let stamps = watched(&gpu.device, "the timestamps of a frame", || {
            Ok(has_stamps.then(|| Timestamps::new(&gpu.device, &gpu.queue, 2)))
        })?;
        Ok(Self { gpu: gpu.clone(), stamps, warm: Cell::new(None) })
    }

    /// The source of times on this device.
    pub fn source(&self) -> ClockSource {
        if self.stamps.is_some() { ClockSource::Gpu } else { ClockSource::Host }
    }

    /// True if timestamps on the GPU measure the time.
    pub fn is_gpu(&self) -> bool {
        self.stamps.is_some()
    }

    /// The median time of each entry of `work` over `samples` samples, after a warm-up. Within each round, the host's
    /// clock measures them in turn, so that other load on the processor slows all of them alike.
    ///
    /// # Errors
    /// Errors of recording, and [`GpuError::DeviceLost`].
    pub fn medians(&self, samples: u32, work: &mut [TimedCommands<'_>]) -> Result<Vec<FrameTime>, GpuError> {
        let all = match &self.stamps {
            Some(stamps) => work.iter_mut().map(|work| self.on_gpu(stamps, samples, work)).collect::<Result<_, _>>()?,
            None => self.on_host(samples, work)?,
        };
        let time = |times: Vec<f64>| FrameTime { estimate: MedianEstimate::of(times), source: self.source(), samples };
        Ok(all.into_iter().map(time).collect())
    }

    fn on_gpu(&self, stamps: &Timestamps, samples: u32, work: &mut TimedCommands<'_>) -> Result<Vec<f64>, GpuError> {
        let burst = (BURST_MS / self.time_burst(stamps, 2, work)?).clamp(2.0, BURST) as u32;
        if self.warm.get().is_none_or(|warm| warm.elapsed() > STAYS_WARM) {
            self.warm_up(stamps, burst, work)?;
        }
        let times = (0..samples).map(|_| self.time_burst(stamps, burst, work)).collect();
        self.warm.set(Some(Instant::now()));
        times
    }

    /// Runs bursts until none was faster for [`STEADY`].
    fn warm_up(&self, stamps: &Timestamps, frames: u32, work: &mut TimedCommands<'_>) -> Result<(), GpuError> {
        let start = Instant::now();
        let (mut fastest, mut since) = (f64::INFINITY, start);
        while since.elapsed() < STEADY && start.elapsed() < MAX_WARM_UP {
            let ms = self.time_burst(stamps, frames, work)?;
            if ms < FASTER * fastest {
                (fastest, since) = (ms, Instant::now());
            }
        }
        Ok(())
    }

    /// Milliseconds of the last of `frames` frames that are submitted without gaps.
    fn time_burst(&self, stamps: &Timestamps, frames: u32, work: &mut TimedCommands<'_>) -> Result<f64, GpuError> {
        for _ in 1..frames {
            self.gpu.submit(&mut *work)?;
        }
        self.gpu.submit(|encoder| {
            encoder.write_timestamp(&stamps.queries, 0);
            work(encoder)?;
            encoder.write_timestamp(&stamps.queries, 1);
            stamps.resolve(encoder);
            Ok::<(), GpuError>(())
        })?;
        Ok(stamps.read()?[0])
    }

    /// The samples of each entry of `work`; a round takes one of each.
    fn on_host(&self, samples: u32, work: &mut [TimedCommands<'_>]) -> Result<Vec<Vec<f64>>, GpuError> {
        let mut all = vec![Vec::new(); work.len()];
        for round in 0..HOST_WARM_UP + samples {
            for (work, times) in work.iter_mut().zip(&mut all) {
                let start = Instant::now();
                self.gpu.submit(&mut *work)?;
                self.gpu.wait()?;
                if round >= HOST_WARM_UP {
                    times.push(start.elapsed().as_secs_f64() * 1e3);
                }
            }
        }
        Ok(all)
    }
}
