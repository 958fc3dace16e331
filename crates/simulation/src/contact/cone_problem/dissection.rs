//! Nested dissection: an order of the nodes of a graph for which a matrix factors with little fill-in and a
//! low elimination tree.
//!
//! The separator of a set comes first, then each of its two parts in the same way **(George 1973)**. A
//! separator is a set of nodes at one distance from a node at the edge of the set. Rows are eliminated from
//! the last to the first.

use core::ops::Range;

use robot_dynamics_core::clone_in_place::clone_in_place;

/// Sets of at most this many nodes are not divided.
const LARGEST_LEAF: usize = 3;

const NONE: usize = usize::MAX;

clone_in_place! {
    /// The graph, and memory for its order.
    #[derive(Debug, Default)]
    pub(super) struct Dissection {
        names: Vec<usize>,
        /// The node of each name.
        nodes: Vec<usize>,
        edges: Vec<[usize; 2]>,
        /// The index of each node's first neighbour, and the end of the last.
        begins: Vec<usize>,
        neighbors: Vec<usize>,
        /// The nodes of the sets that are not yet divided, one set after the other, and the range of each
        /// set.
        open: Vec<usize>,
        sets: Vec<Range<usize>>,
        /// The set of each node, and its level there.
        inside: Vec<usize>,
        levels: Vec<usize>,
        queue: Vec<usize>,
        order: Vec<usize>,
    }
}

impl Dissection {
    /// Allocates memory for n nodes.
    pub(super) fn new(n: usize) -> Self {
        let room = || Vec::with_capacity(n + 1);
        Self {
            names: room(),
            nodes: room(),
            edges: Vec::with_capacity(4 * n),
            begins: room(),
            neighbors: Vec::with_capacity(8 * n),
            open: room(),
            sets: Vec::with_capacity(n + 1),
            inside: room(),
            levels: room(),
            queue: room(),
            order: room(),
        }
    }

    /// Starts with these nodes, given by their names, and no edges.
    pub(super) fn begin(&mut self, names: &[usize]) {
        self.names.clear();
        self.names.extend_from_slice(names);
        let most = names.iter().max().map_or(0, |name| name + 1);
        if self.nodes.len() < most {
            self.nodes.resize(most, NONE);
        }
        for (node, name) in names.iter().enumerate() {
            self.nodes[*name] = node;
        }
        self.edges.clear();
    }

    /// Adds an edge. A repeated edge or a loop changes nothing.
    pub(super) fn join(&mut self, one: usize, two: usize) {
        let edge = [self.nodes[one], self.nodes[two]];
        if edge[0] != edge[1] && self.edges.last() != Some(&edge) {
            self.edges.push(edge);
        }
    }

    /// The names in order.
    pub(super) fn order(&mut self) -> &[usize] {
        self.list_neighbors();
        let count = self.names.len();
        let Self { open, sets, inside, levels, order, .. } = self;
        open.clear();
        open.extend(0..count);
        sets.clear();
        sets.push(0..count);
        inside.clear();
        inside.resize(count, 0);
        levels.clear();
        levels.resize(count, NONE);
        order.clear();
        // A set's number is the index of its first node. Each step replaces the last set.
        while let Some(set) = self.sets.pop() {
            self.divide(set);
        }
        for node in &mut self.order {
            *node = self.names[*node];
        }
        &self.order
    }

    fn list_neighbors(&mut self) {
        let Self { names, edges, begins, neighbors, .. } = self;
        let count = names.len();
        begins.clear();
        begins.resize(count + 1, 0);
        for end in edges.iter().flatten() {
            begins[end + 1] += 1;
        }
        for node in 0..count {
            begins[node + 1] += begins[node];
        }
        neighbors.clear();
        neighbors.resize(begins[count], 0);
        for &[one, two] in &*edges {
            for (from, to) in [(one, two), (two, one)] {
                neighbors[begins[from]] = to;
                begins[from] += 1;
            }
        }
        begins.rotate_right(1);
        begins[0] = 0;
    }

