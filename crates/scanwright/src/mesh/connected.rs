//! Connected sets of vertices or triangles.

/// Connected sets of the items `0..n` that have a key, each with the key that all of it share: by lowest item, each
/// set from there outwards. `neighbours` of an item in any order, mutual. Cost O(n) and a look at every neighbour.
pub fn connected<K: PartialEq, N: IntoIterator<Item = u32>>(
    n: usize,
    key: impl Fn(u32) -> Option<K>,
    neighbours: impl Fn(u32) -> N,
) -> Vec<(K, Vec<u32>)> {
    let mut seen = vec![false; n];
    let mut sets = Vec::new();
    for start in 0..n as u32 {
        if seen[start as usize] {
            continue;
        }
        let Some(mine) = key(start) else { continue };
        seen[start as usize] = true;
        let mut set = vec![start];
        let mut next = 0;
        while next < set.len() {
            for u in neighbours(set[next]) {
                if !seen[u as usize] && key(u).is_some_and(|k| k == mine) {
                    seen[u as usize] = true;
                    set.push(u);
                }
            }
            next += 1;
        }
        sets.push((mine, set));
    }
    sets
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_of_one_key_are_one_set_and_those_without_are_in_none() {
        let keys = [Some('a'), Some('a'), None, Some('a'), Some('b'), Some('b')];
        let beside = |i: u32| [i.checked_sub(1), (i < 5).then_some(i + 1)].into_iter().flatten();
        let sets = connected(6, |i| keys[i as usize], beside);
        assert_eq!(sets, [('a', vec![0, 1]), ('a', vec![3]), ('b', vec![4, 5])]);
    }
}
