//! Linear systems whose equations may depend on each other, rows, and transposes.

/// A pivot below this fraction of the largest entry is zero: its equation depends on the others.
const DEPENDENT: f64 = 1e-9;

/// Solves S x = r for `width` right-hand sides in place, by elimination with complete pivoting. Dependent
/// equations are left out, and unknowns without an equation are 0. S is n×n, r is n×`width`, row-major.
pub(super) fn solve_dependent(system: &mut [f64], n: usize, right: &mut [f64], width: usize) {
    let largest = system.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    let mut order: Vec<usize> = (0..n).collect();
    let mut rank = n;
    for step in 0..n {
        let mut pivot = (0.0, step, step);
        for i in step..n {
            for j in step..n {
                let size = system[i * n + j].abs();
                if size > pivot.0 {
                    pivot = (size, i, j);
                }
            }
        }
        let (size, row, column) = pivot;
        if size <= DEPENDENT * largest {
            rank = step;
            break;
        }
        if row != step {
            (0..n).for_each(|j| system.swap(step * n + j, row * n + j));
            (0..width).for_each(|j| right.swap(step * width + j, row * width + j));
        }
        if column != step {
            (0..n).for_each(|i| system.swap(i * n + step, i * n + column));
            order.swap(step, column);
        }
        let inverse = 1.0 / system[step * n + step];
        for i in step + 1..n {
            let factor = system[i * n + step] * inverse;
            if factor == 0.0 {
                continue;
            }
            for j in step..n {
                system[i * n + j] -= factor * system[step * n + j];
            }
            let (above, below) = right.split_at_mut(i * width);
            let pivot_row = &above[step * width..(step + 1) * width];
            below[..width].iter_mut().zip(pivot_row).for_each(|(x, pivot)| *x -= factor * pivot);
        }
    }
    right[rank * width..].fill(0.0);
    for step in (0..rank).rev() {
        let (above, below) = right.split_at_mut((step + 1) * width);
        let own = &mut above[step * width..];
        for j in step + 1..rank {
            let factor = system[step * n + j];
            let solved = &below[(j - step - 1) * width..(j - step) * width];
            own.iter_mut().zip(solved).for_each(|(x, solved)| *x -= factor * solved);
        }
        let inverse = 1.0 / system[step * n + step];
        for x in own.iter_mut() {
            *x *= inverse;
        }
    }
    // Back to the order of the unknowns.
    let solved = right[..n * width].to_vec();
    for (at, unknown) in order.into_iter().enumerate() {
        right[unknown * width..(unknown + 1) * width].copy_from_slice(&solved[at * width..(at + 1) * width]);
    }
}

/// Appends a row of `width` numbers with these entries; entries of one column are added.
pub(super) fn push_row(matrix: &mut Vec<f64>, width: usize, terms: impl Iterator<Item = (usize, f64)>) {
    let begin = matrix.len();
    matrix.resize(begin + width, 0.0);
    terms.for_each(|(k, entry)| matrix[begin + k] += entry);
}

/// The transpose of a row-major matrix.
pub(super) fn transpose(matrix: &[f64], rows: usize, columns: usize) -> Vec<f64> {
    let mut transposed = vec![0.0; rows * columns];
    for (i, row) in matrix.chunks_exact(columns.max(1)).enumerate() {
        row.iter().enumerate().for_each(|(j, entry)| transposed[j * rows + i] = *entry);
    }
    transposed
}

#[cfg(test)]
mod tests {
    use nalgebra::DMatrix;
    use robot_dynamics_number::SplitMix64;

    use super::solve_dependent;

    /// Products of random rows with entries below 1 have a condition number below 1e4 here, so the residual
    /// is rounding times that.
    #[test]
    fn consistent_systems_are_solved_at_any_rank() {
        let mut random = SplitMix64::new(11);
        for n in 1..9 {
            for rank in 0..=n {
                let mut matrix =
                    |rows, columns| DMatrix::from_fn(rows, columns, |_, _| random.uniform(-1.0, 1.0));
                let (left, right, x) = (matrix(n, rank), matrix(rank, n), matrix(n, 3));
                let system = left * right;
                let wanted = &system * x;
                let mut entries = system.transpose().as_slice().to_vec();
                let mut solution = wanted.transpose().as_slice().to_vec();
                solve_dependent(&mut entries, n, &mut solution, 3);
                let solution = DMatrix::from_row_slice(n, 3, &solution);
                let off = (&system * solution - &wanted).amax();
                assert!(off < 1e-10, "{n}, rank {rank}: {off:e}");
            }
        }
    }
}
