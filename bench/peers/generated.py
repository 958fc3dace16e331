#!/usr/bin/env python3
"""Measures generated code beside other generators' and beside Pinocchio: the same robots, the same random
states, in turns.

    python3 bench/peers/generated.py                 Panda and Talos; some minutes once built
    python3 bench/peers/generated.py --robot panda   one of them

One state: C and Rust of `dynamics generate`, the library's call, C that CppADCodeGen and CasADi write from
Pinocchio's algorithms, and Pinocchio's best build. Many states on one thread: the library's batch and
generated Rust over lanes, beside Pinocchio's best build in a loop. C is compiled by gcc and by clang with -O3
-march=native, Rust for the same processor, and by clang and rustc also without SLP vectorisation. Both of
Pinocchio's conventions are tried. The fastest program of each side counts. bench/README.md describes
measurements and noise.
"""

import argparse
import json
import os
import re
import shutil
import statistics
import subprocess
from pathlib import Path

import sides

if __name__ == "__main__":
    sides.enter()

from agreement import check, condition_numbers
from robots import ROBOTS, STATES, Robot
from run import machine, measure

OPTIMIZED = ["-O3", "-march=native", "-fno-math-errno"]
WORLD = [f"{name}@world" for name in ("forward_dynamics", "mass_matrix")]


class Variants(sides.Side):
    """A side with several programs for each robot and algorithm, of which the fastest counts."""

    def __init__(self, name, algorithms, note):
        super().__init__(name, None, None, "body", algorithms, note)
        self.programs, self.fastest = {}, {}

    def call(self, robot, algorithm, mode, value, robot_file=None):
        results, program, spelled = self.fastest[robot.name, algorithm]
        command = [program, results, robot.folder / f"states.{self.convention}.bin", spelled, mode, value]
        return run(*command)

    def check_all(self, robot, algorithm, mine, condition):
        """Exits unless every program agrees."""
        for program in self.programs[robot.name, algorithm].values():
            self.fastest[robot.name, algorithm] = program
            check(robot, [mine, self], algorithm, condition)

    def choose(self, robot, algorithm, milliseconds):
        """Tries all a few times in turn and keeps the fastest. Returns its name."""
        programs = self.programs[robot.name, algorithm]

        def time(name):
            self.fastest[robot.name, algorithm] = programs[name]
            return self.time(robot, algorithm, milliseconds)["min_ns"]

        name = sides.fastest(programs, time)
        self.fastest[robot.name, algorithm] = programs[name]
        return name


def run(*command, **options):
    """A program's output; exits with its errors if it fails."""
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False, **options)
    if done.returncode:
        raise SystemExit(f"{' '.join(map(str, command))}\n{done.stdout[-2000:]}{done.stderr[-4000:]}")
    return done.stdout


def fresh(folder):
    """An empty folder."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    return folder


def spelled(label):
    """A label as part of a file's name."""
    return re.sub(r"\W+", "_", label)


def linked(folder, name, code, results, flags):
    """{compiler: (results, program)} of generated C with its driver, by gcc and by clang, with SLP
    vectorisation and without."""
    described = folder / f"{name}.results"
    described.write_text(" ".join(map(str, results)))
    programs = {}
    clang = sides.clang()
    gcc, clang = ("gcc", "g++"), (clang.replace("++", ""), clang)
    compilers = [("gcc", gcc, []), ("clang", clang, []), ("clang, no SLP", clang, ["-fno-slp-vectorize"])]
    for label, (compiler, driver), options in compilers:
        if not shutil.which(compiler):
            continue
        program = folder / f"{name}.{spelled(label)}"
        built = folder / f"{program.name}.o"
        run("nice", compiler, *OPTIMIZED, *options, "-w", "-c", code, "-o", built)
        side = [*sides.CXX, "-w", *flags, sides.HERE / "generated_side.cpp", built, "-lm", "-o", program]
        run("nice", driver, *side)
        programs[label] = (described, program, name)
    return programs


def writer(kind):
    """The program that writes C by CppADCodeGen or CasADi, compiled once."""
    prefix, casadi = sides.site_packages() / "cmeel.prefix", sides.site_packages() / "casadi"
    flags = ["-std=c++17", "-O1", "-DNDEBUG", *sides.pinocchio_flags()]
    if kind == "casadi":
        own = ["-DCASADI", "-isystem", str(casadi / "include"), f"-L{casadi}", "-lcasadi", f"-Wl,-rpath,{casadi}"]
    else:
        own = [f"-L{prefix / 'lib'}", "-lcppad_lib", f"-Wl,-rpath,{prefix / 'lib'}", "-ldl"]
    return sides.compiled(f"writer_{kind}", "pinocchio_writer.cpp", [*flags, *own])


