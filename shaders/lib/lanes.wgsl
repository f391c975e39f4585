// What all invocations of a workgroup know together, through workgroup memory. Where the host has asked for subgroups and the device has
// them, `lanes_subgroups` stands here instead, with the same functions. All invocations of the workgroup call them, each function once
// or with a barrier in between.

// An invocation of a workgroup, as an argument of an entry point.
struct Lane {
    @builtin(local_invocation_index) index: u32,
}

// The most invocations; always a multiple of the invocations of a row.
const LANES_MOST: u32 = 256u;
// Rows of the workgroup add up by themselves, then all rows do: two barriers, where a tree needs eight.
const LANES_ROW: u32 = 16u;
const LANES_ROWS: u32 = LANES_MOST / LANES_ROW;

var<workgroup> lanes_counts: array<u32, LANES_MOST>;
var<workgroup> lanes_row_counts: array<u32, LANES_ROWS>;
var<workgroup> lanes_values: array<vec2f, LANES_MOST>;
var<workgroup> lanes_row_values: array<vec2f, LANES_ROWS>;

// A number of the invocation's own below that of all invocations, in the order in which `lanes_scan` adds up.
fn lanes_place(lane: Lane) -> u32 {
    return lane.index;
}

// The count of this invocation and of all before it, and of all.
fn lanes_scan(lane: Lane, lanes: u32, count: u32) -> vec2u {
    let row = lane.index / LANES_ROW;
    lanes_counts[lane.index] = count;
    workgroupBarrier();
    var through = 0u;
    for (var other = row * LANES_ROW; other <= lane.index; other++) { through += lanes_counts[other]; }
    if lane.index % LANES_ROW == LANES_ROW - 1u { lanes_row_counts[row] = through; }
    workgroupBarrier();
    var all = 0u;
    for (var other = 0u; other < lanes / LANES_ROW; other++) {
        through += select(0u, lanes_row_counts[other], other < row);
        all += lanes_row_counts[other];
    }
    return vec2u(through, all);
}

// The sums of both numbers over all invocations, always in the same order.
fn lanes_sum(lane: Lane, lanes: u32, value: vec2f) -> vec2f {
    lanes_values[lane.index] = value;
    workgroupBarrier();
    if lane.index < lanes / LANES_ROW {
        var part = vec2f();
        for (var other = 0u; other < LANES_ROW; other++) { part += lanes_values[lane.index * LANES_ROW + other]; }
        lanes_row_values[lane.index] = part;
    }
    workgroupBarrier();
    var sum = vec2f();
    for (var other = 0u; other < lanes / LANES_ROW; other++) { sum += lanes_row_values[other]; }
    return sum;
}

// The sum of the first numbers and the larger of the second ones.
fn lanes_joined(a: vec2f, b: vec2f) -> vec2f {
    return vec2f(a.x + b.x, max(a.y, b.y));
}

// The same of all invocations.
fn lanes_sum_and_most(lane: Lane, lanes: u32, value: vec2f) -> vec2f {
    lanes_values[lane.index] = value;
    workgroupBarrier();
    if lane.index < lanes / LANES_ROW {
        var part = lanes_values[lane.index * LANES_ROW];
        for (var other = 1u; other < LANES_ROW; other++) {
            part = lanes_joined(part, lanes_values[lane.index * LANES_ROW + other]);
        }
        lanes_row_values[lane.index] = part;
    }
    workgroupBarrier();
    var joined = lanes_row_values[0];
    for (var other = 1u; other < lanes / LANES_ROW; other++) { joined = lanes_joined(joined, lanes_row_values[other]); }
    return joined;
}

// The largest number of the invocations for which this one speaks, if it speaks for any.
fn lanes_most_near(value: f32) -> f32 {
    return value;
}

// Whether this invocation speaks for those near it, itself among them.
fn lanes_speaks(lane: Lane) -> bool {
    return true;
}
