//! Geometry and topology as numbered entities.

use crate::brep::{Curve, EdgeUse, Face, Geometry, Solid};
use crate::math::{Frame, Point3, UnitVec3};
use crate::surface::Surface;
use crate::surface::bspline::{DEGREE, SplineCurve, SplineSurface};

/// Collects entity lines.
#[derive(Debug, Default)]
pub(super) struct Entities {
    /// Numbers taken by others before.
    taken: usize,
    lines: Vec<String>,
}

impl Entities {
    /// The first entity gets the number `first`.
    pub(super) fn starting_at(first: usize) -> Self {
        Self { taken: first - 1, lines: Vec::new() }
    }

    /// Adds an entity and returns its number.
    pub(super) fn add(&mut self, text: &str) -> usize {
        let id = self.taken + self.lines.len() + 1;
        self.lines.push(format!("#{id}={text};"));
        id
    }

    pub(super) fn text(&self) -> String {
        self.lines.join("\n")
    }

    fn point(&mut self, point: &Point3) -> usize {
        self.add(&format!("CARTESIAN_POINT('',({},{},{}))", real(point.x), real(point.y), real(point.z)))
    }

    fn direction(&mut self, d: &UnitVec3) -> usize {
        self.add(&format!("DIRECTION('',({},{},{}))", real(d.x), real(d.y), real(d.z)))
    }

    pub(super) fn placement(&mut self, frame: &Frame) -> usize {
        let origin = self.point(&frame.origin);
        let (z, x) = (self.direction(&frame.z), self.direction(&frame.x));
        self.add(&format!("AXIS2_PLACEMENT_3D('',#{origin},#{z},#{x})"))
    }

    fn curve(&mut self, curve: &Curve) -> usize {
        match curve {
            Curve::Line { origin, direction } => {
                let point = self.point(origin);
                let direction = self.direction(direction);
                let vector = self.add(&format!("VECTOR('',#{direction},1.)"));
                self.add(&format!("LINE('',#{point},#{vector})"))
            }
            Curve::Circle { frame, radius } => {
                let placement = self.placement(frame);
                self.add(&format!("CIRCLE('',#{placement},{})", real(*radius)))
            }
            Curve::Ellipse { frame, semi_axes: (a, b) } => {
                let placement = self.placement(frame);
                self.add(&format!("ELLIPSE('',#{placement},{},{})", real(*a), real(*b)))
            }
            Curve::Spline(spline) => self.spline_curve(spline),
        }
    }

    fn spline_curve(&mut self, spline: &SplineCurve) -> usize {
        let poles: Vec<usize> = spline.poles.iter().map(|p| self.point(p)).collect();
        let (multiplicities, knots) = knot_lists(&spline.knots);
        self.add(&format!(
            "B_SPLINE_CURVE_WITH_KNOTS('',{DEGREE},{},.UNSPECIFIED.,.F.,.F.,{multiplicities},{knots},.UNSPECIFIED.)",
            references(&poles)
        ))
    }

    fn spline_surface(&mut self, spline: &SplineSurface) -> usize {
        let n_v = spline.n_poles().1;
        let rows: Vec<String> = spline
            .poles
            .chunks(n_v)
            .map(|row| {
                let ids: Vec<usize> = row.iter().map(|p| self.point(p)).collect();
                references(&ids)
            })
            .collect();
        let (mu, ku) = knot_lists(&spline.knots_u);
        let (mv, kv) = knot_lists(&spline.knots_v);
        self.add(&format!(
            "B_SPLINE_SURFACE_WITH_KNOTS('',{DEGREE},{DEGREE},({}),.UNSPECIFIED.,.F.,.F.,.F.,{mu},{mv},{ku},{kv},.UNSPECIFIED.)",
            rows.join(",")
        ))
    }

    fn surface(&mut self, geometry: &Geometry, frame: &Frame) -> usize {
        let surface = match geometry {
            Geometry::Spline(spline) => return self.spline_surface(spline),
            Geometry::Analytic(surface) => surface,
        };
        let placement = self.placement(frame);
        match surface {
            Surface::Plane(_) => self.add(&format!("PLANE('',#{placement})")),
            Surface::Cylinder(s) => {
                self.add(&format!("CYLINDRICAL_SURFACE('',#{placement},{})", real(s.radius)))
            }
            Surface::Cone(s) => {
                // The radius belongs to the placement, which is beside the face.
                let radius = s.radius + s.axis.height(&frame.origin) * s.half_angle.tan();
                self.add(&format!(
                    "CONICAL_SURFACE('',#{placement},{},{})",
                    real(radius.max(0.0)),
                    real(s.half_angle)
                ))
            }
            Surface::Sphere(s) => self.add(&format!("SPHERICAL_SURFACE('',#{placement},{})", real(s.radius))),
            Surface::Torus(s) => self.add(&format!(
                "TOROIDAL_SURFACE('',#{placement},{},{})",
                real(s.major_radius.abs()),
                real(s.minor_radius)
            )),
        }
    }

