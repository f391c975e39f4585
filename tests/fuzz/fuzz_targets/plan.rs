//! PlanCache of the shipped pipelines for arbitrary devices and frames.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    afterimage_fuzz::Target::Plan.run(bytes);
});
