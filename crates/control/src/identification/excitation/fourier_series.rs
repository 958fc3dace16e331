//! Periodic motions as finite Fourier series.

use core::f64::consts::TAU;

/// A periodic motion of joints, with exact derivatives. **(Swevers et al. 1997)**
///
/// With ω = 2π/T, for each coordinate
///
/// q(t) = c + Σₖ (aₖ sin kωt − bₖ cos kωt)/(kω), v(t) = Σₖ aₖ cos kωt + bₖ sin kωt, k = 1 … K.
///
/// ```
/// use robot_dynamics::control::identification::FourierSeries;
/// let swing = FourierSeries { period: 2.0, offsets: vec![0.3], sines: vec![vec![1.5]], cosines: vec![vec![0.0]] };
/// let (mut q, mut v, mut a) = ([0.0], [0.0], [0.0]);
/// swing.evaluate(0.5, &mut q, &mut v, &mut a);
/// assert!((q[0] - 0.3 - 1.5 / std::f64::consts::PI).abs() < 1e-15 && v[0].abs() < 1e-15);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct FourierSeries {
    /// T \[s\].
    pub period: f64,
    /// c of each coordinate \[rad or m\].
    pub offsets: Vec<f64>,
    /// a₁ … a_K of each coordinate \[rad/s or m/s\].
    pub sines: Vec<Vec<f64>>,
    /// b₁ … b_K of each coordinate \[rad/s or m/s\].
    pub cosines: Vec<Vec<f64>>,
}

impl FourierSeries {
    /// q, v and a at a time \[s\]. It does not allocate memory.
    ///
    /// # Panics
    /// If a slice is longer than the number of coordinates.
    #[track_caller]
    pub fn evaluate(&self, t: f64, q: &mut [f64], v: &mut [f64], a: &mut [f64]) {
        q.copy_from_slice(&self.offsets);
        v.fill(0.0);
        a.fill(0.0);
        for i in 0..q.len() {
            for (k, (sine, cosine)) in self.sines[i].iter().zip(&self.cosines[i]).enumerate() {
                let [position, velocity, acceleration] = harmonic(self.period, k + 1, t);
                q[i] += sine * position[0] + cosine * position[1];
                v[i] += sine * velocity[0] + cosine * velocity[1];
                a[i] += sine * acceleration[0] + cosine * acceleration[1];
            }
        }
    }
}

/// The factors of aₖ and bₖ in q, v and a.
fn harmonic(period: f64, k: usize, t: f64) -> [[f64; 2]; 3] {
    let rate = k as f64 * TAU / period;
    let (sine, cosine) = (rate * t).sin_cos();
    [[sine / rate, -cosine / rate], [cosine, sine], [-rate * sine, rate * cosine]]
}

/// The free coefficients of a coordinate: c, and aₖ and bₖ, or those of k ≥ 2 if the motion starts at rest.
///
/// Rest at t = 0 means Σ aₖ = 0 and Σ k bₖ = 0, which a₁ and b₁ fulfil.
#[derive(Clone, Copy, Debug)]
pub(super) struct Basis {
    pub(super) period: f64,
    pub(super) harmonics: usize,
    pub(super) from_rest: bool,
}

impl Basis {
    /// The first free harmonic.
    fn first(self) -> usize {
        if self.from_rest { 2 } else { 1 }
    }

    /// The number of free coefficients of a coordinate.
    pub(super) fn len(self) -> usize {
        1 + 2 * (self.harmonics + 1 - self.first())
    }

    /// The factors of the free coefficients in q, v and a.
    pub(super) fn factors(self, t: f64) -> [Vec<f64>; 3] {
        let one = harmonic(self.period, 1, t);
        let mut all = [vec![1.0], vec![0.0], vec![0.0]];
        for part in 0..2 {
            for k in self.first()..=self.harmonics {
                let own = harmonic(self.period, k, t);
                // a₁ = −Σ aₖ and b₁ = −Σ k bₖ.
                let ratio = match (self.from_rest, part) {
                    (false, _) => 0.0,
                    (true, 0) => 1.0,
                    (true, _) => k as f64,
                };
                for (list, (own, one)) in all.iter_mut().zip(own.iter().zip(&one)) {
                    list.push(own[part] - ratio * one[part]);
                }
            }
        }
        all
    }

    /// The series of free coefficients, one block for each coordinate.
    pub(super) fn series(self, x: &[f64]) -> FourierSeries {
        let free = self.harmonics + 1 - self.first();
        let (mut offsets, mut sines, mut cosines) = (Vec::new(), Vec::new(), Vec::new());
        for own in x.chunks_exact(self.len()) {
            let (mut sine, mut cosine) = (own[1..=free].to_vec(), own[1 + free..].to_vec());
            if self.from_rest {
                sine.insert(0, -sine.iter().sum::<f64>());
                let weighted = cosine.iter().enumerate().map(|(i, b)| (i + 2) as f64 * b);
                cosine.insert(0, -weighted.sum::<f64>());
            }
            offsets.push(own[0]);
            sines.push(sine);
            cosines.push(cosine);
        }
        FourierSeries { period: self.period, offsets, sines, cosines }
    }
}
