//! Tiles: consecutive rows with the same zeros.

/// The number of columns side by side.
pub const WIDTH: usize = 8;

/// The largest number of rows that fit the registers together with columns of three matrices.
pub(crate) const TALLEST: usize = 4;

/// A chain of coordinates, each the only child of the previous one. All share the ancestors of the first
/// and the descendants of the last.
#[derive(Clone, Copy, Debug)]
pub struct Tile {
    pub first: usize,
    pub rows: usize,
    /// The number of ancestors of the first coordinate.
    pub depth: usize,
    /// The end of the descendants of the last coordinate, which follow it.
    pub end: usize,
}

/// Splits the coordinates of a tree into tiles of limited height. `dof_parent` is λ; `may_follow` tells
/// whether a coordinate may be in the tile of the previous one.
pub(crate) fn tiles(dof_parent: &[usize], tallest: usize, may_follow: impl Fn(usize) -> bool) -> Vec<Tile> {
    let n = dof_parent.len();
    let end = ends(dof_parent);
    let mut depth: Vec<usize> = Vec::with_capacity(n);
    for above in dof_parent {
        depth.push(depth.get(*above).map_or(0, |above| above + 1));
    }
    let follows = |k: usize| k < n && dof_parent[k] == k - 1 && end[k] == end[k - 1] && may_follow(k);
    let (mut tiles, mut first) = (Vec::new(), 0);
    while first < n {
        let mut last = first + 1;
        while follows(last) {
            last += 1;
        }
        while first < last {
            let rows = tallest.min(last - first);
            tiles.push(Tile { first, rows, depth: depth[first], end: end[first] });
            first += rows;
        }
    }
    tiles
}

/// One past the last descendant of each coordinate.
fn ends(dof_parent: &[usize]) -> Vec<usize> {
    let mut ends: Vec<usize> = (1..=dof_parent.len()).collect();
    for k in (0..dof_parent.len()).rev() {
        let own = ends[k];
        if let Some(carried) = ends.get_mut(dof_parent[k]) {
            *carried = own.max(*carried);
        }
    }
    ends
}

/// The expression for index 0, 1, … up to a constant count of at most four. Every index is then a constant,
/// and indices beyond the count are not compiled. Otherwise a tile of three rows would include code, and
/// panics, for a fourth.
macro_rules! each {
    ($count:expr, $i:ident => $body:expr) => {
        each!($count, $i => $body; 0 1 2 3)
    };
    ($count:expr, $i:ident => $body:expr; $($index:literal)*) => {{
        $(
            if const { $count > $index } {
                #[allow(non_upper_case_globals)]
                const $i: usize = $index;
                $body;
            }
        )*
    }};
}
pub(crate) use each;

/// Compiles a function for each number of rows, or columns, of a tile.
macro_rules! by_count {
    ($count:expr, $function:ident::<$($parameter:ty),*>($($argument:expr),*)) => {
        match $count {
            4 => $function::<$($parameter,)* 4>($($argument),*),
            3 => $function::<$($parameter,)* 3>($($argument),*),
            2 => $function::<$($parameter,)* 2>($($argument),*),
            _ => $function::<$($parameter,)* 1>($($argument),*),
        }
    };
}
pub(crate) use by_count;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::factorization::sparse::NONE;

    /// A chain 0, 1; then the leaf 2 and the chain 3, 4, both children of 1.
    const FORK: [usize; 5] = [NONE, 0, 1, 1, 3];

    fn numbers(tiles: &[Tile]) -> Vec<[usize; 4]> {
        tiles.iter().map(|tile| [tile.first, tile.rows, tile.depth, tile.end]).collect()
    }

    #[test]
    fn a_fork_ends_a_tile() {
        assert_eq!(numbers(&tiles(&FORK, 4, |_| true)), [[0, 2, 0, 5], [2, 1, 2, 3], [3, 2, 2, 5]]);
    }

    #[test]
    fn tiles_are_no_taller_than_asked_and_part_where_asked() {
        let chain = [NONE, 0, 1, 2, 3, 4];
        assert_eq!(numbers(&tiles(&chain, 4, |_| true)), [[0, 4, 0, 6], [4, 2, 4, 6]]);
        assert_eq!(numbers(&tiles(&chain, 4, |k| k != 1)), [[0, 1, 0, 6], [1, 4, 1, 6], [5, 1, 5, 6]]);
    }
}
