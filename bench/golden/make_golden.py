#!/usr/bin/env python3
"""Writes testdata/golden: robots as numbers, random states, and Pinocchio's results.

    python3 bench/golden/make_golden.py            writes every file
    python3 bench/golden/make_golden.py --check    compares with the committed files instead
    python3 bench/golden/make_golden.py panda ur5  only these

The files' fields are described in bench/golden/README.md.
"""

import argparse
import datetime
import importlib.metadata
import sys
import zlib

import environment

if __name__ == "__main__":
    environment.enter()

import numpy as np
import pinocchio as pin

import golden_file
from described_robot import describe, rebuilt
from reference import Robot, symmetric

OUT = environment.ROOT / "testdata" / "golden"

# name: (file in example-robot-data/robots, licence its package states, floating base, rotor inertias)
EXAMPLES = {
    "double_pendulum": ("double_pendulum_description/urdf/double_pendulum_continuous.urdf", "BSD", False, None),
    "ur5_example": ("ur_description/urdf/ur5_robot.urdf", "BSD", False, None),
    # The same arm with chosen rotor inertias, for the sum M + diag(I_rotor ratio^2).
    "ur5_with_rotors": ("ur_description/urdf/ur5_robot.urdf", "BSD", False, [0.6, 0.6, 0.4, 0.15, 0.1, 0.05]),
    "panda_example": ("panda_description/urdf/panda.urdf", "Apache-2.0", False, None),
    "kinova": ("kinova_description/robots/kinova.urdf", "BSD", False, None),
    "xarm7": ("xarm_description/urdf/xarm7.urdf", "BSD-3-Clause", False, None),
    "allegro_hand": ("allegro_hand_description/urdf/allegro_right_hand.urdf", "BSD", False, None),
    "baxter": ("baxter_description/urdf/baxter.urdf", "BSD", False, None),
    "tiago": ("tiago_description/robots/tiago_no_hand.urdf", "Apache-2.0", False, None),
    "pr2": ("pr2_description/urdf/pr2.urdf", "BSD", False, None),
    "solo12": ("solo_description/robots/solo12.urdf", "BSD-3-Clause", True, None),
    "anymal_c": ("anymal_c_simple_description/urdf/anymal.urdf", "BSD-3-Clause", True, None),
    "bolt": ("bolt_description/robots/bolt.urdf", "BSD-3-Clause", True, None),
    "g1": ("g1_description/urdf/g1_29dof_rev_1_0.urdf", "BSD-3-Clause", True, None),
    "talos": ("talos_data/robots/talos_reduced.urdf", "Apache-2.0", True, None),
}

# The robots of this repository with a floating root; the others are fixed to the world.
FLOATING = {"quadruped", "humanoid"}

# Above this many degrees of freedom: four states instead of eight.
LARGE = 24
# Up to this many degrees of freedom: with the regressor.
SMALL = 9


def provenance(source, licence, mimic, armature):
    """The origin of the numbers."""
    versions = {name: importlib.metadata.version(name) for name in ("pin", "example-robot-data", "numpy")}
    record = {
        "tool": "Pinocchio",
        "version": pin.__version__,
        "packages": versions,
        "command": "python3 bench/golden/make_golden.py",
        "date": datetime.date.today().isoformat(),
        "robot_file": source,
        "licence": licence,
    }
    if not source.startswith("robots/"):
        record["robot_package"] = f"example-robot-data {versions['example-robot-data']} (PyPI)"
        record["robot_note"] = "numbers of Pinocchio's model: links joined by fixed joints are one link"
    if mimic:
        record["mimic"] = "y = independent velocities, v = G y: M_y = G^T M G; Pinocchio's own mimic joints agree"
    if armature is not None:
        record["armature"] = "rotor inertias chosen here, not the maker's"
    return record


