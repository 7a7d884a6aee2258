//! The searches of `eta` that start at one end of a strip: the distribution of their node accesses.

use std::cmp::Reverse;

/// One in this many searches counts as expensive, as in Porcu and Scateni 2006, section 4.2.
const EXPENSIVE: usize = 10;

/// The node accesses of each search, and whether it found a tunnel.
#[derive(Debug, Default)]
pub(super) struct Searches(Vec<(u64, bool)>);

impl Searches {
    /// Adds a search.
    pub(super) fn add(&mut self, accesses: u64, has_found: bool) {
        self.0.push((accesses, has_found));
    }

    /// Returns the total number of node accesses; `None` without searches.
    pub(super) fn accesses(&self) -> Option<u64> {
        (!self.0.is_empty()).then(|| self.0.iter().map(|search| search.0).sum())
    }

    /// Returns the metrics of the searches; empty without searches.
    ///
    /// `search_accesses` is the total number of node accesses. `percent_expensive` is the
    /// percentage of accesses by the most expensive tenth of the searches.
    /// `percent_expensive_not_found` is the percentage of these searches that found nothing.
    pub(super) fn figures(mut self) -> Vec<(String, f64)> {
        if self.0.is_empty() {
            return Vec::new();
        }
        self.0.sort_unstable_by_key(|&(accesses, has_found)| (Reverse(accesses), has_found));
        let sum = |searches: &[(u64, bool)]| searches.iter().map(|search| search.0).sum::<u64>();
        let expensive = &self.0[..self.0.len().div_ceil(EXPENSIVE)];
        let not_found = expensive.iter().filter(|search| !search.1).count();
        let percent = |part: f64, whole: f64| if whole == 0.0 { 0.0 } else { 100.0 * part / whole };
        let all = sum(&self.0) as f64;
        vec![
            ("search_accesses".into(), all),
            ("percent_expensive".into(), percent(sum(expensive) as f64, all)),
            ("percent_expensive_not_found".into(), percent(not_found as f64, expensive.len() as f64)),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tenth_with_most_accesses_is_expensive() {
        let mut searches = Searches::default();
        (0..18).for_each(|_| searches.add(10, true));
        searches.add(700, false);
        searches.add(120, true);
        let figures = searches.figures().into_iter().map(|(_, value)| value).collect::<Vec<_>>();
        assert_eq!(figures, [1000.0, 82.0, 50.0]);
        assert!(Searches::default().figures().is_empty());
    }
}
