"""HTML of a robot for notebooks: its joints, limits and load report."""

from __future__ import annotations

from typing import TYPE_CHECKING

from robot_dynamics._native import _html as escape

if TYPE_CHECKING:
    from robot_dynamics.robot import Joint, Robot

_STYLE = """<style>
.robot-dynamics { font-size: 0.92em }
.robot-dynamics th, .robot-dynamics td { text-align: left; padding: 0.1em 0.8em 0.1em 0; font-variant-numeric: tabular-nums }
.robot-dynamics td.number { text-align: right }
.robot-dynamics summary { cursor: pointer }
</style>"""


def robot_html(robot: Robot) -> str:
    """HTML of a robot.

    Parameters
    ----------
    robot : Robot
        Robot to show.

    Returns
    -------
    str
        HTML element.
    """
    degrees = "degree" if robot.nv == 1 else "degrees"
    title = f"<b>{escape(robot.name)}</b>: {robot.nv} {degrees} of freedom, {robot.total_mass:.2f} kg"
    return f'<div class="robot-dynamics">{_STYLE}{title}{_joints(robot)}{_report(robot)}</div>'


def _joints(robot: Robot) -> str:
    """Table of the joints."""
    depth = {joint.child_link: 0 for joint in robot.joints}
    for joint in robot.joints:  # parents come first
        depth[joint.child_link] = depth.get(joint.parent_link, 0) + 1
    head = "".join(f"<th>{name}</th>" for name in ("joint", "kind", "moves", "v", "range", "velocity", "effort"))
    rows = "".join(_row(joint, depth[joint.child_link]) for joint in robot.joints)
    return (
        f"<details open><summary>{len(robot.joints)} joint{'s' if len(robot.joints) != 1 else ''}</summary>"
        f"<table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table></details>"
    )


def _row(joint: Joint, depth: int) -> str:
    """Row of a joint in the table."""
    first, last = joint.v.start, joint.v.stop - 1
    place = "" if last < first else str(first) if last == first else f"{first}–{last}"
    if joint.mimic:
        place = f"follows {joint.mimic[0]}"
    limits = joint.limits
    is_bounded = limits.lower > -float("inf") or limits.upper < float("inf")
    words = [f'<td style="padding-left:{0.9 * (depth - 1):.1f}em">{escape(joint.name)}</td>']
    words += [f"<td>{escape(word)}</td>" for word in (joint.kind, joint.child_link, place)]
    numbers = (
        f"{limits.lower:.4g} … {limits.upper:.4g}" if is_bounded else "",
        "" if limits.velocity == float("inf") else f"{limits.velocity:.4g}",
        "" if limits.effort == float("inf") else f"{limits.effort:.4g}",
    )
    words += [f'<td class="number">{number}</td>' for number in numbers]
    return f"<tr>{''.join(words)}</tr>"


def _report(robot: Robot) -> str:
    """Warnings and report of the file."""
    report = robot.report
    warnings = "".join(f"<li>{escape(text)}</li>" for text in report.grouped_warnings)
    lines = "\n".join(escape(line) for line in str(report).split("\n"))
    count = len(report.warnings)
    said = f"{count} warning{'s' if count != 1 else ''} of its file" if count else "no warnings of its file"
    is_open = " open" if count else ""
    return (
        f"<details{is_open}><summary>{said}</summary><ul>{warnings}</ul>"
        f"<details><summary>the whole report</summary><pre>{lines}</pre></details></details>"
    )
