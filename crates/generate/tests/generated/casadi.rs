//! The calling convention of CasADi: called as CasADi calls it, and by CasADi itself if Python has it.

use std::process::Command;

use robot_dynamics::algorithms::gravity;
use robot_dynamics::model::Workspace;
use robot_dynamics_generate::{Arithmetic, Function, GenerateError, Precision, Request, Target, generate};

use crate::folder::Folder;
use crate::robots;

const STRICT: [&str; 8] =
    ["-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-ffp-contract=off", "-fPIC", "-shared"];

/// A caller that omits an argument and a result, and reads the shapes of a Jacobian.
const CALLER: &str = r#"
#include <stdio.h>
int robot_gravity(const double **arg, double **res, long long *iw, double *w, int mem);
const long long *robot_mass_matrix_sparsity_out(long long i);
long long jac_robot_gravity_n_in(void);
const char *jac_robot_gravity_name_out(long long i);
const long long *jac_robot_gravity_sparsity_out(long long i);
int jac_robot_gravity_work(long long *arg, long long *res, long long *iw, long long *w);
int main(void) {
    const double q[2] = {0.3, 1.2};
    double g[2], w[64];
    const double *arg[2] = {q, 0};
    double *res[1] = {g};
    long long n[4];
    robot_gravity(arg, res, 0, w, 0);
    printf("%.17g %.17g\n", g[0], g[1]);
    arg[0] = 0;
    robot_gravity(arg, res, 0, w, 0);
    printf("%.17g %.17g\n", g[0], g[1]);
    res[0] = 0;
    robot_gravity(arg, res, 0, w, 0);
    jac_robot_gravity_work(n, n + 1, n + 2, n + 3);
    printf("%lld %s %lld %lld %lld\n", jac_robot_gravity_n_in(), jac_robot_gravity_name_out(0), n[0], n[1], n[3]);
    printf("%lld %lld %lld\n", robot_mass_matrix_sparsity_out(0)[0], robot_mass_matrix_sparsity_out(0)[2], jac_robot_gravity_sparsity_out(0)[2]);
    return 0;
}
"#;

#[test]
fn the_calling_convention_is_casadis() {
    let model = robots::named("two_r.urdf");
    let request =
        Request::new(Target::Casadi, vec![Function::Gravity, Function::MassMatrix]).with_name("robot");
    let folder = Folder::of("casadi_two_r", &generate(&model, &request).unwrap());
    folder.compile("cc", &[&STRICT[..], &["-O1", "robot.c", "-lm", "-o", "robot.so"]].concat());
    std::fs::write(folder.0.join("caller.c"), CALLER).unwrap();
    folder.run("cc", &["-std=c99", "caller.c", "robot.c", "-ffp-contract=off", "-lm", "-o", "caller"]);
    let output = folder.run("./caller", &[]);
    let lines: Vec<Vec<&str>> = output.lines().map(|line| line.split(' ').collect()).collect();
    let w = &mut Workspace::<f64>::new(&model);
    for (line, q) in [(&lines[0], [0.3, 1.2]), (&lines[1], [0.0, 0.0])] {
        let mut expected = [0.0; 2];
        gravity(&model, w, &q, &mut expected);
        for (found, expected) in line.iter().zip(expected) {
            assert!((found.parse::<f64>().unwrap() - expected).abs() < 1e-13, "{output}");
        }
    }
    // Two arguments of the Jacobian: q, and the result that it does not read; 2 x 2 without zeros.
    assert_eq!(lines[2], ["2", "jac_gravity_q", "2", "1", "4"]);
    assert_eq!(lines[3], ["2", "1", "1"]);
}

/// The Python interpreter, if it has CasADi.
fn python_with_casadi() -> Option<String> {
    let python = std::env::var("PYTHON").unwrap_or_else(|_| "python3".into());
    let has_casadi = Command::new(&python).args(["-c", "import casadi"]).output();
    if has_casadi.is_ok_and(|output| output.status.success()) {
        return Some(python);
    }
    println!("left out: {python} has no CasADi");
    None
}

