// Sums, scans and maxima over all invocations of a workgroup: first within subgroups, then through workgroup memory.
// Nothing is assumed about the size of a subgroup, whether it is full, or which invocations it contains.

struct Invocation {
    @builtin(local_invocation_index) index: u32,
    @builtin(subgroup_id) subgroup: u32,
    @builtin(num_subgroups) subgroups: u32,
    @builtin(subgroup_invocation_id) within: u32,
}

// The largest number of invocations, and therefore of subgroups.
const WORKGROUP_MAX: u32 = 256u;

var<workgroup> workgroup_counts: array<u32, WORKGROUP_MAX>;
var<workgroup> workgroup_sums: array<vec2f, WORKGROUP_MAX>;

fn workgroup_rank(invocation: Invocation) -> u32 {
    return workgroup_scan(invocation, 0u, 1u).x - 1u;
}

fn workgroup_scan(invocation: Invocation, invocations: u32, count: u32) -> vec2u {
    let own = subgroupInclusiveAdd(count);
    let all = subgroupAdd(count);
    // Ends all reads of a previous call.
    workgroupBarrier();
    if is_subgroup_leader(invocation) { workgroup_counts[invocation.subgroup] = all; }
    workgroupBarrier();
    var scanned = vec2u(own, 0u);
    for (var other = 0u; other < invocation.subgroups; other++) {
        let part = workgroup_counts[other];
        scanned += vec2u(select(0u, part, other < invocation.subgroup), part);
    }
    return scanned;
}

fn workgroup_sum(invocation: Invocation, invocations: u32, value: vec2f) -> vec2f {
    let part = subgroupAdd(value);
    workgroupBarrier();
    if is_subgroup_leader(invocation) { workgroup_sums[invocation.subgroup] = part; }
    workgroupBarrier();
    var sum = vec2f();
    for (var other = 0u; other < invocation.subgroups; other++) {
        sum += workgroup_sums[other];
    }
    return sum;
}

fn sum_and_max(a: vec2f, b: vec2f) -> vec2f {
    return vec2f(a.x + b.x, max(a.y, b.y));
}

fn workgroup_sum_and_max(invocation: Invocation, invocations: u32, value: vec2f) -> vec2f {
    let part = vec2f(subgroupAdd(value.x), subgroupMax(value.y));
    workgroupBarrier();
    if is_subgroup_leader(invocation) { workgroup_sums[invocation.subgroup] = part; }
    workgroupBarrier();
    var joined = workgroup_sums[0];
    for (var other = 1u; other < invocation.subgroups; other++) {
        joined = sum_and_max(joined, workgroup_sums[other]);
    }
    return joined;
}

fn subgroup_max(value: f32) -> f32 {
    return subgroupMax(value);
}

fn is_subgroup_leader(invocation: Invocation) -> bool {
    return invocation.within == subgroupBroadcastFirst(invocation.within);
}
