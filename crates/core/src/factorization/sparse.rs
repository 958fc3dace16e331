//! The factorization M = LᵀDL that keeps the zeros of a tree's mass matrix, O(n depth²).
//!
//! M_ij is zero unless one of the two DoFs is an ancestor of the other. Eliminating from the last DoF to the
//! first causes no fill-in. Row k of L, whose diagonal is 1, has entries only at the ancestors λ(k), λ(λ(k)),
//! … of k. **(RBDA §6.5)**
//!
//! There are no square roots. If M is diagonal, a velocity is therefore its momentum divided once, and its
//! rounding has no bias that would accumulate over steps.
//!
//! `tree_factor` is the same factorization in tiles, for the many right sides of the
//! derivatives. With mimic joints the coordinates do not form a tree; then λ(k) = k − 1, which gives the
//! dense factorization.

use robot_dynamics_integrators::IntegratorError;
use robot_dynamics_number::Scalar;

use crate::Model;
use crate::model::Dof;

/// λ of a DoF without a parent.
pub const NONE: usize = usize::MAX;

/// λ, the parent of each DoF of the tree: the previous DoF of its body, or the last one of the parent body.
pub fn dof_parents(model: &Model) -> Vec<usize> {
    let dof_parent = |(k, dof): (usize, &Dof)| {
        let body = &model.bodies[dof.body];
        if k > body.dof {
            return k - 1;
        }
        model.bodies.get(body.parent).map_or(NONE, |parent| parent.dof + parent.motion.nv() - 1)
    };
    model.dofs.iter().enumerate().map(dof_parent).collect()
}

/// λ of each coordinate. Mimic joints and armature of tendons couple branches; then the parent of each
/// coordinate is the previous one.
pub fn coordinate_parents(model: &Model) -> Vec<usize> {
    if model.needs_dense_factor {
        return (0..model.nv).map(|k| k.checked_sub(1).unwrap_or(NONE)).collect();
    }
    dof_parents(model)
}

/// For each DoF the index of its tree in the forest λ, and the number of trees.
pub fn trees(dof_parent: &[usize]) -> (Vec<usize>, usize) {
    let (mut trees, mut count) = (Vec::with_capacity(dof_parent.len()), 0);
    for &dof_parent in dof_parent {
        trees.push(if dof_parent == NONE { count } else { trees[dof_parent] });
        count += usize::from(dof_parent == NONE);
    }
    (trees, count)
}

/// Changes λ so that a matrix which also couples these two DoFs keeps its remaining zeros. Both paths to the
/// root become one chain in the order of their indices; all other DoFs keep their parents.
///
/// Ancestors of k stay ancestors of k, so the factor of a matrix with fewer entries is right as well.
pub fn couple(dof_parent: &mut [usize], [mut one, mut two]: [usize; 2]) {
    let before = |k: usize| if k == NONE { 0 } else { k + 1 };
    while one != two {
        if before(one) < before(two) {
            (one, two) = (two, one);
        }
        // `one` is the later of the two, and its path continues with the later of λ(one) and `two`.
        let next = dof_parent[one];
        if before(next) < before(two) {
            dof_parent[one] = two;
        }
        one = next;
    }
}

/// The ancestors of DoF k, nearest first.
#[inline(always)]
pub fn dof_ancestors(dof_parent: &[usize], k: usize) -> impl Iterator<Item = usize> + '_ {
    // `NONE` is out of range, which ends the chain.
    core::iter::successors(dof_parent.get(dof_parent[k]).map(|_| dof_parent[k]), |&i| {
        dof_parent.get(dof_parent[i]).map(|_| dof_parent[i])
    })
}

/// Overwrites the lower triangle of M, row-major, with L, and its diagonal with D. `dof_parent` is λ. A
/// negative pivot becomes NaN, and so do the solutions.
#[inline(always)]
pub fn factor<S: Scalar>(dof_parent: &[usize], m: &mut [S]) {
    factor_by(dof_parent, m, |entry, _, inverse| entry * inverse);
}

/// [`factor`] with one rounding for each quotient.
pub fn factor_by_division(dof_parent: &[usize], m: &mut [f64]) {
    factor_by(dof_parent, m, |entry, pivot, _| entry / pivot);
}

/// [`factor_by_division`] of a matrix equal to `mass`, or larger in the sense of quadratic forms. Rejects a
/// pivot that does not exceed the rounding of its row of M.
///
/// # Errors
/// [`IntegratorError::SingularMass`] with that DoF.
pub fn factor_watched(
    dof_parent: &[usize],
    m: &mut [f64],
    mass: impl Fn(usize) -> f64,
) -> Result<(), IntegratorError> {
    factor_by_division(dof_parent, m);
    let n = dof_parent.len();
    check_pivots((0..n).map(|k| (m[k * n + k], mass(k))))
}

/// Rejects a pivot that does not exceed the rounding of its row. Each pivot comes with the diagonal entry of
/// its row.
///
/// # Errors
/// [`IntegratorError::SingularMass`] with the last such DoF.
pub fn check_pivots(
    pivots: impl DoubleEndedIterator<Item = (f64, f64)> + ExactSizeIterator,
) -> Result<(), IntegratorError> {
    let least = f64::EPSILON * pivots.len() as f64;
    for (coordinate, (pivot, mass)) in pivots.enumerate().rev() {
        // Also rejects NaN.
        if !(pivot > least * mass && pivot.is_finite()) {
            return Err(IntegratorError::SingularMass { coordinate, pivot });
        }
    }
    Ok(())
}

