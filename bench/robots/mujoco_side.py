"""MuJoCo's result of loading a file."""

import re

import mujoco
import numpy as np

from servant import serve

SHAPES = re.compile(rb"<(visual|collision)\b(?:[^>]*/>|.*?</\1\s*>)", re.DOTALL)


def answer(request):
    """Degrees of freedom, mass and M at qpos0; {"refused": why} if loading fails.

    Visual and collision shapes are removed first, as their meshes are missing.
    """
    try:
        with open(request["file"], "rb") as file:
            text, shapes = SHAPES.subn(b"", file.read())
        if shapes:
            model = mujoco.MjModel.from_xml_string(text.decode("utf-8"))
        else:
            model = mujoco.MjModel.from_xml_path(request["file"])
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        mass = np.zeros((model.nv, model.nv))
        if model.nv:
            mujoco.mj_fullM(model, data, mass)
        result = {"nq": model.nq, "nv": model.nv, "mass": float(np.sum(model.body_mass))}
        result["mass_matrix"] = mass.tolist()
    except Exception as error:  # noqa: BLE001: whatever the library throws is its answer
        return {"refused": f"{type(error).__name__}: {error}"}
    return result


if __name__ == "__main__":
    serve(answer)
