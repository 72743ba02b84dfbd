"""PPO and SAC on ``cocarry/Carry-v1`` next to the built-in controller, on humans that training never draws.

    pip install "./python[gymnasium]" -r python/examples/requirements.txt
    python python/examples/learn.py --out carried.csv

With ``residual`` actions an agent adds up to a tenth of the robot's limits to the inputs of the built-in controller
(``mutual`` with eqs. 8 and 7); with ``inputs`` it drives wheels and joints alone. The return is the environment's: -C of
an episode that arrives, and a charge for one that does not.

Training draws seeds below 2^32; the humans of the evaluation have seeds from 2^33, the same for all agents. An agent is
the network after its last update, without exploration. Returns are compared human by human. Intervals are 95 %: of
agents over training seeds (Student's t), of the others over humans. The untrained agents act at random or not at all.
"""

from __future__ import annotations

import argparse
import contextlib
import csv
import os
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from typing import Any

import gymnasium
import numpy as np
from ppo import HELD_OUT, T_95, WORLDS, interval

Act = Callable[[np.ndarray], np.ndarray]
Episodes = list[dict[str, Any]]
BUILT_IN = ("built-in", "residual")
COLUMNS = ["agent", "action", "training_seed", "steps_trained", "world", "seed", "outcome", "steps", "return"]


def vector(action: str, plant: str, lanes: int, mode: str) -> gymnasium.vector.VectorEnv:
    """Environments side by side, in one thread; what the built-in controller would do is not asked for."""
    return gymnasium.make_vec(
        "cocarry/Carry-v1", lanes, plant=plant, action=action, built_in=False, threads=1, autoreset_mode=mode
    )


def carry(act: Act, action: str, plant: str, humans: int) -> Episodes:
    """An episode with every held-out human in every world. act: (n, size) observations to (n, inputs) actions."""
    count = len(WORLDS) * humans
    environment = vector(action, plant, count, "NextStep")
    environment.reset(seed=0)
    episodes: Episodes = []
    for lane in range(count):
        world, human = divmod(lane, humans)
        asked = {"reset_mask": np.arange(count) == lane, "world": world, "seed": HELD_OUT + human}
        observations, _ = environment.reset(options=asked)
        episodes.append({"world": WORLDS[world], "seed": HELD_OUT + human, "return": 0.0})
    over = np.zeros(count, dtype=bool)
    while not over.all():
        observations, rewards, terminated, truncated, info = environment.step(act(observations))
        for i in np.flatnonzero(~over):
            episodes[i]["return"] += float(rewards[i])
            if terminated[i] or truncated[i]:
                episodes[i] |= {"outcome": info["outcome"][i], "steps": info["summary"][i]["steps"]}
        over |= terminated | truncated
    return episodes


def train(algorithm: str, action: str, plant: str, seed: int, steps: int, humans: int) -> Episodes:
    """Trains an agent; returns its episodes with the held-out humans."""
    import torch
    from stable_baselines3 import PPO, SAC
    from stable_baselines3.common.vec_env import VecNormalize

    from native_vector import NativeVector

    torch.set_num_threads(1)
    begin = time.perf_counter()
    lanes = 32 if algorithm == "ppo" else 8
    environment = VecNormalize(NativeVector(vector(action, plant, lanes, "SameStep"), 1_000_003 * seed), gamma=0.99)
    # exploration begins with a standard deviation of 0.14 of an action's range, in both
    model: PPO | SAC
    if algorithm == "ppo":
        model = PPO(
            "MlpPolicy", environment, seed=seed, device="cpu", n_steps=128, batch_size=512, n_epochs=8,
            learning_rate=lambda left: 3e-4 * max(left, 0.05), policy_kwargs={"log_std_init": -2.0},
        )  # fmt: skip
    else:
        model = SAC(
            "MlpPolicy", environment, seed=seed, device="cpu", learning_starts=2000, batch_size=256,
            gradient_steps=2, ent_coef="auto_0.01", policy_kwargs={"log_std_init": -2.0},
        )  # fmt: skip
    model.learn(steps)

    def act(observations: np.ndarray) -> np.ndarray:
        return model.predict(environment.normalize_obs(observations), deterministic=True)[0]

    about = {"agent": algorithm, "action": action, "training_seed": seed, "steps_trained": model.num_timesteps}
    episodes = [{**about, **episode} for episode in carry(act, action, plant, humans)]
    seconds = time.perf_counter() - begin
    print(f"{algorithm} {action} {seed}: {model.num_timesteps} steps, {seconds:.0f} s", flush=True)
    return episodes


