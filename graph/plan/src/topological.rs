//! Topological order.

use std::collections::BTreeSet;

/// Kahn's algorithm, always taking the smallest number that is ready: small edits of a file move little. `before` are
/// the numbers that each number waits for; those on a cycle are left out.
pub(crate) fn stable_order(before: &[BTreeSet<usize>]) -> Vec<usize> {
    let mut waiting: Vec<usize> = before.iter().map(BTreeSet::len).collect();
    let mut ready: BTreeSet<usize> = (0..before.len()).filter(|number| waiting[*number] == 0).collect();
    let after = transposed(before);
    let mut order = Vec::with_capacity(before.len());
    while let Some(number) = ready.pop_first() {
        order.push(number);
        for later in &after[number] {
            waiting[*later] -= 1;
            ready.extend((waiting[*later] == 0).then_some(*later));
        }
    }
    order
}

/// For each number those that wait for it, in ascending order.
pub(crate) fn transposed<B>(before: &[B]) -> Vec<Vec<usize>>
where
    for<'a> &'a B: IntoIterator<Item = &'a usize>,
{
    let mut after = vec![Vec::new(); before.len()];
    for (number, waits) in before.iter().enumerate() {
        waits.into_iter().for_each(|earlier| after[*earlier].push(number));
    }
    after
}
