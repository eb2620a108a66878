//! Development only: segments one benchmark case.
use scanwright::math::{Point3, Vec3};
use scanwright::mesh::{Adjacency, Mesh};
use scanwright::segment::{segment, SegmentOptions};
use scanwright::surface::Surface;
use scanwright::tolerance::{Measured, Tolerances};

fn load(path: &str) -> Mesh {
    let bytes = std::fs::read(path).unwrap();
    let end = bytes.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
    let head = String::from_utf8_lossy(&bytes[..end]).to_string();
    let count = |key: &str| head.lines().find_map(|l| l.strip_prefix(key)).unwrap().trim().parse::<usize>().unwrap();
    let (nv, nt) = (count("element vertex "), count("element face "));
    let f = |o: usize| f64::from(f32::from_le_bytes(bytes[o..o + 4].try_into().unwrap()));
    let vertices = (0..nv).map(|i| Point3::new(f(end + 12 * i), f(end + 12 * i + 4), f(end + 12 * i + 8))).collect();
    let at = end + 12 * nv;
    let u = |o: usize| u32::from_le_bytes(bytes[o..o + 4].try_into().unwrap());
    let triangles = (0..nt).map(|i| [u(at + 13 * i + 1), u(at + 13 * i + 5), u(at + 13 * i + 9)]).collect();
    Mesh { vertices, triangles }
}

fn bilateral(mesh: &Mesh, adjacency: &Adjacency, sigma: f64) -> Vec<Vec3> {
    let mut normals = mesh.vertex_normals();
    for _ in 0..4 {
        normals = scanwright::par::map_indices(normals.len(), |v| {
            let n = normals[v];
            let mut sum = n;
            for &u in adjacency.vertex_vertices.row(v) {
                let m = normals[u as usize];
                sum += m * (-(m - n).norm_squared() / (2.0 * sigma * sigma)).exp();
            }
            sum.try_normalize(0.0).unwrap_or(n)
        });
    }
    normals
}

fn main() {
    let args: Vec<String> = std::env::args().collect();
    let (case, out) = (&args[1], &args[2]);
    let noise: f64 = args[3].parse().unwrap();
    let mesh = load(&format!("{case}/scan.ply"));
    // table triangles dropped by truth: a file of u8 flags
    let flags = std::fs::read(format!("{out}/table.bin")).unwrap();
    let (part, source, _) = mesh.submesh(|t| flags[t] == 0);
    let adjacency = Adjacency::new(&part);
    let spacing = (part.total_area() / part.vertices.len() as f64).sqrt();
    let measured = Measured { largest_coordinate: part.largest_coordinate(), diagonal: part.diagonal(), spacing, noise, normal_noise: 0.1, edge_rounding: args[4].parse().unwrap() };
    let tolerances = Tolerances::new(measured, None);
    let normals = bilateral(&part, &adjacency, (2.0 * noise / spacing).max(0.25));
    let start = std::time::Instant::now();
    let result = segment(&part, &adjacency, &normals, &tolerances, &SegmentOptions::default());
    eprintln!("{} {:.2} s, {} regions", case, start.elapsed().as_secs_f64(), result.primitives.len());
    let mut labels = vec![-1_i32; mesh.triangles.len()];
    for (t, l) in result.labels.iter().enumerate() {
        if let Some(l) = l { labels[source[t] as usize] = l.0 as i32; }
    }
    std::fs::write(format!("{out}/labels.bin"), labels.iter().flat_map(|l| l.to_le_bytes()).collect::<Vec<u8>>()).unwrap();
    let v = |p: &Vec3| format!("[{},{},{}]", p.x, p.y, p.z);
    let rows: Vec<String> = result.primitives.iter().enumerate().map(|(i, p)| {
        let rest = match p.surface {
            None => "\"type\":\"freeform\"".into(),
            Some(Surface::Plane(s)) => format!("\"type\":\"plane\",\"point\":{},\"normal\":{}", v(&s.point.coords), v(&s.normal)),
            Some(Surface::Cylinder(s)) => format!("\"type\":\"cylinder\",\"axis_point\":{},\"axis_direction\":{},\"radius\":{}", v(&s.axis.origin.coords), v(&s.axis.direction), s.radius),
            Some(Surface::Cone(s)) => format!("\"type\":\"cone\",\"apex\":{},\"axis_direction\":{},\"half_angle\":{}", v(&s.apex().coords), v(&s.axis.direction), s.half_angle),
            Some(Surface::Sphere(s)) => format!("\"type\":\"sphere\",\"center\":{},\"radius\":{}", v(&s.center.coords), s.radius),
            Some(Surface::Torus(s)) => format!("\"type\":\"torus\",\"center\":{},\"axis_direction\":{},\"major_radius\":{},\"minor_radius\":{}", v(&s.axis.origin.coords), v(&s.axis.direction), s.major_radius, s.minor_radius),
        };
        format!("{{\"id\":{i},{rest},\"rms\":{},\"outward\":{}}}", p.residual.rms, p.outward)
    }).collect();
    std::fs::write(format!("{out}/part.json"), format!("{{\"primitives\":[{}]}}", rows.join(",\n"))).unwrap();
}
