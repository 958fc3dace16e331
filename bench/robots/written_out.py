"""A robot file with its defaults written out, for programs that need them; the robot's motion does not
change."""

import re
from xml.etree import ElementTree

DEFAULT_MOMENTS = dict.fromkeys(("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), "0")
LIMITED = ("revolute", "prismatic")


def tree(data):
    """The file's root element and the prefixes that were declared."""
    text = data.decode("utf-8-sig", "replace")
    text = re.sub(r"<!--.*?-->", "", text, flags=re.DOTALL)
    text = re.sub(r"<\?xml\b.*?\?>", "", text, flags=re.DOTALL)
    declared = set(re.findall(r"xmlns:([\w.-]+)\s*=", text)) | {"xml", "xmlns"}
    used = set(re.findall(r"</?([\w.-]+):[\w.-]+", text)) | set(re.findall(r"\s([\w.-]+):[\w.-]+\s*=\s*[\"']", text))
    missing = sorted(used - declared)
    names = "".join(f' xmlns:{prefix}="{prefix}"' for prefix in missing)
    text = re.sub(r"<robot\b", "<robot" + names, text, count=1)
    return ElementTree.fromstring(text.strip()), missing


def followers(data):
    """{mimic joint: (joint, ratio, offset)}; a fixed joint mimics no joint."""
    try:
        root, _ = tree(data)
    except ElementTree.ParseError:
        return {}
    found = {}
    for joint in root.findall("joint"):
        mimic = joint.find("mimic")
        if mimic is not None and joint.get("type") in ("revolute", "continuous", "prismatic"):
            ratio, offset = (float(mimic.get(key, default)) for key, default in (("multiplier", 1), ("offset", 0)))
            found[joint.get("name")] = (mimic.get("joint"), ratio, offset)
    return found


def armatures(data):
    """{joint: rotor inertia of MuJoCo's attribute `armature`}, which URDF lacks."""
    root, _ = tree(data)
    found = {}
    for joint in root.findall("joint"):
        for dynamics in joint.findall("dynamics")[:1]:
            if dynamics.get("armature"):
                found[joint.get("name")] = float(dynamics.get("armature"))
    return found


def written_out(data):
    """The file's new text, and the changes; raises ElementTree.ParseError."""
    root, missing = tree(data)
    changes = [f"the prefix {prefix}: is declared" for prefix in missing]
    if not (root.get("name") or "").strip():
        root.set("name", "robot")
        changes.append("the robot has a name")
    kept = ElementTree.Element("robot", {"name": root.get("name")})
    links = [written_link(link, changes) for link in root.findall("link")]
    joints = [written_joint(joint, changes) for joint in root.findall("joint") if joint.find("parent") is not None]
    kept.extend(links + joints)
    parents = {joint.find("parent").get("link") for joint in joints}
    if "world" in parents - {link.get("name") for link in links}:
        kept.append(ElementTree.Element("link", {"name": "world"}))
        changes.append("the link world is there")
    if not changes:
        changes.append("only what moves is kept")
    return ElementTree.tostring(kept, encoding="unicode"), sorted(set(changes))


def first(element, name, changes):
    """The first element of a name; the others are removed."""
    found = element.findall(name)
    if len(found) > 1:
        changes.append(f"of several <{name}> the first is kept")
    return found[0] if found else None


def written_link(link, changes):
    """A link with a mass and all moments, or with no inertial."""
    kept = ElementTree.Element("link", {"name": link.get("name", "")})
    inertial = first(link, "inertial", changes)
    if inertial is None:
        return kept
    whole = ElementTree.SubElement(kept, "inertial")
    origin = first(inertial, "origin", changes)
    if origin is not None:
        whole.append(written_origin(origin))
    mass = first(inertial, "mass", changes)
    if mass is None:
        changes.append("<mass> without a number is written as 0")
    ElementTree.SubElement(whole, "mass", {"value": "0" if mass is None else mass.get("value", "0").strip()})
    inertia = first(inertial, "inertia", changes)
    given = {} if inertia is None else {key: inertia.get(key) for key in DEFAULT_MOMENTS if inertia.get(key)}
    if inertia is None:
        changes.append("<inertia> is written as zeros")
    elif len(given) < 6:
        changes.append("a missing moment is written as 0")
    if any(len(value.split()) == 1 and value != value.strip() for value in given.values()):
        changes.append("white space about a moment goes")
    given = {key: value.strip() for key, value in given.items()}
    ElementTree.SubElement(whole, "inertia", DEFAULT_MOMENTS | given)
    return kept


def written_origin(origin):
    """An origin with xyz and rpy."""
    return ElementTree.Element("origin", {key: " ".join(origin.get(key, "0 0 0").split()) for key in ("xyz", "rpy")})


def written_joint(joint, changes):
    """Removes from a joint what only motors need."""
    kind = joint.get("type", "")
    kept = ElementTree.Element("joint", {"name": joint.get("name", ""), "type": kind})
    origin = first(joint, "origin", changes)
    if origin is not None:
        kept.append(written_origin(origin))
    for name in ("parent", "child"):
        end = first(joint, name, changes)
        ElementTree.SubElement(kept, name, {"link": "" if end is None else end.get("link", "")})
    axis = first(joint, "axis", changes)
    if axis is not None and kind != "fixed":
        ElementTree.SubElement(kept, "axis", {"xyz": " ".join(axis.get("xyz", "1 0 0").split())})
    if kind in LIMITED:
        limit = first(joint, "limit", changes)
        if limit is None or not {"effort", "velocity"} <= set(limit.keys()):
            changes.append("limits are written")
        ElementTree.SubElement(kept, "limit", {"lower": "-1", "upper": "1", "effort": "1", "velocity": "1"})
    mimic = first(joint, "mimic", changes)
    if mimic is not None and kind != "fixed":
        kept.append(mimic)
    return kept
