"""A URDF as SDF, for programs that read only SDF: moving joints, masses and limits, without shapes."""

from pathlib import Path
from xml.etree import ElementTree

NOWHERE = "0 0 0 0 0 0"
# A fixed joint has no axis, but some readers want one.
NO_AXIS = "<axis><xyz>0 0 1</xyz><limit/></axis>"


def sdf_of(path: Path) -> str:
    """The robot of a URDF as SDF text, with its first link fixed to the world; links without mass get 1e-9 kg
    and kg·m²."""
    urdf = ElementTree.parse(path).getroot()
    joints = {child(joint): joint.get("name", "") for joint in urdf.findall("joint")}
    parts = []
    for link in urdf.findall("link"):
        name, body = link.get("name", ""), link.find("inertial")
        at = f' relative_to="{joints[name]}"' if name in joints else ""
        parts.append(f'<link name="{name}"><pose{at}>{NOWHERE}</pose>{inertial(body)}</link>')
    for joint in urdf.findall("joint"):
        parent = attribute(joint, "parent", "link")
        place = f'<pose relative_to="{parent}">{pose(joint)}</pose>'
        links = f"<parent>{parent}</parent><child>{child(joint)}</child>"
        kind = joint.get("type")
        parts.append(f'<joint name="{joint.get("name")}" type="{kind}">{place}{links}{axis(joint)}</joint>')
    root = next(link.get("name", "") for link in urdf.findall("link") if link.get("name") not in joints)
    held = f'<pose relative_to="world">{NOWHERE}</pose><parent>world</parent><child>{root}</child>{NO_AXIS}'
    parts.append(f'<joint name="held" type="fixed">{held}</joint>')
    return f'<sdf version="1.10"><model name="{urdf.get("name")}">{"".join(parts)}</model></sdf>'


def attribute(element: ElementTree.Element, tag: str, key: str, default: str = "") -> str:
    """An attribute of an element's part, if present."""
    part = element.find(tag)
    return default if part is None else part.get(key, default)


def child(joint: ElementTree.Element) -> str:
    return attribute(joint, "child", "link")


def pose(element: ElementTree.Element) -> str:
    """Position and fixed-axis angles of its origin; SDF writes them like URDF."""
    return " ".join(attribute(element, "origin", key, "0 0 0") for key in ("xyz", "rpy"))


def inertial(body: ElementTree.Element | None) -> str:
    terms = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
    if body is None:
        inertia = {term: "1e-9" if term[1] == term[2] else "0" for term in terms}
        return written(NOWHERE, "1e-9", inertia)
    return written(pose(body), attribute(body, "mass", "value"), {term: attribute(body, "inertia", term) for term in terms})


def written(place: str, mass: str, inertia: dict[str, str]) -> str:
    terms = "".join(f"<{key}>{value}</{key}>" for key, value in inertia.items())
    return f"<inertial><pose>{place}</pose><mass>{mass}</mass><inertia>{terms}</inertia></inertial>"


def axis(joint: ElementTree.Element) -> str:
    if joint.get("type") == "fixed":
        return NO_AXIS
    keys = ("lower", "upper", "effort", "velocity")
    limits = "".join(f"<{key}>{x}</{key}>" for key in keys if (x := attribute(joint, "limit", key)))
    return f"<axis><xyz>{attribute(joint, 'axis', 'xyz', '1 0 0')}</xyz><limit>{limits}</limit></axis>"
