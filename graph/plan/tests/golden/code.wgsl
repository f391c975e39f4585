// dim > downsample_tap13 650x362 [11, 91, 1]
fn run(at: Point) -> vec4f {
    let kernel0 = dim(textureLoad(image0, at.pixel, 0));
    return kernel0;
}
fn texel_of_source(pixel: vec2i) -> vec4f {
    let size = 2.0 * extent2;
    let inside = clamp(pixel, vec2i(0), vec2i(size) - 1);
    return run(Point(inside, (vec2f(inside) + 0.5) / size, size));
}
@compute @workgroup_size(64)
fn compute(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) invocation: u32) {
    let last = vec2i(extent2) - 1;
    let column = i32(group.x) * 62 + i32(invocation) - 1;
    let first = i32(group.y) * 4;
    let end = min(first + 4, last.y + 1);
    var state: DownsampleRows;
    for (var row = first - 1; row <= end; row++) {
        let corner = 2 * vec2i(column, row);
        let square = Square(
            texel_of_source(corner),
            texel_of_source(corner + vec2i(1, 0)),
            texel_of_source(corner + vec2i(0, 1)),
            texel_of_source(corner + vec2i(1, 1)),
        );
        let value = downsample_rows_tap13(&state, square, invocation);
        if row > first && invocation > 0u && invocation < 63u && column <= last.x {
            textureStore(result1, vec2i(column, row - 1), value);
        }
    }
}


// soft > soft [41, 23, 1]
struct PassUniform {
    sizes: array<vec4i, 2>,
}
@group(0) @binding(0) var<uniform> params0: PassUniform;
@group(0) @binding(1) var image1: texture_2d<f32>;
@group(0) @binding(2) var linear2: sampler;
@group(0) @binding(3) var result3: texture_storage_2d<rgba16float, write>;
var<workgroup> tile_memory: array<vec2u, 1296>;
fn tile_pack(v: vec4f) -> vec2u { return vec2u(pack2x16float(v.xy), pack2x16float(v.zw)); }
fn tile_cell(index: i32) -> vec4f {
    let cell = tile_memory[index];
    return vec4f(unpack2x16float(cell.x), unpack2x16float(cell.y));
}
var<private> tile_zero: i32;
var<private> tile_row: i32;
var<private> tile_bounds: vec2f;
fn tile_size(t: u32) -> vec2u { return vec2u(tile_bounds); }
fn tile_texel(t: u32, p: vec2i) -> vec4f { return tile_cell(tile_zero + p.y * tile_row + p.x); }
fn tile_tap(t: u32, s: u32, uv: vec2f) -> vec4f {
    let p = uv * tile_bounds - 0.5;
    let corner = floor(p);
    let f = p - corner;
    let i = tile_zero + i32(corner.y) * tile_row + i32(corner.x);
    let top = mix(tile_cell(i), tile_cell(i + 1), f.x);
    let bottom = mix(tile_cell(i + tile_row), tile_cell(i + tile_row + 1), f.x);
    return mix(top, bottom, f.y);
}
fn tile_start(next: vec2i, next_size: vec2i, size: vec2i, reach: f32) -> vec2i {
    let center = (vec2f(next) + 0.5) / vec2f(next_size) * vec2f(size) - 0.5;
    // A little less than the exact start, so that rounding loses no texel.
    return vec2i(floor(center - reach - 0.01));
}
fn tile_size_of(stage: i32) -> vec2i { return params0.sizes[stage].xy; }
fn tile_share(group: vec2i, size: vec2i, last: vec2i) -> vec2i {
    let whole = group * 32 >= last;
    return select(vec2i(vec2u(group * 32) * vec2u(size) / vec2u(last)), size, whole);
}
fn stage0(at: Point) -> vec4f {
    let kernel0 = soft_soft(image1, linear2, at);
    return kernel0;
}
fn stage1(at: Point) -> vec4f {
    let kernel1 = soft_soft_2(0u, 0u, at);
    return kernel1;
}
@compute @workgroup_size(16, 16)
fn compute(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) invocation: u32) {
    let last = tile_size_of(1);
    let origin1 = vec2i(group.xy) * 32;
    let origin0 = tile_start(origin1, tile_size_of(1), tile_size_of(0), 1.0);
    let size0 = tile_size_of(0);
    let from0 = tile_share(vec2i(group.xy), size0, last);
    let to0 = tile_share(vec2i(group.xy) + 1, size0, last);
    for (var k = invocation; k < 1296u; k += 256u) {
        let q = origin0 + vec2i(i32(k % 36u), i32(k / 36u));
        let p = clamp(q, vec2i(0), size0 - 1);
        let value = stage0(Point(p, (vec2f(p) + 0.5) / vec2f(size0), vec2f(size0)));
        tile_memory[0 + i32(k)] = tile_pack(value);
    }
    workgroupBarrier();
    tile_row = 36;
    tile_zero = 0 - origin0.y * 36 - origin0.x;
    tile_bounds = vec2f(tile_size_of(0));
    let size1 = tile_size_of(1);
    let from1 = tile_share(vec2i(group.xy), size1, last);
    let to1 = tile_share(vec2i(group.xy) + 1, size1, last);
    for (var k = invocation; k < 1024u; k += 256u) {
        let q = origin1 + vec2i(i32(k % 32u), i32(k / 32u));
        let p = clamp(q, vec2i(0), size1 - 1);
        let value = stage1(Point(p, (vec2f(p) + 0.5) / vec2f(size1), vec2f(size1)));
        if all(q >= from1) && all(q < to1) { textureStore(result3, p, value); }
    }
}


