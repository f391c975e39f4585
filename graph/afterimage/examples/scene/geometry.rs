//! Vertices of a small scene: a plane, boxes, spheres.

/// The vertices and indices of all objects.
#[derive(Default)]
pub(crate) struct Mesh {
    vertices: Vec<Vertex>,
    indices: Vec<u32>,
}

/// A corner of a triangle.
struct Vertex {
    place: [f32; 3],
    normal: [f32; 3],
    /// Its color, and how strongly it emits light.
    color: [f32; 4],
}

impl Mesh {
    /// The vertices: ten floats each.
    pub(crate) fn vertex_bytes(&self) -> Vec<u8> {
        let numbers =
            self.vertices.iter().flat_map(|vertex| vertex.place.into_iter().chain(vertex.normal).chain(vertex.color));
        numbers.flat_map(f32::to_le_bytes).collect()
    }

    /// The indices: 32 bits each.
    pub(crate) fn index_bytes(&self) -> Vec<u8> {
        self.indices.iter().copied().flat_map(u32::to_le_bytes).collect()
    }

    /// How many indices there are.
    pub(crate) fn count(&self) -> u32 {
        self.indices.len() as u32
    }

    /// The objects of the scene.
    pub(crate) fn scene() -> Self {
        let mut mesh = Self::default();
        let (stone, clay, leaf) = ([0.55, 0.52, 0.48, 0.0], [0.62, 0.24, 0.14, 0.0], [0.16, 0.42, 0.2, 0.0]);
        mesh.plane(12.0, stone);
        mesh.cuboid([-2.2, 0.9, -0.6], [0.9, 0.9, 0.9], 0.5, clay);
        mesh.cuboid([1.9, 0.5, 1.2], [0.5, 0.5, 1.1], -0.35, [0.2, 0.3, 0.55, 0.0]);
        mesh.cuboid([0.6, 1.6, -2.6], [0.25, 1.6, 0.25], 0.2, stone);
        mesh.sphere([0.1, 0.8, 0.6], 0.8, leaf);
        mesh.sphere([2.9, 0.45, -1.0], 0.45, [0.75, 0.7, 0.3, 0.0]);
        // These emit light: the bloom of the pipeline reads alpha.
        mesh.sphere([0.6, 3.5, -2.6], 0.3, [1.0, 0.55, 0.2, 1.0]);
        mesh.sphere([-1.1, 0.25, 1.9], 0.25, [0.25, 0.6, 1.0, 1.0]);
        mesh
    }

    /// Things of colored glass.
    pub(crate) fn glass() -> Self {
        let mut mesh = Self::default();
        mesh.cuboid([1.2, 0.75, 2.6], [0.7, 0.75, 0.04], 0.35, [0.95, 0.62, 0.3, 0.0]);
        mesh.cuboid([0.2, 0.6, 2.9], [0.7, 0.6, 0.04], 0.6, [0.45, 0.75, 0.95, 0.0]);
        mesh
    }

    /// A square on the ground.
    fn plane(&mut self, half: f32, color: [f32; 4]) {
        let corners = [[-half, 0.0, -half], [-half, 0.0, half], [half, 0.0, half], [half, 0.0, -half]];
        self.quad(corners, [0.0, 1.0, 0.0], color);
    }

    /// A box with these half sides, turned around the vertical.
    fn cuboid(&mut self, center: [f32; 3], half: [f32; 3], turn: f32, color: [f32; 4]) {
        let (sin, cos) = turn.sin_cos();
        let turned = |[x, y, z]: [f32; 3]| [x * cos + z * sin, y, z * cos - x * sin];
        for axis in 0..3 {
            for side in [-1.0_f32, 1.0] {
                let (across, up) = ((axis + 1) % 3, (axis + 2) % 3);
                let mut normal = [0.0; 3];
                normal[axis] = side;
                let corner = |u: f32, v: f32| {
                    let mut place = [0.0; 3];
                    (place[axis], place[across], place[up]) =
                        (side * half[axis], u * side * half[across], v * half[up]);
                    let place = turned(place);
                    [0, 1, 2].map(|axis| center[axis] + place[axis])
                };
                let corners = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
                self.quad(corners, turned(normal), color);
            }
        }
    }

