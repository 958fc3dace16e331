"""Libraries for arrays beside this package: jaxsim, adam and frax under `jax.jit` and `vmap`,
pytorch_kinematics.

    pip install ./python jaxsim adam-robotics frax pytorch_kinematics      # those that are missing are left out
    python bench/peers/array_libraries.py [ROBOT] [--states N] [--rounds N] [--only NAME]

All use float64 on one core (on Linux the process is bound to it) and the same states. The compile time is the
first call minus a later one. Agreement is the largest difference from this package over the largest number of
its result. Rounds run this package and the peer in turns; ratios are within a round.
"""

import argparse
import os
import statistics
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

if hasattr(os, "sched_setaffinity"):
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
os.environ.setdefault("XLA_FLAGS", "--xla_cpu_multi_thread_eigen=false")
os.environ.setdefault("JAX_PLATFORMS", "cpu")

import numpy as np

import robot_dynamics as rd
from sdf import sdf_of

ROBOTS = Path(__file__).parents[2] / "robots"
Calls = dict[str, tuple[Callable[..., Any], tuple[str, ...]]]
"""For each quantity a function of arrays, and the arrays that it takes; for one state."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("robot", nargs="?", default="panda")
    parser.add_argument("--states", type=int, default=10_000)
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--only")
    options = parser.parse_args()
    path = ROBOTS / f"{options.robot}.urdf"
    robot = rd.load(path)
    random = np.random.default_rng(1)
    state = dict(zip(("v", "a", "tau"), random.uniform(-1, 1, (3, options.states, robot.nv)), strict=True))
    state["q"] = robot.random_configuration(options.states, seed=1)
    print(f"{robot.name}: {options.states} states, one core, median of {options.rounds} rounds")
    print("| | agreement | compiled in, s | one state, µs | many, ns each | many, over this package |")
    print("| --- | ---: | ---: | ---: | ---: | ---: |")
    for name, peer in (("jaxsim", jaxsim), ("adam", adam), ("frax", frax), ("pytorch_kinematics", pytorch_kinematics)):
        if options.only in (None, name):
            try:
                peer(robot, path, state, options.rounds)
            except (ImportError, FileNotFoundError) as error:
                print(f"{name}: not here ({error})")


def row(
    name: str, ours: Callable[[], Any], single: Callable[[], Any], many: Callable[[], Any], count: int, rounds: int
) -> None:
    """A line of the table; `single` and `many` wait for the result."""
    expected = ours()
    begun = time.perf_counter()
    found = many()
    first = time.perf_counter() - begun
    single()
    times: list[tuple[float, float]] = []
    for _ in range(rounds):
        pair = []
        for call in (ours, many):
            begun = time.perf_counter()
            call()
            pair.append(time.perf_counter() - begun)
        times.append((pair[0], pair[1]))
    calls = []
    for _ in range(20 * rounds):
        begun = time.perf_counter()
        single()
        calls.append(time.perf_counter() - begun)
    off = np.abs(np.asarray(found) - expected).max() / np.abs(expected).max()
    ratios = sorted(peer / own for own, peer in times)
    later = statistics.median(peer for _, peer in times)
    spread = f"{statistics.median(ratios):.0f} ({ratios[0]:.0f} to {ratios[-1]:.0f})"
    print(
        f"| {name} | {off:.0e} | {max(first - later, 0.0):.2f} | {statistics.median(calls) * 1e6:.1f} "
        f"| {later / count * 1e9:.0f} | {spread} |",
        flush=True,
    )


def with_jax(name: str, robot: rd.Robot, state: dict[str, Any], calls: Calls, rounds: int, vmap: Any = None) -> None:
    """The lines of a library of JAX; `vmap` if it has its own function for many states."""
    import jax

    for quantity, (function, reads) in calls.items():
        arrays = [state[each] for each in reads]
        given = [jax.numpy.asarray(array) for array in arrays]
        first = [array[0] for array in given]
        one, many = jax.jit(function), jax.jit((vmap or jax.vmap)(function))
        method = getattr(robot, quantity)
        row(
            f"{name}, {quantity}",
            lambda method=method, arrays=arrays: method(*arrays, threads=1),
            lambda one=one, first=first: one(*first).block_until_ready(),
            lambda many=many, given=given: many(*given).block_until_ready(),
            len(state["q"]),
            rounds,
        )


def jaxsim(robot: rd.Robot, path: Path, state: dict[str, Any], rounds: int) -> None:
    """JaxSim reads URDF through Gazebo's `gz`, so it gets SDF."""
    import jax

    jax.config.update("jax_enable_x64", True)
    import jaxsim.api as js

    gravity = -robot.gravity_vector[2]
    model = js.model.JaxSimModel.build_from_model_description(sdf_of(path), is_urdf=False, gravity=gravity)
    names = [joint.name for joint in robot.joints if joint.v.stop > joint.v.start]
    order = np.array([names.index(name) for name in model.joint_names()])
    back = np.argsort(order)

    def data(q: Any, v: Any) -> Any:
        return js.data.JaxSimModelData.build(model=model, joint_positions=q[order], joint_velocities=v[order])

    def inverse(q: Any, v: Any, a: Any) -> Any:
        return js.model.inverse_dynamics(model, data(q, v), joint_accelerations=a[order])[1][back]

    def mass(q: Any) -> Any:
        whole = js.model.free_floating_mass_matrix(model, data(q, 0.0 * q))
        return whole[-robot.nv :, -robot.nv :][back][:, back]

    calls: Calls = {"inverse_dynamics": (inverse, ("q", "v", "a")), "mass_matrix": (mass, ("q",))}
    if not model.floating_base():

        def forward(q: Any, v: Any, tau: Any) -> Any:
            return js.model.forward_dynamics_aba(model, data(q, v), joint_forces=tau[order])[1][back]

        calls["forward_dynamics"] = (forward, ("q", "v", "tau"))
    with_jax("jaxsim", robot, state, calls, rounds)


