"""Generated Rust over lanes beside the library's batches, one thread: python3 bench/generated_lanes.py ROBOT.urdf [--floating-base]

Both compute the same 1024 random states in double precision. They take turns for several rounds, each a process of its own; a round
gives the median of its calls, the table the median of the rounds and in brackets the least and the largest. The ratio is taken within
a round: above 1 the generated code is faster. First the numbers are compared. The generated code is compiled as Cargo does by default;
like the library it finds the machine's instructions when it runs. `--fused` code rounds a multiply-add once, as the library does.
"""

import argparse
import array
import os
import pathlib
import platform
import random
import statistics
import struct
import subprocess
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
FUNCTIONS = ["inverse_dynamics", "forward_dynamics", "mass_matrix", "mass_matrix_related"]
STATES = 1024

MEASURE = """
use std::time::Instant;

use robot::robot::{NQ, NV, lanes::{self, InstructionSet}};

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let bytes = std::fs::read(&arguments[1]).unwrap();
    let milliseconds: f64 = arguments[2].parse().unwrap();
    let numbers: Vec<f64> =
        bytes[32..].chunks(8).map(|x| f64::from_le_bytes(x.try_into().unwrap())).collect();
    let (mut q, mut v, mut a, mut tau) = (vec![], vec![], vec![], vec![]);
    for state in numbers.chunks(NQ + 3 * NV) {
        let mut rest = state;
        for (table, width) in [(&mut q, NQ), (&mut v, NV), (&mut a, NV), (&mut tau, NV)] {
            table.extend_from_slice(&rest[..width]);
            rest = &rest[width..];
        }
    }
    let limit = InstructionSet::best();
    let states = q.len() / NQ;
    let related = robot::robot::MASS_MATRIX_RELATED_ENTRIES.len();
    measure("inverse_dynamics", NV, states, milliseconds, &arguments[3], |out| lanes::inverse_dynamics(limit, &q, &v, &a, out));
    measure("forward_dynamics", NV, states, milliseconds, &arguments[3], |out| lanes::forward_dynamics(limit, &q, &v, &tau, out));
    measure("mass_matrix", NV * NV, states, milliseconds, &arguments[3], |out| lanes::mass_matrix(limit, &q, out));
    measure("mass_matrix_related", related, states, milliseconds, &arguments[3], |out| lanes::mass_matrix_related(limit, &q, out));
}

fn measure(name: &str, width: usize, states: usize, milliseconds: f64, folder: &str, compute: impl Fn(&mut [f64])) {
    let mut out = vec![0.0; width * states];
    compute(&mut out);
    let mut times = Vec::new();
    let start = Instant::now();
    while times.is_empty() || start.elapsed().as_secs_f64() * 1e3 < milliseconds {
        let before = Instant::now();
        compute(&mut out);
        times.push(before.elapsed().as_secs_f64() * 1e9 / states as f64);
    }
    times.sort_by(f64::total_cmp);
    println!("{name} {:.2} {:.2}", times[times.len() / 2], times[0]);
    let bytes: Vec<u8> = out.iter().flat_map(|x| x.to_le_bytes()).collect();
    std::fs::write(format!("{folder}/{name}.bin"), bytes).unwrap();
}
"""


def run(*command, **options):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, **options)
    if done.returncode:
        raise SystemExit(f"{command}:\n{done.stdout}{done.stderr}")
    return done.stdout


def target():
    return ROOT / os.environ.get("CARGO_TARGET_DIR", "target")


def build(folder, dynamics, robot, options):
    """The generated crate with the program that measures it."""
    functions = ",".join(FUNCTIONS)
    run(dynamics, "generate", robot, "--target", "rust", "--lanes", "--functions", functions, "--name", "robot", *options, "-o", folder)
    (folder / "src/bin").mkdir()
    (folder / "src/bin/measure.rs").write_text(MEASURE)
    number = f'patch.crates-io.robot-dynamics-number.path="{ROOT}/crates/number"'
    run("cargo", "build", "--release", "--offline", "--config", number, "--target-dir", folder / "target", cwd=folder)
    return folder / "target/release/measure"


