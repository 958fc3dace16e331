"""Robot in the browser, with meshcat: its visual shapes and meshes, or its inertias as boxes."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from robot_dynamics import _native

if TYPE_CHECKING:
    from robot_dynamics.robot import Robot

# Frames per second.
_RATE = 30.0

# Default colours: red, green, blue and opacity.
_GREY = (0.62, 0.66, 0.72, 1.0)
_INERTIA = (0.95, 0.60, 0.25, 0.85)

# Half the length of the drawn part of an infinite plane [m].
_ENDLESS = 5.0


class DrawnShape(NamedTuple):
    """Drawn object on a link."""

    link: str
    """Name of the link."""
    link_from_shape: NDArray[np.float64]
    """Pose of the object in the link, with its scale (4, 4)."""
    geometry: Any
    """Geometry of meshcat."""
    color: tuple[float, float, float, float]
    """Red, green, blue and opacity, from 0 to 1."""


def show(robot: Robot, trajectory: Any, *, dt: float | None, open_browser: bool) -> Any:
    """Show a robot in the browser; see `Robot.show`.

    Parameters
    ----------
    robot : Robot
        Robot to show.
    trajectory : Motion, TimedPath or array_like, shape (n, nq) or (nq,), optional
        Configurations; default: the neutral one.
    dt : float or None
        Time between configurations of an array [s].
    open_browser : bool
        Whether to open a browser.

    Returns
    -------
    meshcat.Visualizer
        The viewer.

    Raises
    ------
    ImportError
        meshcat is missing.
    ValueError
        The trajectory has the wrong shape, or `dt` is missing.
    """
    try:
        import meshcat
        from meshcat import animation
    except ImportError as error:
        raise ImportError("the viewer needs meshcat: pip install robot-dynamics[view]") from error
    times, configurations = _configurations(robot, trajectory, dt)
    viewer = meshcat.Visualizer()
    things = drawn_shapes(robot)
    paths = [f"{robot.name}/{k}" for k in range(len(things))]
    for path, thing in zip(paths, things, strict=True):
        viewer[path].set_object(thing.geometry, _material(thing))
    _set_poses(viewer, robot, things, paths, configurations[0])
    _set_camera(viewer, robot, things, configurations)
    if len(configurations) > 1:
        film = animation.Animation(default_framerate=_RATE)
        for k in range(int(np.floor(times[-1] * _RATE)) + 1):
            nearest = int(np.abs(times - k / _RATE).argmin())
            with film.at_frame(viewer, k) as frame:
                _set_poses(frame, robot, things, paths, configurations[nearest])
        viewer.set_animation(film)
    if open_browser:
        viewer.open()
    return viewer


def drawn_shapes(robot: Robot) -> list[DrawnShape]:
    """Objects to draw: the visual shapes of each link, or its collision shapes if it has none.

    A link whose meshes all cannot be drawn is drawn as the box of its inertia. So are all links of a robot
    without shapes. A mesh cannot be drawn if its file is missing, or if meshcat does not read its format. A
    warning names it.

    Parameters
    ----------
    robot : Robot
        Robot to draw.

    Returns
    -------
    list of DrawnShape
        Objects.
    """
    description = robot.describe()
    of_links: dict[str, dict[str, list[DrawnShape]]] = {}
    missing: dict[str, str] = {}
    for shape in description["shapes"]:
        parts = list(_draw_shape(shape))
        if parts:
            of_links.setdefault(shape["link"], {}).setdefault(shape["role"], []).extend(parts)
        elif "mesh" in shape["shape"]:
            missing[shape["shape"]["mesh"]["name"]] = shape["link"]
    if missing:
        named = ", ".join(map(repr, [*missing][:3])) + (", ..." if len(missing) > 3 else "")
        text = f"robot `{robot.name}`: {len(missing)} mesh{'es' if len(missing) > 1 else ''} cannot be drawn: {named}"
        warnings.warn(_native._visible(text, False), stacklevel=4)
    things = [thing for roles in of_links.values() for thing in roles.get("visual", roles.get("collision", []))]
    without = set(missing.values()) - set(of_links)
    return things + [thing for thing in _draw_inertias(robot) if not things or thing.link in without]


def _draw_shape(shape: Any) -> Iterator[DrawnShape]:
    from meshcat import geometry

    (form, size), pose = next(iter(shape["shape"].items())), _matrix(shape["link_from_shape"])
    color = tuple(shape["color"] or _GREY)
    along_z = _rotation_about_x(np.pi / 2)  # cylinders of meshcat are along y

    def thing(made: Any, own: NDArray[np.float64] | None = None) -> DrawnShape:
        return DrawnShape(shape["link"], pose if own is None else pose @ own, made, color)

    if form == "box":
        yield thing(geometry.Box(size["size"]))
    elif form == "sphere":
        yield thing(geometry.Sphere(size["radius"]))
    elif form == "ellipsoid":
        yield thing(geometry.Sphere(1.0), np.diag([*size["half_axes"], 1.0]))
    elif form in ("cylinder", "capsule"):
        yield thing(geometry.Cylinder(size["length"], size["radius"]), along_z)
        if form == "capsule":
            for end in (-0.5, 0.5):
                at = np.eye(4)
                at[2, 3] = end * size["length"]
                yield thing(geometry.Sphere(size["radius"]), at)
    elif form == "plane":
        lengths = [2.0 * (half or _ENDLESS) for half in size["half_size"]]
        below = np.eye(4)
        below[2, 3] = -0.005
        yield thing(geometry.Box([*lengths, 0.01]), below)
    elif form == "mesh":
        made = _mesh(size["file"])
        if made is not None:
            yield thing(made, np.diag([*size["scale"], 1.0]))


def _mesh(file: str | None) -> Any:
    """Mesh of a file as meshcat reads it, or `None`."""
    from meshcat import geometry

    if file is None or not Path(file).is_file():
        return None
    kinds = {".stl": "StlMeshGeometry", ".obj": "ObjMeshGeometry", ".dae": "DaeMeshGeometry"}
    kind = kinds.get(Path(file).suffix.lower())
    return None if kind is None else getattr(geometry, kind).from_file(file)


def _draw_inertias(robot: Robot) -> Iterator[DrawnShape]:
    from meshcat import geometry

    for link, (pose, edges) in inertia_boxes(robot).items():
        yield DrawnShape(link, pose, geometry.Box(list(edges)), _INERTIA)


def _material(thing: DrawnShape) -> Any:
    from meshcat import geometry

    red, green, blue = (round(255 * min(max(part, 0.0), 1.0)) for part in thing.color[:3])
    opacity = thing.color[3]
    # STL files often have normals of 0, which meshcat draws black. Flat shading uses those of the triangles.
    flat = getattr(thing.geometry, "mesh_format", None) == "stl"
    return geometry.MeshPhongMaterial(
        color=red << 16 | green << 8 | blue, opacity=opacity, transparent=opacity < 1.0, flatShading=flat, shininess=20
    )


def _set_camera(viewer: Any, robot: Robot, things: list[DrawnShape], configurations: NDArray[np.float64]) -> None:
    """Move the camera so that all links are visible in the first and the last configuration.

    The camera looks at the world's origin.
    """
    links = sorted({thing.link for thing in things})
    if not links:
        return
    ends = robot.frame_poses(configurations[[0, -1]], links)[..., :3, 3].reshape(-1, 3)
    reach = float(np.clip(np.linalg.norm(ends, axis=1).max(), 0.3, 20.0))
    x, y, z = (reach + 0.2) * np.array([1.1, -0.9, 0.6])
    # The y axis of the camera frame points up.
    viewer["/Cameras/default/rotated/<object>"].set_property("position", [x, z, -y])


def _matrix(pose: Any) -> NDArray[np.float64]:
    """Homogeneous matrix (4, 4) of a pose of the description."""
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = pose["rotation"], pose["translation"]
    return matrix


def _rotation_about_x(angle: float) -> NDArray[np.float64]:
    matrix = np.eye(4)
    matrix[1:3, 1:3] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    return matrix


def inertia_boxes(robot: Robot) -> dict[str, tuple[NDArray[np.float64], NDArray[np.float64]]]:
    """Homogeneous box with the same mass and moments as each link.

    The edges solve m (b² + c²)/12 = I₁ and its cyclic permutations. For moments that no rigid body has, an
    edge gets a small positive length.

    Parameters
    ----------
    robot : Robot
        Robot.

    Returns
    -------
    dict of str to tuple
        For each link with inertia, link_from_box (4, 4) and the edges (3,) [m].
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


def _set_poses(viewer: Any, robot: Robot, things: list[DrawnShape], paths: list[str], q: NDArray[np.float64]) -> None:
    poses = robot.frame_poses(q, [thing.link for thing in things])
    for path, thing, pose in zip(paths, things, poses, strict=True):
        viewer[path].set_transform(pose @ thing.link_from_shape)


def _configurations(
    robot: Robot, trajectory: Any, dt: float | None
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    if trajectory is None:
        trajectory = robot.neutral()
    if hasattr(trajectory, "times"):
        return trajectory.times, trajectory.q
    configurations = np.atleast_2d(np.asarray(trajectory, np.float64))
    if configurations.ndim != 2 or configurations.shape[1] != robot.nq:
        raise ValueError(f"a trajectory must have shape (n, {robot.nq}), got {configurations.shape}")
    if len(configurations) > 1 and dt is None:
        raise ValueError("pass `dt`, the time between configurations [s]")
    times: NDArray[np.float64] = np.arange(len(configurations), dtype=np.float64) * (dt or 0.0)
    return times, configurations
