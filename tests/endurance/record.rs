//! Memory and descriptors of the process over time, as a table, a plot and a verdict.

use std::fmt::Write as _;
use std::time::Instant;

use afterimage_lab::plot::svg::{Anchor, Canvas};

/// Memory and descriptors of the process at one time.
#[derive(Clone, Copy)]
pub struct Sample {
    at: Instant,
    /// MiB that are allocated. Where the allocator does not tell, those of the process.
    allocated: f64,
    /// MiB of memory of the process (RSS): also what the allocator keeps between allocations.
    memory: f64,
    descriptors: usize,
}

impl Sample {
    pub fn now() -> Self {
        let status = std::fs::read_to_string("/proc/self/status").expect("Linux has this file");
        let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:")).expect("it states the memory");
        let kibibytes: f64 = line.trim().trim_end_matches(" kB").parse().expect("a number");
        let descriptors = std::fs::read_dir("/proc/self/fd").expect("Linux has this folder").count();
        let memory = kibibytes / 1024.0;
        Self { at: Instant::now(), allocated: allocated().unwrap_or(memory), memory, descriptors }
    }
}

/// MiB that this process, with its libraries, has allocated and not freed.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
#[allow(unsafe_code, reason = "glibc tells what it has given out by a function in C alone")]
fn allocated() -> Option<f64> {
    // SAFETY: the function takes nothing, and may be called on any thread at any time.
    let info = unsafe { libc::mallinfo2() };
    Some((info.uordblks + info.hblkhd) as f64 / f64::from(1 << 20))
}

#[cfg(not(all(target_os = "linux", target_env = "gnu")))]
fn allocated() -> Option<f64> {
    None
}

/// The samples of all rounds.
#[derive(Default)]
pub struct Record(Vec<Sample>);

/// Memory is flat if it grows by less than this share over the second half.
const FLAT: f64 = 0.02;

impl Record {
    pub fn push(&mut self, sample: Sample) {
        self.0.push(sample);
    }

    pub fn last(&self) -> String {
        let text = |s: &Sample| {
            format!("{:.2} MiB allocated, {:.1} MiB in use, {} descriptors", s.allocated, s.memory, s.descriptors)
        };
        self.0.last().map_or(String::new(), text)
    }

    fn second_half(&self) -> &[Sample] {
        &self.0[self.0.len() / 2..]
    }

    /// The growth in descriptors from the first round of the second half to the last.
    pub fn more_descriptors(&self) -> i64 {
        let half = self.second_half();
        let count = |sample: Option<&Sample>| sample.map_or(0, |sample| sample.descriptors as i64);
        count(half.last()) - count(half.first())
    }

    /// MiB a round over the second half, by least squares, and the mean of it.
    fn slope(&self, of: fn(&Sample) -> f64) -> (f64, f64) {
        let half = self.second_half();
        let count = half.len().max(1) as f64;
        let mean = half.iter().map(of).sum::<f64>() / count;
        let middle = (count - 1.0) / 2.0;
        let from_middle = |index: usize| index as f64 - middle;
        let terms = half.iter().enumerate();
        let with_memory: f64 = terms.map(|(index, sample)| from_middle(index) * (of(sample) - mean)).sum();
        let squares: f64 = (0..half.len()).map(|index| from_middle(index).powi(2)).sum();
        (if squares > 0.0 { with_memory / squares } else { 0.0 }, mean)
    }

    /// What is allocated decides. The memory of the process is in the table and in the plot: it also depends on how
    /// the allocator places blocks, which differs from run to run with the work that others do on the machine.
    pub fn is_flat(&self) -> bool {
        let (slope, mean) = self.slope(|sample| sample.allocated);
        slope * (self.second_half().len() as f64) < FLAT * mean
    }