def add_recorded(side, kind, robot):
    """C from Pinocchio's algorithms by a recording number type, in both conventions."""
    program = writer(kind)
    for algorithm in sides.CORE:
        found = side.programs.setdefault((robot.name, algorithm), {})
        for spelled in [algorithm] + [name for name in WORLD if name.startswith(algorithm)]:
            folder = fresh(robot.folder / kind / spelled)
            run(program, robot.folder / "robot.txt", spelled, folder)
            if kind == "casadi":
                places = [int(x) for x in (folder / "entries.txt").read_text().split()]
                code, results = folder / "robot.c", [len(places), *places]
            else:
                width = robot.nv * (robot.nv + 1) // 2 if algorithm == "mass_matrix" else robot.nv
                code, results = folder / "robot_forward_zero.c", [width]
            if algorithm != "mass_matrix":
                results = results[:1]
            flags = ["-DCASADI"] if kind == "casadi" else ["-DCPPAD"]
            convention = " in the world's frame" if spelled in WORLD else ""
            for compiler, built in linked(folder, spelled, code, results, flags).items():
                found[f"{compiler}{convention}"] = built


def add_ours(c, rust, lanes, dynamics, robot):
    """C and Rust of `dynamics generate`; M without entries that are always zero."""
    functions = {"inverse_dynamics": 3, "forward_dynamics": 3, "mass_matrix_related": 1}
    base = ["--floating-base"] if robot.floating else []
    generate = [dynamics, "generate", robot.folder / "robot.urdf", *base, "--name", "robot"]
    generate += ["--functions", ",".join(functions)]
    for options, label in [(["--fused"], "fused"), (["--fused", "--platform-sine"], "fused, the system's sine")]:
        folder = fresh(robot.folder / "generated" / spelled(label))
        run(*generate, "--target", "c", *options, "-o", folder)
        source = (folder / "robot.c").read_text()
        table = re.search(r"_entries\[\d+\]\[2\] = (.*?);", source, re.DOTALL)[1]
        pairs = [tuple(map(int, pair)) for pair in re.findall(r"\{\s*(\d+),\s*(\d+)\s*\}", table)]
        places = [i * robot.nv - i * (i - 1) // 2 + j - i for i, j in pairs]
        for function, arguments in functions.items():
            algorithm = function.removesuffix("_related")
            results = [len(places), *places] if function == "mass_matrix_related" else [robot.nv]
            flags = [f"-DFUNCTION=robot_{function}", f"-DARGUMENTS={arguments}"]
            for compiler, built in linked(folder, function, folder / "robot.c", results, flags).items():
                c.programs.setdefault((robot.name, algorithm), {})[f"{compiler}, {label}"] = built
    for options, label in [([], "nothing fused"), (["--fused"], "fused")]:
        folder = fresh(robot.folder / "generated" / f"rust_{spelled(label)}")
        run(*generate, "--target", "rust", "--lanes", *options, "-o", folder)
        (folder / "src" / "bin").mkdir()
        shutil.copy(sides.HERE / "generated_side.rs", folder / "src" / "bin" / "side.rs")
        number = f'patch.crates-io.robot-dynamics-number.path="{sides.ROOT}/crates/number"'
        command = ["nice", "cargo", "build", "--release", "--offline", "--config", number, "--target-dir", folder / "target"]
        native = "-C target-cpu=native"
        for kind, flags in [("plain", ""), ("native", native), ("native, no SLP", f"{native} -C no-vectorize-slp")]:
            run(*command, cwd=folder, env=os.environ | {"RUSTFLAGS": flags})
            program = folder / f"side_{spelled(kind)}"
            shutil.copy(folder / "target" / "release" / "side", program)
            for algorithm in sides.CORE:
                single, batch = (robot.name, algorithm), (robot.name, f"{algorithm}_batch_f64")
                if kind == "plain":
                    lanes.programs.setdefault(batch, {})[label] = (program, program, batch[1])
                else:
                    rust.programs.setdefault(single, {})[f"{label}, {kind}"] = (program, program, algorithm)


def records(rows):
    """One record for each side of each row; ratios are relative to the first side."""
    for (robot, algorithm), times in rows.items():
        first = "generated lanes" if "_batch_" in algorithm else "generated C"
        for side, own in times.items():
            ratios = [peer / base for (peer, _), (base, _) in zip(own, times[first])]
            yield {
                "robot": robot,
                "algorithm": algorithm,
                "side": side,
                "ns": round(statistics.median(x for x, _ in own), 1),
                "least_ns": round(min(x for _, x in own), 1),
                "ratio": round(statistics.median(ratios), 3),
                "spread": [round(min(ratios), 3), round(max(ratios), 3)],
                "rounds": len(own),
            }


def table(title, found, algorithms, names):
    """Nanoseconds of the first side, and the peers' ratios to it."""
    print(f"\n{title}\n\n| robot | algorithm | " + " | ".join(names) + " |")
    print("|" + " --- |" * (2 + len(names)))
    rows = {}
    for record in found:
        if record["algorithm"] in algorithms:
            rows.setdefault((record["robot"], record["algorithm"]), {})[record["side"]] = record
    for (robot, algorithm), by_side in rows.items():
        cells = [robot, f"`{algorithm.removesuffix('_batch_f64')}`", f"{by_side[names[0]]['ns']:.0f}"]
        for record in map(by_side.get, names[1:]):
            low, high = record["spread"]
            cells.append(f"{record['ns']:.0f} ({record['ratio']:.2f}; {low:.2f} to {high:.2f})")
        print("| " + " | ".join(cells) + " |")


def main():
    """Builds, checks, measures, prints."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--robot", nargs="+", choices=ROBOTS, default=["panda", "talos"])
    parser.add_argument("--rounds", type=int, default=9, help="how often every side has its turn")
    parser.add_argument("--milliseconds", type=float, default=200, help="that a side is measured for in a round")
    parser.add_argument("--json", type=Path, metavar="OUT", help="the measurements go to this file as JSON lines")
    arguments = parser.parse_args()

    mine = sides.ours()
    target = os.environ.get("CARGO_TARGET_DIR", sides.ROOT / "target")
    dynamics = sides.cargo(sides.ROOT, ["-p", "robot-dynamics-cli", "--locked"], target) / "dynamics"
    native = sides.pinocchio_native()
    batches = [f"{name}_batch_f64" for name in sides.CORE]
    c = Variants("generated C", sides.CORE, "dynamics generate --target c")
    rust = Variants("generated Rust", sides.CORE, "dynamics generate --target rust, -C target-cpu=native")
    lanes = Variants("generated lanes", batches, "dynamics generate --target rust --lanes, cargo build --release")
    cppad = Variants("CppADCodeGen", sides.CORE, "of Pinocchio's algorithms, 2.4.3")
    casadi = Variants("CasADi", sides.CORE, "of Pinocchio's algorithms, 3.8.2")
    about = json.dumps({"machine": machine()})
    print(about)
    rows = {}
    for name in arguments.robot:
        robot = Robot(name, sides.CACHE)
        sides.say(f"{name}: generating and compiling")
        add_ours(c, rust, lanes, dynamics, robot)
        add_recorded(cppad, "cppad", robot)
        add_recorded(casadi, "casadi", robot)
        condition = condition_numbers(robot, mine)
        for algorithm in [*sides.CORE, *batches]:
            own = [side for side in (c, rust, lanes, cppad, casadi) if algorithm in side.algorithms]
            for side in own:
                side.check_all(robot, algorithm, mine, condition)
                print(f"{name}: {algorithm}: {side.name}: {side.choose(robot, algorithm, arguments.milliseconds / 4)}")
            check(robot, [mine, native], algorithm, condition)
            if native.has_choice(robot, algorithm):
                native.choose(robot, algorithm, arguments.milliseconds / 2)
            having = [side for side in [mine, *own, native] if algorithm in side.algorithms]
            rows[name, algorithm] = measure(robot, having, algorithm, arguments.rounds, arguments.milliseconds)
    print(f"\n{STATES} states; ns a state: the median over the rounds; in brackets how many times the first column's, median and range")
    found = list(records(rows))
    singles = ["generated C", "generated Rust", "ours", "CppADCodeGen", "CasADi", "pinocchio native"]
    table("One state", found, sides.CORE, singles)
    table("Many states, one thread", found, batches, ["generated lanes", "ours", "pinocchio native"])
    if arguments.json:
        arguments.json.write_text(about + "\n" + "".join(json.dumps(one) + "\n" for one in found))
    print(json.dumps({"load at the end": [round(x, 2) for x in os.getloadavg()]}))


if __name__ == "__main__":
    main()