    /// Two triangles, counterclockwise as they are seen from where the normal points.
    fn quad(&mut self, corners: [[f32; 3]; 4], normal: [f32; 3], color: [f32; 4]) {
        let first = self.vertices.len() as u32;
        self.vertices.extend(corners.map(|place| Vertex { place, normal, color }));
        self.indices.extend([0, 1, 2, 0, 2, 3].map(|corner| first + corner));
    }

    /// An icosahedron whose faces are divided three times.
    fn sphere(&mut self, center: [f32; 3], radius: f32, color: [f32; 4]) {
        for face in icosahedron() {
            self.face(face, 3, &|direction| Vertex {
                place: [0, 1, 2].map(|axis| center[axis] + radius * direction[axis]),
                normal: direction,
                color,
            });
        }
    }

    fn face(&mut self, [a, b, c]: [[f32; 3]; 3], divisions: u32, vertex: &dyn Fn([f32; 3]) -> Vertex) {
        if divisions == 0 {
            let first = self.vertices.len() as u32;
            self.vertices.extend([a, b, c].map(vertex));
            self.indices.extend([first, first + 1, first + 2]);
            return;
        }
        let middle = |p: [f32; 3], q: [f32; 3]| unit([0, 1, 2].map(|axis| p[axis] + q[axis]));
        let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
        for face in [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]] {
            self.face(face, divisions - 1, vertex);
        }
    }
}

/// The faces of an icosahedron on the unit sphere, counterclockwise as they are seen from outside.
pub(crate) fn icosahedron() -> Vec<[[f32; 3]; 3]> {
    let t = (1.0 + 5.0_f32.sqrt()) / 2.0;
    let mut corners = Vec::new();
    for (one, golden) in [(-1.0, -t), (-1.0, t), (1.0, -t), (1.0, t)] {
        corners.extend([[one, golden, 0.0], [0.0, one, golden], [golden, 0.0, one]].map(unit));
    }
    // Neighbors of the unit sphere are this near.
    let is_edge = |p: [f32; 3], q: [f32; 3]| dot(p, q) > 0.4 && dot(p, q) < 0.5;
    let mut faces = Vec::new();
    for (i, a) in corners.iter().enumerate() {
        for (j, b) in corners.iter().enumerate().skip(i + 1) {
            for c in corners.iter().skip(j + 1) {
                if is_edge(*a, *b) && is_edge(*b, *c) && is_edge(*a, *c) {
                    let outwards = dot(cross(sub(*b, *a), sub(*c, *a)), *a) > 0.0;
                    faces.push(if outwards { [*a, *b, *c] } else { [*a, *c, *b] });
                }
            }
        }
    }
    faces
}

fn sub(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [0, 1, 2].map(|axis| a[axis] - b[axis])
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The vector of length 1 in the same direction.
pub(crate) fn unit(a: [f32; 3]) -> [f32; 3] {
    let length = dot(a, a).sqrt();
    a.map(|number| number / length)
}

/// The matrix from the world to a camera at `eye` that looks at `at`, in columns.
pub(crate) fn look_at(eye: [f32; 3], at: [f32; 3]) -> [[f32; 4]; 4] {
    let back = unit(sub(eye, at));
    let right = unit(cross([0.0, 1.0, 0.0], back));
    let up = cross(back, right);
    let column = |axis: usize| [right[axis], up[axis], back[axis], 0.0];
    let shift = [right, up, back].map(|side| -dot(side, eye));
    [column(0), column(1), column(2), [shift[0], shift[1], shift[2], 1.0]]
}

/// A perspective with depth 0 at the near plane and 1 at the far plane, in columns.
pub(crate) fn perspective(degrees: f32, aspect: f32, near: f32, far: f32) -> [[f32; 4]; 4] {
    let scale = 1.0 / (degrees.to_radians() / 2.0).tan();
    let depth = far / (near - far);
    [[scale / aspect, 0.0, 0.0, 0.0], [0.0, scale, 0.0, 0.0], [0.0, 0.0, depth, -1.0], [0.0, 0.0, near * depth, 0.0]]
}
