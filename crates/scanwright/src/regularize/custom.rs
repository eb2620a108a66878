//! What is the custom on a part: the prior probability of a relation, from those relations that need none.

/// How often a relation holds among those seen so well that agreement proves it.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Custom {
    tested: f64,
    held: f64,
}

impl Custom {
    /// Counts a relation that was seen well enough to tell.
    pub fn count(&mut self, holds: bool) {
        self.tested += 1.0;
        self.held += f64::from(u8::from(holds));
    }

    /// Probability that the next one holds: Laplace's rule of succession.
    pub fn prior(&self) -> f64 {
        (self.held + 1.0) / (self.tested + 2.0)
    }

    /// Probability that a relation which is met does not hold, by Bayes' rule; unrelated things meet it with
    /// probability `accident`.
    pub fn accident(&self, accident: f64) -> f64 {
        let by_accident = (1.0 - self.prior()) * accident;
        by_accident / (by_accident + self.prior())
    }
}
