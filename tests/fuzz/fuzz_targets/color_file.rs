//! Color files from arbitrary text.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    afterimage_fuzz::Target::ColorFile.run(bytes);
});
