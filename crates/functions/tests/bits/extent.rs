//! The extent of a run.

/// The name of the variable that asks for all, or for a little where the processor is emulated.
const ASKED: &str = "NATIVE_BITS";

/// The extent of a run.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Extent {
    pub(crate) random_robots: usize,
    /// Larger graphs are left out.
    pub(crate) operations: usize,
    /// Operations of all graphs of one robot; the functions are taken in turn, from another one on for each robot.
    pub(crate) of_robot: usize,
    /// Whether each function is compared with and without fused multiply-adds, but for the largest graphs; else with or without, in turn.
    pub(crate) is_whole: bool,
}

impl Extent {
    /// By the environment: `NATIVE_BITS=whole` leaves no function of a robot out, `NATIVE_BITS=few` is for emulators.
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
