"""The compared programs: building and calling each.

A cache folder has all programs, built once for each state of sources, versions and compiler.
"""

import hashlib
import json
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
CACHE = Path(os.environ.get("PEERS_CACHE", ROOT / "target" / "peers"))
REQUIREMENTS = (HERE / "requirements.txt", HERE.parent / "golden" / "requirements.txt")

# Pinocchio's list of joint types is longer than Boost's default lists.
LONG_LISTS = [
    "-DBOOST_MPL_LIMIT_LIST_SIZE=30",
    "-DBOOST_MPL_LIMIT_VECTOR_SIZE=30",
    "-DBOOST_MPL_CFG_NO_PREPROCESSED_HEADERS",
    "-DBOOST_FUSION_INVOKE_MAX_ARITY=12",
]
CXX = ["-std=c++17", "-O3", "-DNDEBUG"]
KINEMATICS = ["frame_poses", "jacobian"]
CORE = ["inverse_dynamics", "forward_dynamics", "mass_matrix"]
DERIVATIVES = ["inverse_dynamics_derivatives", "forward_dynamics_derivatives"]
SINGLE = [*CORE, "coriolis_matrix", *KINEMATICS, "jacobian_in_frame", *DERIVATIVES]
# Many states on one thread; a peer without batches calls its function for each state.
BATCHES = [
    *(f"{name}_batch_{number}" for name in CORE for number in ("f64", "f32")),
    *(f"{name}_batch_f64" for name in DERIVATIVES),
]
# The same on two threads, beside one.
THREADS = [f"{name}_batch_f64_threads" for name in CORE[:2]]
ALGORITHMS = [*SINGLE, *BATCHES, *THREADS]


