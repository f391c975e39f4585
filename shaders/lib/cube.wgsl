// Reads tables over the unit cube. One texel per entry: the first at 0, the last at 1.
import package::math::between;
import package::sampling::{tap3, tap3_plane, texel3};

// The eight entries around a color, weighted in 32 bits.
fn cube_trilinear(table: texture_3d<f32>, rgb: vec3f) -> vec3f {
    let last = vec3f(textureDimensions(table)) - 1.0;
    let p = clamp(rgb, vec3f(0.0), vec3f(1.0)) * last;
    let base = min(floor(p), last - 1.0);
    let i = vec3i(base);
    let f = p - base;
    return between(tap3_plane(table, i, f.xy), tap3_plane(table, i + vec3i(0, 0, 1), f.xy), f.z).rgb;
}

// The eight entries around a color, weighted by the device's filter, which has 8 bits.
fn cube_fetched(table: texture_3d<f32>, table_sampler: sampler, rgb: vec3f) -> vec3f {
    let size = vec3f(textureDimensions(table));
    let uvw = (clamp(rgb, vec3f(0.0), vec3f(1.0)) * (size - 1.0) + 0.5) / size;
    return tap3(table, table_sampler, uvw).rgb;
}

// The four corners of the tetrahedron around a color: from the lowest corner along the axis of the largest fraction,
// then of the middle one, then of the smallest. Grays depend only on entries of the gray axis.
fn cube_tetrahedral(table: texture_3d<f32>, rgb: vec3f) -> vec3f {
    let last = vec3f(textureDimensions(table)) - 1.0;
    let p = clamp(rgb, vec3f(0.0), vec3f(1.0)) * last;
    let base = min(floor(p), last - 1.0);
    let f = p - base;
    let x_leads = f.x >= f.y && f.x >= f.z;
    let y_leads = !x_leads && f.y >= f.z;
    let x_trails = !x_leads && f.x < f.y && f.x < f.z;
    let y_trails = !x_trails && !y_leads && f.y < f.z;
    let first = select(select(vec3i(0, 0, 1), vec3i(0, 1, 0), y_leads), vec3i(1, 0, 0), x_leads);
    let last_axis = select(select(vec3i(0, 0, 1), vec3i(0, 1, 0), y_trails), vec3i(1, 0, 0), x_trails);
    let most = max(f.x, max(f.y, f.z));
    let least = min(f.x, min(f.y, f.z));
    let middle = dot(f, vec3f(1.0) - vec3f(first) - vec3f(last_axis));
    let i = vec3i(base);
    return (1.0 - most) * texel3(table, i).rgb
        + (most - middle) * texel3(table, i + first).rgb
        + (middle - least) * texel3(table, i + 1 - last_axis).rgb
        + least * texel3(table, i + 1).rgb;
}
