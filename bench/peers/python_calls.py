"""The cost of one call from Python: this package beside the same call from Rust, and beside Pinocchio and
MuJoCo.

    pip install ./python pin mujoco
    python bench/peers/python_calls.py [ROBOT] [--rounds N]

One state, one thread, with `out=` if supported. A number is the minimum over rounds of a hundred calls, since
other load only adds time. For batches it is the minimum of five calls. Peers that are not installed are left
out. Their numbers must agree with this package's before they are timed.
"""

import argparse
import time
import timeit
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import robot_dynamics as rd
from robot_dynamics import _native

ROBOTS = Path(__file__).parents[2] / "robots"
BATCH = 100_000


def least(call: Callable[..., Any], *arguments: Any, rounds: int, **options: Any) -> float:
    """Nanoseconds of one call, as a statement of a program."""
    names = [f"x{k}" for k in range(len(arguments))]
    given = ", ".join(names + [f"{name}={name}" for name in options])
    scope = {"call": call, **dict(zip(names, arguments, strict=True)), **options}
    return min(timeit.Timer(f"call({given})", globals=scope).repeat(rounds, 100)) * 1e7


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("robot", nargs="?", default="panda")
    parser.add_argument("--rounds", type=int, default=3000)
    options = parser.parse_args()
    robot = rd.load(ROBOTS / f"{options.robot}.urdf")
    random = np.random.default_rng(1)
    q = robot.random_configuration(seed=1)
    v, a, tau = random.uniform(-1, 1, (3, robot.nv))
    single(robot, q, v, a, tau, options.rounds)
    batches(robot, random)


