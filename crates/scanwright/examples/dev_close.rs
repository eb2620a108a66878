use scanwright::brep::close::close;
use scanwright::condition::Support;
use scanwright::math::{Axis, Point3, UnitVec3, Vec3};
use scanwright::mesh::Mesh;
use scanwright::recognize::{Primitive, Residual};
use scanwright::segment::{RegionId, Segmentation};
use scanwright::surface::{Cone, Cylinder, Plane, Sphere, Surface, Torus};
use scanwright::tolerance::{Measured, Tolerances};
use std::io::Write;
fn main() {
    let dir = std::env::args().nth(1).unwrap();
    let read = |n: &str| std::fs::read(format!("{dir}/{n}")).unwrap();
    let v: Vec<f64> = read("v.bin").chunks(8).map(|c| f64::from_le_bytes(c.try_into().unwrap())).collect();
    let t: Vec<u32> = read("t.bin").chunks(4).map(|c| u32::from_le_bytes(c.try_into().unwrap())).collect();
    let l: Vec<i32> = read("l.bin").chunks(4).map(|c| i32::from_le_bytes(c.try_into().unwrap())).collect();
    let mesh = Mesh {
        vertices: v.chunks(3).map(|c| Point3::new(c[0], c[1], c[2])).collect(),
        triangles: t.chunks(3).map(|c| [c[0], c[1], c[2]]).collect(),
    };
    let text = std::fs::read_to_string(format!("{dir}/s.txt")).unwrap();
    let (mut h, mut diag, mut support, mut primitives) = (0.0, 0.0, None, Vec::new());
    let noise: f64 = std::env::args().nth(2).map_or(0.0, |x| x.parse().unwrap());
    let mut rng = scanwright::random::Rng::for_task(1, "dev", 0);
    for line in text.lines() {
        let w: Vec<&str> = line.split_whitespace().collect();
        let mut x: Vec<f64> = w.iter().skip(1).filter_map(|s| s.parse().ok()).collect();
        if w[0] == "h" {
            h = x[0];
            diag = x[1];
            continue;
        }
        if w[0] == "table" {
            support = Some(Support {
                plane: Plane {
                    point: Point3::new(x[0], x[1], x[2]),
                    normal: UnitVec3::new_normalize(Vec3::new(x[3], x[4], x[5])),
                },
                on_table: vec![],
                outlines: vec![],
            });
            continue;
        }
        let outward = x.remove(0) > 0.5;
        let ang = noise * 0.3_f64.to_radians() / 0.1;
        let mut g = |s: f64| s * rng.normal();
        let p = |x: &[f64]| Point3::new(x[0], x[1], x[2]);
        let u = |x: &[f64], g: &mut dyn FnMut(f64) -> f64| {
            UnitVec3::new_normalize(Vec3::new(x[0] + g(ang), x[1] + g(ang), x[2] + g(ang)))
        };
        let o = if w[0] == "freeform" {
            Point3::origin()
        } else {
            let q = p(&x);
            q + Vec3::new(g(noise * h), g(noise * h), g(noise * h))
        };
        let surface = match w[0] {
            "plane" => Some(Surface::Plane(Plane { point: o, normal: u(&x[3..], &mut g) })),
            "sphere" => Some(Surface::Sphere(Sphere { center: o, radius: x[3] + g(noise * h) })),
            "cylinder" => Some(Surface::Cylinder(Cylinder {
                axis: Axis { origin: o, direction: u(&x[3..], &mut g) },
                radius: x[6] + g(noise * h),
            })),
            "cone" => Some(Surface::Cone(Cone {
                axis: Axis { origin: o, direction: u(&x[3..], &mut g) },
                radius: x[6] + g(noise * h),
                half_angle: x[7] + g(ang),
            })),
            "torus" => Some(Surface::Torus(Torus {
                axis: Axis { origin: o, direction: u(&x[3..], &mut g) },
                major_radius: x[6] + g(noise * h),
                minor_radius: x[7] + g(noise * h),
            })),
            _ => None,
        };
        primitives.push(Primitive {
            surface,
            outward,
            residual: Residual::default(),
            covariance: vec![],
            ambiguous: None,
        });
    }
    let segmentation = Segmentation {
        labels: l.iter().map(|&l| (l >= 0).then_some(RegionId(l as u32))).collect(),
        primitives,
    };
    let tolerances = Tolerances::new(
        Measured {
            largest_coordinate: mesh.largest_coordinate(),
            diagonal: diag,
            spacing: (mesh.total_area() / mesh.vertices.len() as f64).sqrt(),
            noise: 0.1 * h,
            normal_noise: 0.1,
            edge_rounding: h,
        },
        None,
    );
    let start = std::time::Instant::now();
    let closed = close(&mesh, &segmentation, support.as_ref(), &tolerances);
    let m = &closed.labelled;
    println!(
        "time {:.2} open {} faces {}",
        start.elapsed().as_secs_f64(),
        closed.open.len(),
        closed
            .assumed_faces
            .iter()
            .map(|f| format!("{}:{:?}:{:.1}", f.region.0, f.assumption, f.area))
            .collect::<Vec<_>>()
            .join(" ")
    );
    for o in &closed.open {
        println!("  OPEN {} {}", o.rim.len(), o.reason);
    }
    let out = format!("{dir}/out.bin");
    let mut f = std::io::BufWriter::new(std::fs::File::create(out).unwrap());
    f.write_all(&(m.mesh.vertices.len() as u64).to_le_bytes()).unwrap();
    f.write_all(&(m.mesh.triangles.len() as u64).to_le_bytes()).unwrap();
    for p in &m.mesh.vertices {
        for c in p.iter() {
            f.write_all(&c.to_le_bytes()).unwrap();
        }
    }
    for t in &m.mesh.triangles {
        for c in t {
            f.write_all(&c.to_le_bytes()).unwrap();
        }
    }
    for l in &m.labels {
        f.write_all(&l.0.to_le_bytes()).unwrap();
    }
    for a in &m.assumed {
        f.write_all(&u32::from(*a).to_le_bytes()).unwrap();
    }
}