// downsample_tap13 325x181 [6, 46, 1]
fn run(at: Point) -> vec4f {
    let kernel0 = copy(textureLoad(image0, at.pixel, 0));
    return kernel0;
}
fn texel_of_source(pixel: vec2i) -> vec4f {
    let size = 2.0 * extent2;
    let inside = clamp(pixel, vec2i(0), vec2i(size) - 1);
    return run(Point(inside, (vec2f(inside) + 0.5) / size, size));
}
@compute @workgroup_size(64)
fn compute(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) invocation: u32) {
    let last = vec2i(extent2) - 1;
    let column = i32(group.x) * 62 + i32(invocation) - 1;
    let first = i32(group.y) * 4;
    let end = min(first + 4, last.y + 1);
    var state: DownsampleRows;
    for (var row = first - 1; row <= end; row++) {
        let corner = 2 * vec2i(column, row);
        let square = Square(
            texel_of_source(corner),
            texel_of_source(corner + vec2i(1, 0)),
            texel_of_source(corner + vec2i(0, 1)),
            texel_of_source(corner + vec2i(1, 1)),
        );
        let value = downsample_rows_tap13(&state, square, invocation);
        if row > first && invocation > 0u && invocation < 63u && column <= last.x {
            textureStore(result1, vec2i(column, row - 1), value);
        }
    }
}


// far [82, 91, 1]
fn run(at: Point) -> vec4f {
    let kernel0 = far(image0, linear1, at);
    return kernel0;
}
fn point_at(pixel: vec2i) -> Point {
    return Point(pixel, (vec2f(pixel) + 0.5) / extent3, extent3);
}
@compute @workgroup_size(16, 8)
fn compute(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_id) local: vec3u) {
    let away = vec2i(group.xy * vec2u(16u, 8u) + local.xy);
    let size = vec2i(extent3);
    let first = vec2i(away.x, size.y - 1 - away.y);
    if first.x >= size.x { return; }
    let value0 = run(point_at(max(first - vec2i(0, 0), vec2i())));
    if first.y >= 0 { textureStore(result2, first - vec2i(0, 0), value0); }
}
@vertex
fn vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    let uv = vec2f(f32(2u * (index & 1u)), f32(index & 2u));
    return vec4f(2.0 * uv.x - 1.0, 1.0 - 2.0 * uv.y, 0.0, 1.0);
}
@fragment
fn fragment(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return run(point_at(vec2i(position.xy)));
}


