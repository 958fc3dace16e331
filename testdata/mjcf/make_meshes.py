#!/usr/bin/env python3
"""Writes the small meshes of this folder.

They are a wedge (STL), a star prism with polygons as faces (OBJ), and a bent bar (MSH).

    python3 testdata/mjcf/make_meshes.py
"""

import math
import struct
from pathlib import Path

FOLDER = Path(__file__).resolve().parent / "meshes"


def prism(outline, height):
    """Points and outward faces of a prism over a counter-clockwise outline."""
    n = len(outline)
    points = [(x, y, z) for z in (0.0, height) for x, y in outline]
    sides = [(i, (i + 1) % n, n + (i + 1) % n, n + i) for i in range(n)]
    return points, [tuple(reversed(range(n))), tuple(range(n, 2 * n)), *sides]


def fans(faces):
    """Triangles of convex faces."""
    return [(face[0], face[k], face[k + 1]) for face in faces for k in range(1, len(face) - 1)]


def main():
    """Writes the three files."""
    FOLDER.mkdir(exist_ok=True)
    points, faces = prism([(0.0, 0.0), (0.3, 0.0), (0.1, 0.2)], 0.15)
    triangles = fans(faces)
    body = b"".join(struct.pack("<12fH", 0, 0, 0, *(x for i in face for x in points[i]), 0) for face in triangles)
    # Many binary files begin like text files.
    (FOLDER / "wedge.stl").write_bytes(b"solid wedge".ljust(80, b" ") + struct.pack("<I", len(triangles)) + body)
    lines = ["solid wedge"]
    for face in triangles:
        lines += ["facet normal 0 0 0", "outer loop"]
        lines += ["vertex %r %r %r" % points[i] for i in face]
        lines += ["endloop", "endfacet"]
    (FOLDER / "wedge_text.stl").write_text("\n".join([*lines, "endsolid wedge", ""]))
    star = [((0.2 if k % 2 else 0.08) * math.cos(k * math.pi / 5), (0.2 if k % 2 else 0.08) * math.sin(k * math.pi / 5))
            for k in range(10)]
    points, faces = prism([(0.05 + x, y - 0.02) for x, y in star], 0.1)
    lines = ["# A star: not convex, with faces of ten and of four corners.", *("v %.9g %.9g %.9g" % point for point in points)]
    lines += ["f " + " ".join(str(i + 1) for i in face) for face in faces]
    (FOLDER / "star.obj").write_text("\n".join(lines) + "\n")
    points, faces = prism([(0.0, 0.0), (0.2, 0.0), (0.2, 0.05), (0.05, 0.05), (0.05, 0.3), (0.0, 0.3)], 0.04)
    # An L from convex pieces, top and bottom.
    faces = [(1, 0, 3, 2), (3, 0, 5, 4), (6, 7, 8, 9), (6, 9, 10, 11), *faces[2:]]
    triangles = fans(faces)
    data = struct.pack("<4i", len(points), 0, 0, len(triangles))
    data += b"".join(struct.pack("<3f", *point) for point in points)
    data += b"".join(struct.pack("<3i", *face) for face in triangles)
    (FOLDER / "bar.msh").write_bytes(data)


if __name__ == "__main__":
    main()
