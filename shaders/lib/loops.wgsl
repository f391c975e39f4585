// The steps of all loops in one call of a kernel function that is not built in: what never ends would stop the device.
var<private> steps_left: i32;

// `most` is a limit of `graph/wgsl/src/limits/mod.rs`.
fn begin_steps(most: i32) {
    steps_left = most;
}

// Counts a step; whether it is one more than there may be. Then it is so for all further steps.
fn is_last_step() -> bool {
    steps_left -= 1;
    return steps_left < 0;
}

// True if a loop ended because it had too many steps.
fn were_steps_cut() -> bool {
    return steps_left < 0;
}