// downsample_tap13 162x90 > upsample_tent 325x181 > upsample_tent 650x362 > composite_add_tent + composite_add_pixel + exposure_metered [41, 23, 1]
struct PassUniform {
    sizes: array<vec4i, 4>,
    @align(16) kernel1: Upsample,
    @align(16) kernel2: Upsample,
    @align(16) kernel3: composite_Composite,
    @align(16) kernel4: composite_Composite_2,
    @align(16) kernel5: Exposure,
}
@group(0) @binding(0) var<uniform> params0: PassUniform;
@group(0) @binding(1) var image1: texture_2d<f32>;
@group(0) @binding(2) var linear2: sampler;
@group(0) @binding(3) var image3: texture_2d<f32>;
@group(0) @binding(4) var image4: texture_2d<f32>;
@group(0) @binding(5) var image5: texture_2d<f32>;
@group(0) @binding(6) var<storage, read> value6: array<vec4f>;
@group(0) @binding(7) var result7: texture_storage_2d<rgba16float, write>;
var<workgroup> tile_memory: array<vec2u, 666>;
fn tile_pack(v: vec4f) -> vec2u { return vec2u(pack2x16float(v.xy), pack2x16float(v.zw)); }
fn tile_cell(index: i32) -> vec4f {
    let cell = tile_memory[index];
    return vec4f(unpack2x16float(cell.x), unpack2x16float(cell.y));
}
var<private> tile_zero: i32;
var<private> tile_row: i32;
var<private> tile_bounds: vec2f;
fn tile_size(t: u32) -> vec2u { return vec2u(tile_bounds); }
fn tile_texel(t: u32, p: vec2i) -> vec4f { return tile_cell(tile_zero + p.y * tile_row + p.x); }
fn tile_tap(t: u32, s: u32, uv: vec2f) -> vec4f {
    let p = uv * tile_bounds - 0.5;
    let corner = floor(p);
    let f = p - corner;
    let i = tile_zero + i32(corner.y) * tile_row + i32(corner.x);
    let top = mix(tile_cell(i), tile_cell(i + 1), f.x);
    let bottom = mix(tile_cell(i + tile_row), tile_cell(i + tile_row + 1), f.x);
    return mix(top, bottom, f.y);
}
fn tile_start(next: vec2i, next_size: vec2i, size: vec2i, reach: f32) -> vec2i {
    let center = (vec2f(next) + 0.5) / vec2f(next_size) * vec2f(size) - 0.5;
    // A little less than the exact start, so that rounding loses no texel.
    return vec2i(floor(center - reach - 0.01));
}
fn tile_size_of(stage: i32) -> vec2i { return params0.sizes[stage].xy; }
fn tile_share(group: vec2i, size: vec2i, last: vec2i) -> vec2i {
    let whole = group * 32 >= last;
    return select(vec2i(vec2u(group * 32) * vec2u(size) / vec2u(last)), size, whole);
}
fn stage0(at: Point) -> vec4f {
    let kernel0 = downsample_tap13(image1, linear2, at);
    return kernel0;
}
fn stage1(at: Point) -> vec4f {
    let kernel1 = upsample_tent(textureLoad(image1, at.pixel, 0), 0u, 0u, at, params0.kernel1);
    return kernel1;
}
fn stage2(at: Point) -> vec4f {
    let kernel2 = upsample_tent(textureLoad(image3, at.pixel, 0), 0u, 0u, at, params0.kernel2);
    return kernel2;
}
fn stage3(at: Point) -> vec4f {
    let kernel3 = composite_add_tent(textureLoad(image4, at.pixel, 0), 0u, 0u, at, params0.kernel3);
    let kernel4 = composite_add_pixel(kernel3, textureLoad(image5, at.pixel, 0), params0.kernel4);
    let kernel5 = exposure_metered(kernel4, value6[0].x, params0.kernel5);
    return kernel5;
}
@compute @workgroup_size(16, 16)
fn compute(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) invocation: u32) {
    let last = tile_size_of(3);
    let origin3 = vec2i(group.xy) * 32;
    let origin2 = tile_start(origin3, tile_size_of(3), tile_size_of(2), 1.0);
    let origin1 = tile_start(origin2, tile_size_of(2), tile_size_of(1), 1.0);
    let origin0 = tile_start(origin1, tile_size_of(1), tile_size_of(0), 1.0);
    let size0 = tile_size_of(0);
    let from0 = tile_share(vec2i(group.xy), size0, last);
    let to0 = tile_share(vec2i(group.xy) + 1, size0, last);
    for (var k = invocation; k < 144u; k += 256u) {
        let q = origin0 + vec2i(i32(k % 12u), i32(k / 12u));
        let p = clamp(q, vec2i(0), size0 - 1);
        let value = stage0(Point(p, (vec2f(p) + 0.5) / vec2f(size0), vec2f(size0)));
        tile_memory[0 + i32(k)] = tile_pack(value);
    }
    workgroupBarrier();
    tile_row = 12;
    tile_zero = 0 - origin0.y * 12 - origin0.x;
    tile_bounds = vec2f(tile_size_of(0));
    let size1 = tile_size_of(1);
    let from1 = tile_share(vec2i(group.xy), size1, last);
    let to1 = tile_share(vec2i(group.xy) + 1, size1, last);
    for (var k = invocation; k < 225u; k += 256u) {
        let q = origin1 + vec2i(i32(k % 15u), i32(k / 15u));
        let p = clamp(q, vec2i(0), size1 - 1);
        let value = stage1(Point(p, (vec2f(p) + 0.5) / vec2f(size1), vec2f(size1)));
        tile_memory[441 + i32(k)] = tile_pack(value);
    }
    workgroupBarrier();
    tile_row = 15;
    tile_zero = 441 - origin1.y * 15 - origin1.x;
    tile_bounds = vec2f(tile_size_of(1));
    let size2 = tile_size_of(2);
    let from2 = tile_share(vec2i(group.xy), size2, last);
    let to2 = tile_share(vec2i(group.xy) + 1, size2, last);
    for (var k = invocation; k < 441u; k += 256u) {
        let q = origin2 + vec2i(i32(k % 21u), i32(k / 21u));
        let p = clamp(q, vec2i(0), size2 - 1);
        let value = stage2(Point(p, (vec2f(p) + 0.5) / vec2f(size2), vec2f(size2)));
        tile_memory[0 + i32(k)] = tile_pack(value);
    }
    workgroupBarrier();
    tile_row = 21;
    tile_zero = 0 - origin2.y * 21 - origin2.x;
    tile_bounds = vec2f(tile_size_of(2));
    let size3 = tile_size_of(3);
    let from3 = tile_share(vec2i(group.xy), size3, last);
    let to3 = tile_share(vec2i(group.xy) + 1, size3, last);
    for (var k = invocation; k < 1024u; k += 256u) {
        let q = origin3 + vec2i(i32(k % 32u), i32(k / 32u));
        let p = clamp(q, vec2i(0), size3 - 1);
        let value = stage3(Point(p, (vec2f(p) + 0.5) / vec2f(size3), vec2f(size3)));
        if all(q >= from3) && all(q < to3) { textureStore(result7, p, value); }
    }
}


