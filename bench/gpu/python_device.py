"""Verifies and measures `robot_dynamics.gpu` on a CUDA device: `python bench/gpu/python_device.py [seconds]`.

It needs PyTorch with CUDA; CuPy and JAX are used if they are there. Each part that fails prints its error,
and the others follow. Parts that would begin after the given time (default: 85 s) are left out. The last line
is the number of failures, which is also the exit status.

Times are those of CUDA events around repeated calls, after a warm-up. A call of a step is one step. Errors
are relative to the largest number of the result. Their bound is 1e-9 in float64 and 2e-3 in float32, times
the condition number's effect: some hundred roundings, as in docs/gpu.md.
"""

from __future__ import annotations

import os
import sys
import tempfile
import time
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any

BEGUN = time.perf_counter()
BUDGET = float(sys.argv[1]) if len(sys.argv) > 1 else 85.0
os.environ.setdefault("RUST_MIN_STACK", str(64 << 20))
os.environ.setdefault("ROBOT_DYNAMICS_KERNEL_CACHE", tempfile.mkdtemp(prefix="robot-dynamics-kernels-"))

import numpy as np  # noqa: E402
import torch  # noqa: E402

import robot_dynamics as rd  # noqa: E402

FAILURES: list[str] = []
BOUNDS = {"float64": 1e-9, "float32": 2e-3}
FUNCTIONS = [
    "inverse_dynamics",
    "forward_dynamics",
    "mass_matrix",
    "bias",
    "kinetic_energy",
    "inverse_dynamics_pullback",
    "forward_dynamics_pullback",
    "semi_implicit_euler_step",
    "rk4_step",
]
ROBOTS = {"panda": False, "quadruped": True}
DEVICE = "cuda:0"


def seconds() -> float:
    return time.perf_counter() - BEGUN


def part(title: str, run: Callable[[], None]) -> None:
    """Runs a part, unless time is over."""
    if seconds() > BUDGET:
        print(f"\n== {title}: left out after {seconds():.0f} s", flush=True)
        return
    print(f"\n== {title} ({seconds():.0f} s)", flush=True)
    try:
        run()
    except Exception:
        FAILURES.append(title)
        traceback.print_exc(limit=6, file=sys.stdout)
        print(f"FAILED: {title}", flush=True)


def check(what: str, is_true: bool, detail: object = "") -> None:
    print(f"  {'ok    ' if is_true else 'FAILED'} {what} {detail}", flush=True)
    if not is_true:
        FAILURES.append(what)


def load(name: str) -> rd.Robot:
    file = Path(__file__).parents[2] / "robots" / f"{name}.urdf"
    if file.is_file():
        return rd.load(file, floating_base=ROBOTS[name])
    return rd.example(name)


