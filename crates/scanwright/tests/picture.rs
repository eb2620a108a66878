//! Pictures: what is nearer hides what is farther, areas are right, bytes are the same.

use scanwright::math::{Point3, Vec3};
use scanwright::mesh::Mesh;
use scanwright::par;
use scanwright::render::{Camera, Color, Image, Sheet, View, picture};

const RED: Color = Color([220, 40, 40]);
const BLUE: Color = Color([40, 40, 220]);

#[test]
fn a_sphere_covers_the_area_of_its_disc() {
    let radius = 3.0;
    let sphere = sphere(radius, 60);
    let colors = vec![RED; sphere.triangles.len()];
    let image =
        draw(&sphere, &colors, Camera::around(Vec3::z_axis(), 0.7, 0.4), (400, 400), &corners(radius));
    let n_covered = (0..400 * 400).filter(|i| is_reddish(&image, *i)).count() as f64;

    // A cube of half edge `radius` frames it: its corners in these two directions span at most the diagonal, so the
    // scale is found from the picture itself, by its widest row.
    let widest =
        (0..400).map(|y| (0..400).filter(|x| is_reddish(&image, y * 400 + x)).count()).max().unwrap() as f64;
    let expected = std::f64::consts::FRAC_PI_4 * widest * widest;
    // One pixel more or less along the rim, on both measures.
    let bound = 2.0 * std::f64::consts::PI * widest;
    assert!((n_covered - expected).abs() < bound, "{n_covered} pixels, expected {expected} within {bound}");
    assert!(widest > 100.0, "the sphere is {widest} pixels wide");
}

#[test]
fn what_is_nearer_hides_what_is_farther() {
    // Two squares seen along x: red in front for one camera, blue for its opposite.
    let mut mesh = Mesh::default();
    let mut colors = Vec::new();
    for (x, color) in [(1.0, RED), (-1.0, BLUE)] {
        let first = mesh.vertices.len() as u32;
        mesh.vertices
            .extend([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(y, z)| Point3::new(x, y, z)));
        mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        colors.extend([color, color]);
    }
    let middle = |azimuth: f64| {
        let camera = Camera::around(Vec3::z_axis(), azimuth, 0.0);
        let image = draw(&mesh, &colors, camera, (100, 100), &mesh.vertices);
        let at = 3 * (50 * 100 + 50);
        (image.pixels[at], image.pixels[at + 2])
    };
    let (red, blue) = middle(0.0);
    assert!(red > 2 * blue, "in front of red: red {red}, blue {blue}");
    let (red, blue) = middle(std::f64::consts::PI);
    assert!(blue > 2 * red, "in front of blue: red {red}, blue {blue}");
}

#[test]
fn pictures_do_not_depend_on_the_number_of_threads() {
    let sphere = sphere(1.0, 30);
    let colors: Vec<Color> =
        (0..sphere.triangles.len()).map(|t| if t % 2 == 0 { RED } else { BLUE }).collect();
    let camera = Camera::around(Vec3::x_axis(), 0.3, -0.5);
    let with = |n| par::with_threads(Some(n), || draw(&sphere, &colors, camera, (123, 77), &sphere.vertices));
    assert!(with(1) == with(2), "one and two threads draw different pictures");
}

#[test]
fn png_holds_the_pixels() {
    let sphere = sphere(1.0, 20);
    let colors = vec![BLUE; sphere.triangles.len()];
    let image = draw(&sphere, &colors, Camera::around(Vec3::z_axis(), 0.0, 0.0), (64, 48), &sphere.vertices);
    let bytes = image.to_png();
    let mut reader = png::Decoder::new(std::io::Cursor::new(&bytes)).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    assert_eq!((info.width, info.height), (64, 48));
    assert!(pixels == image.pixels, "decoded pixels differ");
}

#[test]
fn degenerate_scenes_are_drawn() {
    let camera = Camera::around(Vec3::z_axis(), 0.0, 0.0);
    let empty = draw(&Mesh::default(), &[], camera, (40, 30), &[]);
    assert!(empty.pixels.chunks(3).all(|p| p == &empty.pixels[..3]), "nothing drawn is background");
    let sliver = vec![[0, 0, 0], [0, 1, 1], [0, 1, 2]];
    for size in [0.0, 1e-30, 1e30] {
        let vertices = vec![Point3::origin(), Point3::new(size, 0.0, 0.0), Point3::new(0.0, size, 0.0)];
        let mesh = Mesh { vertices, triangles: sliver.clone() };
        let image = draw(&mesh, &[RED; 3], camera, (40, 30), &mesh.vertices);
        assert_eq!(image.pixels.len(), 3 * 40 * 30);
    }
}

fn draw(
    mesh: &Mesh,
    colors: &[Color],
    camera: Camera,
    (width, height): (usize, usize),
    frame: &[Point3],
) -> Image {
    let groups = vec![0; mesh.triangles.len()];
    let view = View { mesh, colors, groups: &groups, camera, title: "" };
    picture(&[view], &Sheet { width, height, frame, legend: &[] })
}

/// Whether a pixel is more red than the grey background can be.
fn is_reddish(image: &Image, pixel: usize) -> bool {
    let [red, green, _] = [0, 1, 2].map(|k| i32::from(image.pixels[3 * pixel + k]));
    red - green > 20
}

fn corners(half: f64) -> Vec<Point3> {
    let sign = |i: usize, bit: usize| if i >> bit & 1 == 0 { -half } else { half };
    (0..8).map(|i| Point3::new(sign(i, 0), sign(i, 1), sign(i, 2))).collect()
}

/// A sphere of `n` rings and as many meridians, both ends closed by slivers.
fn sphere(radius: f64, n: usize) -> Mesh {
    let mut mesh = Mesh::default();
    for i in 0..=n {
        let polar = std::f64::consts::PI * i as f64 / n as f64;
        for j in 0..n {
            let turn = std::f64::consts::TAU * j as f64 / n as f64;
            let direction = Vec3::new(polar.sin() * turn.cos(), polar.sin() * turn.sin(), polar.cos());
            mesh.vertices.push(Point3::from(direction * radius));
        }
    }
    let at = |i: usize, j: usize| (i * n + j % n) as u32;
    for i in 0..n {
        for j in 0..n {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh
}
