//! Byte offsets to line numbers.

/// The start of each line of a text.
///
/// ```
/// let lines = robot_dynamics_xml::Lines::of("a\nbc\n");
/// assert_eq!((lines.line(0), lines.line(2)), (1, 2));
/// ```
pub struct Lines {
    starts: Vec<usize>,
}

impl Lines {
    /// The lines of a text.
    pub fn of(text: &str) -> Self {
        let breaks = text.bytes().enumerate().filter(|&(_, byte)| byte == b'\n').map(|(at, _)| at + 1);
        Self { starts: core::iter::once(0).chain(breaks).collect() }
    }

    /// The line, from 1, that contains the byte.
    pub fn line(&self, byte: usize) -> usize {
        self.starts.partition_point(|&start| start <= byte)
    }
}
