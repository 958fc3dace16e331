//! CUDA C: its kernels compiled as C++ by the system's compiler, and run thread by thread.

use robot_dynamics::model::Model;
use robot_dynamics_generate::{Arithmetic, Function, Precision, Request, Target, generate};

use crate::folder::{Folder, summary};
use crate::robots;

/// Definitions of CUDA's extensions of C++, for one thread at a time.
const STAND_IN: &str = r"
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#define __global__
#define __device__
#define __noinline__
struct Place { int x; };
static Place blockIdx, blockDim, threadIdx;
static unsigned long long __double_as_longlong(double x) { unsigned long long n; memcpy(&n, &x, 8); return n; }
static unsigned int __float_as_int(float x) { unsigned int n; memcpy(&n, &x, 4); return n; }
enum { cudaSuccess };
static int cudaDeviceSynchronize() { return cudaSuccess; }
static int cudaGetLastError() { return cudaSuccess; }
static const char *cudaGetErrorString(int) { return 0; }
template <typename T> static int cudaMallocManaged(T **at, size_t size) { *at = (T *)malloc(size); return cudaSuccess; }
";

/// Every function in both precisions has the library's bits, on a processor.
#[test]
fn every_kernel_has_the_bits_of_the_library() {
    let model = robots::named("gripper.urdf");
    for (name, precision) in [("cuda_double", Precision::Double), ("cuda_single", Precision::Single)] {
        let output = on_processor(name, &model, robots::with_derivatives(&model), precision);
        assert_eq!(output, summary(72, false));
    }
}

/// So has a step with contact, whose sweeps are a loop, for even and odd numbers of sweeps, and its stages.
#[test]
fn a_step_with_contact_has_the_bits_of_the_library() {
    let model = robots::on_ground();
    let mut functions = Function::OF_CONTACT.to_vec();
    let of_three = Function::ContactStep { sweeps: 3 };
    functions.extend([of_three.clone(), of_three.pullback(), Function::ContactFixedPoint.pullback()]);
    for (name, precision) in [("cuda_contact", Precision::Double), ("cuda_contact_single", Precision::Single)]
    {
        assert_eq!(on_processor(name, &model, functions.clone(), precision), summary(9, false));
    }
}

/// The output of the generated test, compiled as C++ for the processor.
fn on_processor(name: &str, model: &Model, functions: Vec<Function>, precision: Precision) -> String {
    let request =
        Request::new(Target::Cuda, functions).with_arithmetic(Arithmetic::new(precision)).with_name("robot");
    let mut generated = generate(model, &request).unwrap();
    for file in &mut generated.files {
        if file.name == "test_robot.cu" {
            // A launch becomes a loop over its threads.
            let lines = file.text.lines().map(|line| match line.split_once("<<<1, ") {
                Some((kernel, rest)) => {
                    let (states, arguments) = rest.split_once(">>>").unwrap();
                    format!(
                        "for (threadIdx.x = 0; threadIdx.x < {states} + 3; threadIdx.x++) {kernel}{arguments}"
                    )
                }
                None => line.to_owned(),
            });
            file.text = format!("{STAND_IN}{}\n", lines.collect::<Vec<_>>().join("\n"));
        }
    }
    let folder = Folder::of(name, &generated);
    folder.compile("c++", &["-x", "c++", "-O0", "-Wall", "-ffp-contract=off", "test_robot.cu", "-o", "test"]);
    folder.run("./test", &[])
}

/// nvcc fuses products and sums by default. The expected values are those of the unchanged operations, so the
/// Makefile disables it.
#[test]
fn the_test_lets_nvcc_fuse_nothing() {
    let model = robots::named("two_r.urdf");
    for arithmetic in [Arithmetic::default(), Arithmetic::default().with_fused()] {
        let request = Request::new(Target::Cuda, vec![Function::Gravity]).with_arithmetic(arithmetic);
        let generated = generate(&model, &request).unwrap();
        assert!(generated.file("Makefile").unwrap().text.contains("$(NVCC) -O2 --fmad=false "));
    }
}
