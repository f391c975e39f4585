// Sums, scans and maxima over all invocations of a workgroup, through workgroup memory. All invocations of the
// workgroup must call them, and a barrier is needed between two calls of the same function.

// An invocation of a workgroup, as an argument of an entry point.
struct Invocation {
    @builtin(local_invocation_index) index: u32,
}

// The largest number of invocations, a multiple of a row.
const WORKGROUP_MAX: u32 = 256u;
// Each row of invocations is summed, then all rows: two barriers, where a tree needs eight.
const WORKGROUP_ROW: u32 = 16u;
const WORKGROUP_ROWS: u32 = WORKGROUP_MAX / WORKGROUP_ROW;

var<workgroup> workgroup_counts: array<u32, WORKGROUP_MAX>;
var<workgroup> workgroup_row_counts: array<u32, WORKGROUP_ROWS>;
var<workgroup> workgroup_values: array<vec2f, WORKGROUP_MAX>;
var<workgroup> workgroup_row_values: array<vec2f, WORKGROUP_ROWS>;

// The inclusive prefix sum of the counts, and their total.
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

// The sums of both numbers over all invocations, in a fixed order.
fn workgroup_sum(invocation: Invocation, invocations: u32, value: vec2f) -> vec2f {
    workgroup_values[invocation.index] = value;
    workgroupBarrier();
    if invocation.index < invocations / WORKGROUP_ROW {
        var part = vec2f();
        for (var other = 0u; other < WORKGROUP_ROW; other++) {
            part += workgroup_values[invocation.index * WORKGROUP_ROW + other];
        }
        workgroup_row_values[invocation.index] = part;
    }
    workgroupBarrier();
    var sum = vec2f();
    for (var other = 0u; other < invocations / WORKGROUP_ROW; other++) { sum += workgroup_row_values[other]; }
    return sum;
}

// The sum of the first numbers and the maximum of the second.
fn sum_and_max(a: vec2f, b: vec2f) -> vec2f {
    return vec2f(a.x + b.x, max(a.y, b.y));
}

// The same over all invocations.
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
    for (var other = 1u; other < invocations / WORKGROUP_ROW; other++) {
        joined = sum_and_max(joined, workgroup_row_values[other]);
    }
    return joined;
}