// log_gaussian_average & log_gaussian_average [16, 8, 1]
struct PassUniform {
    @align(16) kernel0: log_gaussian_LogGaussian,
    @align(16) kernel1: log_gaussian_LogGaussian_2,
}
@group(0) @binding(6) var<uniform> cells_params: PassUniform;
fn cells_texel(pixel: vec2i) -> vec4f { return texel_inside(log_gaussian_picture, pixel); }
@compute @workgroup_size(256)
fn compute(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) invocation: u32) {
    let whole = textureDimensions(log_gaussian_picture);
    let size = stride_size(whole, 1u);
    let lattice = vec2u(32u, 16u);
    let number = invocation / 64u;
    let within = invocation % 64u;
    let inner = vec2u(number % 2u, number / 2u);
    let place = group.xy * vec2u(2u, 2u) + inner;
    let first = place * size / lattice;
    let end = ((place + 1u) * size + lattice - 1u) / lattice;
    let centred = cell_first(place, size, lattice);
    let beyond = cell_first(place + 1u, size, lattice);
    let cell0 = Cell(
        place / vec2u(2u, 2u),
        (inner.y % 2u * 2u + inner.x % 2u) * 64u + within,
        256u,
        inner.y / 2u * 1u + inner.x / 2u,
    );
    var state0 = log_gaussian_log_gaussian_begin(cell0);
    let cell1 = Cell(
        place / vec2u(1u, 1u),
        (inner.y % 1u * 1u + inner.x % 1u) * 64u + within,
        64u,
        inner.y / 1u * 2u + inner.x / 1u,
    );
    var state1 = log_gaussian_log_gaussian_begin_2(cell1);
    workgroupBarrier();
    for (var x = first.x + within % 64u; x < end.x; x += 64u) {
        for (var y = first.y + within / 64u; y < end.y; y += 1u) {
            let pixel = vec2u(x, y);
            let share = cell_share(pixel, place, size, lattice);
            let is_centred = all(pixel >= centred) && all(pixel < beyond);
            let picked = vec2i(pixel);
            let seen = Seen(picked, cells_texel(picked), share.x * share.y, is_centred);
            log_gaussian_log_gaussian_visit(&state0, cell0, seen);
            log_gaussian_log_gaussian_visit_2(&state1, cell1, seen);
        }
    }
    log_gaussian_log_gaussian_finish(&state0, cell0);
    log_gaussian_log_gaussian_finish_2(&state1, cell1);
}


