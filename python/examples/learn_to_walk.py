"""Teach the quadruped to walk with commanded velocities, by proximal policy optimization.

    python examples/learn_to_walk.py --envs 256 --iterations 400 --threads 2 --terrain flat --seed 1 --out walk

`--simulation device` takes the steps with contact of `robot_dynamics.gpu`, on flat ground: on a graphics
processor with `--device cuda`, or on this processor, where they are some twenty times as fast.

It needs PyTorch. The folder `--out` receives the reward curve (`curve.csv`), the weights (`policy.pt`) and
the policy as plain C (`policy.c`). It also has a recorded motion of the trained policy (`rollout.npz`), and
the policy as ONNX (`policy.onnx`) if the package onnx is installed. `--seconds` ends the training early.

The method is proximal policy optimization (Schulman and others 2017) with generalized advantages (Schulman
and others 2016). The step size follows the divergence of the policy, as in Rudin and others, *Learning to
Walk in Minutes Using Massively Parallel Deep Reinforcement Learning*, 2022.
"""

import argparse
import csv
import time
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import nn

from robot_dynamics.device_walk import DeviceWalk
from robot_dynamics.gym import RobotEnv, Walk
from robot_dynamics.policy_code import policy_code
from robot_dynamics.randomization import Pushes, Randomization
from robot_dynamics.torch_env import TorchEnv
from robot_dynamics.walking import rough_ground


@dataclass(frozen=True)
class Settings:
    """Numbers of the method."""

    steps: int = 24
    """Control steps of each environment in an iteration."""
    epochs: int = 5
    batches: int = 4
    discount: float = 0.99
    trace: float = 0.95
    """λ of the advantages."""
    clip: float = 0.2
    divergence: float = 0.01
    """Wanted divergence of the policy in an iteration."""
    rate: float = 1e-3
    """First step size."""
    entropy: float = 0.003
    value_weight: float = 1.0
    gradient: float = 1.0
    """Largest norm of the gradient."""
    hidden: tuple[int, ...] = (128, 128, 64)
    deviation: float = 0.6
    """First standard deviation of the actions."""


def network(inputs: int, hidden: tuple[int, ...], outputs: int, gain: float) -> nn.Sequential:
    """Linear layers with ELU between them; the last layer has weights of this size."""
    widths, parts = [inputs, *hidden], []
    for one, other in zip(widths[:-1], widths[1:], strict=True):
        parts += [nn.Linear(one, other), nn.ELU()]
    last = nn.Linear(widths[-1], outputs)
    nn.init.orthogonal_(last.weight, gain)
    nn.init.zeros_(last.bias)
    return nn.Sequential(*parts, last)


class Agent(nn.Module):
    """Policy with normal actions, value function, and running mean and variance of the observations."""

    def __init__(self, observations: int, actions: int, settings: Settings) -> None:
        super().__init__()
        self.actor = network(observations, settings.hidden, actions, 0.01)
        self.critic = network(observations, settings.hidden, 1, 1.0)
        self.log_deviation = nn.Parameter(torch.full((actions,), float(np.log(settings.deviation))))
        self.register_buffer("mean", torch.zeros(observations))
        self.register_buffer("variance", torch.ones(observations))
        self.register_buffer("count", torch.tensor(1e-4))

    def learn_scale(self, seen: torch.Tensor) -> None:
        """Include observations in the running mean and variance."""
        mean, variance, count = seen.mean(0), seen.var(0, unbiased=False), float(len(seen))
        total, away = self.count + count, mean - self.mean
        squares = self.variance * self.count + variance * count + away**2 * self.count * count / total
        self.mean += away * count / total
        self.variance.copy_(squares / total)
        self.count.copy_(total)

    def scaled(self, seen: torch.Tensor) -> torch.Tensor:
        """Observations with mean 0 and variance 1, cut off at ±10."""
        return ((seen - self.mean) / torch.sqrt(self.variance + 1e-8)).clamp(-10.0, 10.0)

    def forward(self, seen: torch.Tensor) -> torch.Tensor:
        """Most likely actions, clipped to ±1."""
        return self.actor((seen - self.mean) / torch.sqrt(self.variance + 1e-8)).clamp(-1.0, 1.0)


