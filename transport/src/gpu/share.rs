//! Work that several GPUs share.

use std::sync::{Mutex, PoisonError};

/// Does items on GPUs, each of which takes the next one whenever it is free; the results come in the order of the
/// items. `begin` makes what a GPU needs for all of them. After an error no further item is begun.
///
/// # Errors
/// That of the first item, or GPU, which failed.
pub(crate) fn share<G: Sync, S, I: Send, R: Send, E: Send>(
    gpus: &[G],
    items: impl ExactSizeIterator<Item = I> + Send,
    begin: impl Fn(&G) -> Result<S, E> + Sync,
    work: impl Fn(&G, &S, I) -> Result<R, E> + Sync,
) -> Result<Vec<R>, E> {
    let mut results: Vec<Option<Result<R, E>>> = (0..items.len()).map(|_| None).collect();
    let left = Mutex::new(items.zip(&mut results));
    let next = || left.lock().unwrap_or_else(PoisonError::into_inner).next();
    let stop = || while next().is_some() {};
    let serve = |gpu: &G| -> Result<(), E> {
        let shared = begin(gpu).inspect_err(|_| stop())?;
        while let Some((item, result)) = next() {
            let found = work(gpu, &shared, item);
            if found.is_err() {
                stop();
            }
            *result = Some(found);
        }
        Ok(())
    };
    match gpus {
        [gpu] => serve(gpu)?,
        gpus => std::thread::scope(|scope| {
            let serving: Vec<_> = gpus.iter().map(|gpu| scope.spawn(|| serve(gpu))).collect();
            serving
                .into_iter()
                .try_for_each(|one| one.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
        })?,
    }
    results.into_iter().flatten().collect()
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;

    #[test]
    fn results_come_in_the_order_of_items_whatever_shares_them() {
        for gpus in [1, 2, 5, 30] {
            let gpus: Vec<usize> = (0..gpus).collect();
            let begun = AtomicUsize::new(0);
            let begin = |gpu: &usize| {
                begun.fetch_add(1, Ordering::Relaxed);
                Ok::<usize, String>(*gpu)
            };
            let work = |gpu: &usize, shared: &usize, item: usize| {
                assert_eq!(gpu, shared);
                Ok(item * item)
            };
            let found = share(&gpus, 0..20, begin, work);
            assert_eq!(found, Ok((0..20).map(|item| item * item).collect()));
            assert_eq!(begun.into_inner(), gpus.len());
        }
    }

    #[test]
    fn an_error_ends_the_work_and_so_does_a_gpu_that_cannot_begin() {
        for gpus in [&[0][..], &[0, 1, 2]] {
            let done = AtomicUsize::new(0);
            let work = |_: &usize, (): &(), item: usize| match item {
                3.. => Err(item),
                _ => Ok(done.fetch_add(1, Ordering::Relaxed)),
            };
            assert_eq!(share(gpus, 0..1000, |_| Ok(()), work), Err(3));
            assert_eq!(done.into_inner(), 3);
            let begin = |gpu: &usize| if *gpu == 0 { Err(77) } else { Ok(()) };
            assert_eq!(share(gpus, 0..1000, begin, |_, (), item| Ok(item)), Err(77));
        }
    }
}
