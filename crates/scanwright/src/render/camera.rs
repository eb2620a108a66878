use crate::math::{Point3, UnitVec3, Vec3, any_perpendicular, try_unit};

/// A direction to look from; the projection is parallel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    right: Vec3,
    up: Vec3,
    towards_eye: Vec3,
}

impl Camera {
    /// Looks at the scene from `azimuth` (about `up`) and `elevation` (above the ground), both in radians.
    pub fn around(up: UnitVec3, azimuth: f64, elevation: f64) -> Self {
        // The world's own axes are kept where they can be, so that upright scans look as their files say.
        let x = try_unit(Vec3::x() - up.into_inner() * up.x).filter(|_| up.x.abs() < 0.9);
        let x = x.unwrap_or_else(|| any_perpendicular(&up)).into_inner();
        let y = up.cross(&x);
        let ground = x * azimuth.cos() + y * azimuth.sin();
        let towards_eye = ground * elevation.cos() + up.into_inner() * elevation.sin();
        let right = up.cross(&ground);
        Self { right, up: towards_eye.cross(&right), towards_eye }
    }

    /// Unit vector from the scene to the eye.
    pub fn towards_eye(&self) -> Vec3 {
        self.towards_eye
    }

    /// Right, up and towards the eye.
    fn local(&self, point: &Point3) -> Vec3 {
        let p = point.coords;
        Vec3::new(p.dot(&self.right), p.dot(&self.up), p.dot(&self.towards_eye))
    }

    fn bounds(&self, points: &[Point3]) -> (Vec3, Vec3) {
        let empty = (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY));
        points.iter().map(|p| self.local(p)).fold(empty, |(lo, hi), p| (lo.inf(&p), hi.sup(&p)))
    }

    /// Pixels per length so that `points` fit a panel with `margin` (a share of it) left on each side.
    pub(super) fn fitting_scale(&self, points: &[Point3], panel: (usize, usize), margin: f64) -> f64 {
        let (lo, hi) = self.bounds(points);
        let free = 1.0 - 2.0 * margin;
        let across = free * panel.0 as f64 / (hi.x - lo.x);
        let upright = free * panel.1 as f64 / (hi.y - lo.y);
        let scale = across.min(upright);
        if scale.is_finite() && scale > 0.0 { scale } else { 1.0 }
    }

    /// A screen of `width` x `height` samples with the middle of `points` in its middle.
    pub(super) fn screen(&self, points: &[Point3], width: usize, height: usize, scale: f64) -> Screen {
        let (lo, hi) = self.bounds(points);
        let middle = if points.is_empty() { Vec3::zeros() } else { (lo + hi) / 2.0 };
        let extent = if points.is_empty() { 1.0 } else { (hi - lo).norm() };
        let center = (0.5 * width as f64, 0.5 * height as f64);
        Screen { camera: *self, middle, scale, center, extent }
    }
}

/// Where points land on a panel.
pub(super) struct Screen {
    camera: Camera,
    middle: Vec3,
    scale: f64,
    center: (f64, f64),
    extent: f64,
}

impl Screen {
    /// Sample coordinates and depth in samples, larger is nearer.
    pub(super) fn project(&self, point: &Point3) -> [f32; 3] {
        let p = (self.camera.local(point) - self.middle) * self.scale;
        [(self.center.0 + p.x) as f32, (self.center.1 - p.y) as f32, p.z as f32]
    }

    /// A direction as right, up, towards the eye.
    pub(super) fn direction(&self, v: &Vec3) -> [f32; 3] {
        [self.camera.right, self.camera.up, self.camera.towards_eye].map(|axis| v.dot(&axis) as f32)
    }

    /// Size of the framed scene, samples.
    pub(super) fn depth_extent(&self) -> f32 {
        (self.extent * self.scale) as f32
    }
}
