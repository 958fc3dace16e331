//! Linear combinations of vectors.

use robot_dynamics_number::Scalar;

/// Σⱼ kⱼ xⱼ over the first `count` stages.
#[inline(always)]
pub fn sum_stages<S: Scalar>(count: usize, k: impl Fn(usize) -> f64, x: &[S], sum: &mut [S]) {
    let n = sum.len();
    let mut is_first = true;
    for j in 0..count {
        let k = k(j);
        if k == 0.0 {
            continue;
        }
        let (k, x) = (S::from_f64(k), &x[j * n..(j + 1) * n]);
        for i in 0..n {
            sum[i] = if is_first { k * x[i] } else { k.mul_add(x[i], sum[i]) };
        }
        is_first = false;
    }
    if is_first {
        sum.fill(S::zero());
    }
}

/// x ← start + h x.
#[inline(always)]
pub fn start_from<S: Scalar>(start: &[S], h: S, x: &mut [S]) {
    for i in 0..x.len() {
        x[i] = h.mul_add(x[i], start[i]);
    }
}

/// x ← h x.
#[inline(always)]
pub fn scale<S: Scalar>(h: S, x: &mut [S]) {
    for x in x.iter_mut() {
        *x = h * *x;
    }
}

/// x ← x + k y.
pub fn add_scaled(x: &mut [f64], k: f64, y: &[f64]) {
    x.iter_mut().zip(y).for_each(|(x, y)| *x += k * y);
}
