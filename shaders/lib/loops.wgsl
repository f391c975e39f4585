// The steps of all loops in one call of a kernel function that is not built in: what never ends would stop the device.
// The limit is `LOOP_STEPS` of `graph/wgsl/src/limits/mod.rs`.
var<private> loop_steps: u32;

fn begin_steps() {
    loop_steps = 0u;
}

// Counts a step; whether it is one more than there may be.
fn is_last_step() -> bool {
    loop_steps += 1u;
    return loop_steps > 1048576u;
}