def states(robot: rd.Robot, count: int, dtype: str, seed: int = 1) -> dict[str, Any]:
    """Random states on the card; beyond 65 536 states they repeat."""
    few = min(count, 65_536)
    random = np.random.default_rng(seed)
    own = {"q": robot.random_configuration(few, seed=seed)}
    own |= {name: random.uniform(-1.0, 1.0, (few, robot.nv)) for name in ("v", "a", "tau", "cotangent")}
    repeated = {name: torch.tensor(x, dtype=getattr(torch, dtype), device=DEVICE) for name, x in own.items()}
    return {name: x.repeat(-(-count // few), 1)[:count].contiguous() for name, x in repeated.items()}


COMPILED: dict[tuple[str, str], rd.gpu.DeviceFunctions] = {}


def compiled(name: str, dtype: str) -> rd.gpu.DeviceFunctions:
    if (name, dtype) not in COMPILED:
        COMPILED[name, dtype] = rd.gpu.Device(DEVICE).compile(ROBOT[name], FUNCTIONS, dtype=dtype)
    return COMPILED[name, dtype]


def environment() -> None:
    device = rd.gpu.Device(DEVICE)
    print(f"  {device.description}; torch {torch.__version__}, CUDA {torch.version.cuda}; {os.cpu_count()} processors")
    print(f"  NVRTC {rd.gpu.compiler_library.find()}")


def compilation() -> None:
    for name in ROBOTS:
        for dtype in BOUNDS:
            begun = time.perf_counter()
            compiled(name, dtype)
            cold = time.perf_counter() - begun
            begun = time.perf_counter()
            rd.gpu.Device(DEVICE).compile(ROBOT[name], FUNCTIONS, dtype=dtype)
            print(f"  {name} {dtype}: {len(FUNCTIONS)} functions in {cold:.2f} s, {time.perf_counter() - begun:.2f} s "
                  "with files of the cache", flush=True)
    files = list(Path(os.environ["ROBOT_DYNAMICS_KERNEL_CACHE"]).iterdir())
    print(f"  the cache has {len(files)} files, {sum(file.stat().st_size for file in files) / 1e6:.1f} MB")


def expected(robot: rd.Robot, name: str, s: dict[str, Any]) -> list[Any]:
    """Results of the library on the processor, in float64."""
    q, v, a, tau, weights = (s[own].cpu().numpy().astype(np.float64) for own in ("q", "v", "a", "tau", "cotangent"))
    q = robot.normalize(q)
    if name.endswith("_step"):
        integrator = {"semi_implicit_euler_step": "semi-implicit-euler", "rk4_step": "rk4"}[name]
        end = robot.rollout(q, v, tau, steps=1, dt=1e-3, integrator=integrator, without=["effort-limits"])
        return [end.q, end.v]
    given = {
        "inverse_dynamics": (q, v, a),
        "forward_dynamics": (q, v, tau),
        "mass_matrix": (q,),
        "bias": (q, v),
        "kinetic_energy": (q, v),
        "inverse_dynamics_pullback": (q, v, a, weights),
        "forward_dynamics_pullback": (q, v, tau, weights),
    }[name]
    found = getattr(robot, name)(*given)
    found = list(found) if isinstance(found, tuple) else [found]
    # The pullback on the device returns the acceleration as well.
    return [robot.forward_dynamics(q, v, tau), *found] if name == "forward_dynamics_pullback" else found


def arguments(function: rd.gpu.DeviceFunction, s: dict[str, Any]) -> list[Any]:
    return [1e-3 if name == "h" else s[name] for name in function.arguments]


def verification() -> None:
    for name, robot in ROBOT.items():
        for dtype, bound in BOUNDS.items():
            s = states(robot, 4096, dtype)
            for own in FUNCTIONS:
                function = compiled(name, dtype)[own]
                found = function(*arguments(function, s))
                found = found if isinstance(found, tuple) else [found]
                worst = 0.0
                for result, right in zip(found, expected(robot, own, s), strict=True):
                    off = np.abs(result.cpu().numpy().astype(np.float64) - right).max()
                    worst = max(worst, off / max(1.0, np.abs(right).max()))
                check(f"{name} {dtype} {own}", bool(worst <= bound), f"{worst:.1e} of at most {bound:.0e}")


def gradients() -> None:
    for name, robot in ROBOT.items():
        s = states(robot, 1000, "float64")
        functions = compiled(name, "float64")
        q, v, tau = (s[own].clone().requires_grad_() for own in ("q", "v", "tau"))
        (functions.forward_dynamics(q, v, tau) * s["cotangent"]).sum().backward()
        host = {own: x.cpu().numpy() for own, x in s.items()}
        right = robot.forward_dynamics_pullback(host["q"], host["v"], host["tau"], host["cotangent"])
        for what, leaf, other in (("v", v, right.by_velocity), ("tau", tau, right.by_force)):
            off = np.abs(leaf.grad.cpu().numpy() - other).max() / max(1.0, np.abs(other).max())
            check(f"{name}: gradient of forward dynamics by {what}", bool(off < 1e-9), f"{off:.1e}")

        # The same rollout on the processor, by the library's own gradients.
        from robot_dynamics.torch import rollout

        weights = torch.tensor(np.random.default_rng(5).uniform(-1, 1, (2, 64, robot.nq)), device=DEVICE)
        for integrator, step in (("semi-implicit-euler", "semi_implicit_euler_step"), ("rk4", "rk4_step")):
            leaves = [s[own][:64].clone().requires_grad_() for own in ("q", "v", "tau")]
            others = [x.detach().cpu().clone().requires_grad_() for x in leaves]

            def loss(end: Any, device: str) -> Any:
                own = weights.to(device)
                return (end.q * own[0]).sum() + (end.v * own[1, :, : robot.nv]).sum()

            loss(functions.rollout(*leaves, steps=20, dt=1e-3, step=step), DEVICE).backward()
            loss(rollout(robot, *others, steps=20, dt=1e-3, integrator=integrator, without=["effort-limits"]), "cpu").backward()
            for what, leaf, other in zip("q v tau".split(), leaves, others, strict=True):
                off = float((leaf.grad.cpu() - other.grad).abs().max() / other.grad.abs().max().clamp(min=1.0))
                check(f"{name}: gradient of 20 steps of {integrator} by {what}", off < 1e-8, f"{off:.1e}")


def no_copies() -> None:
    robot = ROBOT["panda"]
    functions = compiled("panda", "float32")
    s = states(robot, 65_536, "float32")
    q, v, tau = s["q"], s["v"], s["tau"]
    functions.forward_dynamics(q, v, tau)
    torch.cuda.synchronize()
    before = torch.cuda.memory_allocated()
    torch.cuda.reset_peak_memory_stats()
    result = functions.forward_dynamics(q, v, tau)
    grown, peak = torch.cuda.memory_allocated() - before, torch.cuda.max_memory_allocated() - before
    check("a call allocates its result alone", grown == peak == result.numel() * 4, f"{grown} and {peak} bytes")
    free = torch.cuda.mem_get_info()[0]
    for _ in range(20):
        functions.forward_dynamics(q, v, tau, out=result)
    torch.cuda.synchronize()
    check("calls with out= allocate nothing", torch.cuda.memory_allocated() - before == grown
          and torch.cuda.mem_get_info()[0] == free)
    addresses = q.data_ptr(), v.data_ptr()
    end = functions.rollout(q, v, tau, steps=7, dt=1e-3, step="rk4_step", out=(q, v))
    check("a rollout in place returns the same memory", (end.q.data_ptr(), end.v.data_ptr()) == addresses)


def streams() -> None:
    functions = compiled("panda", "float32")
    s = states(ROBOT["panda"], 65_536, "float32")
    q, v, tau = s["q"], s["v"], s["tau"]
    right = functions.forward_dynamics(q, v, tau)
    late = torch.zeros_like(q)
    torch.cuda.synchronize()
    stream, event = torch.cuda.Stream(), torch.cuda.Event()
    with torch.cuda.stream(stream):
        torch.cuda._sleep(200_000_000)
        late.copy_(q)
        found = functions.forward_dynamics(late, v, tau)
        event.record()
    check("a call does not wait", not event.query())
    stream.synchronize()
    check("a call follows the commands before it on the stream", torch.equal(found, right))
    found = functions.forward_dynamics(q, v, tau, stream=stream)
    stream.synchronize()
    check("stream= is the stream of the call", torch.equal(found, right))

    graph, out = torch.cuda.CUDAGraph(), torch.zeros_like(right)
    with torch.cuda.graph(graph):
        functions.forward_dynamics(q, v, tau, out=out)
    out.zero_()
    graph.replay()
    torch.cuda.synchronize()
    check("a call is captured in a graph of CUDA", torch.equal(out, right))


def repetition() -> None:
    for name in ROBOTS:
        for dtype in BOUNDS:
            functions, s = compiled(name, dtype), states(ROBOT[name], 65_536, dtype)
            ends = [functions.rollout(s["q"], s["v"], s["tau"], steps=50, dt=1e-3, step="rk4_step") for _ in range(3)]
            few = functions.rollout(*(s[x][:1000].contiguous() for x in ("q", "v", "tau")), steps=50, dt=1e-3, step="rk4_step")
            same = all(torch.equal(end.q, ends[0].q) and torch.equal(end.v, ends[0].v) for end in ends[1:])
            check(f"{name} {dtype}: 50 steps repeat their bits", same and torch.equal(few.v, ends[0].v[:1000]))


def libraries() -> None:
    functions, s = compiled("panda", "float32"), states(ROBOT["panda"], 1000, "float32")
    right = functions.bias(s["q"], s["v"])

    class Interface:
        """An array of another library."""

        def __init__(self, tensor: Any) -> None:
            self.__cuda_array_interface__ = tensor.__cuda_array_interface__

    out = torch.zeros_like(right)
    torch.cuda.synchronize()
    functions.bias(Interface(s["q"]), Interface(s["v"]), out=Interface(out))
    torch.cuda.synchronize()
    check("__cuda_array_interface__", torch.equal(out, right))
    try:
        import cupy
    except ImportError as error:
        print(f"  left out: {error}")
    else:
        found = functions.bias(cupy.asarray(s["q"]), cupy.asarray(s["v"]))
        check("CuPy", isinstance(found, cupy.ndarray) and torch.equal(torch.as_tensor(found, device=DEVICE), right))


def jax_programs() -> None:
    """Foreign calls of XLA, in a program and with gradients."""
    os.environ.setdefault("XLA_PYTHON_CLIENT_PREALLOCATE", "false")
    import jax

    functions, s = compiled("panda", "float32"), states(ROBOT["panda"], 1000, "float32")
    q, v, tau, weights = (jax.dlpack.from_dlpack(s[name]) for name in ("q", "v", "tau", "cotangent"))
    print(f"  jax {jax.__version__} on {q.device}")
    right = functions.forward_dynamics(s["q"], s["v"], s["tau"])
    found = jax.jit(lambda q, v, tau: functions.forward_dynamics(2.0 * (0.5 * q), v, tau))(q, v, tau)
    check("a call in a program", torch.equal(torch.from_dlpack(found), right))

    def loss(v: Any, tau: Any) -> Any:
        return (functions.forward_dynamics(q, v, tau) * weights).sum()

    by_v, by_tau = jax.jit(jax.grad(loss, argnums=(0, 1)))(v, tau)
    leaves = s["v"].clone().requires_grad_(), s["tau"].clone().requires_grad_()
    (functions.forward_dynamics(s["q"], *leaves) * s["cotangent"]).sum().backward()
    same = all(torch.equal(torch.from_dlpack(own), leaf.grad) for own, leaf in zip((by_v, by_tau), leaves, strict=True))
    check("gradients are those of PyTorch", same)
    end = jax.jit(lambda q, v, tau: functions.rollout(q, v, tau, steps=50, dt=1e-3, step="rk4_step"))(q, v, tau)
    own = functions.rollout(s["q"], s["v"], s["tau"], steps=50, dt=1e-3, step="rk4_step")
    check("a rollout in a program", torch.equal(torch.from_dlpack(end.q), own.q))


def rate(call: Callable[[], object], states: int, least: float = 0.06) -> float:
    """Millions of states per second."""
    call()
    torch.cuda.synchronize()
    start, end = torch.cuda.Event(enable_timing=True), torch.cuda.Event(enable_timing=True)
    repetitions = 2
    while True:
        start.record()
        for _ in range(repetitions):
            call()
        end.record()
        end.synchronize()
        elapsed = 1e-3 * start.elapsed_time(end)
        if elapsed >= least or repetitions >= 4096:
            return states * repetitions / elapsed / 1e6
        repetitions = min(4096, max(2 * repetitions, int(1.2 * repetitions * least / elapsed)))


def times() -> None:
    counts = (65_536, 1_048_576)
    print("  millions of states per second; a step in a rollout counts as one")
    print(f"  {'':44}" + "".join(f"{dtype + ' ' + str(count):>20}" for dtype in BOUNDS for count in counts))
    for name, robot in ROBOT.items():
        rows: dict[str, list[str]] = {}
        for dtype in BOUNDS:
            functions = compiled(name, dtype)
            for count in counts:
                s = states(robot, count, dtype)
                for own in FUNCTIONS:
                    function = functions[own]
                    given = function._given(arguments(function, s), None)
                    out = function._run(given)
                    out = out[0] if len(out) == 1 else out
                    reads = function._memory(given.library, given.arrays, list(function.arguments.values()), count)
                    outs = out if isinstance(out, list) else [out]
                    writes = function._memory(given.library, outs, list(function.results.values()), count)

                    def call() -> None:
                        function(*arguments(function, s), out=out)

                    def by_columns() -> None:
                        function._compiled._compute(own, reads, writes, given.stream, True)

                    rows.setdefault(f"{name} {own}", []).append(timed(call, count))
                    rows.setdefault(f"{name} {own}, by columns", []).append(timed(by_columns, count))
                    del out, outs
                for step in ("semi_implicit_euler_step", "rk4_step"):
                    q, v = s["q"].clone(), s["v"].clone()
                    zero = torch.zeros_like(v)

                    def roll() -> None:
                        functions.rollout(q, v, zero, steps=100, dt=1e-4, step=step, out=(q, v))

                    rows.setdefault(f"{name} rollout of 100 {step}s", []).append(timed(roll, 100 * count))
                torch.cuda.empty_cache()
        for title, entries in rows.items():
            print(f"  {title:44}" + "".join(f"{entry:>20}" for entry in entries), flush=True)


def timed(call: Callable[[], object], states: int) -> str:
    if seconds() > BUDGET:
        return "-"
    try:
        return f"{rate(call, states):.1f}"
    except Exception as error:
        FAILURES.append(f"a time: {error}")
        return type(error).__name__


def training() -> None:
    """A loop of optimisation that stays on the card."""
    robot, functions = ROBOT["panda"], compiled("panda", "float32")
    s = states(robot, 65_536, "float32")
    tau = torch.zeros_like(s["tau"]).requires_grad_()
    optimizer = torch.optim.SGD([tau], lr=10.0)

    def iterate() -> Any:
        optimizer.zero_grad()
        end = functions.rollout(s["q"], s["v"], tau, steps=20, dt=1e-3, step="semi_implicit_euler_step")
        loss = end.v.square().sum(dim=-1).mean()
        loss.backward()
        optimizer.step()
        return loss.detach()

    losses = [iterate() for _ in range(3)]
    print(f"  gradients of 20 steps of 65536 states: {rate(iterate, 20 * 65_536):.1f} million steps per second")
    losses.append(iterate())
    check("a loss falls", float(losses[-1]) < float(losses[0]), [f"{float(x):.4f}" for x in losses])


def contact() -> None:
    """Steps with contact of the quadruped, against the same step on the processor."""
    robot = ROBOT["quadruped"]
    if "contact_step" not in str(rd.gpu.Device("cpu").compile(robot, ["contact_step"], dtype="float64").names):
        return
    begun = time.perf_counter()
    functions = {dtype: rd.gpu.Device(DEVICE).compile(robot, ["contact_step"], dtype=dtype) for dtype in BOUNDS}
    print(f"  compiled in {time.perf_counter() - begun:.2f} s")
    for dtype, bound in BOUNDS.items():
        s = states(robot, 4096, dtype)
        s["q"][:, 2] = 0.45
        s["q"][:, 3:7] = torch.tensor([0.0, 0.0, 0.0, 1.0])
        given = [s["q"], 0.1 * s["v"], s["tau"], 2e-3, 0.7, 0.0]
        found = functions[dtype].contact_step(*given)
        own = rd.gpu.Device("cpu").compile(robot, ["contact_step"], dtype="float64")
        right = own.contact_step(*(x.cpu().double() if isinstance(x, torch.Tensor) else x for x in given))
        off = float((found.v_next.cpu().double() - right.v_next).abs().max() / right.v_next.abs().max())
        touching = int((right.impulses_next.abs().sum(dim=-1) > 0).sum())
        check(f"{dtype} contact_step", off < bound, f"{off:.1e}, {touching} of 4096 touch the ground")
        for count in (65_536, 262_144):
            s = states(robot, count, dtype)
            q, v, tau = s["q"], torch.zeros_like(s["v"]), torch.zeros_like(s["tau"])
            q[:, 2] = 0.45
            q[:, 3:7] = torch.tensor([0.0, 0.0, 0.0, 1.0])
            own = functions[dtype]

            def roll() -> None:
                own.rollout(q, v, tau, steps=20, dt=2e-3, friction=0.7, out=(q, v))

            print(f"  {dtype} {count}: {timed(roll, 20 * count)} million steps per second")


def processor() -> None:
    """The library's batches on this machine's processors, for comparison."""
    for name, robot in ROBOT.items():
        for dtype in BOUNDS:
            host = {own: x.cpu().numpy() for own, x in states(robot, 65_536, dtype).items()}
            host["q"] = robot.normalize(host["q"])
            line = []
            for own, given in (("inverse_dynamics", "q v a"), ("forward_dynamics", "q v tau"), ("mass_matrix", "q")):
                given = [host[x] for x in given.split()]
                getattr(robot, own)(*given)
                begun, repetitions = time.perf_counter(), 0
                while time.perf_counter() - begun < 0.15:
                    getattr(robot, own)(*given)
                    repetitions += 1
                line.append(f"{own} {65_536e-6 * repetitions / (time.perf_counter() - begun):.1f}")
            print(f"  {name} {dtype}: {', '.join(line)} million states per second")


ROBOT: dict[str, rd.Robot] = {}


def main() -> int:
    def robots() -> None:
        ROBOT.update({name: load(name) for name in ROBOTS})
        print(", ".join(f"  {name}: nq {robot.nq}, nv {robot.nv}" for name, robot in ROBOT.items()))

    part("robots", robots)
    part("environment", environment)
    part("compilation", compilation)
    part("results against the processor", verification)
    part("gradients", gradients)
    part("no copies", no_copies)
    part("streams", streams)
    part("same bits", repetition)
    part("libraries of arrays", libraries)
    part("JAX", jax_programs)
    part("processor", processor)
    part("training", training)
    part("contact", contact)
    part("times", times)
    print(f"\n{len(FAILURES)} failures after {seconds():.0f} s" + "".join(f"\n  {own}" for own in dict.fromkeys(FAILURES)))
    return min(len(FAILURES), 100)


if __name__ == "__main__":
    sys.exit(main())
