//! The texts of errors and panics.

use std::fmt::Write;
use std::panic::{AssertUnwindSafe, catch_unwind};

use robot_dynamics_expression::{Arithmetic, Precision, trace};
use robot_dynamics_native::{AngleOutOfRange, CompileError, Kernel, Width, best_instructions};
use robot_dynamics_number::InstructionSet;

#[test]
fn errors() {
    let errors = [
        CompileError::NoEncoder { instructions: InstructionSet::Portable },
        CompileError::NotOnThisProcessor { instructions: InstructionSet::Avx512 },
        CompileError::Precision { found: Precision::Double, expected: Precision::Single },
        CompileError::PlatformSine,
        CompileError::Argument { argument: 1, index: 7, length: 7 },
        CompileError::TooManyTables { count: 17, most: 16 },
        CompileError::TooLarge { operations: 5_000_000 },
        CompileError::Refused { cause: std::io::ErrorKind::PermissionDenied.into() },
        CompileError::Differs { result: 0, index: 3, found: 1.5, expected: 2.5 },
    ];
    let mut text = String::new();
    for error in errors {
        let kind = format!("{error:?}");
        let kind = kind.split([' ', '{']).next().unwrap_or_default();
        let _ = writeln!(text, "{kind}: {error}");
    }
    let _ = writeln!(text, "AngleOutOfRange: {AngleOutOfRange}");
    insta::assert_snapshot!(text);
}

/// Slices of wrong lengths.
#[test]
fn panics() {
    let arithmetic = Arithmetic::default();
    let (graph, results) = trace(arithmetic, &[2], |x| vec![vec![x[0][0] + x[0][1], x[0][0]]]);
    let compile =
        |width| Kernel::<f64>::compile(&graph, &results, &[2], arithmetic, best_instructions(), width).ok();
    let (Some(kernel), Some(lanes)) = (compile(Width::One), compile(Width::Lanes)) else {
        return println!("left out: there is no encoder for this processor");
    };
    let mut text = String::new();
    let mut record = |what: &str, call: &mut dyn FnMut()| {
        let panic = catch_unwind(AssertUnwindSafe(call)).expect_err("a panic");
        let owned = panic.downcast_ref::<String>().cloned();
        let message = owned.or_else(|| panic.downcast_ref::<&str>().map(|&text| text.to_owned()));
        let _ = writeln!(text, "{what}: {}", message.expect("a text"));
    };
    for (input, output, scratch) in [(1, 2, 64), (3, 2, 64), (2, 1, 64)] {
        let (input, mut output, mut scratch) = (vec![0.0; input], vec![0.0; output], vec![0.0; scratch]);
        record("one state", &mut || {
            let _ = kernel.call(&[&input], &mut [&mut output], &mut scratch);
        });
    }
    record("no argument", &mut || {
        let _ = kernel.call(&[], &mut [&mut [0.0; 2]], &mut [0.0; 64]);
    });
    record("a kernel for lanes", &mut || {
        let _ = lanes.call(&[&[0.0; 2]], &mut [&mut [0.0; 2]], &mut [0.0; 512]);
    });
    record("three rows", &mut || {
        let _ = kernel.call_rows(3, &[&[0.0; 4]], &mut [&mut [0.0; 6]], &mut [0.0; 64], |_| {});
    });
    insta::assert_snapshot!(text);
}

/// The needed length depends on the width of this machine's registers, so the text is compared without it.
#[test]
fn short_scratch_memory() {
    let arithmetic = Arithmetic::default();
    let (graph, results) = trace(arithmetic, &[1], |x| vec![vec![x[0][0] * x[0][0]]]);
    let Ok(kernel) =
        Kernel::<f64>::compile(&graph, &results, &[1], arithmetic, best_instructions(), Width::Lanes)
    else {
        return println!("left out: there is no encoder for this processor");
    };
    let needed = kernel.scratch_len();
    let mut call = || {
        let _ = kernel.call_rows(1, &[&[1.0]], &mut [&mut [0.0]], &mut [], |_| {});
    };
    let panic = catch_unwind(AssertUnwindSafe(&mut call)).expect_err("a panic");
    let message = panic.downcast_ref::<String>().expect("a text");
    insta::assert_snapshot!(message.replace(&needed.to_string(), "NEEDED"));
}
