//! Memory limits of the machine and of this process.

use std::fs::File;
use std::io::Read as _;
use std::sync::OnceLock;

use crate::codec::Budget;

/// Assumed where the system does not state its memory.
const ASSUMED: u64 = 16 << 30;
/// One of how many parts of the memory decoding an image may take. A sequence has up to four images in flight.
const SHARE: u64 = 4;

/// The budget for decoding an image if the user names none: a quarter of the machine's memory, or of what its control
/// group may use.
pub fn default_budget() -> Budget {
    static MEMORY: OnceLock<u64> = OnceLock::new();
    Budget(*MEMORY.get_or_init(machine_memory) / SHARE)
}

fn machine_memory() -> u64 {
    let machine = system_text("/proc/meminfo").and_then(|text| total(&text)).unwrap_or(ASSUMED);
    let group = system_text("/sys/fs/cgroup/memory.max").and_then(|text| text.trim().parse().ok());
    machine.min(group.unwrap_or(u64::MAX))
}

/// The bytes of memory that this process may use, if they are limited (`ulimit -v`, `ulimit -d`). A driver
/// that does not fit is not found.
pub fn memory_limit() -> Option<u64> {
    least(&system_text("/proc/self/limits")?)
}

/// The lines `Max address space  500000000  unlimited  bytes` and `Max data size  ...`: the first number is the limit.
fn least(limits: &str) -> Option<u64> {
    let of = |line: &str| {
        let rest = line.strip_prefix("Max address space").or_else(|| line.strip_prefix("Max data size"))?;
        rest.split_whitespace().next()?.parse().ok()
    };
    limits.lines().filter_map(of).min()
}

/// The line `MemTotal: 16316412 kB`, in bytes.
fn total(text: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix("MemTotal:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?.checked_mul(1024)
}

/// A text that the system makes when it is read, so that its file has no length.
fn system_text(path: &str) -> Option<String> {
    let mut text = String::new();
    File::open(path).ok()?.take(64 << 10).read_to_string(&mut text).ok()?;
    Some(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_memory_is_read_from_the_text_of_the_system() {
        assert_eq!(total("MemTotal:       24518456 kB\nMemFree:  1 kB\n"), Some(24_518_456 * 1024));
        assert_eq!(total("MemTotal: much\n"), None);
        assert_eq!(total(""), None);
    }

    #[test]
    fn a_limit_of_memory_is_read_from_the_text_of_the_system() {
        let limits = |space: &str, data: &str| {
            format!("Max data size   {data}   unlimited   bytes\nMax address space   {space}   unlimited   bytes\n")
        };
        assert_eq!(least(&limits("500000000", "unlimited")), Some(500_000_000));
        assert_eq!(least(&limits("500000000", "400000000")), Some(400_000_000));
        assert_eq!(least(&limits("unlimited", "unlimited")), None);
        assert_eq!(least(""), None);
    }

    #[test]
    fn the_budget_is_a_part_of_the_memory() {
        let Budget(bytes) = default_budget();
        assert!((64 << 20..1 << 46).contains(&bytes), "{bytes}");
    }
}
