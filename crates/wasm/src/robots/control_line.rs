//! Controls as a function of time.

/// Controls at given times, linear between them, and constant before and after.
#[derive(Clone, Debug, Default)]
pub(crate) struct ControlLine {
    pub(crate) times: Vec<f64>,
    /// One row for each time.
    pub(crate) controls: Vec<Vec<f64>>,
}

impl ControlLine {
    /// The same controls at all times.
    pub(crate) fn constant(controls: Vec<f64>) -> Self {
        Self { times: vec![0.0], controls: vec![controls] }
    }

    /// Writes the controls at a time \[s\] into `controls`.
    pub(crate) fn at(&self, time: f64, controls: &mut [f64]) {
        let after = self.times.partition_point(|t| *t <= time);
        let (Some(from), to) = (after.checked_sub(1).or(Some(0)), after) else { return };
        let (Some(before), Some(start)) = (self.controls.get(from), self.times.get(from)) else { return };
        let next = self.controls.get(to).zip(self.times.get(to));
        for (k, control) in controls.iter_mut().enumerate() {
            *control = match next {
                Some((next, end)) if end > start && time > *start => {
                    before[k] + (time - start) / (end - start) * (next[k] - before[k])
                }
                _ => before[k],
            };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::ControlLine;

    #[test]
    fn a_line_is_constant_outside_and_straight_between() {
        let line = ControlLine { times: vec![1.0, 3.0], controls: vec![vec![0.0], vec![4.0]] };
        for (time, expected) in [(0.0, 0.0), (1.0, 0.0), (1.5, 1.0), (3.0, 4.0), (9.0, 4.0)] {
            let mut found = [f64::NAN];
            line.at(time, &mut found);
            assert_eq!(found, [expected], "at {time} s");
        }
        let mut untouched = [7.0];
        ControlLine::default().at(1.0, &mut untouched);
        assert_eq!(untouched, [7.0]);
    }
}
