"""The robots of the benchmarks, for this library and for MuJoCo."""

import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from starts import AMPLITUDE, control_amplitudes

import robot_dynamics as rd

ROBOTS = Path(__file__).resolve().parents[2] / "robots"


@dataclass
class Scene:
    """One robot with its ground."""

    name: str
    robot: rd.Robot
    options: dict[str, Any]
    """Options of `SimulationBatch`: the ground, the time step, disabled effects."""
    model: mujoco.MjModel
    inputs: str
    """`controls` of the file's motors, or `torques` of the joints if the file has none."""
    amplitudes: np.ndarray
    """The largest absolute value of each input."""

    @property
    def field(self) -> str:
        """Name of MuJoCo's field for the inputs."""
        return "ctrl" if self.inputs == "controls" else "qfrc_applied"


def scene(path: Path) -> Scene:
    """The scene of a file: MJCF with its own ground and time step, or URDF above a plane at 2 ms."""
    if path.suffix == ".urdf":
        return _urdf(path)
    robot, model = rd.load(path), mujoco.MjModel.from_xml_path(str(path))
    model.opt.cone = mujoco.mjtCone.mjCONE_ELLIPTIC  # the only cones of this library
    options = {"dt": float(model.opt.timestep)}
    return Scene(path.name, robot, options, model, "controls", control_amplitudes(model))


def _urdf(path: Path) -> Scene:
    """A URDF robot that touches only the ground; MuJoCo reads the file that this library writes."""
    robot = rd.load(path, floating_base=True)
    with tempfile.TemporaryDirectory() as folder:
        written = Path(folder) / "robot.xml"
        robot.write(written)
        spec = mujoco.MjSpec.from_file(str(written))
    spec.worldbody.add_geom(name="the ground", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0, 0, 1])
    spec.compiler.fusestatic = True  # fixed links are part of their parents, as in this library
    model = spec.compile()
    plane = model.geom("the ground").id
    for shape in range(model.ngeom):
        touches = bool(model.geom_contype[shape] or model.geom_conaffinity[shape])
        moves = model.body_weldid[model.geom_bodyid[shape]] != 0
        model.geom_contype[shape] = int(touches and moves)
        model.geom_conaffinity[shape] = int(shape == plane)
    model.opt.timestep, model.opt.cone = 0.002, mujoco.mjtCone.mjCONE_ELLIPTIC
    options = {"dt": 0.002, "ground": rd.Ground(), "without": ["link-contacts"]}
    efforts = np.asarray(robot.limits.effort, float)
    amplitudes = 0.2 * AMPLITUDE * np.where(np.isfinite(efforts), efforts, 0.0)
    return Scene(path.name, robot, options, model, "torques", amplitudes)
