"""Verifies and measures steps with contact on a device: `python bench/gpu/contact_steps.py [cuda|cpu]
[FOLDER]`.

It needs PyTorch. Quadrupeds fall onto the ground, with their feet alone or with feet and trunk as contact
points. Rates are those of rollouts of 50 steps of 2 ms, medians of seven, on CUDA by its events. Energy is
that of the whole graphics processor. The distance to the converged step is that of the velocities after one
step, from states after 0.5 s of motion and with their multipliers.
"""

from __future__ import annotations

import json
import statistics
import sys
import time
import traceback
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import torch

import robot_dynamics as rd
import robot_dynamics.gpu

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "learning"))
PLACE = sys.argv[1] if len(sys.argv) > 1 else "cuda"
OUT = Path(sys.argv[2]) if len(sys.argv) > 2 else None
DT, FRICTION, CONVERGED = 2e-3, 0.7, 400
ROWS: list[dict[str, Any]] = []
FAILURES: list[str] = []


def quadruped(touching: tuple[str, ...]) -> rd.Robot:
    """The quadruped, of which only links with these words in their names touch."""
    tree = ET.parse(HERE.parents[1] / "robots" / "quadruped.urdf")
    for link in tree.getroot().findall("link"):
        if not any(word in link.get("name", "") for word in touching):
            for shape in link.findall("collision"):
                link.remove(shape)
    return rd.loads(ET.tostring(tree.getroot(), encoding="unicode"), floating_base=True)


def starts(robot: rd.Robot, count: int, dtype: torch.dtype) -> tuple[torch.Tensor, ...]:
    """Random states above the ground, and random torques."""
    torch.manual_seed(1)
    q = torch.zeros(count, robot.nq, device=PLACE, dtype=torch.float64)
    q[:, 2], q[:, 6] = 0.42, 1.0
    q[:, 7:] = torch.tensor([0.0, 0.7, -1.4] * 4, device=PLACE, dtype=torch.float64)
    q[:, 7:] += 0.1 * (torch.rand(count, 12, device=PLACE, dtype=torch.float64) - 0.5)
    v = 0.4 * (torch.rand(count, robot.nv, device=PLACE, dtype=torch.float64) - 0.5)
    tau = torch.zeros_like(v)
    tau[:, 6:] = 4.0 * (torch.rand(count, 12, device=PLACE, dtype=torch.float64) - 0.5)
    return q.to(dtype), v.to(dtype), tau.to(dtype)


def seconds(run: Any, repeats: int = 7) -> list[float]:
    """Times of repeated runs, after one."""
    run()
    times = []
    for _ in range(repeats):
        if PLACE == "cpu":
            begun = time.perf_counter()
            run()
            times.append(time.perf_counter() - begun)
            continue
        begin, end = torch.cuda.Event(enable_timing=True), torch.cuda.Event(enable_timing=True)
        begin.record()
        run()
        end.record()
        wait()
        times.append(begin.elapsed_time(end) / 1e3)
    return times


def wait() -> None:
    """Waits for the device."""
    if PLACE != "cpu":
        torch.cuda.synchronize()


def part(title: str, run: Any) -> None:
    begun = time.perf_counter()
    try:
        run()
    except Exception:
        FAILURES.append(title)
        traceback.print_exc(limit=5, file=sys.stdout)
    print(f"-- {title}: {time.perf_counter() - begun:.1f} s", flush=True)


def measure(name: str, robot: rd.Robot, device: Any, dtype: str, counts: list[int]) -> None:
    from energy import EnergyMeter

    begun = time.perf_counter()
    functions = device.compile(robot, ["contact_step"], dtype=dtype)
    functions.rollout(*starts(robot, 64, getattr(torch, dtype)), steps=1, dt=DT, friction=FRICTION)
    wait()
    print(f"{name} {dtype}: compiled in {time.perf_counter() - begun:.1f} s", flush=True)
    for count in counts:
        q, v, tau = starts(robot, count, getattr(torch, dtype))
        steps = 50
        run = lambda: functions.rollout(q, v, tau, steps=steps, dt=DT, friction=FRICTION)  # noqa: E731
        times = seconds(run)
        rates = [count * steps / t for t in times]
        with EnergyMeter() as meter:
            blocks = max(1, int(1.0 / statistics.median(times)))
            for _ in range(blocks):
                run()
            wait()
        joules = None if meter.joules is None else meter.joules / (blocks * count * steps)
        end = run()
        finite = int((torch.isfinite(end.q).all(1)).sum())
        row = {"robot": name, "dtype": dtype, "robots": count, "rate": statistics.median(rates),
               "range": [min(rates), max(rates)], "joules_per_step": joules, "finite": finite}
        ROWS.append(row)
        energy = "" if joules is None else f"{1e9 * joules:.0f} nJ a step"
        print(f"| {name} | {dtype} | {count} | {row['rate'] / 1e6:.1f} ({min(rates) / 1e6:.1f} to {max(rates) / 1e6:.1f}) M/s | {energy} | finite {finite} |", flush=True)