    /// Writes all faces of a solid; their numbers, in order.
    pub(super) fn faces(&mut self, solid: &Solid) -> Vec<usize> {
        let vertices: Vec<usize> = solid
            .vertices
            .iter()
            .map(|v| {
                let point = self.point(&v.point);
                self.add(&format!("VERTEX_POINT('',#{point})"))
            })
            .collect();
        let edges: Vec<usize> = solid
            .edges
            .iter()
            .map(|edge| {
                let curve = self.curve(&edge.curve);
                let (start, end) = (vertices[edge.start.0 as usize], vertices[edge.end.0 as usize]);
                self.add(&format!("EDGE_CURVE('',#{start},#{end},#{curve},.T.)"))
            })
            .collect();
        solid.faces.iter().map(|face| self.face(solid, face, &edges)).collect()
    }

    fn face(&mut self, solid: &Solid, face: &Face, edges: &[usize]) -> usize {
        let geometry = solid.geometry(face);
        let mut bounds = Vec::new();
        for (i, run) in face.loops.iter().enumerate() {
            let uses: Vec<usize> = run
                .uses
                .iter()
                .map(|EdgeUse { edge, forward }| {
                    let sense = if *forward { "T" } else { "F" };
                    self.add(&format!("ORIENTED_EDGE('',*,*,#{},.{sense}.)", edges[edge.0 as usize]))
                })
                .collect();
            let edge_loop = self.add(&format!("EDGE_LOOP('',{})", references(&uses)));
            let bound = if i == 0 { "FACE_OUTER_BOUND" } else { "FACE_BOUND" };
            bounds.push(self.add(&format!("{bound}('',#{edge_loop},.T.)")));
        }
        let surface = self.surface(geometry, &face.frame);
        // A lemon is the inner part of a spindle torus: there the written surface's own normal turns over.
        let lemon = matches!(geometry, Geometry::Analytic(Surface::Torus(t)) if t.major_radius < 0.0);
        let sense = if face.same_sense == lemon { "F" } else { "T" };
        let kind = geometry.kind().map_or("freeform", |k| k.name());
        self.add(&format!(
            "ADVANCED_FACE('region {} {kind}{}',{},#{surface},.{sense}.)",
            face.region.0,
            if face.assumed { " assumed" } else { "" },
            references(&bounds)
        ))
    }
}

/// `(#1,#2)`.
pub(super) fn references(ids: &[usize]) -> String {
    let list: Vec<String> = ids.iter().map(|id| format!("#{id}")).collect();
    format!("({})", list.join(","))
}

/// Multiplicities and distinct knots.
fn knot_lists(knots: &[f64]) -> (String, String) {
    let groups: Vec<&[f64]> = knots.chunk_by(|a, b| a == b).collect();
    let multiplicities: Vec<String> = groups.iter().map(|g| g.len().to_string()).collect();
    let values: Vec<String> = groups.iter().map(|g| real(g[0])).collect();
    (format!("({})", multiplicities.join(",")), format!("({})", values.join(",")))
}

/// A real as Part 21 wants it: always with a point, the exponent in capitals.
pub(super) fn real(value: f64) -> String {
    // Negative zero and denormals read back as zero in any case.
    let value = if value.abs() < f64::MIN_POSITIVE { 0.0 } else { value };
    let text = format!("{value:?}");
    let (mantissa, exponent) = text.split_once('e').map_or((text.as_str(), None), |(m, e)| (m, Some(e)));
    let mantissa = if mantissa.contains('.') { mantissa.to_owned() } else { format!("{mantissa}.") };
    let mantissa = mantissa.strip_suffix(".0").map_or(mantissa.clone(), |m| format!("{m}."));
    exponent.map_or(mantissa.clone(), |e| format!("{mantissa}E{e}"))
}

#[cfg(test)]
mod tests {
    use super::real;

    #[test]
    fn reals_carry_a_point() {
        for (value, text) in
            [(1.0, "1."), (-0.0, "0."), (0.25, "0.25"), (1e-20, "1.E-20"), (-1.5e300, "-1.5E300")]
        {
            assert_eq!(real(value), text);
        }
    }
}