def states(robot, seed):
    """The random states and every quantity at each; the first two have more quantities."""
    rng = np.random.default_rng(seed)
    small = robot.nv <= SMALL and not robot.mimics and not robot.floating
    for index in range(4 if robot.nv > LARGE else 8):
        state = robot.random_state(rng)
        q, v, a, tau = (state[key] for key in ("q", "v", "a", "tau"))
        out = {**state, **robot.dynamics(q, v, a, tau), **robot.momentum(q, v), **robot.kinematics(q, v)}
        if index < 2:
            out |= robot.derivatives(q, v, a, tau)
            if small:
                out["joint_torque_regressor"] = robot.regressor(q, v, a)
        check_laws(robot, out)
        if index == 0:
            check_derivatives(robot, out)
        yield out


def check_laws(robot, state):
    """Laws that the numbers must satisfy to be a reference."""
    mass, v, a = state["mass_matrix"], state["v"], state["a"]
    condition = np.linalg.cond(mass)
    eps = np.finfo(float).eps
    close("T = v.M v/2", 0.5 * v @ mass @ v, state["kinetic_energy"], 1e-12)
    close("tau = M a + b", mass @ a + state["bias"], state["inverse_dynamics"], 1e-12)
    close("b = C v + g", state["coriolis_matrix"] @ v + state["gravity"], state["bias"], 1e-12)
    forward = mass @ state["forward_dynamics"] + state["bias"]
    close("forward then inverse", forward, state["tau"], 10 * condition * eps)
    close("h = A v", state["centroidal_momentum_matrix"] @ v, state["centroidal_momentum"], 1e-12)
    linear = robot.moving_mass() * state["center_of_mass_velocity"]
    close("p = m v_c", linear, state["centroidal_momentum"][:3], 1e-12)
    if "inverse_mass_matrix" in state:
        close("M M^-1", mass @ state["inverse_mass_matrix"], np.eye(robot.nv), 10 * condition * eps)


def check_derivatives(robot, state):
    """Compares derivatives along one direction, and the rates of the Jacobians, with central differences."""
    q, v, a, tau = (state[key] for key in ("q", "v", "a", "tau"))
    step = 1e-5
    direction = np.cos(np.arange(robot.nv))

    def slope(f):
        return (f(step) - f(-step)) / (2 * step)

    for name in ("inverse_dynamics", "forward_dynamics"):
        by_q = slope(lambda h, name=name: robot.dynamics(robot.integrate(q, h * direction), v, a, tau)[name])
        by_v = slope(lambda h, name=name: robot.dynamics(q, v + h * direction, a, tau)[name])
        # The error of the differences is step^2 times third derivatives, amplified by M^-1 in the forward
        # dynamics.
        close(f"{name} by q", state[f"{name}_by_q"] @ direction, by_q, 1e-5)
        close(f"{name} by v", state[f"{name}_by_v"] @ direction, by_v, 1e-5)
    for frame, rate in state["tip_jacobian_rate"].items():
        moving = slope(lambda h, f=frame: robot.kinematics(robot.integrate(q, h * v), v)["tip_jacobian"][f])
        close(f"rate of the Jacobian, {frame}", rate, moving, 1e-7)


def close(what, x, y, tolerance):
    """x = y within the tolerance, relative to the largest number."""
    scale = max(np.max(np.abs(x), initial=0), np.max(np.abs(y), initial=0))
    gap = np.max(np.abs(np.asarray(x) - y), initial=0)
    if not gap <= tolerance * scale:
        raise AssertionError(f"{what}: off by {gap:.2e} at scale {scale:.2e}")


def check_description(robot, description, state):
    """A model from the description's numbers alone moves like the robot."""
    again = rebuilt(description)
    q, v, a, tau = (state[key] for key in ("q", "v", "a", "tau"))
    values, momentum = again.dynamics(q, v, a, tau), again.momentum(q, v)
    # Pinocchio 4.1.0's kinetic energy omits the rotors of revolute joints about an oblique axis.
    energies = ("potential_energy",) if robot.model.armature.any() else ("kinetic_energy", "potential_energy")
    for key in ("mass_matrix", "bias", "gravity", "inverse_dynamics", *energies):
        close(f"description: {key}", values[key], state[key], 1e-12)
    close("description: centre of mass", momentum["center_of_mass"], state["center_of_mass"], 1e-12)


