//! Root finding in a bracket.

/// The root of g between two times at which g has opposite signs, to four roundings of t.
///
/// The ITP method uses the false position, truncated towards the middle and projected onto a shrinking
/// interval around it. It needs at most one evaluation more than bisection, and far fewer on smooth g.
/// Source: Oliveira, Takahashi, *An enhancement of the bisection method average performance preserving minmax
/// optimality*, ACM TOMS 47 (2020).
pub(super) fn find_root(from: (f64, f64), to: (f64, f64), mut g: impl FnMut(f64) -> f64) -> f64 {
    let ((mut a, mut ga), (mut b, mut gb)) = (from, to);
    if gb == 0.0 {
        return b;
    }
    let tolerance = 4.0 * f64::EPSILON * a.abs().max(b.abs()).max(b - a);
    let truncation = 0.2 / (b - a);
    let bisections = ((b - a) / (2.0 * tolerance)).log2().ceil().max(0.0);
    // The half width of bisection after the same number of evaluations, with one to spare.
    let mut allowed = tolerance * 2f64.powf(bisections + 1.0);
    while b - a > 2.0 * tolerance {
        let middle = 0.5 * (a + b);
        let false_position = (gb * a - ga * b) / (gb - ga);
        let side = (middle - false_position).signum();
        let cut = (truncation * (b - a) * (b - a)).min((middle - false_position).abs());
        let truncated = false_position + side * cut;
        let reach = (allowed - 0.5 * (b - a)).max(0.0);
        let t = if (truncated - middle).abs() <= reach { truncated } else { middle - side * reach };
        let value = g(t);
        if value == 0.0 {
            return t;
        }
        if (value > 0.0) == (gb > 0.0) {
            (b, gb) = (t, value);
        } else {
            (a, ga) = (t, value);
        }
        allowed *= 0.5;
    }
    0.5 * (a + b)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Smooth, steep, flat and discontinuous functions: the root is accurate to four roundings, with at most
    /// one evaluation more than bisection.
    #[test]
    fn roots_are_found_in_few_looks() {
        type Function = fn(f64) -> f64;
        let cases: [(Function, f64, f64, f64); 5] = [
            (|x| x * x - 2.0, 0.0, 2.0, 2f64.sqrt()),
            (|x| x.powi(9) - 1e-3, 0.0, 1.0, 1e-3f64.powf(1.0 / 9.0)),
            (|x| (1e3 * (x - 0.7)).atan(), 0.0, 1.0, 0.7),
            (|x| if x < 0.3 { -1.0 } else { 1e-9 }, 0.0, 1.0, 0.3),
            (|x| -x.cos(), 1.0, 2.0, std::f64::consts::FRAC_PI_2),
        ];
        for (g, a, b, expected) in cases {
            let mut looks = 0;
            let root = find_root((a, g(a)), (b, g(b)), |x| {
                looks += 1;
                g(x)
            });
            assert!((root - expected).abs() <= 8.0 * f64::EPSILON * b, "{root} {expected}");
            assert!(looks <= 53, "{looks} looks at {expected}");
        }
    }
}
