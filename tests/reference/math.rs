//! Three-vectors, row-major 3×3 matrices and the Hermite step, also for equal edges.

/// A color or any other triple; linear Rec.709 where nothing else is said.
pub(crate) type Rgb = [f64; 3];

/// Row-major: row i makes output i of `matrix · column`.
pub(crate) type Matrix = [[f64; 3]; 3];

/// The scalar product of two triples.
pub(crate) fn dot(a: Rgb, b: Rgb) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// `matrix · column`.
pub(crate) fn transform(matrix: &Matrix, column: Rgb) -> Rgb {
    matrix.map(|row| dot(row, column))
}

/// `a · b`: the matrix that applies `b` first.
pub(crate) fn product(a: &Matrix, b: &Matrix) -> Matrix {
    let columns = transpose(b);
    a.map(|row| columns.map(|column| dot(row, column)))
}

pub(crate) fn transpose(m: &Matrix) -> Matrix {
    [0, 1, 2].map(|column| [0, 1, 2].map(|row| m[row][column]))
}

/// A matrix that scales each channel on its own.
pub(crate) fn diagonal([x, y, z]: Rgb) -> Matrix {
    [[x, 0.0, 0.0], [0.0, y, 0.0], [0.0, 0.0, z]]
}

/// The inverse by cofactors; the matrices of this book are far from singular.
pub(crate) fn inverse(m: &Matrix) -> Matrix {
    let cofactor = |row: usize, column: usize| {
        let (r1, r2) = ((row + 1) % 3, (row + 2) % 3);
        let (c1, c2) = ((column + 1) % 3, (column + 2) % 3);
        m[r1][c1] * m[r2][c2] - m[r1][c2] * m[r2][c1]
    };
    let determinant: f64 = (0..3).map(|column| m[0][column] * cofactor(0, column)).sum();
    [0, 1, 2].map(|row| [0, 1, 2].map(|column| cofactor(column, row) / determinant))
}

/// Applies `f` to the channels of two triples.
pub(crate) fn zip(a: Rgb, b: Rgb, f: impl Fn(f64, f64) -> f64) -> Rgb {
    [f(a[0], b[0]), f(a[1], b[1]), f(a[2], b[2])]
}

pub(crate) fn largest(rgb: Rgb) -> f64 {
    rgb[0].max(rgb[1]).max(rgb[2])
}

/// `a` at t = 0, `b` at t = 1.
pub(crate) fn mix(a: f64, b: f64, t: f64) -> f64 {
    a * (1.0 - t) + b * t
}

/// The Hermite step from 0 at `low` to 1 at `high`; a jump at `high` when the edges are equal or
/// swapped (WGSL leaves those cases undefined).
pub(crate) fn smooth_step(low: f64, high: f64, x: f64) -> f64 {
    if high <= low {
        return if x >= high { 1.0 } else { 0.0 };
    }
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

#[test]
fn an_inverse_undoes_its_matrix() {
    let matrix = [[2.0, 1.0, 0.5], [-1.0, 3.0, 0.25], [0.0, 4.0, 1.5]];
    let identity = product(&matrix, &inverse(&matrix));
    for (row, expected) in identity.iter().zip(diagonal([1.0; 3])) {
        for (value, expected) in row.iter().zip(expected) {
            assert!((value - expected).abs() < 1e-14, "{identity:?}");
        }
    }
}
