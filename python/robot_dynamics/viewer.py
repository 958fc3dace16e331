"""A robot in the browser, with meshcat: its links as lines from joint to joint, its inertias as boxes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from robot_dynamics.robot import Robot

# Pictures a second.
_RATE = 30.0


def show(robot: Robot, trajectory: Any, *, step: float | None, open_browser: bool) -> Any:
    """Shows it; see `Robot.show`."""
    try:
        import meshcat
        from meshcat import animation, geometry
    except ImportError as error:
        raise ImportError("the viewer needs meshcat: pip install robot-dynamics[view]") from error
    times, configurations = _configurations(robot, trajectory, step)
    viewer = meshcat.Visualizer()
    shapes = boxes(robot)
    for name, (_, size) in shapes.items():
        material = geometry.MeshLambertMaterial(color=0x4C78A8, opacity=0.75)
        viewer[f"{robot.name}/{name}"].set_object(geometry.Box(list(size)), material)
    _place(viewer, robot, shapes, configurations[0])
    if len(configurations) > 1:
        film = animation.Animation(default_framerate=_RATE)
        for k in range(int(np.floor(times[-1] * _RATE)) + 1):
            nearest = int(np.abs(times - k / _RATE).argmin())
            with film.at_frame(viewer, k) as frame:
                _place(frame, robot, shapes, configurations[nearest])
        viewer.set_animation(film)
    if open_browser:
        viewer.open()
    return viewer


def boxes(robot: Robot) -> dict[str, tuple[NDArray[np.float64], NDArray[np.float64]]]:
    """For each link with inertia the homogeneous box of the same mass and moments: link_from_box (4, 4), edges (3,) [m].

    m (b² + c²)/12 = I₁ and its like, solved for the edges; of moments that no body has, the edge is as short as a
    picture needs.
    """
    found = {}
    for link in robot.describe()["links"]:
        body = link["mass_properties"]
        if body is None or body["mass"] <= 0.0:
            continue
        xx, xy, xz, yy, yz, zz = body["inertia"]
        moments, axes = np.linalg.eigh(np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]))
        if np.linalg.det(axes) < 0.0:
            axes[:, 0] *= -1.0
        squared = 6.0 * (moments.sum() - 2.0 * moments) / body["mass"]
        edges = np.sqrt(np.maximum(squared, 1e-6))
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = axes, body["center_of_mass"]
        found[link["name"]] = (pose, edges)
    return found


def _place(viewer: Any, robot: Robot, shapes: Any, q: NDArray[np.float64]) -> None:
    poses = robot.frame_poses(q, list(shapes))
    for (name, (link_from_box, _)), pose in zip(shapes.items(), poses, strict=True):
        viewer[f"{robot.name}/{name}"].set_transform(pose @ link_from_box)


def _configurations(
    robot: Robot, trajectory: Any, step: float | None
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    if trajectory is None:
        trajectory = robot.neutral()
    if hasattr(trajectory, "times"):
        return trajectory.times, trajectory.q
    configurations = np.atleast_2d(np.asarray(trajectory, np.float64))
    if configurations.ndim != 2 or configurations.shape[1] != robot.nq:
        raise ValueError(f"a trajectory has shape (n, {robot.nq}), got {configurations.shape}")
    if len(configurations) > 1 and step is None:
        raise ValueError("say with `step` how many seconds lie between configurations")
    times: NDArray[np.float64] = np.arange(len(configurations), dtype=np.float64) * (step or 0.0)
    return times, configurations