def log_density(x: torch.Tensor, mean: torch.Tensor, log_deviation: torch.Tensor) -> torch.Tensor:
    """Logarithm of the density of independent normal numbers, without the constant."""
    return (-0.5 * ((x - mean) / log_deviation.exp()) ** 2 - log_deviation).sum(-1)


class Rollout:
    """Steps of all environments with the current policy."""

    def __init__(self, envs: TorchEnv | DeviceWalk, settings: Settings) -> None:
        shape, device = (settings.steps, envs.num_envs), envs.device
        self.seen = torch.zeros(*shape, envs.observations, device=device)
        self.actions = torch.zeros(*shape, envs.actions, device=device)
        self.means = torch.zeros(*shape, envs.actions, device=device)
        self.densities, self.rewards, self.values, self.following = torch.zeros(4, *shape, device=device)
        self.fails, self.ends, self.counts = torch.zeros(3, *shape, dtype=torch.bool, device=device)
        self.now = torch.zeros(0)
        self.restarts = torch.zeros(envs.num_envs, dtype=torch.bool, device=device)

    def record(self, envs: TorchEnv | DeviceWalk, agent: Agent, settings: Settings) -> None:
        """Take steps; environments that restart in a step do not count in it."""
        with torch.no_grad():
            self._record(envs, agent, settings)

    def _record(self, envs: TorchEnv | DeviceWalk, agent: Agent, settings: Settings) -> None:
        for t in range(settings.steps):
            self.seen[t] = self.now
            scaled = agent.scaled(self.now)
            self.means[t] = agent.actor(scaled)
            self.actions[t] = self.means[t] + agent.log_deviation.exp() * torch.randn_like(self.means[t])
            self.densities[t] = log_density(self.actions[t], self.means[t], agent.log_deviation)
            self.values[t] = agent.critic(scaled)[:, 0]
            self.now, self.rewards[t], self.fails[t], truncated = envs.step(self.actions[t])
            self.counts[t] = ~self.restarts
            self.restarts = self.ends[t] = self.fails[t] | truncated
            # An episode that ends without failure has the value of its last state.
            self.following[t] = agent.critic(agent.scaled(self.now))[:, 0]

    def advantages(self, settings: Settings) -> torch.Tensor:
        """Generalized advantages of all actions."""
        found, running = torch.zeros_like(self.rewards), torch.zeros_like(self.rewards[0])
        for t in reversed(range(settings.steps)):
            change = self.rewards[t] + settings.discount * self.following[t] * ~self.fails[t] - self.values[t]
            running = change + settings.discount * settings.trace * running * ~self.ends[t]
            found[t] = running
        return found


class Learner:
    """Improves an agent after each rollout."""

    def __init__(self, agent: Agent, settings: Settings) -> None:
        self.agent, self.settings, self.rate = agent, settings, settings.rate
        self.optimizer = torch.optim.Adam(agent.parameters(), lr=settings.rate)

    def improve(self, rollout: Rollout) -> float:
        """Take steps along the gradient of the clipped objective; returns the last divergence."""
        settings, agent = self.settings, self.agent
        advantages, counts = rollout.advantages(settings), rollout.counts.flatten()
        goals = (advantages + rollout.values).flatten()[counts]
        advantages = advantages.flatten()[counts]
        advantages = (advantages - advantages.mean()) / (advantages.std() + 1e-8)
        seen, actions, means = (table.flatten(0, 1)[counts] for table in (rollout.seen, rollout.actions, rollout.means))
        scaled, densities = agent.scaled(seen), rollout.densities.flatten()[counts]
        earlier = agent.log_deviation.detach().clone()
        divergence = 0.0
        for _ in range(settings.epochs):
            for rows in torch.randperm(len(goals), device=goals.device).chunk(settings.batches):
                mean, log_deviation = agent.actor(scaled[rows]), agent.log_deviation
                with torch.no_grad():
                    spread = (earlier.exp() ** 2 + (mean - means[rows]) ** 2) / (2.0 * log_deviation.exp() ** 2)
                    divergence = float((log_deviation - earlier + spread - 0.5).sum(-1).mean())
                    if divergence > 2.0 * settings.divergence:
                        self.rate = max(1e-5, self.rate / 1.5)
                    elif divergence < 0.5 * settings.divergence:
                        self.rate = min(1e-2, self.rate * 1.5)
                    self.optimizer.param_groups[0]["lr"] = self.rate
                ratio = (log_density(actions[rows], mean, log_deviation) - densities[rows]).exp()
                clipped = ratio.clamp(1.0 - settings.clip, 1.0 + settings.clip)
                gain = torch.minimum(ratio * advantages[rows], clipped * advantages[rows]).mean()
                error = ((agent.critic(scaled[rows])[:, 0] - goals[rows]) ** 2).mean()
                loss = settings.value_weight * error - gain - settings.entropy * log_deviation.sum()
                self.optimizer.zero_grad()
                loss.backward()
                nn.utils.clip_grad_norm_(agent.parameters(), settings.gradient)
                self.optimizer.step()
        agent.learn_scale(seen)
        return divergence


