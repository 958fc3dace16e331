//! Random calls with random handles, lengths, pointers and numbers: no crash, no panic, and no write beyond
//! the outputs.
//!
//! Unsafe code: the interface takes pointers. Those of this program are null, or point into one block of
//! memory that holds as many numbers as the length says, or the length is more than memory has.
#![allow(unsafe_code)]
// Random bits become numbers of any type.
#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap)]

#[macro_use]
#[path = "../common/mod.rs"]
mod common;
mod calls;
mod handles;
mod makers;
mod memory;

use std::collections::BTreeMap;
use std::sync::Mutex;

use common::Robot;
use memory::Fuzz;
use robot_dynamics::description::{Base, JointKinds, RandomRobotOptions, random_robot};
use robot_dynamics::{Format, write};
use robot_dynamics_c::Status;

/// The panics of the library: a query hides the status.
static PANICS: Mutex<Vec<String>> = Mutex::new(Vec::new());

/// An arm, a robot with loops, a floating robot, and a robot without motion.
fn robots() -> Vec<Robot> {
    let options = RandomRobotOptions {
        kinds: JointKinds::Turning,
        joints: 2,
        base: Base::Floating,
        ..RandomRobotOptions::default()
    };
    let floating = write(&random_robot(2, &options), Format::Mjcf, None).expect("a text").text;
    let rigid = "<robot name='rigid'><link name='base'/></robot>";
    let load = |name| Robot::load(name, false);
    vec![
        load("robots/three_r.urdf"),
        load("robots/linkage.xml"),
        Robot::from_text(&floating),
        Robot::from_text(rigid),
    ]
}

/// Makes calls from a seed. Returns how often each status occurred.
fn run(seed: u64, calls: usize) -> BTreeMap<i32, usize> {
    std::panic::set_hook(Box::new(|info| {
        if info.location().is_some_and(|place| place.file().contains("tests")) {
            eprintln!("{info}");
            return;
        }
        PANICS.lock().unwrap_or_else(std::sync::PoisonError::into_inner).push(info.to_string());
    }));
    let robots = robots();
    let mut fuzz = Fuzz::new(seed, &robots);
    let (mut statuses, mut faults) = (BTreeMap::new(), BTreeMap::new());
    for call in 0..calls {
        let (name, status) = calls::random(&mut fuzz);
        *statuses.entry(status as i32).or_default() += 1;
        assert!(fuzz.outside_is_untouched(), "call {call}, {name}, wrote beyond its outputs");
        let panics = std::mem::take(&mut *PANICS.lock().expect("a list"));
        for panic in panics {
            *faults.entry((name, panic)).or_insert(0) += 1;
        }
        if status == Status::Panic {
            faults.entry((name, common::message())).or_insert(0);
        }
    }
    fuzz.free_all();
    assert!(faults.is_empty(), "seed {seed}: {faults:#?}");
    statuses
}

/// Most of the calls are valid enough to reach the library, and many kinds of errors occur.
fn check(statuses: &BTreeMap<i32, usize>, calls: usize) {
    let of = |status: Status| statuses.get(&(status as i32)).copied().unwrap_or_default();
    assert_eq!(of(Status::Panic), 0);
    assert!(of(Status::Ok) > calls / 5, "{statuses:?}");
    for status in [Status::InvalidInput, Status::InvalidHandle, Status::UnknownName, Status::File] {
        assert!(of(status) > 0, "{status:?} in {statuses:?}");
    }
}

#[test]
fn million_random_calls_neither_panic_nor_write_beyond_outputs() {
    for seed in 1..=10 {
        let statuses = run(seed, 100_000);
        println!("seed {seed}: {statuses:?}");
        check(&statuses, 100_000);
    }
}