def enter():
    """Returns in an interpreter with the pinned packages; restarts the script in one if needed."""
    digest = hashlib.sha256(b"".join(path.read_bytes() for path in REQUIREMENTS)).hexdigest()[:12]
    home = CACHE / f"venv-{digest}"
    python = home / "bin" / "python"
    if Path(sys.prefix).resolve() == home.resolve():
        return
    if not (home / "complete").exists():
        say(f"making {home} with the packages of {REQUIREMENTS[0].relative_to(ROOT)}")
        shutil.rmtree(home, ignore_errors=True)
        subprocess.run([sys.executable, "-m", "venv", str(home)], check=True)
        pip = [str(python), "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
        subprocess.run([*pip, "-r", str(REQUIREMENTS[0])], check=True)
        (home / "complete").touch()
    os.execv(python, [str(python), *sys.argv])


def of_one_state(algorithm):
    """The algorithm that a batch computes for each state."""
    return algorithm.split("_batch_")[0]


def say(what):
    """Prints what takes time."""
    print(what, file=sys.stderr, flush=True)


def fastest(variants, time):
    """The variant with the least time, each tried a few times in turn."""
    least = {}
    for _ in range(3):
        for variant in variants:
            least[variant] = min(time(variant), least.get(variant, float("inf")))
    return min(least, key=least.get)


class Side:
    """One program: its name, the robot's file and states that it reads, and its algorithms."""

    # If it cannot use the robot's gravity: the file for this project's program in the comparison of numbers.
    reference_file = "robot.json"

    def __init__(self, name, program, robot_file, convention, algorithms, note):
        self.name, self.program, self.note = name, program, note
        self.robot_file, self.convention, self.algorithms = robot_file, convention, algorithms

    def call(self, robot, algorithm, mode, value, robot_file=None):
        """Runs it on a prepared robot. Returns its standard output."""
        files = [
            str(robot.folder / (robot_file or self.robot_file)),
            str(robot.folder / f"states.{self.convention}.bin"),
        ]
        command = [str(self.program), *files, self.spelled(robot, algorithm), mode, str(value)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            sys.exit(f"{self.name}: {' '.join(command)}\n{done.stderr}")
        return done.stdout

    def spelled(self, _robot, algorithm):
        """The algorithm's name on the program's command line."""
        return algorithm

    def time(self, robot, algorithm, milliseconds):
        """{median_ns, min_ns, blocks}."""
        return json.loads(self.call(robot, algorithm, "time", milliseconds))


class Ours(Side):
    """This project, with a given number of threads."""

    def __init__(self, name, program, algorithms, note, threads):
        super().__init__(name, program, "robot.json", "body", algorithms, note)
        self.threads = threads

    def spelled(self, _robot, algorithm):
        return f"{algorithm}_{self.threads}" if algorithm in THREADS else algorithm


class Dynibo(Side):
    """dynibo's gravity is the constant 9.80665 m/s^2."""

    reference_file = "robot.standard_gravity.json"


class Pinocchio(Side):
    """Pinocchio has two of its algorithms in two conventions, of which the faster is measured.

    It has no lanes: its batch on one core is its single call in a loop.
    """

    def __init__(self, *arguments):
        super().__init__(*arguments)
        self.faster = {}

    def spelled(self, robot, algorithm):
        algorithm = of_one_state(algorithm)
        return self.faster.get((robot.name, algorithm), algorithm)

    def has_choice(self, robot, algorithm):
        """Whether both conventions still have to be tried."""
        algorithm = of_one_state(algorithm)
        return algorithm in ("forward_dynamics", "mass_matrix") and (robot.name, algorithm) not in self.faster

    def choose(self, robot, algorithm, milliseconds):
        """Tries both conventions, a few times in turn, and keeps the faster. Returns its name."""
        algorithm = of_one_state(algorithm)

        def time(spelling):
            self.faster[robot.name, algorithm] = spelling
            return self.time(robot, algorithm, milliseconds)["min_ns"]

        self.faster[robot.name, algorithm] = fastest((algorithm, f"{algorithm}@world"), time)
        return self.faster[robot.name, algorithm]


def clang():
    """The newest installed clang++."""
    for name in [f"clang++-{version}" for version in range(30, 13, -1)] + ["clang++"]:
        if path := shutil.which(name):
            return path
    sys.exit("clang++ is missing: apt-get install clang-19 (or clang)")


def site_packages():
    """The folder of this interpreter's packages."""
    return Path(next(path for path in sys.path if path.endswith("site-packages")))


def compiled(name, source, flags):
    """Compiles a C++ program once, with one job at low priority. Returns its path."""
    compiler = clang()
    version = subprocess.run([compiler, "--version"], capture_output=True, text=True, check=True).stdout
    processor = next((x for x in Path("/proc/cpuinfo").read_text().splitlines() if x.startswith("flags")), "")
    sources = [(HERE / file).read_bytes() for file in (source, "side.hpp", "pinocchio_robot.hpp", *(p.resolve() for p in REQUIREMENTS))]
    key = "\n".join([version, processor, *flags]).encode()
    digest = hashlib.sha256(b"".join([*sources, key])).hexdigest()[:12]
    program = CACHE / "bin" / f"{name}-{digest}"
    if program.exists():
        return program
    program.parent.mkdir(parents=True, exist_ok=True)
    say(f"compiling {program} (Pinocchio's headers take minutes and 2 to 3 GB)")
    before, part = time.monotonic(), program.with_suffix(".part")
    command = ["nice", "-n", "10", compiler, str(HERE / source), *flags, "-o", str(part)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"{' '.join(command)}\n{done.stderr[:4000]}")
    part.rename(program)
    say(f"  {time.monotonic() - before:.0f} s")
    return program


def cargo(folder, arguments, target, rustflags=None):
    """Builds a Rust program with the default release profile and `rustflags`. Returns the folder of programs.
    """
    flags = ("RUSTFLAGS", "CARGO_ENCODED_RUSTFLAGS", "CARGO_BUILD_RUSTFLAGS", "CARGO_PROFILE_")
    environment = {key: value for key, value in os.environ.items() if not key.startswith(flags)}
    environment["CARGO_TARGET_DIR"] = str(target)
    if rustflags:
        environment["RUSTFLAGS"] = rustflags
    command = ["nice", "-n", "10", "cargo", "build", "--release", "--quiet", *arguments]
    subprocess.run(command, cwd=folder, env=environment, check=True)
    return Path(target) / "release"


def ours():
    """This project's program with the default build: cargo build --release, no flags."""
    target = os.environ.get("CARGO_TARGET_DIR", ROOT / "target")
    program = cargo(ROOT, ["-p", "bench", "--bin", "peer_side", "--locked"], target) / "peer_side"
    return Ours("ours", program, ALGORITHMS, "cargo build --release, no flags", 2)


def ours_in_cpp():
    """This project's C++ layer, linked with the static library of the default build.

    It checks that its input and output are finite in every call.
    """
    target = os.environ.get("CARGO_TARGET_DIR", ROOT / "target")
    archive = cargo(ROOT, ["-p", "robot-dynamics-c", "--locked"], target) / "librobot_dynamics_c.a"
    include = ROOT / "cpp" / "include"
    # The cache names programs by their flags. Another library or header must give another program.
    parts = [archive, *sorted(path for path in include.rglob("*") if path.is_file())]
    digest = hashlib.sha256(b"".join(path.read_bytes() for path in parts)).hexdigest()[:12]
    flags = [*CXX, f"-DLIBRARY_{digest}", f"-I{include}", str(archive), "-lpthread", "-ldl", "-lm"]
    return Side(
        "ours from C++",
        compiled("robot_dynamics_cpp", "robot_dynamics_side.cpp", flags),
        *("robot.urdf", "body", [*CORE, "coriolis_matrix", "jacobian", "jacobian_in_frame", *DERIVATIVES]),
        "cpp/include, linked statically; checks its arguments and results",
    )


def one_thread(side):
    """This project with two threads beside one."""
    return Ours("ours, one thread", side.program, THREADS, "the same program", 1)


def pinocchio_flags():
    """Compiler flags of programs that include Pinocchio's headers."""
    prefix = site_packages() / "cmeel.prefix"
    return [*LONG_LISTS, "-isystem", str(prefix / "include"), "-isystem", str(prefix / "include" / "eigen3")]


def pinocchio_native():
    """Pinocchio's best build."""
    return Pinocchio(
        "pinocchio native",
        compiled("pinocchio_native", "pinocchio_side.cpp", [*CXX, *pinocchio_flags(), "-march=native"]),
        *("robot.txt", "body", [*SINGLE, *BATCHES]),
        "4.1.0, header-only, clang++ -O3 -march=native",
    )


def peers():
    """All peers, built if needed."""
    prefix, mujoco = site_packages() / "cmeel.prefix", site_packages() / "mujoco"
    library = [f"-L{prefix / 'lib'}", "-lpinocchio_default", f"-Wl,-rpath,{prefix / 'lib'}"]
    shipped = [*CXX, *pinocchio_flags(), "-DPINOCCHIO_ENABLE_TEMPLATE_INSTANTIATION", *library]
    with_mujoco = ["-isystem", str(mujoco / "include"), f"-Wl,-rpath,{mujoco}", str(mujoco / "libmujoco.so.4.0.0")]
    dynibo = CACHE / "dynibo"
    plain = cargo(HERE / "dynibo", ["--locked"], dynibo / "plain") / "dynibo_side"
    tuned = cargo(HERE / "dynibo", ["--locked"], dynibo / "native", "-C target-cpu=native") / "dynibo_side"
    return [
        ours_in_cpp(),
        Pinocchio(
            "pinocchio shipped",
            compiled("pinocchio_shipped", "pinocchio_side.cpp", shipped),
            *("robot.txt", "body", SINGLE),
            "4.1.0, the PyPI wheel's library",
        ),
        pinocchio_native(),
        Side(
            "mujoco",
            compiled("mujoco", "mujoco_side.cpp", [*CXX, *with_mujoco]),
            *("robot.xml", "mixed", [*CORE, *KINEMATICS]),
            "4.0.0, C API of the PyPI wheel, contacts off",
        ),
        Dynibo("dynibo", plain, "robot.urdf", "world", [*CORE, *KINEMATICS], "0.5.3, cargo build --release"),
        Dynibo("dynibo native", tuned, "robot.urdf", "world", [*CORE, *KINEMATICS], "0.5.3, -C target-cpu=native"),
    ]
