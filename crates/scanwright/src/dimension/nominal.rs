//! The round value that a measured one may mean.
//!
//! Of the grids of round values the coarsest is taken on which the measured value lies within its uncertainty, when it would
//! rarely lie so by accident. Offered, not applied: `snap` does that when asked.

use serde::Serialize;

use super::tables::{DEGREES, HOLES, INCH, INCHES, METRIC};
use super::{Dimension, DimensionKind, Quantity};
use crate::recognize::Primitive;
use crate::regularize::Manufacture;

/// Standard uncertainties within which a value may be the round one: 1.2 % of true ones are lost.
const MAX_SIGMAS: f64 = 2.5;
/// Share of the grid that four standard uncertainties may cover: the probability to be that near by accident.
const MAX_COINCIDENCE: f64 = 0.2;
/// Evidence, as a logarithm of odds, from which a part is designed in inches: a thousand to one.
const INCH_EVIDENCE: f64 = 7.0;

/// A round value beside a measured one.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Nominal {
    /// Length, or angle in radians.
    pub value: f64,
    /// What it is a multiple of, or the hole it is.
    pub grid: String,
    /// Deviation of the measured value from it in standard uncertainties, with what manufacture may deviate by.
    pub z: f64,
    /// Probability to lie so near to one of the grid by accident.
    pub coincidence: f64,
    /// Whether the model has it instead of the measured value.
    pub applied: bool,
    /// Why it was applied or not.
    pub why: String,
}

/// Offers a round value beside each dimension that one is near to.
///
/// `millimetres`: length of the scan's unit. `primitives`: those that the dimensions refer to. Millimetres or inches are
/// decided for the whole part.
pub fn offer(
    dimensions: &mut [Dimension],
    primitives: &[Primitive],
    millimetres: f64,
    manufacture: &Manufacture,
) {
    let scaled: Vec<Measured> = dimensions
        .iter()
        .map(|dimension| Measured::new(dimension, primitives, millimetres, manufacture))
        .collect();
    let metric = scaled.iter().map(|m| m.on_grid(&METRIC, 1.0)).map(evidence).sum::<f64>();
    let inches = scaled.iter().map(|m| m.on_grid(&INCHES, INCH)).map(evidence).sum::<f64>();
    let in_inches = inches > metric + INCH_EVIDENCE;
    for (dimension, measured) in dimensions.iter_mut().zip(&scaled) {
        dimension.nominal = measured.nominal(in_inches).map(|round| Nominal {
            value: round.value / measured.scale,
            grid: round.grid.to_owned(),
            z: round.z,
            coincidence: round.coincidence,
            applied: false,
            why: "offered".to_owned(),
        });
    }
}

/// How much a round value speaks for its system: what is met by accident says nothing.
fn evidence(round: Option<Round>) -> f64 {
    round.map_or(0.0, |round| -round.coincidence.max(1e-3).ln())
}

/// A dimension in millimetres or degrees.
struct Measured {
    value: f64,
    /// Standard uncertainty, manufacture included.
    uncertainty: f64,
    /// Of the dimension's unit in millimetres or degrees.
    scale: f64,
    is_angle: bool,
    is_bore: bool,
}

/// A value of a table or grid.
struct Round {
    value: f64,
    grid: &'static str,
    z: f64,
    coincidence: f64,
}

impl Measured {
    fn new(
        dimension: &Dimension,
        primitives: &[Primitive],
        millimetres: f64,
        manufacture: &Manufacture,
    ) -> Self {
        let is_angle = dimension.quantity == Quantity::Angle;
        let (scale, form) = if is_angle {
            (180.0 / std::f64::consts::PI, manufacture.angle)
        } else {
            (millimetres, manufacture.length)
        };
        let is_bore = dimension.kind == DimensionKind::Diameter
            && dimension.of.first().and_then(|&k| primitives.get(k as usize)).is_some_and(|p| !p.outward);
        Self {
            value: dimension.value * scale,
            uncertainty: dimension.uncertainty.hypot(form) * scale,
            scale,
            is_angle,
            is_bore,
        }
    }

    fn nominal(&self, in_inches: bool) -> Option<Round> {
        if self.is_angle {
            return self.on_grid(&DEGREES, 1.0);
        }
        let round = if in_inches { self.on_grid(&INCHES, INCH) } else { self.on_grid(&METRIC, 1.0) };
        // A diameter in whole millimetres says more than the table of holes does.
        const WHOLE: [&str; 4] = ["10 mm", "5 mm", "2 mm", "1 mm"];
        if self.is_bore && !in_inches && round.as_ref().is_none_or(|r| !WHOLE.contains(&r.grid)) {
            return self.of_holes().or(round);
        }
        round
    }

