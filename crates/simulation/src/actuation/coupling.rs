//! The stiffness and damping of a tendon or a servo over several coordinates.

/// k c cᵀ of K and d c cᵀ of D, where c is the gradient of a length by several coordinates.
#[derive(Clone, Debug)]
pub(crate) struct Coupling {
    /// The nonzero entries of c, in increasing order of coordinates.
    pub row: Vec<(usize, f64)>,
    /// k ≥ 0.
    pub stiffness: f64,
    /// d ≥ 0.
    pub damping: f64,
}

impl Coupling {
    /// y −= g k c (c·x).
    pub(crate) fn subtract_stiffness(&self, g: f64, x: &[f64], y: &mut [f64]) {
        let along: f64 = self.row.iter().map(|&(coordinate, factor)| factor * x[coordinate]).sum();
        for &(coordinate, factor) in &self.row {
            y[coordinate] -= g * self.stiffness * factor * along;
        }
    }

    /// The entries of (g d + g² k) c cᵀ on and below the diagonal: row, column, entry.
    pub(crate) fn entries(&self, g: f64) -> impl Iterator<Item = (usize, usize, f64)> + '_ {
        let weight = g * (self.damping + g * self.stiffness);
        self.row.iter().enumerate().flat_map(move |(at, &(i, one))| {
            self.row[..=at].iter().map(move |&(j, other)| (i, j, weight * one * other))
        })
    }
}
