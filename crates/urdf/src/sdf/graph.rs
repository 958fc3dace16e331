//! The graph of links and joints: the joints of a tree, and those that close loops.

use super::parts::SdfLink;

/// The world as a node of the graph; link i is node i + 1.
pub(super) const WORLD_NODE: usize = 0;

/// A joint with its nodes.
pub(super) struct Edge {
    pub(super) joint: usize,
    pub(super) parent: usize,
    pub(super) child: usize,
}

/// The joints of the tree, and those that close loops: in the file's order, a joint between two links that
/// are already connected.
pub(super) fn split(links: &[SdfLink], edges: &[Edge]) -> (Vec<Edge>, Vec<Edge>) {
    let mut leader: Vec<usize> = (0..=links.len()).collect();
    for (index, link) in links.iter().enumerate() {
        if link.is_static {
            leader[index + 1] = WORLD_NODE;
        }
    }
    let (mut tree, mut loops) = (Vec::new(), Vec::new());
    for &Edge { joint, parent, child } in edges {
        let [one, other] = [parent, child].map(|node| find(&mut leader, node));
        let edge = Edge { joint, parent, child };
        if one == other {
            loops.push(edge);
        } else {
            leader[one.max(other)] = one.min(other);
            tree.push(edge);
        }
    }
    (tree, loops)
}

/// The joints from the roots on: with their nodes, parents first. A root has no joint.
pub(super) fn orient(links: &[SdfLink], tree: &[Edge]) -> Vec<(Option<usize>, usize, usize)> {
    let count = links.len() + 1;
    let mut neighbours = vec![Vec::new(); count];
    let mut is_child = vec![false; count];
    for edge in tree {
        neighbours[edge.parent].push((edge.joint, edge.child));
        neighbours[edge.child].push((edge.joint, edge.parent));
        is_child[edge.child] = true;
    }
    let mut order = Vec::new();
    let mut is_reached = vec![false; count];
    is_reached[WORLD_NODE] = true;
    let mut pending = vec![WORLD_NODE];
    for (index, link) in links.iter().enumerate() {
        if link.is_static {
            is_reached[index + 1] = true;
            order.push((None, WORLD_NODE, index + 1));
            pending.push(index + 1);
        }
    }
    // Links that are not the child of a joint come first as roots.
    let roots = (1..count).filter(|&node| !is_child[node]).chain((1..count).filter(|&node| is_child[node]));
    for root in core::iter::once(WORLD_NODE).chain(roots) {
        if !is_reached[root] {
            is_reached[root] = true;
            order.push((None, WORLD_NODE, root));
            pending.push(root);
        }
        let mut next = 0;
        while let Some(&node) = pending.get(next) {
            next += 1;
            for &(joint, other) in &neighbours[node] {
                if !is_reached[other] {
                    is_reached[other] = true;
                    order.push((Some(joint), node, other));
                    pending.push(other);
                }
            }
        }
        pending.clear();
    }
    order
}

/// The representative of a set of nodes.
fn find(leader: &mut [usize], mut node: usize) -> usize {
    while leader[node] != node {
        leader[node] = leader[leader[node]];
        node = leader[node];
    }
    node
}
