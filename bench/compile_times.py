#!/usr/bin/env python3
"""Measures compile times: the rows of the table in docs/performance.md.

    python3 bench/compile_times.py

Everything is built in a separate folder, from downloaded packages only.
"""

import os
import shutil
import subprocess
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent

# A user's program that moves a batch of states.
PROGRAM = """

use robot_dynamics::batch::{BatchWorkspace, Rollout, RolloutStates, Torques, rollout};
use robot_dynamics::description::{RandomRobotOptions, random_robot};
use robot_dynamics::model::{Model, neutral};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
    let (mut q, mut v) = (neutral(&model).repeat(20), vec![0.0; 20 * model.nv()]);
    let integrator = robot_dynamics::simulation::Integrator::RungeKutta4;
    let how = Rollout::new(integrator, 1e-3, 100);
    let mut workspace = BatchWorkspace::new(&model);
    rollout(&model, &mut workspace, &how, Torques::Zero, RolloutStates::ends(&mut q, &mut v), None)?;
    println!("{}", v[0]);
    Ok(())
}
"""


def seconds(folder, target, *arguments):
    """The duration of a cargo command."""
    flags = ("RUSTFLAGS", "CARGO_ENCODED_RUSTFLAGS", "CARGO_BUILD_RUSTFLAGS", "CARGO_PROFILE_", "CARGO_INCREMENTAL")
    environment = {key: value for key, value in os.environ.items() if not key.startswith(flags)}
    environment["CARGO_TARGET_DIR"] = str(target)
    start = time.monotonic()
    subprocess.run(["cargo", *arguments, "--quiet"], cwd=folder, env=environment, check=True)
    return time.monotonic() - start


def row(what, took):
    """A row of the table."""
    print(f"| {what} | {took:.0f} s |", flush=True)


def main():
    """Builds, and prints the table."""
    folder = Path(tempfile.mkdtemp(prefix="compile-times-"))
    build = ("build", "--release")
    subprocess.run(["cargo", "fetch", "--locked", "--quiet"], cwd=ROOT, check=True)
    print(f"| on {os.cpu_count()} cores | time |\n| --- | ---: |")
    try:
        target = folder / "command"
        row("the command, from nothing", seconds(ROOT, target, *build, "--locked"))
        (ROOT / "crates/cli/src/main.rs").touch()
        row("the command, after a change to its `main.rs`", seconds(ROOT, target, *build, "--locked"))
        (ROOT / "crates/core/src/algorithms/mass_matrix.rs").touch()
        row("the command, after a change to an algorithm", seconds(ROOT, target, *build, "--locked"))
        (ROOT / "crates/simulation/src/contact/cone_problem/solution.rs").touch()
        row("the command, after a change to the contact solver", seconds(ROOT, target, *build, "--locked"))
        copy = folder / "copy"
        for file in subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True).stdout.splitlines():
            (copy / file).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / file, copy / file)
        quick = ("build", "--profile", "incremental", "--locked")
        row("the command by the profile `incremental`, from nothing", seconds(copy, target, *quick))
        # A change of arithmetic: the function that writes all columns of a mass matrix.
        algorithm = copy / "crates/core/src/algorithms/mass_matrix.rs"
        text = algorithm.read_text()
        changed = text.replace("rows[5 * width] = nz;", "rows[5 * width] = nz + nz - nz;")
        assert changed != text
        algorithm.write_text(changed)
        row("the same, after a change to an algorithm", seconds(copy, target, *quick))
        user = folder / "user"
        (user / "src").mkdir(parents=True)
        shutil.copy(ROOT / "Cargo.lock", user)
        path = f'robot-dynamics = {{ path = "{ROOT / "crates/robot-dynamics"}", features = ["batch"] }}\n'
        (user / "Cargo.toml").write_text(
            f'[package]\nname = "user"\nedition = "2024"\n[dependencies]\n{path}[workspace]\n'
        )
        (user / "src/main.rs").write_text(PROGRAM)
        row("a program with a rollout, from nothing", seconds(user, folder / "program", *build))
        (user / "src/main.rs").touch()
        row("the program, after a change to it", seconds(user, folder / "program", *build))
    finally:
        shutil.rmtree(folder)


if __name__ == "__main__":
    main()
