"""Drake's result of loading a file."""

import logging

import numpy as np
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant

from servant import serve


class Kept(logging.Handler):
    """The warnings of one file."""

    def __init__(self):
        super().__init__(logging.WARNING)
        self.lines = []

    def emit(self, record):
        self.lines.append(record.getMessage())


def answer(request):
    """Degrees of freedom, mass and M at the default configuration; {"refused": why} if loading fails."""
    kept, log = Kept(), logging.getLogger("drake")
    log.addHandler(kept)
    log.propagate = False
    try:
        # Without a scene no geometry is read, so that missing meshes cause no error.
        plant = MultibodyPlant(0.0)
        parser = Parser(plant)
        models = parser.AddModels(request["file"])
        bodies = [body for model in models for body in plant.GetBodyIndices(model)]
        if request.get("fixed") and bodies:
            root = plant.get_body(bodies[0])
            plant.WeldFrames(plant.world_frame(), root.body_frame())
        plant.Finalize()
        context = plant.CreateDefaultContext()
        result = {"nq": plant.num_positions(), "nv": plant.num_velocities()}
        result["mass"] = float(plant.CalcTotalMass(context))
        mass = plant.CalcMassMatrix(context) if plant.num_velocities() else np.zeros((0, 0))
        result["mass_matrix"] = mass.tolist()
    # A failed check of Drake raises SystemExit.
    except (Exception, SystemExit) as error:  # noqa: BLE001
        result = {"refused": f"{type(error).__name__}: {error}"}
    finally:
        log.removeHandler(kept)
    return result | {"warned": kept.lines}


if __name__ == "__main__":
    serve(answer)
