use super::{Point3, UnitVec3, Vec3};

/// A directed line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Axis {
    /// A point on the line.
    pub origin: Point3,
    /// Direction of the line.
    pub direction: UnitVec3,
}

impl Axis {
    /// Coordinate of `point` along the axis, from `origin`.
    pub fn height(&self, point: &Point3) -> f64 {
        (point - self.origin).dot(&self.direction)
    }

    /// The vector from the axis to `point`, perpendicular to the axis.
    pub fn radial(&self, point: &Point3) -> Vec3 {
        let offset = point - self.origin;
        offset - self.direction.into_inner() * offset.dot(&self.direction)
    }

    /// The point of the axis nearest to `point`.
    pub fn foot(&self, point: &Point3) -> Point3 {
        self.origin + self.direction.into_inner() * self.height(point)
    }
}

/// A right-handed orthonormal frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// Origin of the frame.
    pub origin: Point3,
    /// First direction.
    pub x: UnitVec3,
    /// Second direction.
    pub y: UnitVec3,
    /// Third direction.
    pub z: UnitVec3,
}

impl Frame {
    /// A frame with the given third direction; the others are chosen deterministically.
    pub fn from_z(origin: Point3, z: UnitVec3) -> Self {
        let x = any_perpendicular(&z);
        let y = UnitVec3::new_normalize(z.cross(&x));
        Self { origin, x, y, z }
    }

    /// Coordinates of `point` in this frame.
    pub fn local(&self, point: &Point3) -> Vec3 {
        let offset = point - self.origin;
        Vec3::new(offset.dot(&self.x), offset.dot(&self.y), offset.dot(&self.z))
    }

    /// Which of `n` equal sectors about the third direction `point` is in, counted from the first direction.
    pub fn sector(&self, point: &Point3, n: usize) -> usize {
        let local = self.local(point);
        let share = (local.y.atan2(local.x) / std::f64::consts::TAU).rem_euclid(1.0);
        // Rounding can make a whole turn of a small negative one.
        ((share * n as f64) as usize).min(n - 1)
    }

    /// The point with coordinates `local` in this frame.
    pub fn global(&self, local: &Vec3) -> Point3 {
        self.origin
            + self.x.into_inner() * local.x
            + self.y.into_inner() * local.y
            + self.z.into_inner() * local.z
    }
}

/// A direction perpendicular to `direction`, chosen by its smallest component.
pub fn any_perpendicular(direction: &UnitVec3) -> UnitVec3 {
    let (x, y, z) = (direction.x.abs(), direction.y.abs(), direction.z.abs());
    let helper = if x <= y && x <= z {
        Vec3::x()
    } else if y <= z {
        Vec3::y()
    } else {
        Vec3::z()
    };
    UnitVec3::new_normalize(helper - direction.into_inner() * direction.dot(&helper))
}
