//! A small seeded generator of random numbers, for tests that fail the same way each time.

/// `SplitMix64`: a 64-bit counter in steps of the golden ratio, passed through a mixing function.
///
/// One word of state, period 2⁶⁴, the same numbers on every machine. It is good enough to draw test states
/// and is not meant for cryptography.
///
/// Source: Steele, Lea, Flood, *Fast splittable pseudorandom number generators* (OOPSLA 2014), fig. 14.
///
/// ```
/// use robot_dynamics_number::SplitMix64;
/// let (mut a, mut b) = (SplitMix64::new(7), SplitMix64::new(7));
/// assert_eq!(a.uniform(-1.0, 1.0), b.uniform(-1.0, 1.0));
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SplitMix64 {
    state: u64,
}

impl SplitMix64 {
    /// The generator that starts at `seed`; equal seeds give equal sequences.
    ///
    /// ```
    /// use robot_dynamics_number::SplitMix64;
    /// assert_eq!(SplitMix64::new(7).next_u64(), SplitMix64::new(7).next_u64());
    /// assert_ne!(SplitMix64::new(7).next_u64(), SplitMix64::new(8).next_u64());
    /// ```
    pub fn new(seed: u64) -> Self {
        Self { state: seed }
    }

    /// The next 64 random bits.
    ///
    /// ```
    /// // As published with the algorithm.
    /// assert_eq!(robot_dynamics_number::SplitMix64::new(1_234_567).next_u64(), 6_457_827_717_110_365_317);
    /// ```
    pub fn next_u64(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number in [low, high), made of the top 53 bits: every value is a multiple of 2⁻⁵³ of the range.
    ///
    /// ```
    /// let mut random = robot_dynamics_number::SplitMix64::new(7);
    /// let mean = (0..10_000).map(|_| random.uniform(0.0, 1.0)).sum::<f64>() / 10_000.0;
    /// assert!((mean - 0.5).abs() < 0.012); // four standard deviations, 4/√(12·10⁴)
    /// ```
    ///
    /// # Panics
    /// If `low > high`, or if either is not finite.
    pub fn uniform(&mut self, low: f64, high: f64) -> f64 {
        assert!(low <= high && (high - low).is_finite(), "invalid range [{low}, {high})");
        let unit = (self.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
        low + (high - low) * unit
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The sequence of seed 1234567 as published with the algorithm's reference implementations.
    #[test]
    fn follows_the_published_sequence() {
        let mut random = SplitMix64::new(1_234_567);
        let expected = [6457827717110365317, 3203168211198807973, 9817491932198370423];
        assert_eq!(expected.map(|_| random.next_u64()), expected);
    }

    /// The mean of n uniform numbers is 1/2 ± 1/√(12 n); four standard deviations at n = 1e4 are 0.0116.
    #[test]
    fn uniform_numbers_fill_their_range() {
        let mut random = SplitMix64::new(1);
        let sample: Vec<f64> = (0..10_000).map(|_| random.uniform(0.0, 1.0)).collect();
        assert!(sample.iter().all(|x| (0.0..1.0).contains(x)));
        let mean = sample.iter().sum::<f64>() / 1e4;
        assert!((mean - 0.5).abs() < 0.0116, "mean {mean}");
    }

    #[test]
    #[should_panic(expected = "[1, 0)")]
    fn an_empty_range_is_refused() {
        SplitMix64::new(0).uniform(1.0, 0.0);
    }
}
