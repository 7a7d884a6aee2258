//! A depth-first search from one terminal within its star, for the method `guided-tunnels`. The
//! path closest to another terminal is tried first.

use super::star::GuidedStar;
use crate::random::Random;
use crate::stripify::tunnel::accesses::{AccessCounter, SearchOutcome};
use crate::stripify::tunnel::context::SearchContext;
use crate::stripify::tunnel::partial_tunnel::PartialTunnel;
use crate::stripify::tunnel::path_tags::TunnelStep;

/// Limits of a search.
#[derive(Debug, Clone, Copy)]
pub(super) struct TunnelLimits {
    /// Maximum length of a tunnel, in edges.
    pub(super) length: u32,
    /// Maximum number of node accesses.
    pub(super) accesses: u32,
    /// Maximum number of loops closed at a time.
    pub(super) loops: u32,
}

/// A search from one terminal.
#[derive(Debug, Default)]
pub(super) struct GuidedSearch {
    tunnel: PartialTunnel,
    /// The loop-free part of a tunnel that came closest to a terminal.
    nearest: Vec<TunnelStep>,
    /// The possible steps from the tip: the distance after the step, a random number, and the step.
    sorted: Vec<(u32, u64, TunnelStep)>,
}

impl GuidedSearch {
    /// Searches for a tunnel from a terminal.
    pub(super) fn find(
        &mut self,
        context: &SearchContext<'_>,
        star: &GuidedStar,
        terminal: u32,
        limits: TunnelLimits,
        random: &mut Random,
        counter: &mut AccessCounter<'_>,
    ) -> SearchOutcome {
        let Self { tunnel, nearest, sorted } = self;
        nearest.clear();
        let mut nearest_distance = u32::MAX;
        let mut add_candidates = |tunnel: &mut PartialTunnel, from| {
            let depth = tunnel.steps().len() as u64;
            sorted.clear();
            context.for_each_step(tunnel.steps(), from, |step, target| {
                let Some(b) = target else { return sorted.push((0, random.next_u64(), step)) };
                if let Some(distance) = star.distance(b)
                    && 2 * (depth + 1) + u64::from(distance) <= u64::from(limits.length)
                {
                    sorted.push((distance, random.next_u64(), step));
                }
            });
            // The best step is tried first, so it is added last.
            sorted.sort_unstable_by_key(|&(distance, random, _)| std::cmp::Reverse((distance, random)));
            tunnel.add_candidates(sorted.iter().map(|&(_, _, step)| step));
        };
        tunnel.begin(context, terminal);
        add_candidates(tunnel, terminal);
        tunnel.search(context, counter, u64::from(limits.accesses), |tunnel, step, [v, b]| {
            if !tunnel.try_step(context, step, [v, b], limits.loops) {
                return;
            }
            if let Some(distance) = star.distance(b).filter(|&d| d < nearest_distance && tunnel.loops() == 0)
            {
                nearest_distance = distance;
                nearest.clear();
                nearest.extend_from_slice(tunnel.steps());
            }
            add_candidates(tunnel, b);
        })
    }

    /// Returns the tunnel that was found.
    pub(super) fn tunnel(&self) -> &[TunnelStep] {
        self.tunnel.steps()
    }

    /// Returns the part of a tunnel that came closest to another terminal. For searches without a
    /// tunnel.
    pub(super) fn nearest(&self) -> &[TunnelStep] {
        &self.nearest
    }
}