def single(robot: rd.Robot, q: Any, v: Any, a: Any, tau: Any, rounds: int) -> None:
    """The table of single calls."""
    vector, matrix = np.zeros(robot.nv), np.zeros((robot.nv, robot.nv))
    frame = len(robot.frame_names) - 1
    # The names of the native quantities; a Jacobian's ends with its reference frame.
    rows: list[tuple[str, tuple[Any, ...], Any]] = [
        ("inverse_dynamics", (q, v, a), vector),
        ("forward_dynamics", (q, v, tau), vector),
        ("bias", (q, v), vector),
        ("gravity", (q,), vector),
        ("mass_matrix", (q,), matrix),
        ("coriolis_matrix", (q, v), matrix),
        ("frame_jacobian_local_world_aligned", (q, frame), np.zeros((6, robot.nv))),
        ("frame_jacobian_local", (q, frame, "local"), np.zeros((6, robot.nv))),
        ("center_of_mass", (q,), np.zeros(3)),
        ("center_of_mass_jacobian", (q,), np.zeros((3, robot.nv))),
    ]
    peers = peer_calls(robot, q, v, a, tau)
    names = list(peers)
    print(f"{robot.name}: one state, one thread [ns]")
    print(f"{'':30}{'Rust':>8}{'out=':>8}{'over':>8}{'new':>8}" + "".join(f"{name:>12}" for name in names))
    for name, arguments, out in rows:
        rust = _native._nanoseconds(robot, name, [q, v, a, tau], rounds)
        method = robot.frame_jacobian if name.startswith("frame_jacobian") else getattr(robot, name)
        given = least(method, *arguments, rounds=rounds, out=out)
        fresh = least(method, *arguments, rounds=rounds)
        line = f"{name:30}{rust:8.0f}{given:8.0f}{given - rust:8.0f}{fresh:8.0f}"
        for peer in names:
            call = peers[peer].get(name)
            line += f"{least(*call, rounds=rounds // 4):12.0f}" if call else f"{'':12}"
        print(line)
    derivatives = least(robot.forward_dynamics_derivatives, q, v, tau, rounds=rounds // 4)
    print(f"{'forward_dynamics_derivatives':30}{'':24}{derivatives:8.0f}")
    for integrator in ("semi-implicit-euler", "rk4"):
        how = {"dt": 1e-3, "integrator": integrator, "without": ("effort-limits",)}
        linearized = least(robot.linearize_step, q, v, tau, rounds=rounds // 4, **how)
        print(f"{f'linearize_step {integrator}':30}{'':24}{linearized:8.0f}")


def peer_calls(robot: rd.Robot, q: Any, v: Any, a: Any, tau: Any) -> dict[str, dict[str, tuple[Any, ...]]]:
    """The peers' calls, each compared first."""
    found: dict[str, dict[str, tuple[Any, ...]]] = {}
    path = str(ROBOTS / f"{robot.name}.urdf")
    try:
        import pinocchio as pin
    except ImportError:
        pass
    else:
        model = pin.buildModelFromUrdf(path)
        data = model.createData()
        if model.nq == robot.nq:
            np.testing.assert_allclose(pin.rnea(model, data, q, v, a), robot.inverse_dynamics(q, v, a), atol=1e-9)
            np.testing.assert_allclose(pin.aba(model, data, q, v, tau), robot.forward_dynamics(q, v, tau), atol=1e-7)
            found["pin"] = {
                "inverse_dynamics": (pin.rnea, model, data, q, v, a),
                "forward_dynamics": (pin.aba, model, data, q, v, tau),
                "bias": (pin.nonLinearEffects, model, data, q, v),
                "gravity": (pin.computeGeneralizedGravity, model, data, q),
                "mass_matrix": (pin.crba, model, data, q),
                "coriolis_matrix": (pin.computeCoriolisMatrix, model, data, q, v),
                "center_of_mass": (pin.centerOfMass, model, data, q),
                "center_of_mass_jacobian": (pin.jacobianCenterOfMass, model, data, q),
            }
            name = robot.frame_names[-1]
            frame = model.getFrameId(name)
            for reference in ("local_world_aligned", "local"):
                seen = getattr(pin, reference.upper())
                jacobian = pin.computeFrameJacobian(model, data, q, frame, seen)
                np.testing.assert_allclose(jacobian, robot.frame_jacobian(q, name, reference), atol=1e-9)
                found["pin"][f"frame_jacobian_{reference}"] = (
                    pin.computeFrameJacobian, model, data, q, frame, seen,
                )
    try:
        import mujoco
    except ImportError:
        pass
    else:
        try:
            model = mujoco.MjModel.from_xml_path(path)
        except ValueError as error:
            print(f"mujoco does not load {path}: {error}")
            return found
        model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)
        data = mujoco.MjData(model)
        if model.nq == robot.nq:
            data.qpos[:], data.qvel[:], data.qacc[:] = q, v, a
            mujoco.mj_inverse(model, data)
            if np.allclose(data.qfrc_inverse, robot.inverse_dynamics(q, v, a), atol=1e-8):
                data.qfrc_applied[:] = tau
                found["mujoco"] = {
                    "inverse_dynamics": (mujoco.mj_inverse, model, data),
                    "forward_dynamics": (mujoco.mj_forward, model, data),
                }
            else:
                print("mujoco's numbers differ (its reader changes the inertias): not timed")
    return found


def batches(robot: rd.Robot, random: Any) -> None:
    """The table of batches."""
    q = robot.random_configuration(BATCH, seed=2)
    v, a, tau = random.uniform(-1, 1, (3, BATCH, robot.nv))
    vector, matrix = np.zeros_like(v), np.zeros((BATCH, robot.nv, robot.nv))
    print(f"\n{BATCH} states [ns each]")
    print(f"{'':30}{'1 thread':>10}{f'{rd.num_threads()} threads':>12}")
    for name, arguments, out in (
        ("inverse_dynamics", (q, v, a), vector),
        ("forward_dynamics", (q, v, tau), vector),
        ("mass_matrix", (q,), matrix),
        ("inverse_dynamics float32", tuple(x.astype(np.float32) for x in (q, v, a)), vector.astype(np.float32)),
    ):
        method = getattr(robot, name.split()[0])
        times = []
        for threads in (1, None):
            rounds = []
            for _ in range(5):
                begun = time.perf_counter()
                method(*arguments, out=out, threads=threads)
                rounds.append((time.perf_counter() - begun) / BATCH * 1e9)
            times.append(min(rounds))
        print(f"{name:30}{times[0]:10.1f}{times[1]:12.1f}")


if __name__ == "__main__":
    main()