def agreement(robot: rd.Robot, device: Any) -> None:
    """float32 beside float64 on the device, and the same bits in repeated runs."""
    ends = {}
    for dtype in ("float64", "float32"):
        functions = device.compile(robot, ["contact_step"], dtype=dtype)
        q, v, tau = starts(robot, 4096, getattr(torch, dtype))

        def run(steps: int) -> Any:
            return functions.rollout(q, v, tau, steps=steps, dt=DT, friction=FRICTION)  # noqa: B023

        first, second = run(250), run(250)
        same = torch.equal(first.q, second.q) and torch.equal(first.v, second.v)
        print(f"same bits in {dtype}: {same}")
        if not same:
            FAILURES.append("bits")
        ends[dtype] = [run(steps).q.double() for steps in (25, 100, 250)]
    for steps, one, two in zip((25, 100, 250), ends["float64"], ends["float32"], strict=True):
        off = (one - two).abs().amax(1)
        print(f"| float32 after {steps} steps | median {off.median():.1e} | 99 % {off.quantile(0.99):.1e} |")


def sweeps(robot: rd.Robot, device: Any) -> None:
    """The distance of a step from the converged one, by its sweeps, with multipliers of the last step."""
    names = [f"contact_step_{n}_sweeps" for n in (2, 4, 8, 32, 64, CONVERGED)]
    functions = device.compile(robot, ["contact_step", *names], dtype="float64")
    q, v, tau = starts(robot, 4096, torch.float64)
    for name in sorted([*names, "contact_step"], key=lambda n: 16 if n == "contact_step" else int(n.split("_")[2])):
        moved = functions.rollout(q, v, tau, steps=250, dt=DT, friction=FRICTION, step=name)
        impulses = moved.tables["impulses"]
        one = functions[name](moved.q, moved.v, tau, DT, FRICTION, impulses)
        best = functions[f"contact_step_{CONVERGED}_sweeps"](moved.q, moved.v, tau, DT, FRICTION, impulses)
        off = (one[1] - best[1]).abs().amax(1)
        ROWS.append({"sweeps": name, "median": off.median().item(), "most": off.max().item()})
        print(f"| {name} | median {off.median():.1e} | 99 % {off.quantile(0.99):.1e} | largest {off.max():.1e} rad/s or m/s |", flush=True)


def gradients(robot: rd.Robot, device: Any) -> None:
    """The pullback beside central differences of converged steps, and its rate."""
    name = f"contact_step_{CONVERGED}_sweeps"
    begun = time.perf_counter()
    functions = device.compile(robot, [name, f"contact_step_{CONVERGED}_sweeps_pullback"], dtype="float64")
    q, v, tau = starts(robot, 512, torch.float64)
    moved = functions.rollout(q, v, tau, steps=250, dt=DT, friction=FRICTION)
    print(f"pullback compiled in {time.perf_counter() - begun:.1f} s")
    count = 512
    call = lambda tau: functions[name](moved.q, moved.v, tau, DT, FRICTION, moved.tables["impulses"])  # noqa: E731
    _, _, impulses = call(tau)
    weights = torch.rand(count, 2 * robot.nv, device=PLACE, dtype=torch.float64) - 0.5
    weights[:, : robot.nv] = 0.0
    pullback = functions[f"{name}_pullback"]
    gradient = pullback(moved.q, moved.v, tau, DT, FRICTION, impulses, weights)[2]
    direction = torch.rand_like(tau) - 0.5
    e = 1e-4
    ends = [call(tau + sign * e * direction)[1] for sign in (1, -1)]
    expected = ((ends[0] - ends[1]) * weights[:, robot.nv :]).sum(1) / (2 * e)
    found = (gradient * direction).sum(1)
    off = (found - expected).abs() / (1e-3 + expected.abs())
    print(f"| gradient by torques against differences | median {off.median():.1e} | 90 % {off.quantile(0.9):.1e} |")


def pullback_rate(robot: rd.Robot, device: Any) -> None:
    functions = device.compile(robot, ["contact_step_pullback"], dtype="float32")
    for count in (8192, 32768):
        q, v, tau = starts(robot, count, torch.float32)
        rows = functions["contact_step_pullback"]
        impulses = torch.zeros(count, *rows.arguments["impulses"], device=PLACE)
        weights = torch.rand(count, 2 * robot.nv, device=PLACE)
        times = seconds(lambda: rows(q, v, tau, DT, FRICTION, impulses, weights))  # noqa: B023
        print(f"| pullback, float32 | {count} | {count / statistics.median(times) / 1e6:.2f} M/s |", flush=True)


def main() -> None:
    device = rd.gpu.Device("cpu" if PLACE == "cpu" else "cuda:0")
    print(device)
    feet, trunk = quadruped(("foot",)), quadruped(("foot", "trunk"))
    part("agreement", lambda: agreement(trunk, device))
    part("rates, feet", lambda: measure("feet", feet, device, "float32", [4096, 8192, 32768, 131072]))
    part("rates, feet and trunk", lambda: measure("feet and trunk", trunk, device, "float32", [8192, 32768, 131072]))
    part("sweeps", lambda: sweeps(trunk, device))
    part("rates in float64", lambda: measure("feet", feet, device, "float64", [8192, 32768]))
    part("gradients", lambda: gradients(feet, device))
    part("rate of the pullback", lambda: pullback_rate(feet, device))
    if OUT:
        OUT.mkdir(parents=True, exist_ok=True)
        (OUT / "contact_steps.json").write_text(json.dumps(ROWS, indent=1))
    print(f"{len(FAILURES)} failures: {FAILURES}")


if __name__ == "__main__":
    main()
