use serde::{Deserialize, Serialize};

use crate::math::{Point3, Vec3};
use crate::pipeline::Reconstruction;

/// Where a region is, and from where it is seen.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Place {
    /// Mean of its triangles' centers, by area.
    pub middle: [f64; 3],
    /// Least coordinates of its vertices.
    pub low: [f64; 3],
    /// Greatest coordinates of its vertices.
    pub high: [f64; 3],
    /// Mean outward normal by area, unit; `None` where the normals cancel, as all round a shaft.
    pub facing: Option<[f64; 3]>,
}

/// A mean normal shorter than this share of the area's says nothing.
const LEAST_FACING: f64 = 0.05;

/// One per region; `None` without triangles.
pub(super) fn places(result: &Reconstruction) -> Vec<Option<Place>> {
    let n = result.segmentation.primitives.len();
    let mut sums = vec![Sums::default(); n];
    for (t, label) in result.segmentation.labels.iter().enumerate() {
        if let Some(region) = label {
            sums[region.0 as usize].add(result.mesh.corners(t), result.mesh.cross(t) / 2.0);
        }
    }
    sums.iter().map(Sums::place).collect()
}

#[derive(Clone)]
struct Sums {
    area: f64,
    moment: Vec3,
    normal: Vec3,
    low: Vec3,
    high: Vec3,
}

impl Default for Sums {
    fn default() -> Self {
        let (low, high) = (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY));
        Self { area: 0.0, moment: Vec3::zeros(), normal: Vec3::zeros(), low, high }
    }
}

impl Sums {
    fn add(&mut self, corners: [Point3; 3], normal: Vec3) {
        let area = normal.norm();
        self.area += area;
        self.normal += normal;
        for corner in corners {
            self.moment += corner.coords * (area / 3.0);
            self.low = self.low.inf(&corner.coords);
            self.high = self.high.sup(&corner.coords);
        }
    }

    fn place(&self) -> Option<Place> {
        let middle = self.moment / self.area;
        let facing = self.normal.norm() > LEAST_FACING * self.area;
        (self.area > 0.0).then(|| Place {
            middle: middle.into(),
            low: self.low.into(),
            high: self.high.into(),
            facing: facing.then(|| self.normal.normalize().into()),
        })
    }
}