/// Values and Jacobians in CasADi; left out if Python has no CasADi.
#[test]
fn casadi_loads_functions_and_jacobians() {
    let Some(python) = python_with_casadi() else { return };
    let model = robots::random();
    let functions = vec![
        Function::InverseDynamics,
        Function::ForwardDynamics,
        Function::MassMatrix,
        Function::KineticEnergy,
        Function::FramePose(model.frames().last().unwrap().name.clone()),
        Function::SemiImplicitEulerStep.pullback(),
    ];
    let request = Request::new(Target::Casadi, functions).with_name("robot");
    let folder = Folder::of("casadi_random", &generate(&model, &request).unwrap());
    folder.compile("cc", &[&STRICT[..], &["-O1", "robot.c", "-lm", "-o", "robot.so"]].concat());
    assert_eq!(folder.run(&python, &["test_robot.py"]), "robot: 6 functions in 5 states, 5 Jacobians\n");
}

/// C code that CasADi writes for expressions with the functions, in the form for acados. The expressions are
/// values, Jacobian products by columns and by rows, and Jacobians, of a differential equation and of a step.
/// Each has its own file. Compiled, linked with the functions and called, it gives CasADi's own results.
const EXPRESSIONS: &str = r#"
import ctypes
import subprocess

import casadi as ca
import numpy as np

forward = ca.external("robot_forward_dynamics", "./robot.so")
step = ca.external("robot_semi_implicit_euler_step", "./robot.so")
(nq, _), (nv, _) = forward.size_in(0), forward.size_in(1)
q, v, tau = ca.MX.sym("q", nq), ca.MX.sym("v", nv), ca.MX.sym("tau", nv)
x = ca.vertcat(q, v)
columns, row = ca.MX.sym("columns", nq + nv, 3), ca.MX.sym("row", nv)
a, ends = forward(q, v, tau), ca.vertcat(*step(q, v, tau, 0.01))
functions = [
    ca.Function("value", [x, tau], [a]),
    ca.Function("by_columns", [x, tau, columns], [a, ca.jtimes(a, x, columns), ca.jacobian(a, tau)]),
    ca.Function("by_rows", [x, tau, row], [ca.jtimes(a, ca.vertcat(x, tau), row, True)]),
    ca.Function("one_step", [x, tau], [ends, ca.jacobian(ends, ca.vertcat(tau, x))]),
]
files = [function.generate(function.name() + ".c", {"casadi_int": "int"}) for function in functions]
subprocess.run(["cc", "-O1", "-fPIC", "-shared", *files, "-L.", "-lrobot", "-lm", "-o", "expressions.so"], check=True)
library = ctypes.CDLL("./expressions.so")

random = np.random.default_rng(1)
for function in functions:
    arguments = [random.uniform(-1.0, 1.0, function.size_in(k)) for k in range(function.n_in())]
    expected = [np.array(each.nonzeros()) for each in function.call([ca.DM(each) for each in arguments])]
    given = [np.asfortranarray(each) for each in arguments]
    found = [np.full(function.nnz_out(k), np.nan) for k in range(function.n_out())]
    arg = (ctypes.c_void_p * function.sz_arg())(*(each.ctypes.data for each in given))
    res = (ctypes.c_void_p * function.sz_res())(*(each.ctypes.data for each in found))
    iw, w = (ctypes.c_int * (function.sz_iw() + 1))(), (ctypes.c_double * (function.sz_w() + 1))()
    assert getattr(library, function.name())(arg, res, iw, w, 0) == 0
    for own, other in zip(found, expected):
        assert np.abs(own - other).max() <= 1e-12 * max(1.0, np.abs(other).max()), function.name()
print("{} functions, the same".format(len(functions)))
"#;

/// The workflow of acados; left out if Python has no CasADi.
#[test]
fn c_that_casadi_writes_links_with_the_functions() {
    let Some(python) = python_with_casadi() else { return };
    let functions = vec![Function::ForwardDynamics, Function::SemiImplicitEulerStep];
    let request = Request::new(Target::Casadi, functions).with_name("robot");
    let model = robots::named("gripper.urdf");
    let folder = Folder::of("casadi_linked", &generate(&model, &request).unwrap());
    folder.run("make", &["robot.so", "librobot.a"]);
    std::fs::write(folder.0.join("expressions.py"), EXPRESSIONS).unwrap();
    assert_eq!(folder.run(&python, &["expressions.py"]), "4 functions, the same\n");
    folder.run("make", &["clean"]);
    assert!(!folder.0.join("librobot.a").exists());
}

#[test]
fn single_precision_is_rejected() {
    let request = Request::new(Target::Casadi, vec![Function::Gravity])
        .with_arithmetic(Arithmetic::new(Precision::Single));
    let error = generate(&robots::named("two_r.urdf"), &request).unwrap_err();
    assert!(matches!(error, GenerateError::NotInTarget { target: "CasADi", .. }), "{error}");
}
