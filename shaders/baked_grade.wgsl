#import cube
#import shaper

struct BakedGrade {
    line: vec4f,
    shaper_curve: vec4f,
}

fn baked_grade(source: vec4f, table: texture_3d<f32>, table_sampler: sampler, params: BakedGrade) -> vec4f {
    return vec4f(cube_fetched(table, table_sampler, shape3(source.rgb, params.line, params.shaper_curve)), source.a);
}

fn baked_grade_tetrahedral(source: vec4f, table: texture_3d<f32>, params: BakedGrade) -> vec4f {
    return vec4f(cube_tetrahedral(table, shape3(source.rgb, params.line, params.shaper_curve)), source.a);
}
