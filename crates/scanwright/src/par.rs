//! The only home of threads. Results never depend on how many there are.

use rayon::prelude::*;

/// `f(i)` for `i` in `0..n`, in order.
pub fn map_indices<T: Send>(n: usize, f: impl Fn(usize) -> T + Sync + Send) -> Vec<T> {
    (0..n).into_par_iter().map(f).collect()
}

/// `f(item)` for every item, in order.
pub fn map<I: Sync, T: Send>(items: &[I], f: impl Fn(&I) -> T + Sync + Send) -> Vec<T> {
    items.par_iter().map(f).collect()
}

/// Fixed chunks of `items` reduced by `fold`, then merged left to right: the same sum whatever the thread count.
pub fn fold_chunks<I: Sync, A: Send>(
    items: &[I],
    chunk: usize,
    fold: impl Fn(&[I]) -> A + Sync + Send,
    merge: impl Fn(A, A) -> A,
) -> Option<A> {
    let parts: Vec<A> = items.par_chunks(chunk.max(1)).map(fold).collect();
    parts.into_iter().reduce(merge)
}

/// Runs both closures, possibly at the same time.
pub fn join<A: Send, B: Send>(a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
    rayon::join(a, b)
}

/// Runs `f` with `n_threads` workers (all processors when `None`).
pub fn with_threads<T: Send>(n_threads: Option<usize>, f: impl FnOnce() -> T + Send) -> T {
    match rayon::ThreadPoolBuilder::new().num_threads(n_threads.unwrap_or(0)).build() {
        Ok(pool) => pool.install(f),
        // Without a pool of its own the work runs on the global one; only speed differs.
        Err(_) => f(),
    }
}