/// `quotient` computes the quotient from an entry, the pivot and its inverse.
#[inline(always)]
fn factor_by<S: Scalar>(dof_parent: &[usize], m: &mut [S], quotient: impl Fn(S, S, S) -> S) {
    let n = dof_parent.len();
    for k in (0..n).rev() {
        let own = m[k * n + k];
        // For negative numbers √ is NaN; for others the sum is unchanged.
        let pivot = own.sqrt().mul_add(S::zero(), own);
        m[k * n + k] = pivot;
        let inverse = S::one() / pivot;
        for i in dof_ancestors(dof_parent, k) {
            let factor = quotient(m[k * n + i], pivot, inverse);
            let square = factor * m[k * n + i];
            m[i * n + i] -= square;
            for j in dof_ancestors(dof_parent, i) {
                let product = factor * m[k * n + j];
                m[i * n + j] -= product;
            }
            m[k * n + i] = factor;
        }
    }
}

/// x ← M⁻¹ x from the result of [`factor`]: Lᵀz = x from the last DoF, D y = z, then L x = y from the first.
#[inline(always)]
pub fn solve<S: Scalar>(dof_parent: &[usize], l: &[S], x: &mut [S]) {
    let n = dof_parent.len();
    for k in (0..n).rev() {
        for i in dof_ancestors(dof_parent, k) {
            let product = l[k * n + i] * x[k];
            x[i] -= product;
        }
    }
    for k in 0..n {
        let mut sum = x[k] / l[k * n + k];
        for i in dof_ancestors(dof_parent, k) {
            sum -= l[k * n + i] * x[i];
        }
        x[k] = sum;
    }
}

/// The lower triangle of M⁻¹, row-major, from the result of [`factor`], O(n² depth). `row` is scratch.
///
/// L X = D⁻¹L⁻ᵀ, and the right side has no entry below the diagonal. Row i of X left of the diagonal is
/// −Σ L_ij X_j over the ancestors j of i, and X is symmetric.
#[inline(always)]
pub fn invert<S: Scalar>(dof_parent: &[usize], l: &[S], row: &mut [S], inverse: &mut [S]) {
    let n = dof_parent.len();
    for i in 0..n {
        row[..i].fill(S::zero());
        let mut j = dof_parent[i];
        while j < n {
            let factor = -l[i * n + j];
            for k in 0..=j {
                row[k] = factor.mul_add(inverse[j * n + k], row[k]);
            }
            for k in j + 1..i {
                row[k] = factor.mul_add(inverse[k * n + j], row[k]);
            }
            j = dof_parent[j];
        }
        let mut diagonal = S::one() / l[i * n + i];
        let mut j = dof_parent[i];
        while j < n {
            diagonal -= l[i * n + j] * row[j];
            j = dof_parent[j];
        }
        inverse[i * n + i] = diagonal;
        inverse[i * n..i * n + i].copy_from_slice(&row[..i]);
    }
}

/// Copies the lower triangle to the upper one.
pub fn mirror<S: Scalar>(n: usize, matrix: &mut [S]) {
    for i in 0..n {
        for j in 0..i {
            matrix[j * n + i] = matrix[i * n + j];
        }
    }
}

#[cfg(test)]
mod tests {
    use robot_dynamics_number::SplitMix64;

    use super::*;

    /// Random trees of DoFs with some pairs joined: the coupled factor solves like the dense one.
    #[test]
    fn coupled_paths_solve_as_dense() {
        for seed in 0..200 {
            let mut random = SplitMix64::new(seed);
            let n = 3 + (seed % 10) as usize;
            let mut below = |k: usize| usize::try_from(random.next_u64() % (k as u64 + 1)).unwrap();
            let tree: Vec<usize> = (0..n).map(|k| below(k).checked_sub(1).unwrap_or(NONE)).collect();
            let joined: Vec<[usize; 2]> = (0..=seed % 3).map(|_| [below(n - 1), below(n - 1)]).collect();
            let mut coupled = tree.clone();
            for pair in &joined {
                couple(&mut coupled, *pair);
            }
            // A sum of squares over each path to the root, and over each joined pair of paths.
            let path = |k: usize| core::iter::once(k).chain(dof_ancestors(&tree, k)).collect::<Vec<_>>();
            let mut sets: Vec<Vec<usize>> = (0..n).map(path).collect();
            sets.extend(joined.iter().map(|[one, two]| [path(*one), path(*two)].concat()));
            let mut matrix = vec![0.0; n * n];
            for set in &sets {
                let row: Vec<f64> =
                    (0..n).map(|k| if set.contains(&k) { random.uniform(-1.0, 1.0) } else { 0.0 }).collect();
                for i in 0..n {
                    for j in 0..n {
                        matrix[i * n + j] += row[i] * row[j] + if i == j { 0.1 } else { 0.0 };
                    }
                }
            }
            let b: Vec<f64> = (0..n).map(|_| random.uniform(-1.0, 1.0)).collect();
            let dense: Vec<usize> = (0..n).map(|k| k.checked_sub(1).unwrap_or(NONE)).collect();
            let [x, expected] = [&coupled, &dense].map(|dof_parent| {
                let (mut factored, mut x) = (matrix.clone(), b.clone());
                factor(dof_parent, &mut factored);
                solve(dof_parent, &factored, &mut x);
                x
            });
            for (x, expected) in x.iter().zip(&expected) {
                assert!(
                    (x - expected).abs() < 1e-9 * expected.abs().max(1.0),
                    "seed {seed}: {x} for {expected}"
                );
            }
            // DoFs that are not joined keep their zeros.
            if joined.iter().all(|[one, two]| one == two) {
                assert_eq!(coupled, tree);
            }
        }
    }
}
