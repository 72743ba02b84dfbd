//! The pairs of sites and discs between which a clear line may lead. The others are too far apart for what
//! stands between them, or a disc is buried in the clearance of obstacles.

use super::disc::{Disc, turn};
use super::sight::Sight;
use super::space::{LOOKUP_MARGIN_M, Space};
use super::straight::Straight;
use crate::geometry::{Bounds, Nearby, Point};

/// For every site and disc, the others that a clear line may lead to.
pub(super) struct Reachable {
    portals: Vec<Point>,
    /// The discs that are not buried, ascending.
    open: Vec<usize>,
    /// Bounds of the distance (m) to which clear lines lead: from every portal, and from every ring; 0 from
    /// those of buried discs.
    from_portals: Vec<f64>,
    from_rings: Vec<f64>,
    near_portals: Nearby,
    /// The open discs, numbered by their place in `open`.
    near_discs: Nearby,
    /// The squares around open discs in which lines from them may end.
    views: Nearby,
    /// The longest straight part, m.
    reach: f64,
}

impl Reachable {
    pub fn new(space: &Space, discs: &[Disc], sites: &[Straight], closed: &[[Point; 2]]) -> Self {
        let sight = Sight::new(space, closed);
        let portals: Vec<Point> = sites.iter().map(Straight::portal).collect();
        let from_portals = portals.iter().map(|&p| sight.limit(p, 0.0, 1.0)).collect();
        let open: Vec<usize> = (0..discs.len()).filter(|&disc| !space.is_buried(&discs[disc])).collect();
        let mut from_rings = vec![0.0; 2 * discs.len()];
        for ring in rings(&open) {
            from_rings[ring] = sight.limit(discs[ring / 2].center, discs[ring / 2].radius, turn(ring));
        }
        let reach = sites.iter().map(|site| site.reach).fold(0.0, f64::max);
        let near_portals = Nearby::new(portals.iter().map(|&p| Bounds { min: p, max: p }));
        let near_discs = Nearby::new(open.iter().map(|&disc| discs[disc].bounds()));
        let views = Nearby::new(open.iter().map(|&disc| {
            let farthest = f64::max(from_rings[2 * disc], from_rings[2 * disc + 1]);
            around(discs[disc].center, farthest + reach)
        }));
        Self { portals, open, from_portals, from_rings, near_portals, near_discs, views, reach }
    }

    /// The number of lines from discs and portals with an open view. All of them must be tried, so this is
    /// nearly the whole work in a large world.
    pub fn lines(&self) -> u64 {
        let open = self.from_portals.iter().chain(&self.from_rings).filter(|limit| limit.is_infinite());
        open.count() as u64 * (2 * self.open.len() + self.portals.len()) as u64
    }

    /// The rings that lines may lead from, ascending.
    pub fn rings(&self) -> impl Iterator<Item = usize> {
        rings(&self.open)
    }

    /// The sites to which lines from a site's far end may lead, and the discs from which lines may lead to the
    /// site, each with whether one from the far end may lead to it; both ascending.
    pub fn reached_from_site(&self, site: usize) -> (Vec<usize>, Vec<(usize, bool)>) {
        let portal = self.portals[site];
        let farthest = self.from_portals[site];
        let seen = self.near_discs.meeting(around(portal, farthest)).into_iter().map(|i| (i, true));
        let seeing = self.views.meeting(around(portal, 0.0)).into_iter().map(|i| (i, false));
        let mut discs: Vec<(usize, bool)> = seen.chain(seeing).collect();
        // two ascending parts; of a disc in both, the first stays
        discs.sort_by_key(|(i, _)| *i);
        discs.dedup_by_key(|(i, _)| *i);
        let discs = discs.into_iter().map(|(i, is_seen)| (self.open[i], is_seen)).collect();
        (self.near_portals.meeting(around(portal, farthest + self.reach)), discs)
    }

    /// The discs to which lines from a ring may lead, ascending.
    pub fn reached_from_ring(&self, ring: usize, disc: &Disc) -> Vec<usize> {
        let met = self.near_discs.meeting(around(disc.center, self.from_rings[ring]));
        met.into_iter().map(|i| self.open[i]).collect()
    }
}

/// The two rings of each of these discs.
fn rings(discs: &[usize]) -> impl Iterator<Item = usize> {
    discs.iter().flat_map(|disc| [2 * disc, 2 * disc + 1])
}

/// Farther than from anywhere to anywhere in a world, m.
const ANYWHERE_M: f64 = 1e6;

/// The square around a point, with sides of twice `radius` (m).
fn around(p: Point, radius: f64) -> Bounds {
    Bounds { min: p, max: p }.grown(radius.min(ANYWHERE_M) + LOOKUP_MARGIN_M)
}
