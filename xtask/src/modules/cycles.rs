//! Cycles of a graph.

/// The strongly connected components of more than one node, each sorted, in order of their first nodes
/// (Tarjan's algorithm).
pub(crate) fn components(nodes: usize, edges: &[(usize, usize)]) -> Vec<Vec<usize>> {
    let mut successors = vec![Vec::new(); nodes];
    for &(from, to) in edges {
        successors[from].push(to);
    }
    let mut search = Search {
        successors,
        next: 0,
        order: vec![None; nodes],
        low: vec![0; nodes],
        stack: Vec::new(),
        is_on_stack: vec![false; nodes],
        found: Vec::new(),
    };
    for node in 0..nodes {
        if search.order[node].is_none() {
            search.visit(node);
        }
    }
    search.found.sort();
    search.found
}

struct Search {
    successors: Vec<Vec<usize>>,
    next: usize,
    order: Vec<Option<usize>>,
    low: Vec<usize>,
    stack: Vec<usize>,
    is_on_stack: Vec<bool>,
    found: Vec<Vec<usize>>,
}

impl Search {
    fn visit(&mut self, node: usize) {
        let order = self.next;
        self.next += 1;
        (self.order[node], self.low[node]) = (Some(order), order);
        self.stack.push(node);
        self.is_on_stack[node] = true;
        for at in 0..self.successors[node].len() {
            let to = self.successors[node][at];
            match self.order[to] {
                None => {
                    self.visit(to);
                    self.low[node] = self.low[node].min(self.low[to]);
                }
                Some(order) if self.is_on_stack[to] => self.low[node] = self.low[node].min(order),
                Some(_) => {}
            }
        }
        if self.low[node] == order {
            let from = self.stack.iter().rposition(|&on| on == node).unwrap_or(0);
            let mut component = self.stack.split_off(from);
            for &on in &component {
                self.is_on_stack[on] = false;
            }
            if component.len() > 1 {
                component.sort_unstable();
                self.found.push(component);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::components;

    #[test]
    fn cycles_are_components_of_more_than_one_node() {
        let edges = [(0, 1), (1, 2), (2, 0), (2, 3), (3, 4), (4, 3), (4, 5)];
        assert_eq!(components(6, &edges), [vec![0, 1, 2], vec![3, 4]]);
    }

    #[test]
    fn a_graph_without_cycles_has_none() {
        assert!(components(4, &[(0, 1), (0, 2), (1, 3), (2, 3)]).is_empty());
        assert!(components(1, &[(0, 0)]).is_empty());
    }
}
