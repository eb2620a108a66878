//! Shortest ways over a graph: E. Dijkstra, "A note on two problems in connexion with graphs", Numerische Mathematik 1 (1959),
//! 269-271, from several starts at once.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// For every node of `n`: the start that is nearest, and the length of the way from it; `u32::MAX` and infinity where none
/// leads. `beside`: the neighbours of a node, with the lengths of the steps to them, none negative.
///
/// Cost O(n log n) for nodes of few neighbours.
pub(in crate::segment) fn from_nearest<N: IntoIterator<Item = (u32, f64)>>(
    n: usize,
    starts: &[u32],
    beside: impl Fn(u32) -> N,
) -> (Vec<u32>, Vec<f64>) {
    let (mut nearest, mut length) = (vec![u32::MAX; n], vec![f64::INFINITY; n]);
    // Lengths of ways are not negative: their bits are in their order.
    let mut heap = BinaryHeap::new();
    for (k, &start) in starts.iter().enumerate() {
        length[start as usize] = 0.0;
        heap.push(Reverse((0_u64, k as u32, start)));
    }
    while let Some(Reverse((bits, start, node))) = heap.pop() {
        if nearest[node as usize] != u32::MAX {
            continue;
        }
        nearest[node as usize] = start;
        for (next, step) in beside(node) {
            let way = f64::from_bits(bits) + step;
            if nearest[next as usize] == u32::MAX && way < length[next as usize] {
                length[next as usize] = way;
                heap.push(Reverse((way.to_bits(), start, next)));
            }
        }
    }
    (nearest, length)
}
