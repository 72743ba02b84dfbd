"""PPO on ``cocarry/Options-v0`` against eq. (6), on humans that training never draws.

    pip install "./python[gymnasium]" -r python/examples/requirements.txt
    python python/examples/ppo.py --out learner.json --picture learner.png

The reward is the environment's default, -(J + J^) a step, undiscounted: the return is minus the paper's accumulated
objective and subjective cost. Training draws seeds below 2^32; the humans of the evaluation have seeds from 2^33.
A policy is the network after its last update, with its most probable action. Costs are compared human by human.
The intervals are 95 %: of PPO and random over training seeds (Student's t), of the methods over humans (normal).

``--steps 250000 --seeds 4 --checks 5`` takes 88 s on two cores: PPO costs 62 +- 360 more than eq. (6), and so does not beat it.
"""

from __future__ import annotations

import argparse
import json
import statistics
import time
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import gymnasium
import numpy as np

import cocarry
import cocarry.environments

WORLDS = [f"environment-{i}" for i in range(1, 5)]
METHODS = ["mutual", "without-model", "robot-led"]
HELD_OUT, VALIDATION = 2**33, 2**32
T_95 = [np.nan, 12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262]  # by degrees of freedom


def of_methods(first: int, humans: int) -> dict[str, np.ndarray]:
    """J + J^ of episodes by the built-in methods: (worlds, humans)."""
    seeds = {"first": first, "last": first + humans - 1}
    costs = {}
    for method in METHODS:
        table = cocarry.sweep({"worlds": WORLDS, "plants": "point", "methods": method, "seeds": seeds})
        total = table["accumulated_objective_cost_m"] + table["accumulated_subjective_cost"]
        order = np.lexsort((table["seed"], table["world"]))
        costs[method] = total[order].reshape(len(WORLDS), humans)
    return costs


def of_policy(act, first: int, humans: int, threads: int = 1) -> np.ndarray:
    """J + J^ of the same episodes through the environment; act: (n, size) observations to (n,) actions."""
    count = len(WORLDS) * humans
    environment = gymnasium.make_vec("cocarry/Options-v0", count, threads=threads)
    environment.reset(seed=0)
    for lane in range(count):
        mask = np.arange(count) == lane
        world, human = divmod(lane, humans)
        observations, _ = environment.reset(options={"reset_mask": mask, "world": world, "seed": first + human})
    total, over = np.zeros(count), np.zeros(count, dtype=bool)
    while not over.all():
        observations, rewards, terminated, truncated, _ = environment.step(act(observations))
        total -= np.where(over, 0.0, rewards)
        over |= terminated | truncated
    return total.reshape(len(WORLDS), humans)


def eq6(observations: np.ndarray) -> np.ndarray:
    """Eq. (6) as a function of observations."""
    options = observations[:, :-3].reshape(len(observations), -1, 7)
    phi = np.minimum(observations[:, -3:-2], 1)
    cost = (1 - phi) * options[:, :, 2] + phi * options[:, :, 3]
    cost[options[:, :, 0] == 0] = np.inf  # worlds with fewer options
    executed = options[:, :, 6] * (cost == cost.min(axis=1, keepdims=True))
    option = np.where(executed.any(axis=1), executed.argmax(axis=1), cost.argmin(axis=1))
    return np.where(observations[:, -2:].any(axis=1), options.shape[1], option)


def train(seed: int, steps: int, lanes: int, checks: int, humans: int) -> dict:
    """Trains one policy; returns its learning curve and its costs of the held-out humans."""
    import torch
    from stable_baselines3 import PPO
    from stable_baselines3.common.callbacks import BaseCallback
    from stable_baselines3.common.vec_env import VecNormalize

    from native_vector import NativeVector

    torch.set_num_threads(1)
    vector = gymnasium.make_vec("cocarry/Options-v0", lanes, threads=1, autoreset_mode="SameStep")
    environment = VecNormalize(NativeVector(vector, 1_000_003 * seed), gamma=1.0)
    model = PPO(
        "MlpPolicy", environment, seed=seed, device="cpu", gamma=1.0, gae_lambda=0.98, n_steps=128, batch_size=2048,
        n_epochs=6, learning_rate=lambda left: 1e-3 * max(left, 0.05), ent_coef=0.003,
    )  # fmt: skip

    def act(observations):
        return model.predict(environment.normalize_obs(observations), deterministic=True)[0]

    curve = []

    def check():
        curve.append([model.num_timesteps, float(of_policy(act, VALIDATION, 20).mean())])

    class Checks(BaseCallback):
        """The points of the learning curve, each after the first whole update that reaches it."""

        def _on_step(self):
            return True

        def _on_rollout_start(self):
            if self.num_timesteps >= len(curve) * steps / checks:
                check()

    model.learn(steps, callback=Checks())
    check()
    return {"seed": seed, "curve": curve, "costs": of_policy(act, HELD_OUT, humans)}


