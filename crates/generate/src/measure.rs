//! What generated code costs on this machine: bytes of code, of stack, and time beside the library's.

mod compile;
mod driver;

use std::fmt::Write;
use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

use expression::Precision;
use functions::FunctionMemory;
use multibody::text::markdown;
use multibody::{Inputs, Model, Quantity, QuantityMemory, Workspace};
use number::Scalar;

use self::compile::Compiled;
use crate::heading::{MARK, commented, lines};
use crate::program::{Case, Program};
use crate::request::{GeneratedFile, prepare};
use crate::{Function, GenerateError, Request, Target};

/// Runs of each function of which the fastest counts, and how long one lasts at least [s].
const RUNS: usize = 7;
const LASTING: f64 = 0.004;

/// Compiles the functions of a request by this machine's compiler, `cc` for C and `rustc` for Rust, and measures them: a table `MEASURED.md` with
/// each function's code and stack, the time of one call, and that of the library's call with the same name.
///
/// Unlike what [`generate`](crate::generate()) gives it differs from machine to machine. `folder` gets the files that are compiled, and is made
/// where it is missing.
///
/// Code is what the symbol table says, of a function in parts all of it; the sine that all share is told apart. Stack is the most that a
/// call takes, with what it calls: of C by the compiler's `-fstack-usage`, of Rust, on x86-64, by the code's own stores to the
/// stack pointer. What a compiler does not tell is left blank. The library's time is that of its best call on one thread,
/// its workspace made before; derivatives and pullbacks that it has not are left blank.
///
/// ```
/// use generate::{Function, GenerateError, Request, Target, measure};
/// let model = multibody::Model::new(multibody::pendulum(2.0, 0.5))?;
/// let folder = std::env::temp_dir().join(format!("measured-{}", std::process::id()));
/// match measure(&model, &Request::new(Target::C, vec![Function::Gravity]), &folder) {
///     Ok(measured) => assert!(measured.text.contains("| gravity |")),
///     Err(GenerateError::Compiler { .. }) => {} // there is none here
///     Err(other) => return Err(other.into()),
/// }
/// # std::fs::remove_dir_all(folder).ok();
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// Those of [`generate`](crate::generate()); [`GenerateError::NotInTarget`] of targets that are called by another program;
/// [`GenerateError::Compiler`] where there is none, or it refuses.
pub fn measure(model: &Model, request: &Request, folder: &Path) -> Result<GeneratedFile, GenerateError> {
    if !matches!(request.target, Target::C | Target::Rust) {
        let remedy = "measure the targets c or rust of the same functions";
        return Err(GenerateError::NotInTarget {
            target: request.target.name(),
            what: "measurement",
            remedy,
        });
    }
    // Over lanes a call is one of many states.
    let request = &Request { lanes: false, ..request.clone() };
    let prepared = prepare(model, request)?;
    prepared.written(model, request).write(folder)?;
    let compiled = compile::compile(request, &prepared, folder)?;
    let mut text = format!("# {}, measured\n\n", markdown(model.name()));
    text += &commented("   ", &lines(model, request));
    let _ = write!(
        text,
        "\n{MARK}: by {}, {} on {}.\n\n| function | code, bytes | stack, bytes | a call, ns | the library's, ns | times |\n\
         | --- | ---: | ---: | ---: | ---: | ---: |\n",
        compiled.by,
        std::env::consts::ARCH,
        std::env::consts::OS,
    );
    for program in &prepared.programs {
        text += &row(model, request, program, &compiled)?;
    }
    if let Some(bytes) = compiled.sine {
        let _ = write!(
            text,
            "\nThe sine is {bytes} bytes of code more, once; where it is inlined it is counted with the functions.\n"
        );
    }
    text += "\nCode without its constants. Stack with what is called. Times are the least of some runs over the test's states, and those \
             of another day or machine differ.\n";
    Ok(GeneratedFile::new("MEASURED.md", text))
}

