// The matrix of Bayer ("An optimum method for two-level rendition of continuous-tone pictures", 1973).

// The place of a dot of the matrix among its 64, from 0: the bits of y and of x xor y, interleaved, the lowest first.
fn bayer_rank(cell: vec2u) -> u32 {
    let mixed = cell.x ^ cell.y;
    var rank = 0u;
    for (var bit = 0u; bit < 3u; bit++) {
        let pair = 2u * ((mixed >> bit) & 1u) + ((cell.y >> bit) & 1u);
        rank = (rank << 2u) | pair;
    }
    return rank;
}

// The share of a color from which on a dot has it: from 1/128 to 127/128.
fn bayer_threshold(dot: vec2i) -> f32 {
    return (f32(bayer_rank(vec2u(dot) % 8u)) + 0.5) / 64.0;
}
