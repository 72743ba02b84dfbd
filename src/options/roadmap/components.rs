//! The connected parts of the roadmap's graph.

use petgraph::graph::{DiGraph, NodeIndex};
use petgraph::unionfind::UnionFind;
use petgraph::visit::EdgeRef;

/// The connected parts of the roadmap's graph, numbered from 0, and the place of every node in its own.
#[derive(Clone, Debug)]
pub(super) struct Components {
    /// The component of every node, and its place there.
    of_node: Vec<[u32; 2]>,
    /// The number of nodes of every component.
    sizes: Vec<u32>,
    /// The rings with stops in each component, ascending.
    rings: Vec<Vec<usize>>,
}

impl Components {
    /// The connected parts of `graph`; `rings` are the nodes on each ring.
    pub fn new<E, R: Iterator<Item = NodeIndex>>(
        graph: &DiGraph<(), E>,
        rings: impl Iterator<Item = R>,
    ) -> Self {
        let mut union = UnionFind::new(graph.node_count());
        for edge in graph.edge_references() {
            union.union(edge.source().index(), edge.target().index());
        }
        let labels: Vec<usize> = union.into_labeling();
        let mut sizes: Vec<u32> = Vec::new();
        let mut number = vec![None; labels.len()];
        let of_node = labels
            .iter()
            .map(|&label| {
                let component = *number[label].get_or_insert_with(|| {
                    sizes.push(0);
                    sizes.len() - 1
                });
                sizes[component] += 1;
                [component as u32, sizes[component] - 1]
            })
            .collect();
        let mut components = Self { of_node, rings: vec![Vec::new(); sizes.len()], sizes };
        for (ring, nodes) in rings.enumerate() {
            for node in nodes {
                let component = components.of(node);
                let with_stops = &mut components.rings[component];
                if with_stops.last() != Some(&ring) {
                    with_stops.push(ring);
                }
            }
        }
        components
    }

    /// The component of a node.
    pub fn of(&self, node: NodeIndex) -> usize {
        self.of_node[node.index()][0] as usize
    }

    /// The place of a node in its component, counted from 0.
    pub fn place(&self, node: NodeIndex) -> usize {
        self.of_node[node.index()][1] as usize
    }

    /// The number of nodes of a component.
    pub fn size(&self, component: usize) -> usize {
        self.sizes[component] as usize
    }

    /// The rings with stops in a component, ascending.
    pub fn rings(&self, component: usize) -> &[usize] {
        &self.rings[component]
    }
}
