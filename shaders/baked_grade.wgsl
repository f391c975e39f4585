#import cube
#import shaper

struct BakedGrade {
    row0: vec4f,    // the primaries of the source to those of the table's axes
    row1: vec4f,
    row2: vec4f,
    line: vec4f,
    shaper_curve: vec4f,
}

// Whether the source has the primaries of the table's axes. The rows are then the identity.
const BAKED_GRADE_SAME_PRIMARIES: bool = false;

// The position of light in the table. Negative light is outside of it, and uses its border.
fn baked_grade_position(light: vec3f, params: BakedGrade) -> vec3f {
    if BAKED_GRADE_SAME_PRIMARIES { return shape3(light, params.line, params.shaper_curve); }
    let rgb = vec3f(dot(params.row0.xyz, light), dot(params.row1.xyz, light), dot(params.row2.xyz, light));
    return shape3(rgb, params.line, params.shaper_curve);
}

fn baked_grade(source: vec4f, table: texture_3d<f32>, table_sampler: sampler, params: BakedGrade) -> vec4f {
    return vec4f(cube_fetched(table, table_sampler, baked_grade_position(source.rgb, params)), source.a);
}

fn baked_grade_tetrahedral(source: vec4f, table: texture_3d<f32>, params: BakedGrade) -> vec4f {
    return vec4f(cube_tetrahedral(table, baked_grade_position(source.rgb, params)), source.a);
}
