//! The pairs of sites and discs between which a clear line may lead. The others are too far apart for what
//! stands between them, or a disc is buried in the clearance of obstacles.

use super::disc::Disc;
use super::sight::{Sight, View};
use super::space::{LOOKUP_MARGIN_M, Space};
use super::straight::Straight;
use crate::geometry::{Bounds, Nearby, Point};

/// For every site and disc, the others that a clear line may lead to.
pub(super) struct Reachable {
    portals: Vec<Point>,
    /// The discs that are not buried, ascending.
    open: Vec<usize>,
    /// How far clear lines lead from every portal, and from the two rings of every open disc.
    from_portals: Vec<View>,
    from_rings: Vec<[View; 2]>,
    near_portals: Nearby,
    /// The open discs, numbered by their place in `open`.
    near_discs: Nearby,
    /// The squares around open discs in which lines from them may end.
    views: Nearby,
    /// The longest straight part, m.
    reach: f64,
}

impl Reachable {
    pub fn new(sight: &Sight, space: &Space, discs: &[Disc], sites: &[Straight]) -> Self {
        let portals: Vec<Point> = sites.iter().map(Straight::portal).collect();
        let from_portals = portals.iter().flat_map(|&p| sight.views(p, 0.0, [1.0])).collect();
        let open: Vec<usize> = (0..discs.len()).filter(|&disc| !space.is_buried(&discs[disc])).collect();
        let views_of = |disc: &Disc| sight.views(disc.center, disc.radius, [1.0, -1.0]);
        let from_rings: Vec<[View; 2]> = open.iter().map(|&disc| views_of(&discs[disc])).collect();
        let reach = sites.iter().map(|site| site.reach).fold(0.0, f64::max);
        let near_portals = Nearby::new(portals.iter().map(|&p| Bounds { min: p, max: p }));
        let near_discs = Nearby::new(open.iter().map(|&disc| discs[disc].bounds()));
        let open_views = open.iter().zip(&from_rings);
        let views =
            Nearby::new(open_views.map(|(&disc, views)| around(discs[disc].center, farthest(views) + reach)));
        Self { portals, open, from_portals, from_rings, near_portals, near_discs, views, reach }
    }

    /// The number of lines from discs and portals with an open view. All of them must be tried, so this is
    /// nearly the whole work in a large world.
    pub fn lines(&self) -> u64 {
        let views = self.from_portals.iter().chain(self.from_rings.iter().flatten());
        let open = views.filter(|view| view.farthest.is_infinite());
        open.count() as u64 * (2 * self.open.len() + self.portals.len()) as u64
    }

    /// The discs that lines may lead from, ascending, with the views of their two rings and the discs that
    /// lines from either may lead to, ascending.
    pub fn discs(&self, discs: &[Disc]) -> impl Iterator<Item = (usize, &[View; 2], Vec<usize>)> {
        self.open.iter().zip(&self.from_rings).map(|(&disc, views)| {
            let met = self.near_discs.meeting(around(discs[disc].center, farthest(views)));
            (disc, views, met.into_iter().map(|i| self.open[i]).collect())
        })
    }

    /// How far clear lines lead from a site's far end.
    pub fn view_from_site(&self, site: usize) -> &View {
        &self.from_portals[site]
    }

    /// The sites to which lines from a site's far end may lead, and the discs from which lines may lead to the
    /// site, each with whether one from the far end may lead to it; both ascending.
    pub fn reached_from_site(&self, site: usize) -> (Vec<usize>, Vec<(usize, bool)>) {
        let portal = self.portals[site];
        let farthest = self.from_portals[site].farthest;
        let seen = self.near_discs.meeting(around(portal, farthest)).into_iter().map(|i| (i, true));
        let seeing = self.views.meeting(around(portal, 0.0)).into_iter().map(|i| (i, false));
        let mut discs: Vec<(usize, bool)> = seen.chain(seeing).collect();
        // two ascending parts; of a disc in both, the first stays
        discs.sort_by_key(|(i, _)| *i);
        discs.dedup_by_key(|(i, _)| *i);
        let discs = discs.into_iter().map(|(i, is_seen)| (self.open[i], is_seen)).collect();
        (self.near_portals.meeting(around(portal, farthest + self.reach)), discs)
    }
}

/// A bound of the distance (m) to the far end of any clear line from either ring of a disc.
fn farthest([left, right]: &[View; 2]) -> f64 {
    left.farthest.max(right.farthest)
}

/// Farther than from anywhere to anywhere in a world, m.
const ANYWHERE_M: f64 = 1e6;

/// The square around a point, with sides of twice `radius` (m).
fn around(p: Point, radius: f64) -> Bounds {
    Bounds { min: p, max: p }.grown(radius.min(ANYWHERE_M) + LOOKUP_MARGIN_M)
}
