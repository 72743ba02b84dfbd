//! The regions on routes that enter no region twice.

/// For every region, whether any route leads through it from `from` to `to`, which are different, and enters
/// no region twice. `neighbors` are the regions next to each region.
///
/// These are the regions in the same biconnected component as an edge added between `from` and `to` (J.
/// Hopcroft and R. Tarjan, Algorithm 447: efficient algorithms for graph manipulation, Communications of the
/// ACM 16, 1973). In a depth-first search that begins with this edge, a region is in the component if its
/// parent is and if an edge leads from the regions below it to one above its parent.
pub(super) fn on_routes(neighbors: &[Vec<usize>], from: usize, to: usize) -> Vec<bool> {
    const UNSEEN: usize = usize::MAX;
    let mut number = vec![UNSEEN; neighbors.len()];
    (number[from], number[to]) = (0, 1);
    // the lowest number that an edge leads to from a region or from those below it
    let mut lowest = number.clone();
    let mut parent = vec![from; neighbors.len()];
    let mut order = vec![from, to];
    let mut path = vec![(to, 0)];
    while let Some((region, edge)) = path.last_mut() {
        let here = *region;
        if let Some(&next) = neighbors[here].get(*edge) {
            *edge += 1;
            if number[next] == UNSEEN {
                (number[next], lowest[next], parent[next]) = (order.len(), order.len(), here);
                order.push(next);
                path.push((next, 0));
            } else {
                lowest[here] = lowest[here].min(number[next]);
            }
        } else {
            path.pop();
            lowest[parent[here]] = lowest[parent[here]].min(lowest[here]);
        }
    }
    let mut is_on_route = vec![false; neighbors.len()];
    (is_on_route[from], is_on_route[to]) = (true, true);
    for &region in &order[2..] {
        let above = parent[region];
        is_on_route[region] = is_on_route[above] && lowest[region] < number[above];
    }
    is_on_route
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::RngExt;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;

    /// Adds the regions of all routes from the end of `route` to `to`.
    fn walk(neighbors: &[Vec<usize>], route: &mut Vec<usize>, to: usize, found: &mut [bool]) {
        let here = route[route.len() - 1];
        if here == to {
            route.iter().for_each(|&region| found[region] = true);
            return;
        }
        for &next in &neighbors[here] {
            if !route.contains(&next) {
                route.push(next);
                walk(neighbors, route, to, found);
                route.pop();
            }
        }
    }

    #[test]
    fn property_the_regions_on_routes_are_those_that_a_search_of_all_routes_finds() {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        for _ in 0..300 {
            let n = rng.random_range(2..9);
            let mut neighbors = vec![Vec::new(); n];
            for _ in 0..rng.random_range(1..14) {
                let [a, b] = [(); 2].map(|()| rng.random_range(0..n));
                neighbors[a].push(b);
                neighbors[b].push(a);
            }
            let mut found = vec![false; n];
            walk(&neighbors, &mut vec![0], 1, &mut found);
            if found[1] {
                assert_eq!(on_routes(&neighbors, 0, 1), found, "{neighbors:?}");
            }
        }
    }
}
