// The longest vectors of each tile of an image, and of the nine tiles around. Kinds that gather read no farther.

struct Tiles {
    side: i32,         // texels of a tile
    mask: vec2f,       // 1 for the components of the vectors
}

fn tiles_longer(a: vec2f, b: vec2f) -> vec2f {
    return select(a, b, dot(b, b) > dot(a, a));
}

// The longest vector in a row of texels.
fn tiles_row(vectors: texture_2d<f32>, at: Point, params: Tiles) -> vec4f {
    var longest = vec2f();
    for (var i = 0; i < params.side; i++) {
        let place = vec2i(at.pixel.x * params.side + i, at.pixel.y);
        longest = tiles_longer(longest, texel(vectors, place).xy * params.mask);
    }
    return vec4f(longest, 0.0, 1.0);
}

// The longest vector in a column of rows.
fn tiles_column(rows: texture_2d<f32>, at: Point, params: Tiles) -> vec4f {
    var longest = vec2f();
    for (var i = 0; i < params.side; i++) {
        let place = vec2i(at.pixel.x, at.pixel.y * params.side + i);
        longest = tiles_longer(longest, texel(rows, place).xy);
    }
    return vec4f(longest, 0.0, 1.0);
}

// The longest vector of the nine tiles around: no vector reaches beyond the next tile.
fn tiles_around(tiles: texture_2d<f32>, at: Point) -> vec4f {
    var longest = vec2f();
    for (var y = -1; y <= 1; y++) {
        for (var x = -1; x <= 1; x++) {
            longest = tiles_longer(longest, texel(tiles, at.pixel + vec2i(x, y)).xy);
        }
    }
    return vec4f(longest, 0.0, 1.0);
}