    /// Orders a small set. Otherwise orders its separator, and adds its parts to the sets.
    fn divide(&mut self, set: Range<usize>) {
        if set.len() <= LARGEST_LEAF {
            self.order.extend_from_slice(&self.open[set.clone()]);
            self.open.truncate(set.start);
            return;
        }
        let number = set.start;
        let first = self.open[number];
        self.walk(first, number);
        // The nodes that the walk did not reach form a set of their own.
        if self.queue.len() < set.len() {
            self.split(set, |level| level != NONE, None);
            return;
        }
        let farthest = self.queue[self.queue.len() - 1];
        self.forget(set.clone());
        self.walk(farthest, number);
        let deepest = self.levels[self.queue[self.queue.len() - 1]];
        // The level with the lowest cost: a small separator that nearly halves the set.
        let (mut best, mut least) = (NONE, usize::MAX);
        let mut before = 0;
        for level in 0..=deepest {
            let size = self.queue[before..].iter().take_while(|node| self.levels[**node] == level).count();
            let after = set.len() - before - size;
            let cost = 2 * size + before.max(after);
            if before > 0 && after > 0 && cost < least {
                (best, least) = (level, cost);
            }
            before += size;
        }
        if best == NONE {
            self.forget(set.clone());
            self.order.extend_from_slice(&self.open[set.clone()]);
            self.open.truncate(set.start);
            return;
        }
        self.split(set, |level| level < best, Some(best));
    }

    /// Computes the distance of the nodes of a set from one of them; `number` is the set's number in
    /// `inside`. Lists the nodes by distance in `queue`.
    fn walk(&mut self, from: usize, number: usize) {
        let Self { begins, neighbors, inside, levels, queue, .. } = self;
        queue.clear();
        queue.push(from);
        levels[from] = 0;
        let mut next = 0;
        while let Some(&node) = queue.get(next) {
            next += 1;
            for &other in &neighbors[begins[node]..begins[node + 1]] {
                if inside[other] == number && levels[other] == NONE {
                    levels[other] = levels[node] + 1;
                    queue.push(other);
                }
            }
        }
    }

    fn forget(&mut self, set: Range<usize>) {
        for node in &self.open[set] {
            self.levels[*node] = NONE;
        }
    }

    /// Orders the nodes of one level, and makes two sets of the others.
    fn split(&mut self, set: Range<usize>, is_first: impl Fn(usize) -> bool, separator: Option<usize>) {
        let Self { open, sets, inside, levels, queue, order, .. } = self;
        queue.clear();
        queue.extend_from_slice(&open[set.clone()]);
        open.truncate(set.start);
        let level = |node: &usize| levels[*node];
        for node in queue.iter().filter(|node| separator == Some(level(node))) {
            order.push(*node);
            inside[*node] = NONE;
        }
        for side in [true, false] {
            let begin = open.len();
            let belongs = |node: &&usize| separator != Some(level(node)) && is_first(level(node)) == side;
            open.extend(queue.iter().filter(belongs));
            for node in &open[begin..] {
                inside[*node] = begin;
            }
            if open.len() > begin {
                sets.push(begin..open.len());
            }
        }
        for node in &*queue {
            levels[*node] = NONE;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Dissection;

    /// The largest number of remaining neighbours of a node at its elimination, by elimination on the graph
    /// itself.
    fn widest_row(count: usize, edges: &[[usize; 2]], order: &[usize]) -> usize {
        let mut joined = vec![vec![false; count]; count];
        for &[a, b] in edges {
            (joined[a][b], joined[b][a]) = (true, true);
        }
        let mut widest = 0;
        for at in (0..count).rev() {
            let left: Vec<usize> =
                order[..at].iter().copied().filter(|other| joined[order[at]][*other]).collect();
            widest = widest.max(left.len());
            for &a in &left {
                for &b in &left {
                    joined[a][b] = true;
                }
            }
        }
        widest
    }

    fn order_of(count: usize, edges: &[[usize; 2]]) -> Vec<usize> {
        let mut dissection = Dissection::default();
        dissection.begin(&(0..count).collect::<Vec<_>>());
        for [a, b] in edges {
            dissection.join(*a, *b);
        }
        let order = dissection.order().to_vec();
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert!(sorted.iter().copied().eq(0..count), "{order:?}");
        order
    }

    /// The middle of a chain comes first, as it is halved again and again. A square of k² nodes is separated
    /// by k nodes. In a graph without edges, every node comes once.
    #[test]
    fn separators_come_first() {
        let chain: Vec<[usize; 2]> = (1..31).map(|k| [k - 1, k]).collect();
        let order = order_of(31, &chain);
        assert!((14..17).contains(&order[0]), "{order:?}");
        assert!(widest_row(31, &chain, &order) <= 2);
        let k = 8;
        let mut square = Vec::new();
        for at in 0..k * k {
            if at % k > 0 {
                square.push([at - 1, at]);
            }
            if at >= k {
                square.push([at - k, at]);
            }
        }
        let order = order_of(k * k, &square);
        // In row order, every row has k entries. Dissection has 3/2 k at the largest separator, and fewer
        // elsewhere.
        assert!(widest_row(k * k, &square, &order) <= 3 * k / 2);
        assert_eq!(order_of(9, &[]).len(), 9);
        assert_eq!(order_of(9, &[[0, 8], [8, 4], [1, 2]]).len(), 9);
    }
}