def learn(
    task: RobotEnv | DeviceWalk,
    settings: Settings,
    iterations: int,
    *,
    seed: int = 1,
    device: str = "cpu",
    seconds: float = np.inf,
    show: bool = False,
) -> tuple[Agent, list[dict[str, float]]]:
    """Train an agent; returns it, and a row of the reward curve for each iteration.

    Episodes of the environments begin at random ages, so that they do not end together.
    """
    torch.manual_seed(seed)
    begun = time.perf_counter()
    envs = TorchEnv(task, device) if isinstance(task, RobotEnv) else task
    agent = Agent(envs.observations, envs.actions, settings).to(device)
    learner, rollout, curve = Learner(agent, settings), Rollout(envs, settings), []
    rollout.now = envs.reset(seed=seed)
    if isinstance(task, RobotEnv):
        task.age[:] = task.np_random.integers(0, task.horizon, task.num_envs)
    else:
        task.age[:] = torch.randint(0, task.horizon, (task.num_envs,), device=task.device)
    agent.learn_scale(rollout.now)
    physics = 0.0
    for iteration in range(1, iterations + 1):
        start = time.perf_counter()
        rollout.record(envs, agent, settings)
        physics += time.perf_counter() - start
        divergence = learner.improve(rollout)
        steps, elapsed = iteration * settings.steps * task.num_envs, time.perf_counter() - begun
        row = {
            "iteration": iteration,
            "steps": steps,
            "seconds": elapsed,
            "reward": float(rollout.rewards[rollout.counts].mean()),
            "failures": float(rollout.fails.sum()) / (settings.steps * task.num_envs),
            "rate": learner.rate,
            "divergence": divergence,
            "deviation": float(agent.log_deviation.detach().exp().mean()),
            "steps_per_second": steps / elapsed,
            "share_of_steps": physics / elapsed,
        }
        row |= {f"term_{name}": float(term.mean()) for name, term in getattr(task, "terms", {}).items()}
        curve.append(row)
        if show and (iteration % 10 == 0 or iteration == iterations):
            terms = " ".join(f"{name} {row[f'term_{name}']:.2f}" for name in ("linear_velocity", "yaw_rate", "gait") if f"term_{name}" in row)
            print(
                f"iteration {iteration:4}: {steps / 1e6:6.2f} million steps, {elapsed:5.0f} s, {row['steps_per_second']:6.0f} steps/s, "
                f"reward of a step {row['reward']:.4f}, failures {row['failures']:.4f}, deviation {row['deviation']:.2f}, rate {row['rate']:.1e} {terms}",
                flush=True,
            )
        if elapsed > seconds:
            break
    return agent, curve


def record(agent: Agent, task: Walk, command: tuple[float, float, float], steps: int) -> dict[str, Any]:
    """Motion of the most likely actions under one command: times, q, v, actions and rewards of
    environment 0."""
    agent = agent.cpu()
    envs = TorchEnv(task)
    task.commands = np.stack([command, command], axis=1)
    seen, rows = envs.reset(seed=0), []
    for _ in range(steps):
        task.command[:] = command
        with torch.no_grad():
            actions = agent(seen)
        seen, rewards, terminated, truncated = envs.step(actions)
        rows.append((task.q[0].copy(), task.v[0].copy(), actions[0].numpy(), float(rewards[0]), task.has_contact[0, :4].copy()))
        if bool(terminated[0] | truncated[0]):
            break
    q, v, actions, rewards, contact = (np.array(column) for column in zip(*rows, strict=True))
    times = task.control_period * np.arange(1, len(q) + 1)
    return {"t": times, "q": q, "v": v, "actions": actions, "rewards": rewards, "contact": contact, "command": np.array(command)}