    pub fn verdict(&self) -> String {
        let word = if self.is_flat() { "flat" } else { "growing" };
        let seconds = self.0.last().map_or(0.0, |last| (last.at - self.0[0].at).as_secs_f64());
        let growth = |of: fn(&Sample) -> f64| {
            let (slope, mean) = self.slope(of);
            let all = slope * self.second_half().len() as f64;
            format!(
                "{mean:.1} MiB in the second half, {:.1} KiB more a round, {all:.2} MiB in all of it",
                slope * 1024.0
            )
        };
        format!(
            "{} rounds, {:.0} min: memory is {word}: allocated {}; of the process {}; descriptors: {} at the end, {} more \
             in the second half",
            self.0.len(),
            seconds / 60.0,
            growth(|sample| sample.allocated),
            growth(|sample| sample.memory),
            self.0.last().map_or(0, |last| last.descriptors),
            self.more_descriptors()
        )
    }

    /// Writes `endurance.csv` and `endurance.svg` into a folder, and prints the verdict.
    pub fn write(&self, folder: &str) {
        let mut table = "round,seconds,MiB allocated,MiB in use,descriptors\n".to_owned();
        for (index, sample) in self.0.iter().enumerate() {
            let seconds = (sample.at - self.0[0].at).as_secs_f64();
            let Sample { allocated, memory, descriptors, .. } = sample;
            writeln!(table, "{},{seconds:.1},{allocated:.3},{memory:.2},{descriptors}", index + 1)
                .expect("a text has room");
        }
        let write = |name: &str, text: &str| {
            let path = std::path::Path::new(folder).join(name);
            std::fs::write(&path, text).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        };
        std::fs::create_dir_all(folder).unwrap_or_else(|error| panic!("{folder}: {error}"));
        write("endurance.csv", &table);
        write("endurance.svg", &self.plot());
        println!("{}", self.verdict());
    }

    /// Memory, allocated and of the process, and descriptors below, all from zero.
    fn plot(&self) -> String {
        let mut canvas = Canvas::new(WIDTH, HEIGHT);
        let rounds = self.0.len();
        let title = format!("{rounds} rounds of 50 reloads, 25 resizes, 100 frames and an opening, at 64x48");
        canvas.text((LEFT, 24.0), 14.0, Anchor::Start, INK, &title);
        let values = |of: fn(&Sample) -> f64| self.0.iter().map(of).collect::<Vec<f64>>();
        panel(&mut canvas, "memory of the process (RSS), MiB", 50.0, &values(|sample| sample.memory));
        panel(&mut canvas, "memory that is allocated, MiB", 250.0, &values(|sample| sample.allocated));
        panel(&mut canvas, "file descriptors", 450.0, &values(|sample| sample.descriptors as f64));
        canvas.text((WIDTH - 20.0, HEIGHT - 12.0), 12.0, Anchor::End, INK, "round");
        canvas.finish()
    }
}

const WIDTH: f64 = 720.0;
const HEIGHT: f64 = 660.0;
const LEFT: f64 = 60.0;
const TALL: f64 = 150.0;
const INK: &str = "#333";

/// One curve with its axes; `top` is the upper edge.
fn panel(canvas: &mut Canvas, title: &str, top: f64, values: &[f64]) {
    let most = values.iter().copied().fold(1.0, f64::max) * 1.1;
    let bottom = top + 20.0 + TALL;
    let wide = WIDTH - 20.0 - LEFT;
    let x = |index: usize| LEFT + wide * index as f64 / (values.len().max(2) - 1) as f64;
    let y = |value: f64| bottom - TALL * value / most;
    canvas.text((LEFT, top + 8.0), 12.0, Anchor::Start, INK, title);
    canvas.line((LEFT, bottom), (WIDTH - 20.0, bottom), INK, false);
    for part in 0..=4 {
        let value = most * f64::from(part) / 4.0;
        canvas.line((LEFT, y(value)), (WIDTH - 20.0, y(value)), "#ddd", false);
        canvas.text((LEFT - 6.0, y(value) + 4.0), 11.0, Anchor::End, INK, &format!("{value:.0}"));
    }
    for part in 0..=4 {
        let index = (values.len() - 1) * part / 4;
        canvas.text((x(index), bottom + 16.0), 11.0, Anchor::Middle, INK, &(index + 1).to_string());
    }
    let points: Vec<(f64, f64)> = values.iter().enumerate().map(|(index, value)| (x(index), y(*value))).collect();
    canvas.path(&points, "#1f6fb2");
}