def numbers(dynamics, robot, floating):
    """nq and nv."""
    with tempfile.TemporaryDirectory() as folder:
        run(dynamics, "generate", robot, *floating, "--target", "c", "--functions", "gravity", "--name", "robot", "-o", folder)
        words = (pathlib.Path(folder) / "robot.h").read_text().split()
    return int(words[words.index("ROBOT_NQ") + 1]), int(words[words.index("ROBOT_NV") + 1])


def write_states(path, nq, nv, floating):
    """Joints within 3 rad or m; a free base's quaternion x y z w has unit length."""
    draw = random.Random(2026)
    rows = array.array("d")
    for _ in range(STATES):
        q = [draw.uniform(-3, 3) for _ in range(nq)]
        if floating:
            size = sum(x * x for x in q[3:7]) ** 0.5
            q[3:7] = [x / size for x in q[3:7]]
        rows.extend(q)
        rows.extend(draw.uniform(-5, 5) for _ in range(3 * nv))
    path.write_bytes(struct.pack("<4Q", STATES, nq, nv, 0) + rows.tobytes())


def times(output):
    return {name: float(median) for name, median, _ in (line.split() for line in output.splitlines())}


def difference(one, other):
    """The largest between two files, of the largest number."""
    a, b = (array.array("d", path.read_bytes()) for path in (one, other))
    assert len(a) == len(b), f"{one} has {len(a)} numbers, {other} {len(b)}"
    return max(abs(x - y) for x, y in zip(a, b)) / max(map(abs, b))


def shown(samples):
    return f"{statistics.median(samples):.1f} ({min(samples):.1f} to {max(samples):.1f})"


def processor():
    lines = pathlib.Path("/proc/cpuinfo")
    names = [line.split(":")[1].strip() for line in lines.read_text().splitlines() if line.startswith("model name")] if lines.exists() else []
    return f"{names[0] if names else platform.processor()}, {len(names)} cores"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("robot")
    parser.add_argument("--floating-base", action="store_true")
    parser.add_argument("--dynamics", default="dynamics", help="the path of the command")
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--milliseconds", type=float, default=200, help="that each function is measured for in a round")
    arguments = parser.parse_args()
    robot = pathlib.Path(arguments.robot).resolve()
    floating = ["--floating-base"] if arguments.floating_base else []
    run("cargo", "build", "--release", "-p", "bench", "--bin", "lanes_side", cwd=ROOT)
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        states = folder / "states.bin"
        write_states(states, *numbers(arguments.dynamics, robot, floating), floating)
        sides = {}
        base = "floating" if floating else "fixed"
        library = [target() / "release/lanes_side", robot, base, states, arguments.milliseconds, folder / "library"]
        sides["library"] = library
        for side, options in [("generated", []), ("fused", ["--fused"])]:
            measure = build(folder / f"{side}_code", arguments.dynamics, robot, [*floating, *options])
            sides[side] = [measure, states, arguments.milliseconds, folder / side]
        for side in sides:
            (folder / side).mkdir()
        rounds = []
        for turn in range(arguments.rounds):
            order = list(sides)
            order = order[turn % 3 :] + order[: turn % 3]
            rounds.append({side: times(run(*sides[side])) for side in order})
        print(f"{robot.name}, {base} base, {STATES} states, one thread; {processor()}; load {os.getloadavg()[0]:.1f}")
        print("ns a state: median of rounds (least to largest); ratio: library over generated, within a round")
        print("| function | library | generated | ratio | generated, fused | ratio | largest difference |")
        print("| --- | --- | --- | --- | --- | --- | --- |")
        for function in FUNCTIONS:
            columns = [shown([one["library"][function] for one in rounds])]
            for side in ["generated", "fused"]:
                columns.append(shown([one[side][function] for one in rounds]))
                ratios = [one["library"][function] / one[side][function] for one in rounds]
                columns.append(f"{statistics.median(ratios):.2f} ({min(ratios):.2f} to {max(ratios):.2f})")
            off = max(difference(folder / side / f"{function}.bin", folder / "library" / f"{function}.bin") for side in ["generated", "fused"])
            print(f"| `{function}` | {' | '.join(columns)} | {off:.0e} |")


if __name__ == "__main__":
    main()