def adam(robot: rd.Robot, path: Path, state: dict[str, Any], rounds: int) -> None:
    """ADAM: all bases float; torques are M a + h of the joints' rows. It takes batches without `vmap`."""
    import jax

    jax.config.update("jax_enable_x64", True)
    from adam.jax import KinDynComputations

    names = [joint.name for joint in robot.joints if joint.v.stop > joint.v.start]
    gravity = np.array([*robot.gravity_vector, 0.0, 0.0, 0.0])
    tree = KinDynComputations(str(path), names, gravity=gravity)

    def base(q: Any) -> Any:
        return jax.numpy.broadcast_to(jax.numpy.eye(4), (*q.shape[:-1], 4, 4))

    def mass(q: Any) -> Any:
        return tree.mass_matrix(base(q), q)[..., 6:, 6:]

    def inverse(q: Any, v: Any, a: Any) -> Any:
        still = jax.numpy.zeros((*q.shape[:-1], 6))
        return (mass(q) @ a[..., None])[..., 0] + tree.bias_force(base(q), q, still, v)[..., 6:]

    calls: Calls = {"inverse_dynamics": (inverse, ("q", "v", "a")), "mass_matrix": (mass, ("q",))}
    with_jax("adam", robot, state, calls, rounds, lambda function: function)


def frax(robot: rd.Robot, path: Path, state: dict[str, Any], rounds: int) -> None:
    """frax."""
    import jax

    jax.config.update("jax_enable_x64", True)
    from frax import Robot

    # It needs an inertia of each link, including the base, where it has no effect.
    description = ElementTree.parse(path)
    for link in description.iter("link"):
        if link.find("inertial") is None:
            body = ElementTree.SubElement(link, "inertial")
            heavy = 1.0 if link.get("name") == robot.link_names[0] else 0.0
            ElementTree.SubElement(body, "mass", value=str(heavy))
            ElementTree.SubElement(
                body,
                "inertia",
                dict.fromkeys(("ixx", "iyy", "izz"), str(heavy)) | dict.fromkeys(("ixy", "ixz", "iyz"), "0"),
            )
    with tempfile.NamedTemporaryFile(suffix=".urdf") as file:
        description.write(file.name)
        tree = Robot(file.name)
    names = [joint.name for joint in robot.joints if joint.v.stop > joint.v.start]
    assert list(tree.joint_names)[-robot.nv :] == names, tree.joint_names

    def inverse(q: Any, v: Any, a: Any) -> Any:
        return tree.crba(q) @ a + tree.nonlinear_bias(q, v)

    calls: Calls = {
        "inverse_dynamics": (inverse, ("q", "v", "a")),
        "forward_dynamics": (lambda q, v, tau: tree.forward_dynamics(q, v, tau, None), ("q", "v", "tau")),
        "mass_matrix": (tree.mass_matrix, ("q",)),
    }
    with_jax("frax", robot, state, calls, rounds)


def pytorch_kinematics(robot: rd.Robot, path: Path, state: dict[str, Any], rounds: int) -> None:
    """pytorch_kinematics: the pose of the last frame, and its Jacobian."""
    import torch
    from pytorch_kinematics import build_serial_chain_from_urdf

    torch.set_num_threads(1)
    frame = robot.frame_names[-1]
    chain = build_serial_chain_from_urdf(path.read_bytes(), frame).to(dtype=torch.float64)
    q = torch.from_numpy(state["q"])
    with torch.no_grad():
        row(
            "pytorch_kinematics, frame_pose",
            lambda: robot.frame_pose(state["q"], frame, threads=1),
            lambda: chain.forward_kinematics(q[0]).get_matrix(),
            lambda: chain.forward_kinematics(q).get_matrix(),
            len(q),
            rounds,
        )
        row(
            "pytorch_kinematics, frame_jacobian",
            lambda: robot.frame_jacobian(state["q"], frame, threads=1),
            lambda: chain.jacobian(q[:1]),
            lambda: chain.jacobian(q),
            len(q),
            rounds,
        )


if __name__ == "__main__":
    main()
