//! Chooses the joints of the tree, and orders them from the world outwards.

use std::collections::{HashMap, VecDeque};

use crate::joint::UsdJoint;

/// Joints in series between two nodes, the first nearer to the world.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Group {
    /// Numbers of joints.
    pub(crate) joints: Vec<usize>,
    pub(crate) from: usize,
    pub(crate) to: usize,
}

/// The parts of the tree in the order of the robot, and the joints that close loops.
#[derive(Debug, Default)]
pub(crate) struct Tree {
    pub(crate) steps: Vec<Step>,
    pub(crate) loops: Vec<usize>,
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Step {
    /// A node that floats in the world.
    Root(usize),
    Joints(Group),
}

/// `roots` are the nodes that become roots, in order of preference. With `stacks`, several joints between two
/// nodes are joints in series; otherwise the further ones close loops.
pub(crate) fn build(joints: &[UsdJoint], nodes: usize, roots: &[usize], stacks: bool) -> Tree {
    let mut tree = Tree::default();
    let mut leader: Vec<usize> = (0..nodes).collect();
    let mut groups: Vec<Group> = Vec::new();
    let mut by_nodes: HashMap<[usize; 2], usize> = HashMap::new();
    for (number, joint) in joints.iter().enumerate() {
        let [a, b] = joint.nodes;
        if joint.is_excluded {
            tree.loops.push(number);
            continue;
        }
        let key = [a.min(b), a.max(b)];
        if stacks && let Some(&group) = by_nodes.get(&key) {
            groups[group].joints.push(number);
            continue;
        }
        let (root_a, root_b) = (find(&mut leader, a), find(&mut leader, b));
        if root_a == root_b {
            tree.loops.push(number);
            continue;
        }
        // The world, node 0, remains the leader of its part.
        leader[root_a.max(root_b)] = root_a.min(root_b);
        by_nodes.insert(key, groups.len());
        groups.push(Group { joints: vec![number], from: a, to: b });
    }
    let mut neighbors: Vec<Vec<usize>> = vec![Vec::new(); nodes];
    for (number, group) in groups.iter().enumerate() {
        neighbors[group.from].push(number);
        neighbors[group.to].push(number);
    }
    let mut is_reached = vec![false; nodes];
    let order = core::iter::once(0).chain(roots.iter().copied()).chain(1..nodes);
    for root in order {
        if is_reached[root] {
            continue;
        }
        if root != 0 {
            tree.steps.push(Step::Root(root));
        }
        is_reached[root] = true;
        let mut queue = VecDeque::from([root]);
        while let Some(node) = queue.pop_front() {
            for &number in &neighbors[node] {
                let group = &groups[number];
                let other = if group.from == node { group.to } else { group.from };
                if !is_reached[other] {
                    is_reached[other] = true;
                    queue.push_back(other);
                    tree.steps.push(Step::Joints(Group { from: node, to: other, ..group.clone() }));
                }
            }
        }
    }
    tree
}

fn find(leader: &mut [usize], mut node: usize) -> usize {
    while leader[node] != node {
        leader[node] = leader[leader[node]];
        node = leader[node];
    }
    node
}
