"""Write the robots of `robots/` as USD to `testdata/usd`, by the converters urdf-usd-converter and
mujoco-usd-converter.

Run it in an environment of its own: the converters bring their own build of USD, which does not work beside
the package usd-core.

    python -m venv venv
    venv/bin/pip install urdf-usd-converter==0.3.4 mujoco-usd-converter==0.8.0
    venv/bin/python bench/golden/make_usd.py
"""

import shutil
import tempfile
from pathlib import Path

import mujoco_usd_converter
import urdf_usd_converter

ROOT = Path(__file__).resolve().parents[2]
CONVERTERS = {".urdf": urdf_usd_converter, ".xml": mujoco_usd_converter}


def main() -> None:
    """Convert each robot to one binary file."""
    output = ROOT / "testdata" / "usd"
    output.mkdir(exist_ok=True)
    for robot in sorted((ROOT / "robots").iterdir()):
        converter = CONVERTERS[robot.suffix].Converter(layer_structure=False)
        with tempfile.TemporaryDirectory() as folder:
            converter.convert(str(robot), folder)
            name = f"{robot.stem}_{robot.suffix[1:]}.usdc"
            (written,) = Path(folder).glob("*.usdc")
            shutil.copyfile(written, output / name)


if __name__ == "__main__":
    main()
