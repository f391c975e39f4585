// What all invocations of a workgroup know together: each subgroup by itself, then all of them through workgroup memory. Nothing is
// assumed of how many invocations a subgroup has, whether it is full, or which ones they are.

struct Lane {
    @builtin(local_invocation_index) index: u32,
    @builtin(subgroup_id) subgroup: u32,
    @builtin(num_subgroups) subgroups: u32,
    @builtin(subgroup_invocation_id) within: u32,
}

// The most invocations, and so the most subgroups.
const LANES_MOST: u32 = 256u;

var<workgroup> lanes_counts: array<u32, LANES_MOST>;
var<workgroup> lanes_sums: array<vec2f, LANES_MOST>;

fn lanes_place(lane: Lane) -> u32 {
    return lanes_scan(lane, 0u, 1u).x - 1u;
}

fn lanes_scan(lane: Lane, lanes: u32, count: u32) -> vec2u {
    let own = subgroupInclusiveAdd(count);
    let all = subgroupAdd(count);
    // What was read here before has been read.
    workgroupBarrier();
    if lanes_speaks(lane) { lanes_counts[lane.subgroup] = all; }
    workgroupBarrier();
    var scanned = vec2u(own, 0u);
    for (var other = 0u; other < lane.subgroups; other++) {
        let part = lanes_counts[other];
        scanned += vec2u(select(0u, part, other < lane.subgroup), part);
    }
    return scanned;
}

fn lanes_sum(lane: Lane, lanes: u32, value: vec2f) -> vec2f {
    let part = subgroupAdd(value);
    workgroupBarrier();
    if lanes_speaks(lane) { lanes_sums[lane.subgroup] = part; }
    workgroupBarrier();
    var sum = vec2f();
    for (var other = 0u; other < lane.subgroups; other++) {
        sum += lanes_sums[other];
    }
    return sum;
}

fn lanes_joined(a: vec2f, b: vec2f) -> vec2f {
    return vec2f(a.x + b.x, max(a.y, b.y));
}

fn lanes_sum_and_most(lane: Lane, lanes: u32, value: vec2f) -> vec2f {
    let part = vec2f(subgroupAdd(value.x), subgroupMax(value.y));
    workgroupBarrier();
    if lanes_speaks(lane) { lanes_sums[lane.subgroup] = part; }
    workgroupBarrier();
    var joined = lanes_sums[0];
    for (var other = 1u; other < lane.subgroups; other++) {
        joined = lanes_joined(joined, lanes_sums[other]);
    }
    return joined;
}

fn lanes_most_near(value: f32) -> f32 {
    return subgroupMax(value);
}

fn lanes_speaks(lane: Lane) -> bool {
    return lane.within == subgroupBroadcastFirst(lane.within);
}
