// A table in a kind without Rust. It arrives as an image of 256 texels in a row, with two words of the table in each
// texel: low half, high half, low half, high half. Halves are whole numbers that an f32 holds exactly.

// The word at an index, counted from 0. Beyond the table it is a word near its end, or zero.
fn table_word(table: texture_2d<f32>, index: u32) -> u32 {
    let words = texel(table, vec2i(i32((index >> 1u) & 255u), i32(index >> 9u)));
    let halves = select(words.xy, words.zw, (index & 1u) == 1u);
    return u32(halves.x) | (u32(halves.y) << 16u);
}

// The word at an index, as a float.
fn table_number(table: texture_2d<f32>, index: u32) -> f32 {
    return bitcast<f32>(table_word(table, index));
}