    /// The nearest value of the coarsest grid that the measured one lies on. `unit`: of the grid, in millimetres or degrees.
    fn on_grid(&self, grids: &[(f64, &'static str)], unit: f64) -> Option<Round> {
        if self.is_angle != std::ptr::eq(grids.as_ptr(), DEGREES.as_ptr()) {
            return None;
        }
        grids.iter().find_map(|&(step, grid)| {
            let step = step * unit;
            let value = (self.value / step).round() * step;
            self.near(value, step, grid).filter(|_| value > 0.0)
        })
    }

    fn of_holes(&self) -> Option<Round> {
        let above = HOLES.partition_point(|hole| hole.0 < self.value);
        let candidates = [above.checked_sub(1), Some(above)];
        let hole = |k: usize| {
            let &(value, name) = HOLES.get(k)?;
            let before = k.checked_sub(1).map_or(value, |j| value - HOLES[j].0);
            let after = HOLES.get(k + 1).map_or(value, |next| next.0 - value);
            self.near(value, before.min(after), name)
        };
        candidates.into_iter().flatten().filter_map(hole).min_by(|a, b| a.z.total_cmp(&b.z))
    }

    /// `value`, one of a grid with this step, if the measured one may mean it.
    fn near(&self, value: f64, step: f64, grid: &'static str) -> Option<Round> {
        let z = (self.value - value).abs() / self.uncertainty;
        let coincidence = 4.0 * self.uncertainty / step;
        (z <= MAX_SIGMAS && coincidence <= MAX_COINCIDENCE).then_some(Round { value, grid, z, coincidence })
    }
}

#[cfg(test)]
mod tests {
    use super::super::{DimensionKind, Seen};
    use super::*;
    use crate::random::Rng;

    fn length(value: f64, uncertainty: f64) -> Dimension {
        Dimension {
            id: 0,
            kind: DimensionKind::Distance,
            of: vec![0, 1],
            value,
            uncertainty,
            quantity: Quantity::Length,
            evidence: Seen { arc: None, area: 1.0, triangles: 1 },
            guess: None,
            nominal: None,
        }
    }

    const EXACT: Manufacture = Manufacture { length: 0.0, angle: 0.0 };

    fn offered(value: f64, uncertainty: f64) -> Option<f64> {
        let mut all = [length(value, uncertainty)];
        offer(&mut all, &[], 1.0, &EXACT);
        all[0].nominal.as_ref().map(|nominal| nominal.value)
    }

    #[test]
    fn values_on_a_grid_are_rounded_right_and_values_off_it_never() {
        const N: usize = 1_000;
        let mut rng = Rng::for_task(3, "nominal", 0);
        let (mut right, mut wrong) = (0, 0);
        for i in 0..N {
            // Millimetres with an uncertainty of a twentieth: none coarser is to be taken, none finer.
            let truth = 11.0 + 2.0 * (i % 4) as f64;
            let uncertainty = 0.05 * (0.2 + 0.8 * rng.uniform());
            let found = offered(truth + uncertainty * rng.normal(), uncertainty);
            right += usize::from(found.is_some_and(|value| (value - truth).abs() < 1e-9));
            // Off every grid by more than six uncertainties: of the finest, 0.05, by at least a fifth of it.
            let off = 0.05 * (i as f64 + 0.2 + 0.6 * rng.uniform());
            let small = 0.2 * 0.05 / 6.0;
            wrong += usize::from(offered(10.0 + off + small * rng.normal(), small).is_some());
        }
        assert!(right >= 970, "{right} of {N}");
        assert_eq!(wrong, 0);
    }

    #[test]
    fn what_is_too_uncertain_is_not_rounded() {
        assert_eq!(offered(10.02, 0.6), None);
        assert_eq!(offered(10.02, 0.04), Some(10.0));
    }

    #[test]
    fn parts_in_inches_are_told_by_all_their_lengths_together() {
        let inches = [0.75, 1.125, 2.375, 0.4375, 1.6875];
        let mut all: Vec<Dimension> = inches.iter().map(|v| length(v * INCH + 0.002, 0.004)).collect();
        offer(&mut all, &[], 1.0, &EXACT);
        for (dimension, value) in all.iter().zip(inches) {
            let nominal = dimension.nominal.as_ref().expect("a round value in inches");
            assert!((nominal.value - value * INCH).abs() < 1e-9, "{nominal:?}");
            assert!(nominal.grid.ends_with("inch"));
        }
    }

    #[test]
    fn bores_may_be_holes_of_threads() {
        let mut all = [length(6.61, 0.01)];
        all[0].kind = DimensionKind::Diameter;
        let bore = Primitive { outward: false, ..Primitive::freeform() };
        offer(&mut all, &[bore], 1.0, &EXACT);
        let nominal = all[0].nominal.as_ref().expect("a hole");
        assert_eq!((nominal.value, nominal.grid.as_str()), (6.6, "M6 clearance hole"));
    }

    #[test]
    fn angles_are_rounded_in_degrees() {
        let mut all = [Dimension {
            kind: DimensionKind::HalfAngle,
            quantity: Quantity::Angle,
            ..length(44.98_f64.to_radians(), 0.02_f64.to_radians())
        }];
        offer(&mut all, &[], 25.4, &EXACT);
        let nominal = all[0].nominal.as_ref().expect("a round angle");
        assert!((nominal.value - 45.0_f64.to_radians()).abs() < 1e-12 && nominal.grid == "15 degrees");
    }
}