// soft [82, 91, 1]
fn run(at: Point) -> vec4f {
    let kernel0 = soft(image0, linear1, at);
    return kernel0;
}
fn point_at(pixel: vec2i) -> Point {
    return Point(pixel, (vec2f(pixel) + 0.5) / extent3, extent3);
}
@compute @workgroup_size(16, 8)
fn compute(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_id) local: vec3u) {
    let away = vec2i(group.xy * vec2u(16u, 8u) + local.xy);
    let size = vec2i(extent3);
    let first = vec2i(away.x, size.y - 1 - away.y);
    if first.x >= size.x { return; }
    let value0 = run(point_at(max(first - vec2i(0, 0), vec2i())));
    if first.y >= 0 { textureStore(result2, first - vec2i(0, 0), value0); }
}
@vertex
fn vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    let uv = vec2f(f32(2u * (index & 1u)), f32(index & 2u));
    return vec4f(2.0 * uv.x - 1.0, 1.0 - 2.0 * uv.y, 0.0, 1.0);
}
@fragment
fn fragment(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return run(point_at(vec2i(position.xy)));
}


// composite_add_pixel [82, 46, 1]
struct PassUniform {
    @align(16) kernel0: Composite,
}
@group(0) @binding(0) var image0: texture_2d<f32>;
@group(0) @binding(1) var image1: texture_2d<f32>;
@group(0) @binding(2) var<uniform> params2: PassUniform;
@group(0) @binding(3) var result3: texture_storage_2d<rgba16float, write>;
@group(0) @binding(4) var<uniform> extent4: vec2f;
fn run(at: Point) -> vec4f {
    let kernel0 = composite_add_pixel(textureLoad(image0, at.pixel, 0), textureLoad(image1, at.pixel, 0), params2.kernel0);
    return kernel0;
}
fn point_at(pixel: vec2i) -> Point {
    return Point(pixel, (vec2f(pixel) + 0.5) / extent4, extent4);
}
@compute @workgroup_size(16, 8)
fn compute(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_id) local: vec3u) {
    let away = vec2i(group.xy * vec2u(16u, 16u) + local.xy);
    let size = vec2i(extent4);
    let first = vec2i(away.x, size.y - 1 - away.y);
    if first.x >= size.x { return; }
    let value0 = run(point_at(max(first - vec2i(0, 0), vec2i())));
    let value1 = run(point_at(max(first - vec2i(0, 8), vec2i())));
    if first.y >= 0 { textureStore(result3, first - vec2i(0, 0), value0); }
    if first.y >= 8 { textureStore(result3, first - vec2i(0, 8), value1); }
}
@vertex
fn vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    let uv = vec2f(f32(2u * (index & 1u)), f32(index & 2u));
    return vec4f(2.0 * uv.x - 1.0, 1.0 - 2.0 * uv.y, 0.0, 1.0);
}
@fragment
fn fragment(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return run(point_at(vec2i(position.xy)));
}


// exposure_metered [82, 46, 1]
struct PassUniform {
    @align(16) kernel0: Exposure,
}
@group(0) @binding(0) var image0: texture_2d<f32>;
@group(0) @binding(1) var<storage, read> value1: array<vec4f>;
@group(0) @binding(2) var<uniform> params2: PassUniform;
@group(0) @binding(3) var result3: texture_storage_2d<rgba16float, write>;
@group(0) @binding(4) var<uniform> extent4: vec2f;
fn run(at: Point) -> vec4f {
    let kernel0 = exposure_metered(textureLoad(image0, at.pixel, 0), value1[0].x, params2.kernel0);
    return kernel0;
}
fn point_at(pixel: vec2i) -> Point {
    return Point(pixel, (vec2f(pixel) + 0.5) / extent4, extent4);
}
@compute @workgroup_size(16, 8)
fn compute(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_id) local: vec3u) {
    let away = vec2i(group.xy * vec2u(16u, 16u) + local.xy);
    let size = vec2i(extent4);
    let first = vec2i(away.x, size.y - 1 - away.y);
    if first.x >= size.x { return; }
    let value0 = run(point_at(max(first - vec2i(0, 0), vec2i())));
    let value1 = run(point_at(max(first - vec2i(0, 8), vec2i())));
    if first.y >= 0 { textureStore(result3, first - vec2i(0, 0), value0); }
    if first.y >= 8 { textureStore(result3, first - vec2i(0, 8), value1); }
}
@vertex
fn vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    let uv = vec2f(f32(2u * (index & 1u)), f32(index & 2u));
    return vec4f(2.0 * uv.x - 1.0, 1.0 - 2.0 * uv.y, 0.0, 1.0);
}
@fragment
fn fragment(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return run(point_at(vec2i(position.xy)));
}