def untrained(plant: str, humans: int) -> list[Episodes]:
    """The built-in controller, and agents that have learned nothing."""
    with_size = {action: vector(action, plant, 1, "NextStep").single_action_space.shape[0] for action in ("residual", "inputs")}
    found = []
    for agent, action in [BUILT_IN, ("standing still", "inputs"), ("random", "residual"), ("random", "inputs")]:
        rng, size = np.random.default_rng(0), with_size[action]
        zero = agent != "random"

        def act(observations: np.ndarray, rng=rng, size=size, zero=zero) -> np.ndarray:
            return np.zeros((len(observations), size)) if zero else rng.uniform(-1, 1, (len(observations), size))

        about = {"agent": agent, "action": action, "training_seed": "", "steps_trained": 0}
        found.append([{**about, **episode} for episode in carry(act, action, plant, humans)])
    return found


def table(runs: list[Episodes]) -> list[str]:
    """A line for every agent: arrivals, return, and return minus that of the built-in controller with the same humans."""
    carried = {(e["world"], e["seed"]): e["return"] for run in runs for e in run if (e["agent"], e["action"]) == BUILT_IN}
    groups: dict[tuple[str, str], list[Episodes]] = {}
    for run in sorted(runs, key=lambda run: (run[0]["steps_trained"] > 0, run[0]["agent"], run[0]["action"])):
        groups.setdefault((run[0]["agent"], run[0]["action"]), []).append(run)
    lines = [f"{'agent':15}{'action':10}{'seeds':>5}{'arrived, %':>18}{'steps':>8}{'return':>12}{'minus built-in':>24}{'early, better':>15}"]
    for (agent, action), of_seeds in groups.items():
        arrived = np.array([[e["outcome"] == "arrived" for e in run] for run in of_seeds])
        returns = np.array([[e["return"] for e in run] for run in of_seeds])
        minus = returns - np.array([carried[e["world"], e["seed"]] for e in of_seeds[0]])
        if len(of_seeds) > 1:
            units, factor = [np.mean(a, axis=1) for a in (arrived, minus)], T_95[len(of_seeds) - 1]
        else:  # a human is one unit over all worlds
            units, factor = [a[0].reshape(len(WORLDS), -1).mean(axis=0) for a in (arrived, minus)], 1.96
        (share, share_half), (mean, half) = (interval(unit, factor) for unit in units)
        early = (~arrived & (minus >= 0)).sum()
        steps = np.mean([e["steps"] for run in of_seeds for e in run])
        lines.append(
            f"{agent:15}{action:10}{len(of_seeds):5}{f'{100 * share:.1f} +- {100 * share_half:.1f}':>18}{steps:8.1f}"
            f"{returns.mean():12.1f}{f'{mean:+.2f} +- {half:.2f}':>24}{f'{early} of {(~arrived).sum()}':>15}"
        )
    return lines


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--algorithms", nargs="+", choices=["ppo", "sac"], default=["ppo", "sac"])
    parser.add_argument("--actions", nargs="+", choices=["residual", "inputs"], default=["residual", "inputs"])
    parser.add_argument("--plant", choices=["kinematic", "rapier"], default="kinematic")
    parser.add_argument("--ppo-steps", type=int, default=400_000, help="training steps of PPO")
    parser.add_argument("--sac-steps", type=int, default=60_000, help="training steps of SAC")
    parser.add_argument("--seeds", type=int, default=3, help="training seeds, at most 10")
    parser.add_argument("--humans", type=int, default=50, help="held-out humans, each in four worlds")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--out", help="a CSV file of all held-out episodes")
    given = parser.parse_args()

    steps = {"ppo": given.ppo_steps, "sac": given.sac_steps}
    work = [
        (algorithm, action, given.plant, seed, steps[algorithm], given.humans)
        for seed in range(given.seeds) for action in given.actions for algorithm in given.algorithms
    ]  # fmt: skip
    runs = untrained(given.plant, given.humans)
    with contextlib.ExitStack() as stack:
        file = stack.enter_context(open(given.out or os.devnull, "w", encoding="utf-8", newline=""))
        writer = csv.DictWriter(file, COLUMNS)
        writer.writeheader()
        writer.writerows(episode for run in runs for episode in run)
        pool = stack.enter_context(ProcessPoolExecutor(given.processes, mp_context=get_context("spawn")))
        for job in as_completed([pool.submit(train, *job) for job in work]):
            runs.append(job.result())
            writer.writerows(runs[-1])
            file.flush()  # an agent that is trained is not lost
    print("\n".join(table(runs)))


if __name__ == "__main__":
    main()
