//! The cost of generated code on this machine: bytes of code, of stack, and time compared with the library's.

mod compilation;
mod driver;
mod timing;

use std::fmt::Write;
use std::hint::black_box;
use std::path::Path;

use robot_dynamics::model::{Model, Workspace};
use robot_dynamics::quantity::{Inputs, Quantity, QuantityMemory};
use robot_dynamics::text::markdown;
use robot_dynamics_expression::Precision;
use robot_dynamics_functions::FunctionMemory;
use robot_dynamics_number::Scalar;

use self::compilation::Measurements;
use self::timing::fastest;
use crate::generated_files::GeneratedFile;
use crate::generation::prepare;
use crate::heading::{MARK, commented, lines};
use crate::program::{Case, Program};
use crate::{Function, GenerateError, Request, Target};

/// Compiles the functions of a request by this machine's compiler, `cc` for C and `rustc` for Rust, and
/// measures them. Returns a table `MEASURED.md` with each function's code and stack, the time of one call,
/// and that of the library's call with the same name.
///
/// Unlike the output of [`generate`](crate::generate()), the table differs from machine to machine. `folder`
/// receives the compiled files and is created if it is missing.
///
/// The size of code is that of the symbol table, of all parts of a function; the shared sine is listed
/// separately. The size of stack is the largest depth of a call and its callees. In C it comes from the
/// compiler's `-fstack-usage`; in Rust, on x86-64, from the instructions that change the stack pointer.
/// Values that a compiler does not report are left blank. The library's time is that of its fastest call on
/// one thread, with an allocated workspace; derivatives and pullbacks that it lacks are left blank.
///
/// ```
/// use robot_dynamics_generate::{Function, GenerateError, Request, Target, measure};
/// let model = robot_dynamics::model::Model::new(robot_dynamics::description::pendulum(2.0, 0.5))?;
/// let folder = std::env::temp_dir().join(format!("measured-{}", std::process::id()));
/// match measure(&model, &Request::new(Target::C, vec![Function::Gravity]), &folder) {
///     Ok(measured) => assert!(measured.text.contains("| gravity |")),
///     Err(GenerateError::Compiler { .. }) => {} // this machine has none
///     Err(other) => return Err(other.into()),
/// }
/// # std::fs::remove_dir_all(folder).ok();
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// Those of [`generate`](crate::generate()); [`GenerateError::NotInTarget`] for targets that another program
/// calls; [`GenerateError::Compiler`] if the compiler is missing or fails.
pub fn measure(model: &Model, request: &Request, folder: &Path) -> Result<GeneratedFile, GenerateError> {
    if !matches!(request.target, Target::C | Target::Rust) {
        let remedy = "measure the same functions for the targets c or rust";
        return Err(GenerateError::NotInTarget {
            target: request.target.name(),
            what: "measurement",
            remedy,
        });
    }
    // A call over lanes computes many states.
    let request = &Request { lanes: false, ..request.clone() };
    let prepared = prepare(model, request)?;
    prepared.written(model, request).write(folder)?;
    let compiled = compilation::compile(request, &prepared, folder)?;
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
    compiled: &Measurements,
) -> Result<String, GenerateError> {
    let shown = |x: Option<usize>| x.map_or(String::new(), |x| x.to_string());
    let own = compiled.of(&program.symbol);
    let library = match request.arithmetic.precision {
        Precision::Double => match time_of_quantity(model, program) {
            None => time_of_library_call::<f64>(model, program, |x| x)?,
            found => found,
        },
        #[allow(clippy::cast_possible_truncation)] // they are singles
        Precision::Single => time_of_library_call::<f32>(model, program, |x| x as f32)?,
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

/// Nanoseconds of the library's call by its table of quantities, if it has the function. The table is
/// compiled optimized with the library; this crate is not.
fn time_of_quantity(model: &Model, program: &Program) -> Option<f64> {
    let quantity = match &program.function {
        Function::MassMatrixRelated => Quantity::MassMatrix,
        // M is one of the results here.
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
    Some(fastest(|count| {
        for k in 0..count {
            let inputs = black_box(&states[k % states.len()]);
            quantity.compute(model, &mut workspace, inputs, black_box(&mut memory));
        }
    }))
}

/// The argument of that name in a case; empty if the function lacks it.
fn argument<'a>(program: &Program, case: &'a Case, name: &str) -> &'a [f64] {
    let at = program.arguments.iter().position(|argument| argument.name == name);
    at.map_or(&[], |at| &case.arguments[at])
}

/// Nanoseconds of the library's call, on the machine's best registers, if it has one.
fn time_of_library_call<S: Scalar>(
    model: &Model,
    program: &Program,
    number: impl Fn(f64) -> S + Copy,
) -> Result<Option<f64>, GenerateError> {
    // Its numbers are entries of M, which is what the library computes.
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
    Ok(Some(fastest(|count| {
        for k in 0..count {
            black_box(memory.compute(black_box(&given[k % given.len()])));
        }
    })))
}

#[cfg(test)]
mod tests;
