//! Images from arbitrary bytes.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    afterimage_fuzz::Target::Image.run(bytes);
});