fn row(
    model: &Model,
    request: &Request,
    program: &Program,
    compiled: &Compiled,
) -> Result<String, GenerateError> {
    let shown = |x: Option<usize>| x.map_or(String::new(), |x| x.to_string());
    let own = compiled.of(&program.symbol);
    let library = match request.arithmetic.precision {
        Precision::Double => match of_table(model, program) {
            None => librarys::<f64>(model, program, |x| x)?,
            found => found,
        },
        #[allow(clippy::cast_possible_truncation)] // they are singles
        Precision::Single => librarys::<f32>(model, program, |x| x as f32)?,
    };
    let time = |x: Option<f64>| x.map_or(String::new(), |x| format!("{x:.1}"));
    let times = library.zip(own.time).map_or(String::new(), |(library, own)| format!("{:.2}", library / own));
    Ok(format!(
        "| {} | {} | {} | {} | {} | {times} |\n",
        markdown(&program.function.to_string()),
        shown(own.code),
        shown(own.stack),
        time(own.time),
        time(library)
    ))
}

/// Nanoseconds of the library's call by its table of quantities, if it is there: that is compiled with the library, at its best, where
/// this crate is not.
fn of_table(model: &Model, program: &Program) -> Option<f64> {
    let quantity = match &program.function {
        Function::MassMatrixRelated => Quantity::MassMatrix,
        // M is among the results here.
        Function::InverseDynamicsDerivatives => return None,
        function => Quantity::named(&function.stem())?,
    };
    let frames: Vec<_> = program.function.frame().and_then(|name| model.frame(name)).into_iter().collect();
    let state = |case| {
        let of = |name| argument(program, case, name);
        Inputs { q: of("q"), v: of("v"), a: of("a"), tau: of("tau"), frames: &frames }
    };
    let states: Vec<Inputs<'_>> = program.cases.iter().map(state).collect();
    let (mut workspace, mut memory) = (Workspace::new(model), QuantityMemory::new(model));
    Some(least(|count| {
        for k in 0..count {
            let inputs = black_box(&states[k % states.len()]);
            quantity.compute(model, &mut workspace, inputs, black_box(&mut memory));
        }
    }))
}

/// The argument of that name in a case; nothing where the function has none.
fn argument<'a>(program: &Program, case: &'a Case, name: &str) -> &'a [f64] {
    let at = program.arguments.iter().position(|argument| argument.name == name);
    at.map_or(&[], |at| &case.arguments[at])
}

/// Nanoseconds of the library's call, on the machine's best registers, where it has one.
fn librarys<S: Scalar>(
    model: &Model,
    program: &Program,
    number: impl Fn(f64) -> S + Copy,
) -> Result<Option<f64>, GenerateError> {
    // Its numbers in a row are taken from M, which is what is computed.
    let function = match &program.function {
        Function::MassMatrixRelated => &Function::MassMatrix,
        function if function.is_through_graph() => return Ok(None),
        function => function,
    };
    let rows = |row: &Vec<f64>| row.iter().map(|&x| number(x)).collect();
    let states: Vec<Vec<Vec<S>>> =
        program.cases.iter().map(|case| case.arguments.iter().map(rows).collect()).collect();
    let given: Vec<Vec<&[S]>> =
        states.iter().map(|state| state.iter().map(Vec::as_slice).collect()).collect();
    let mut memory = FunctionMemory::new(function, model)?;
    Ok(Some(least(|count| {
        for k in 0..count {
            black_box(memory.compute(black_box(&given[k % given.len()])));
        }
    })))
}

/// Nanoseconds of one of some calls.
fn least(mut calls: impl FnMut(usize)) -> f64 {
    let mut time = |count: usize| {
        let start = Instant::now();
        calls(count);
        start.elapsed().as_secs_f64()
    };
    let mut count = 1;
    while time(count) < LASTING {
        count *= 2;
    }
    #[allow(clippy::cast_precision_loss)] // calls of a few milliseconds
    let one = |time: f64| 1e9 * time / count as f64;
    (0..RUNS).map(|_| one(time(count))).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests;