def interval(differences: np.ndarray, factor: float) -> list[float]:
    """Mean, and half the width of the interval."""
    half = factor * differences.std(ddof=1) / np.sqrt(len(differences)) if len(differences) > 1 else np.nan
    return [float(differences.mean()), float(half)]


def compare(costs: dict[str, list[np.ndarray]], baseline: np.ndarray) -> dict:
    """Means, and differences from ``mutual`` of the same humans, for every world and all of them."""
    found = {}
    for name, runs in costs.items():
        per_seed = np.array([[*run.mean(axis=1), run.mean()] for run in runs])
        rows = {}
        for i, world in enumerate([*WORLDS, "all"]):
            if len(runs) > 1:
                against = interval(per_seed[:, i] - [*baseline.mean(axis=1), baseline.mean()][i], T_95[len(runs) - 1])
            else:
                paired = runs[0] - baseline  # a human is one unit over all worlds
                against = interval(paired[i] if i < len(WORLDS) else paired.mean(axis=0), statistics.NormalDist().inv_cdf(0.975))
            rows[world] = {"mean": float(per_seed[:, i].mean()), "minus_mutual": against[0], "half_95": against[1]}
        found[name] = rows
    return found


def draw(curves: np.ndarray, lines: dict[str, float], file: str) -> None:
    """The learning curve; curves: (seeds, checks, 2)."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(figsize=(5.2, 3.2), layout="constrained", facecolor="white")
    steps, costs = curves[0, :, 0] / 1000, curves[:, :, 1]
    mean = costs.mean(axis=0)
    if len(costs) > 1:
        half = T_95[len(costs) - 1] * costs.std(axis=0, ddof=1) / np.sqrt(len(costs))
        axes.fill_between(steps, mean - half, mean + half, color="0.85", label="95 % interval over training seeds")
    axes.plot(steps, mean, color="black", linewidth=2, label=f"PPO, mean of {len(costs)} training seeds")
    for (name, cost), dash in zip(lines.items(), ["--", ":", "-."]):
        axes.axhline(cost, color="0.25", linestyle=dash, linewidth=1.2, label=name)
    low = min(mean.min(), *lines.values())
    axes.set_ylim(low - 150, max(lines.values()) + 1500)
    axes.set(xlabel="Training steps (thousands)", ylabel="Accumulated cost J + J^ of an episode")
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(facecolor="white", framealpha=1, edgecolor="white", fontsize=8)
    figure.savefig(file, dpi=200)


def main(arguments: list[str] | None = None) -> dict:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--steps", type=int, default=400_000, help="training steps of a seed")
    parser.add_argument("--seeds", type=int, default=4, help="training seeds, at most 10")
    parser.add_argument("--humans", type=int, default=100, help="held-out humans")
    parser.add_argument("--lanes", type=int, default=64, help="environments side by side")
    parser.add_argument("--checks", type=int, default=10, help="points of the learning curve")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--out", help="JSON file of all figures")
    parser.add_argument("--picture", help="PNG or SVG file of the learning curve")
    given = parser.parse_args(arguments)

    begin = time.perf_counter()
    costs = {name: [found] for name, found in of_methods(HELD_OUT, given.humans).items()}
    mutual = costs["mutual"][0]
    # the reward is that cost
    np.testing.assert_allclose(of_policy(eq6, HELD_OUT, given.humans), mutual, rtol=1e-9)
    rngs = [np.random.default_rng(seed) for seed in range(given.seeds)]
    costs["random"] = [of_policy(lambda o, r=r: r.integers(0, 5, len(o)), HELD_OUT, given.humans) for r in rngs]
    work = (given.steps, given.lanes, given.checks, given.humans)
    if given.processes > 1:
        with ProcessPoolExecutor(given.processes, mp_context=get_context("spawn")) as pool:
            runs = [job.result() for job in [pool.submit(train, seed, *work) for seed in range(given.seeds)]]
    else:
        runs = [train(seed, *work) for seed in range(given.seeds)]
    costs["ppo"] = [run["costs"] for run in runs]
    found = {
        "steps": given.steps, "training_seeds": given.seeds, "humans": given.humans,
        "seconds": round(time.perf_counter() - begin, 1), "costs": compare(costs, mutual),
        "curves": [run["curve"] for run in runs],
    }  # fmt: skip
    print(f"{'J + J^ (minus mutual)':22}" + "".join(f"{world:>24}" for world in [*WORLDS, "all"]))
    for name, rows in found["costs"].items():
        cells = [f"{r['mean']:.0f} ({r['minus_mutual']:+.0f} +- {r['half_95']:.0f})" for r in rows.values()]
        print(f"{name:22}" + "".join(f"{cell:>24}" for cell in cells))
    print(f"{found['seconds']} s")
    if given.out:
        with open(given.out, "w", encoding="utf-8") as file:
            json.dump(found, file, indent=1)
    if given.picture:
        validation = {name: float(of.mean()) for name, of in of_methods(VALIDATION, 20).items()}
        draw(np.array(found["curves"]), validation, given.picture)
    return found


if __name__ == "__main__":
    main()
