//! Which cells belong to a profile: a labelling of least cost, by a minimum cut.
//!
//! E. A. Dinic, "Algorithm for solution of a problem of maximum flow in networks with power estimation", Soviet
//! Mathematics Doklady 11 (1970), 1277-1280. The cut stands for an energy of one term per cell and one per pair
//! (D. M. Greig, B. T. Porteous, A. H. Seheult, "Exact maximum a posteriori estimation for binary images", Journal of
//! the Royal Statistical Society B 51 (1989), 271-279).

/// Costs of a labelling in two.
#[derive(Debug, Clone, Default)]
pub(super) struct Labelling {
    /// One per node: what being in gains; negative where it costs.
    pub(super) gains: Vec<f64>,
    /// Two nodes and what it costs to part them.
    pub(super) pairs: Vec<(usize, usize, f64)>,
}

#[derive(Debug, Clone, Copy)]
struct Arc {
    to: usize,
    room: f64,
}

struct Network {
    arcs: Vec<Arc>,
    leaving: Vec<Vec<usize>>,
    level: Vec<usize>,
    next: Vec<usize>,
}

impl Labelling {
    /// One per node: whether it is in. Of equally good labellings the one with fewest nodes in.
    pub(super) fn solve(&self) -> Vec<bool> {
        let n = self.gains.len();
        let (source, sink) = (n, n + 1);
        let mut network = Network {
            arcs: Vec::new(),
            leaving: vec![Vec::new(); n + 2],
            level: vec![0; n + 2],
            next: vec![0; n + 2],
        };
        for (i, gain) in self.gains.iter().enumerate() {
            if *gain > 0.0 {
                network.connect(source, i, *gain, 0.0);
            } else if *gain < 0.0 {
                network.connect(i, sink, -gain, 0.0);
            }
        }
        for &(a, b, cost) in self.pairs.iter().filter(|p| p.2 > 0.0) {
            network.connect(a, b, cost, cost);
        }
        let most: f64 = self.gains.iter().map(|g| g.abs()).sum::<f64>() + 1.0;
        while network.layer(source, sink) {
            network.next.fill(0);
            while network.push(source, sink, most) > 0.0 {}
        }
        (0..n).map(|i| network.level[i] != usize::MAX).collect()
    }
}

impl Network {
    fn connect(&mut self, a: usize, b: usize, forward: f64, backward: f64) {
        self.leaving[a].push(self.arcs.len());
        self.arcs.push(Arc { to: b, room: forward });
        self.leaving[b].push(self.arcs.len());
        self.arcs.push(Arc { to: a, room: backward });
    }

    /// Distances from the source over arcs with room; whether the sink is reached.
    fn layer(&mut self, source: usize, sink: usize) -> bool {
        self.level.fill(usize::MAX);
        self.level[source] = 0;
        let mut queue = std::collections::VecDeque::from([source]);
        while let Some(v) = queue.pop_front() {
            for &a in &self.leaving[v] {
                let arc = self.arcs[a];
                if arc.room > EMPTY && self.level[arc.to] == usize::MAX {
                    self.level[arc.to] = self.level[v] + 1;
                    queue.push_back(arc.to);
                }
            }
        }
        self.level[sink] != usize::MAX
    }

    /// Sends flow along one way; how much.
    fn push(&mut self, source: usize, sink: usize, most: f64) -> f64 {
        let mut way: Vec<usize> = Vec::new();
        let mut v = source;
        loop {
            if v == sink {
                let flow = way.iter().map(|&a| self.arcs[a].room).fold(most, f64::min);
                for a in way {
                    self.arcs[a].room -= flow;
                    self.arcs[a ^ 1].room += flow;
                }
                return flow;
            }
            let mut advanced = false;
            while self.next[v] < self.leaving[v].len() {
                let a = self.leaving[v][self.next[v]];
                let arc = self.arcs[a];
                if arc.room > EMPTY && self.level[arc.to] == self.level[v] + 1 {
                    way.push(a);
                    v = arc.to;
                    advanced = true;
                    break;
                }
                self.next[v] += 1;
            }
            if !advanced {
                let Some(a) = way.pop() else { return 0.0 };
                v = self.arcs[a ^ 1].to;
                self.next[v] += 1;
            }
        }
    }
}

/// Room below which an arc is full, so that rounding does not keep the flow going: costs are scaled to about one.
const EMPTY: f64 = 1e-12;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_labelling_is_the_best_of_all() {
        let mut rng = crate::random::Rng::for_task(5, "min-cut", 0);
        for _ in 0..50 {
            let n = 9;
            let gains: Vec<f64> = (0..n).map(|_| rng.uniform() * 2.0 - 1.0).collect();
            let pairs: Vec<(usize, usize, f64)> = (0..14)
                .map(|_| (rng.below(n), rng.below(n), rng.uniform() * 0.7))
                .filter(|p| p.0 != p.1)
                .collect();
            let labelling = Labelling { gains, pairs };
            let energy = |is_in: &dyn Fn(usize) -> bool| -> f64 {
                let gain: f64 = (0..n).filter(|&i| is_in(i)).map(|i| labelling.gains[i]).sum();
                let parted = labelling.pairs.iter().filter(|p| is_in(p.0) != is_in(p.1)).map(|p| p.2);
                parted.sum::<f64>() - gain
            };
            let solved = labelling.solve();
            let found = energy(&|i| solved[i]);
            let best =
                (0..1 << n).map(|bits: usize| energy(&|i| bits >> i & 1 == 1)).fold(f64::INFINITY, f64::min);
            assert!((found - best).abs() < 1e-9, "{found} instead of {best}");
        }
    }
}
