//! The extent of a run.

/// The environment variable for the extent: all, or little where the processor is emulated.
const ASKED: &str = "NATIVE_BITS";

/// The extent of a run.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Extent {
    pub(crate) random_robots: usize,
    /// The largest graph, in operations.
    pub(crate) operations: usize,
    /// The limit on the operations of all graphs of one robot. Each robot starts with another function.
    pub(crate) of_robot: usize,
    /// Whether each function, except the largest graphs, is compared both with and without fused
    /// multiply-adds; otherwise alternately.
    pub(crate) is_whole: bool,
}

impl Extent {
    /// The extent of the environment: `NATIVE_BITS=whole` includes every function of a robot,
    /// `NATIVE_BITS=few` is for emulators.
    pub(crate) fn asked() -> Self {
        match std::env::var(ASKED).as_deref() {
            Ok("whole") => {
                Self { random_robots: 200, operations: usize::MAX, of_robot: usize::MAX, is_whole: true }
            }
            Ok("few") => Self { random_robots: 6, operations: 1000, of_robot: 12_000, is_whole: false },
            Ok(other) => panic!("{ASKED}={other}: `whole` and `few` are known"),
            Err(_) => Self { random_robots: 200, operations: 30_000, of_robot: 50_000, is_whole: false },
        }
    }
}