def check_own_mimic(robot, urdf, state):
    """Pinocchio's model with its own mimic joints agrees with the reduction by G."""
    arguments = (str(urdf), pin.JointModelFreeFlyer()) if robot.floating else (str(urdf),)
    own = pin.buildModelFromUrdf(*arguments, mimic=True)
    if own.nv != robot.nv:
        raise AssertionError(f"Pinocchio's mimic model has {own.nv} degrees of freedom, not {robot.nv}")
    full = dict(zip(robot.names, robot.joint_map @ state["q"][robot.base_nq :] + robot.joint_offset))
    q, order = pin.neutral(own), []
    if robot.floating:
        q[:7], order = state["q"][:7], list(range(6))
    for name, joint in zip(own.names, own.joints):
        if name in robot.independent:
            order.append(robot.base_nv + robot.independent.index(name))
            x = full[name]
            q[joint.idx_q : joint.idx_q + joint.nq] = [np.cos(x), np.sin(x)] if joint.nq == 2 else x
    v, a = state["v"][order], state["a"][order]
    data = own.createData()
    close("own mimic: M", symmetric(pin.crba(own, data, q)), state["mass_matrix"][np.ix_(order, order)], 1e-12)
    close("own mimic: tau", pin.rnea(own, data, q, v, a), state["inverse_dynamics"][order], 1e-12)


def golden(name):
    """The contents of one file."""
    if name in EXAMPLES:
        file, licence, floating, armature = EXAMPLES[name]
        urdf, source = environment.robots_folder() / file, file
    else:
        urdf, floating, armature = environment.ROOT / "robots" / f"{name}.urdf", name in FLOATING, None
        source, licence = f"robots/{name}.urdf", "this repository's own"
    robot = Robot.from_urdf(urdf, floating, armature)
    seed = zlib.crc32(name.encode())
    record = {"provenance": provenance(source, licence, robot.mimics, armature)}
    made = list(states(robot, seed))
    if name in EXAMPLES:
        record["description"] = describe(robot, name)
        check_description(robot, record["description"], made[0])
    else:
        record["urdf"] = source
        record["base"] = "Floating" if robot.floating else "Fixed"
        record["fixed_body"] = robot.fixed_body()
    if robot.mimics:
        check_own_mimic(robot, urdf, made[0])
    record |= {
        "nq": robot.nq,
        "nv": robot.nv,
        "moving_mass": robot.moving_mass(),
        "joints": robot.layout(),
        "tip": robot.model.names[robot.tip()],
        "seed": seed,
        "states": made,
    }
    return record


def main():
    """Writes or compares the files."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", help="robots to do; all when none is named")
    parser.add_argument("--check", action="store_true", help="compare with the committed files, write nothing")
    arguments = parser.parse_args()
    own = sorted(file.stem for file in (environment.ROOT / "robots").glob("*.urdf"))
    known = [*EXAMPLES, *own]
    unknown = [name for name in arguments.names if name not in known]
    if unknown:
        sys.exit(f"no robot named {', '.join(unknown)}; there are {', '.join(known)}")
    OUT.mkdir(parents=True, exist_ok=True)
    failed = 0
    for name in arguments.names or known:
        path = OUT / f"{name}.json"
        record = golden(name)
        if arguments.check:
            verdict = golden_file.compare(path, record)
            failed += not verdict.startswith("same")
        else:
            golden_file.write(path, record)
            verdict = f"{path.stat().st_size / 1024:.0f} KiB"
        print(f"{name:20} nv {record['nv']:3}  states {len(record['states'])}  {verdict}")
    if arguments.check and not arguments.names:
        stale = {file.stem for file in OUT.glob("*.json")} - set(known)
        for name in sorted(stale):
            print(f"{name:20} has a golden file but no robot any more")
        failed += len(stale)
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
