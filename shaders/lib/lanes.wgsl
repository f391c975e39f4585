// What all invocations of a workgroup know together, through workgroup memory. Where the host has asked for subgroups and the device has
// them, `lanes_subgroups` stands here instead, with the same functions. All invocations of the workgroup call them, each function once
// or with a barrier in between.

// An invocation of a workgroup, as an argument of an entry point.
struct Lane {
    @builtin(local_invocation_index) index: u32,
}

// The most invocations.
const LANES_MOST: u32 = 256u;

var<workgroup> lanes_counts: array<u32, LANES_MOST>;
var<workgroup> lanes_sums: array<vec2f, LANES_MOST>;

// A number of the invocation's own below that of all invocations, in the order in which `lanes_scan` adds up.
fn lanes_place(lane: Lane) -> u32 {
    return lane.index;
}

// The count of this invocation and of all before it, and of all.
fn lanes_scan(lane: Lane, lanes: u32, count: u32) -> vec2u {
    var through = count;
    lanes_counts[lane.index] = through;
    for (var reach = 1u; reach < lanes; reach *= 2u) {
        workgroupBarrier();
        let before = select(0u, lanes_counts[max(lane.index, reach) - reach], lane.index >= reach);
        workgroupBarrier();
        through += before;
        lanes_counts[lane.index] = through;
    }
    workgroupBarrier();
    return vec2u(through, lanes_counts[lanes - 1u]);
}

// The sums of both numbers over a power of two of invocations: a tree of a fixed shape.
fn lanes_sum(lane: Lane, lanes: u32, value: vec2f) -> vec2f {
    lanes_sums[lane.index] = value;
    for (var half = lanes / 2u; half > 0u; half /= 2u) {
        workgroupBarrier();
        if lane.index < half { lanes_sums[lane.index] += lanes_sums[lane.index + half]; }
    }
    workgroupBarrier();
    return lanes_sums[0];
}

// The sum of the first number and the largest second one.
fn lanes_sum_and_most(lane: Lane, lanes: u32, value: vec2f) -> vec2f {
    lanes_sums[lane.index] = value;
    for (var half = lanes / 2u; half > 0u; half /= 2u) {
        workgroupBarrier();
        if lane.index < half {
            let other = lanes_sums[lane.index + half];
            let own = lanes_sums[lane.index];
            lanes_sums[lane.index] = vec2f(own.x + other.x, max(own.y, other.y));
        }
    }
    workgroupBarrier();
    return lanes_sums[0];
}

// The largest number of the invocations for which this one speaks, if it speaks for any.
fn lanes_most_near(value: f32) -> f32 {
    return value;
}

// Whether this invocation speaks for those near it, itself among them.
fn lanes_speaks(lane: Lane) -> bool {
    return true;
}
