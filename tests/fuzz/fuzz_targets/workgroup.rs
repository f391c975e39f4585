//! Arbitrary text as a shader whose functions share memory of a workgroup.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    afterimage_fuzz::Target::Workgroup.run(bytes);
});
