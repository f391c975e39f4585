// What all invocations of a workgroup know together, through workgroup memory. Where the host has asked for subgroups and the device has
// them, `workgroup_subgroups` stands here instead, with the same functions. All invocations of the workgroup call them, each function once
// or with a barrier in between.

// An invocation of a workgroup, as an argument of an entry point.
struct Invocation {
    @builtin(local_invocation_index) index: u32,
}

// The most invocations; always a multiple of the invocations of a row.
const WORKGROUP_MAX: u32 = 256u;
// Rows of the workgroup add up by themselves, then all rows do: two barriers, where a tree needs eight.
const WORKGROUP_ROW: u32 = 16u;
const WORKGROUP_ROWS: u32 = WORKGROUP_MAX / WORKGROUP_ROW;

var<workgroup> workgroup_counts: array<u32, WORKGROUP_MAX>;
var<workgroup> workgroup_row_counts: array<u32, WORKGROUP_ROWS>;
var<workgroup> workgroup_values: array<vec2f, WORKGROUP_MAX>;
var<workgroup> workgroup_row_values: array<vec2f, WORKGROUP_ROWS>;

// A number of the invocation's own below that of all invocations, in the order in which `workgroup_scan` adds up.
fn workgroup_rank(invocation: Invocation) -> u32 {
    return invocation.index;
}

// The count of this invocation and of all before it, and of all.
fn workgroup_scan(invocation: Invocation, invocations: u32, count: u32) -> vec2u {
    let row = invocation.index / WORKGROUP_ROW;
    workgroup_counts[invocation.index] = count;
    workgroupBarrier();
    var through = 0u;
    for (var other = row * WORKGROUP_ROW; other <= invocation.index; other++) { through += workgroup_counts[other]; }
    if invocation.index % WORKGROUP_ROW == WORKGROUP_ROW - 1u { workgroup_row_counts[row] = through; }
    workgroupBarrier();
    var all = 0u;
    for (var other = 0u; other < invocations / WORKGROUP_ROW; other++) {
        through += select(0u, workgroup_row_counts[other], other < row);
        all += workgroup_row_counts[other];
    }
    return vec2u(through, all);
}

// The sums of both numbers over all invocations, always in the same order.
fn workgroup_sum(invocation: Invocation, invocations: u32, value: vec2f) -> vec2f {
    workgroup_values[invocation.index] = value;
    workgroupBarrier();
    if invocation.index < invocations / WORKGROUP_ROW {
        var part = vec2f();
        for (var other = 0u; other < WORKGROUP_ROW; other++) { part += workgroup_values[invocation.index * WORKGROUP_ROW + other]; }
        workgroup_row_values[invocation.index] = part;
    }
    workgroupBarrier();
    var sum = vec2f();
    for (var other = 0u; other < invocations / WORKGROUP_ROW; other++) { sum += workgroup_row_values[other]; }
    return sum;
}

// The sum of the first numbers and the larger of the second ones.
fn sum_and_max(a: vec2f, b: vec2f) -> vec2f {
    return vec2f(a.x + b.x, max(a.y, b.y));
}

// The same of all invocations.
fn workgroup_sum_and_max(invocation: Invocation, invocations: u32, value: vec2f) -> vec2f {
    workgroup_values[invocation.index] = value;
    workgroupBarrier();
    if invocation.index < invocations / WORKGROUP_ROW {
        var part = workgroup_values[invocation.index * WORKGROUP_ROW];
        for (var other = 1u; other < WORKGROUP_ROW; other++) {
            part = sum_and_max(part, workgroup_values[invocation.index * WORKGROUP_ROW + other]);
        }
        workgroup_row_values[invocation.index] = part;
    }
    workgroupBarrier();
    var joined = workgroup_row_values[0];
    for (var other = 1u; other < invocations / WORKGROUP_ROW; other++) { joined = sum_and_max(joined, workgroup_row_values[other]); }
    return joined;
}

// The largest number of the invocations for which this one speaks, if it speaks for any.
fn subgroup_max(value: f32) -> f32 {
    return value;
}

// Whether this invocation speaks for those near it, itself among them.
fn is_subgroup_leader(invocation: Invocation) -> bool {
    return true;
}
