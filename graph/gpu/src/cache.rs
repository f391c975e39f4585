//! The driver's pipeline cache as bytes that a program can store between runs.
//!
//! wgpu rejects bytes of another version, adapter or driver, and trusts all others. Therefore a header is written in
//! front: a magic word and a hash, by which damaged bytes are recognized.
#![allow(unsafe_code, reason = "wgpu cannot check what the driver will read; the proof is beside the call")]

const MAGIC: &[u8; 8] = b"AIPIPES1";
const HEADER: usize = MAGIC.len() + size_of::<u64>();

/// A cache with the contents that [`seal`] returned, or empty if the bytes are damaged; `None` where the device has no
/// pipeline cache.
pub(crate) fn open(device: &wgpu::Device, sealed: &[u8]) -> Option<wgpu::PipelineCache> {
    if !device.features().contains(wgpu::Features::PIPELINE_CACHE) {
        return None;
    }
    let descriptor =
        wgpu::PipelineCacheDescriptor { label: Some("afterimage"), data: contents(sealed), fallback: true };
    // SAFETY: the bytes come from `get_data`: only `seal` writes this magic word, and the hash shows that the bytes are
    // unchanged. With `fallback`, bytes of another version, adapter or driver give an empty cache. Whoever can forge
    // the hash can also write the program's own files.
    Some(unsafe { device.create_pipeline_cache(&descriptor) })
}

/// The cache's bytes, with header.
pub(crate) fn seal(cache: &wgpu::PipelineCache) -> Option<Vec<u8>> {
    let data = cache.get_data()?;
    let mut sealed = Vec::with_capacity(HEADER + data.len());
    sealed.extend_from_slice(MAGIC);
    sealed.extend_from_slice(&fnv1a(&data).to_le_bytes());
    sealed.extend_from_slice(&data);
    Some(sealed)
}

/// The bytes behind the header; `None` if the header does not fit.
fn contents(sealed: &[u8]) -> Option<&[u8]> {
    let (header, data) = sealed.split_at_checked(HEADER)?;
    let (magic, hash) = header.split_at(MAGIC.len());
    (magic == MAGIC && hash == fnv1a(data).to_le_bytes()).then_some(data)
}

/// FNV-1a in 64 bits (Fowler, Noll and Vo): enough to detect damage.
fn fnv1a(bytes: &[u8]) -> u64 {
    let step = |hash: u64, byte: &u8| (hash ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3);
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, step)
}

#[cfg(test)]
mod tests {
    use super::{HEADER, MAGIC, contents, fnv1a};

    fn sealed(data: &[u8]) -> Vec<u8> {
        [MAGIC.as_slice(), &fnv1a(data).to_le_bytes(), data].concat()
    }

    #[test]
    fn known_hashes() {
        assert_eq!(fnv1a(b"a"), 0xaf63_dc4c_8601_ec8c);
        assert_eq!(fnv1a(b"foobar"), 0x8594_4171_f739_67e8);
    }

    #[test]
    fn every_flipped_bit_and_every_truncation_is_detected() {
        let whole = sealed(b"pipelines of a driver");
        assert_eq!(contents(&whole), Some(b"pipelines of a driver".as_slice()));
        for bit in 0..whole.len() * 8 {
            let mut flipped = whole.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            assert_eq!(contents(&flipped), None, "bit {bit}");
        }
        for length in 0..whole.len() {
            assert_eq!(contents(&whole[..length]), None, "{length} of {} bytes, header {HEADER}", whole.len());
        }
    }
}
