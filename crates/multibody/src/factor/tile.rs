//! Rows with the same zeros.

/// Columns side by side.
pub(crate) const WIDTH: usize = 8;

/// As many rows as fit the registers beside three matrices' columns.
pub(crate) const TALLEST: usize = 4;

/// Coordinates of which each carries the next and nothing else beside it: what carries the first carries all, and
/// what the last carries all carry.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tile {
    pub first: usize,
    pub rows: usize,
    /// How many coordinates carry the first.
    pub depth: usize,
    /// Where the coordinates end that the last carries; they follow it.
    pub end: usize,
}

/// The coordinates of a tree by tiles of up to so many rows. `carrier` is λ; `may_follow` tells whether a coordinate may
/// stand in the tile of the one before it.
pub(crate) fn tiles(carrier: &[usize], tallest: usize, may_follow: impl Fn(usize) -> bool) -> Vec<Tile> {
    let n = carrier.len();
    let end = ends(carrier);
    let mut depth: Vec<usize> = Vec::with_capacity(n);
    for above in carrier {
        depth.push(depth.get(*above).map_or(0, |above| above + 1));
    }
    let follows = |k: usize| k < n && carrier[k] == k - 1 && end[k] == end[k - 1] && may_follow(k);
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

/// Of each coordinate where those end that it carries.
fn ends(carrier: &[usize]) -> Vec<usize> {
    let mut ends: Vec<usize> = (1..=carrier.len()).collect();
    for k in (0..carrier.len()).rev() {
        let own = ends[k];
        if let Some(carried) = ends.get_mut(carrier[k]) {
            *carried = own.max(*carried);
        }
    }
    ends
}

/// The expression for index 0, 1, ... as far as there are so many, four at most: written out, every index is a constant. What the
/// count excludes is not compiled: a tile of three rows would otherwise have the code of a fourth, and its panics.
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

/// A function compiled for each number of rows, or columns, of a tile.
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
    use crate::factor::sparse::NONE;

    /// 0 − 1, then 2 on its own and 3 − 4, both on 1.
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
