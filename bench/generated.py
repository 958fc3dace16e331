"""Generated C beside the library's single calls: python3 bench/generated.py ROBOT [path of `dynamics`]

Both run in turn, five times, on random states; the least time of each counts, as other programs use the machine at the same time.
The generated code is compiled with `cc -O3 -march=native` as a user would compile it for his own machine, nothing fused; the library is
the default release build, which finds the machine's instructions itself.
"""

import json
import pathlib
import subprocess
import sys
import tempfile

FUNCTIONS = ["inverse_dynamics", "forward_dynamics", "mass_matrix"]
STATES = 1000
ROUNDS = 5

DRIVER = """
#include <stdio.h>
#include <time.h>
#include "robot.h"
#define STATES %(states)d
static double q[STATES][ROBOT_NQ], v[STATES][ROBOT_NV], x[STATES][ROBOT_NV], out[ROBOT_NV * ROBOT_NV];
static double uniform(double reach) {
    static unsigned long long s = 1;
    s = s * 6364136223846793005ull + 1442695040888963407ull;
    return reach * ((double)(s >> 11) / 4503599627370496.0 - 1.0);
}
static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return 1e9 * (double)t.tv_sec + (double)t.tv_nsec;
}
#define TIME(name, call) do { \\
    double best = 1e30; \\
    for (int round = 0; round < 30; round++) { \\
        double start = now(); \\
        for (int i = 0; i < STATES; i++) { call; sink += out[0]; } \\
        double took = (now() - start) / STATES; \\
        if (took < best) best = took; \\
    } \\
    printf("%%s %%.1f\\n", name, best); \\
} while (0)
int main(void) {
    volatile double sink = 0;
    for (int i = 0; i < STATES; i++) {
        for (int k = 0; k < ROBOT_NQ; k++) q[i][k] = uniform(3.0);
        for (int k = 0; k < ROBOT_NV; k++) { v[i][k] = uniform(2.0); x[i][k] = uniform(5.0); }
    }
    TIME("inverse_dynamics", robot_inverse_dynamics(q[i], v[i], x[i], out));
    TIME("forward_dynamics", robot_forward_dynamics(q[i], v[i], x[i], out));
    TIME("mass_matrix", robot_mass_matrix(q[i], out));
    return 0;
}
"""


def run(*command, **options):
    return subprocess.run(command, check=True, capture_output=True, text=True, **options).stdout


def generated(folder):
    """Nanoseconds a call."""
    lines = run(str(folder / "driver")).split("\n")
    return {name: float(time) for name, time in (line.split() for line in lines if line)}


def library(dynamics, robot):
    """Nanoseconds a call, as `dynamics bench` measures them."""
    found = {}
    for line in run(dynamics, "bench", robot, "--quick", "--json").splitlines():
        row = json.loads(line)
        if row.get("group") == "single" and row["number"] == "f64" and row["quantity"] in FUNCTIONS:
            found[row["quantity"]] = row["ns"]
    return found


def main():
    robot = sys.argv[1]
    dynamics = sys.argv[2] if len(sys.argv) > 2 else "dynamics"
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        run(dynamics, "generate", robot, "--target", "c", "--functions", ",".join(FUNCTIONS), "--name", "robot", "-o", name)
        (folder / "driver.c").write_text(DRIVER % {"states": STATES})
        flags = ["-O3", "-march=native", "-ffp-contract=off", "-fno-math-errno"]
        run("cc", *flags, "driver.c", "robot.c", "-lm", "-o", "driver", cwd=folder)
        rounds = [(generated(folder), library(dynamics, robot)) for _ in range(ROUNDS)]
    print(f"{'':20} generated C  library  [ns, the least of {ROUNDS} rounds in turn]")
    for function in FUNCTIONS:
        ours, theirs = (min(side[function] for side in sides) for sides in zip(*rounds))
        print(f"{function:20} {ours:11.0f}  {theirs:7.0f}")


if __name__ == "__main__":
    main()