def save(agent: Agent, curve: list[dict[str, float]], out: Path) -> None:
    """Write the reward curve, the weights, and the policy as C and as ONNX."""
    out.mkdir(parents=True, exist_ok=True)
    with (out / "curve.csv").open("w", newline="") as file:
        table = csv.DictWriter(file, fieldnames=list(curve[0]))
        table.writeheader()
        table.writerows(curve)
    agent = agent.cpu()
    torch.save(agent.state_dict(), out / "policy.pt")
    layers = [(part.weight.detach().numpy(), part.bias.detach().numpy()) for part in agent.actor if isinstance(part, nn.Linear)]
    deviation = torch.sqrt(agent.variance + 1e-8).numpy()
    (out / "policy.c").write_text(policy_code(layers, mean=agent.mean.numpy(), deviation=deviation))
    try:
        import onnx  # noqa: F401
    except ImportError:
        return
    example = torch.zeros(1, len(agent.mean))
    names: dict[str, Any] = {"input_names": ["observation"], "output_names": ["action"], "dynamic_axes": {"observation": {0: "n"}, "action": {0: "n"}}}
    try:
        with warnings.catch_warnings():
            # The new exporter needs the package onnxscript.
            warnings.simplefilter("ignore", DeprecationWarning)
            torch.onnx.export(agent, (example,), str(out / "policy.onnx"), dynamo=False, **names)
    except Exception as error:  # the exporters of some versions need further packages
        print(f"no ONNX file: {error}")


def device_task(options: argparse.Namespace) -> DeviceWalk:
    """Environments on the device, with random friction and strength if asked."""
    if options.terrain != "flat":
        raise SystemExit("--simulation device has flat ground only: leave out --terrain rough, or --simulation")
    ranges: dict[str, Any] = {"friction": (0.5, 1.2), "strength": (0.9, 1.1)} if options.randomize else {}
    return DeviceWalk(options.envs, device=options.device, **ranges)


def main() -> None:
    """Train, record and save."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--envs", type=int, default=256)
    parser.add_argument("--iterations", type=int, default=400)
    parser.add_argument("--threads", type=int, default=None, help="threads of the simulations; default: all")
    parser.add_argument("--network-threads", type=int, default=1, help="threads of the networks on the CPU")
    parser.add_argument("--terrain", choices=["flat", "rough"], default="flat")
    parser.add_argument("--simulation", choices=["walk", "device"], default="walk", help="the class Walk, or DeviceWalk")
    parser.add_argument("--hidden", type=int, nargs="+", default=Settings.hidden, help="widths of the networks' layers")
    parser.add_argument("--epochs", type=int, default=Settings.epochs, help="passes over each rollout")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--seconds", type=float, default=np.inf, help="time after which no iteration begins")
    parser.add_argument("--device", default="cpu", help="device of the networks, for example cuda")
    parser.add_argument("--randomize", action="store_true", help="randomize friction, trunk mass, motors and delays, and push")
    parser.add_argument("--out", type=Path, default=Path("walk"))
    options = parser.parse_args()
    how: dict[str, Any] = {"threads": options.threads, "ground": rough_ground() if options.terrain == "rough" else None}
    alike = how.copy()
    if options.randomize:
        ranges = Randomization((0.5, 1.2), (0.9, 1.2), "trunk", strength=(0.9, 1.1), stiffness=(0.9, 1.1), damping=(0.8, 1.2), delay=(0, 3))
        how |= {"randomization": ranges, "pushes": Pushes("trunk", 60.0), "noise": 0.02}
    torch.set_num_threads(options.network_threads)
    task: RobotEnv | DeviceWalk = Walk(options.envs, **how) if options.simulation == "walk" else device_task(options)
    settings = Settings(hidden=tuple(options.hidden), epochs=options.epochs)
    agent, curve = learn(
        task, settings, options.iterations, seed=options.seed, device=options.device, seconds=options.seconds, show=True
    )
    save(agent, curve, options.out)
    motion = record(agent, Walk(1, **alike), (0.6, 0.0, 0.0), 500)
    np.savez(options.out / "rollout.npz", **motion)
    speed = float(np.mean(motion["v"][len(motion["v"]) // 2 :, 0]))
    print(f"{len(motion['t'])} of 500 steps with the command 0.6 m/s; mean forward speed of the second half {speed:.2f} m/s")


if __name__ == "__main__":
    main()
