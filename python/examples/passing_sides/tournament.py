"""The passing-side policies against the built-in ones: success, time and the hand's acceleration, with 95 % intervals.

    python python/examples/passing_sides/tournament.py --seeds 20 --processes 2
    python python/examples/passing_sides/tournament.py --seeds 20 --policies learned ic-mpc --weights model.ckpt

Every policy carries with the same humans of the same seeds, in bodies (rapier), at most at the speed of the paper's
robot, 0.3 m/s. An episode succeeds once the object's centre is within 0.25 m of B, where the paper's robot stops, unless
it collided, lost the object or ran out of time before. Time and acceleration are those of successes.
"""

from __future__ import annotations

import argparse
import math
import pathlib
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from typing import Any

import cocarry
import numpy as np

from force_partner import ForcePartner
from learned_planner import SCORE_WALLS_PX, WINDOW_PX, LearnedPlanner
from passing_policies import IcMpc, VanillaMpc
from scenes import OnePost, Scene, Walls

ROOM = pathlib.Path(__file__).with_name("room.toml")
WORLDS = ["room", "environment-1", "environment-2", "environment-3", "environment-4"]
HUMANS = ["force", "scripted", "boltzmann", "preference"]
#: The policies of the paper, as published, and with base and object kept clear of all walls.
OTHERS: dict[str, type[VanillaMpc]] = {"ic-mpc": IcMpc, "vanilla-mpc": VanillaMpc, "ic-mpc-walls": IcMpc, "vanilla-mpc-walls": VanillaMpc}
#: Walls of the score, pixels, and heading of an object that points at the human, rad: the learned planner as published,
#: with the score's walls at the window's sides, and as if the two carried side by side. All need a file of weights.
LEARNED: dict[str, tuple[tuple[float, float], float]] = {
    "learned": (SCORE_WALLS_PX, math.pi),
    "learned-sides": (WINDOW_PX, math.pi),
    "learned-beside": (SCORE_WALLS_PX, math.pi / 2.0),
}
POLICIES = [*OTHERS, "mutual", "mutual-learns", "follow-hand", "human-led", "robot-led"]
SPEED_M_PER_S = 0.3
SUCCESS_DISTANCE_M = 0.25
#: Largest simulated time of an episode, s, in the room and in other worlds.
TIME_LIMIT_S = {"room": 60.0, "other": 150.0}
PLANNING_STEP_S = 0.2
#: The hand's acceleration is measured without the first second, as in the paper.
START_S = 1.0
RESAMPLES = 2000


@dataclass(frozen=True)
class Cell:
    """One episode of the tournament."""

    world: str
    human: str
    policy: str
    seed: int
    #: The checkpoint of the learned planner.
    weights: str | None = None


@dataclass(frozen=True)
class Result:
    """The result of an episode."""

    #: How it ended: "success", or the outcome that came before.
    outcome: str
    #: Time until the end, s.
    time_s: float
    #: Mean of the norm of the hand's acceleration, m/s^2, from its positions at every planning step.
    hand_acceleration_m_per_s2: float
    #: Root mean square of the human's force on the object, N.
    hand_force_n: float


def play(cell: Cell) -> Result:
    """Plays an episode."""
    world = cocarry.World(ROOM) if cell.world == "room" else cocarry.World(cell.world)
    limit = TIME_LIMIT_S.get(cell.world, TIME_LIMIT_S["other"])
    options = world.options()
    draws = np.random.default_rng([cell.seed, 43])
    preferred, patience_ns = int(draws.integers(len(options))), float(draws.uniform(10.0, 80.0))
    model = {"scripted": f"scripted(0:{options[preferred]})", "boltzmann": "boltzmann(2)"}.get(cell.human, "preference")
    built_in: dict[str, Any] = {} if cell.policy in [*OTHERS, *LEARNED] else {"method": cell.policy.removesuffix("-learns")}
    scenario = cocarry.Scenario(
        world,
        plant="rapier",
        seed=cell.seed,
        belief_update="learn" if cell.policy == "mutual-learns" else "prior",
        human_model=model,
        speed_m_per_s=SPEED_M_PER_S,
        planning_step_s=PLANNING_STEP_S,
        max_steps=round(limit / PLANNING_STEP_S),
        **built_in,
    )
    partners: dict[str, Any] = {}
    if cell.human == "force":
        reach_m = 0.45 if cell.world == "room" else 0.6
        partners["human"] = ForcePartner(
            preferred,
            reach_m=reach_m,
            speed_m_per_s=SPEED_M_PER_S,
            patience_ns=patience_ns,
            walls=Walls(world),
        )
    if cell.policy in OTHERS:
        walls = Walls(world) if cell.world != "room" or cell.policy.endswith("-walls") else None
        target = (float(world.target[0]), float(world.target[1]))
        scene: Scene = OnePost((0.0, 0.0), target, walls) if cell.world == "room" or walls is None else walls
        partners["policy"] = OTHERS[cell.policy](scene, cell.seed)
    if cell.policy in LEARNED:
        if cell.weights is None or cell.world != "room":
            raise ValueError(f"{cell.policy} in {cell.world}: it needs --weights, and knows only the room")
        post = OnePost((0.0, 0.0), (float(world.target[0]), float(world.target[1])))
        walls_px, heading = LEARNED[cell.policy]
        partners["policy"] = LearnedPlanner(cell.weights, post, cell.seed, score_walls=walls_px, heading=heading)
    episode = cocarry.Episode(scenario, **partners)
    hands: list[tuple[float, float]] = []
    forces: list[float] = []
    outcome = None
    for tick in episode:
        hands.append((tick["hand_x_m"], tick["hand_y_m"]))
        forces.append(tick["hand_force_n"])
        if math.dist((tick["object_x_m"], tick["object_y_m"]), world.target) < SUCCESS_DISTANCE_M:
            outcome = "success"
            break
    outcome = outcome or str(episode.summary["outcome"])
    if outcome == "arrived":
        outcome = "success"
    moved = np.array(hands[round(START_S / PLANNING_STEP_S) :])
    accelerations = np.diff(moved, n=2, axis=0) / PLANNING_STEP_S**2 if len(moved) > 2 else np.full((1, 2), np.nan)
    return Result(
        outcome,
        len(hands) * PLANNING_STEP_S,
        float(np.hypot(*accelerations.T).mean()),
        float(np.sqrt(np.mean(np.square(forces)))),
    )


def share_interval(successes: int, count: int) -> tuple[float, float]:
    """Wilson's 95 % interval of a share."""
    z = 1.959964
    share, spread = successes / count, z * z / count
    centre = (share + spread / 2.0) / (1.0 + spread)
    half = z * math.sqrt(share * (1.0 - share) / count + spread / count / 4.0) / (1.0 + spread)
    return max(0.0, centre - half), min(1.0, centre + half)


def mean_interval(values: Sequence[float]) -> tuple[float, float, float]:
    """Mean and its 95 % interval by the bootstrap (percentiles of resampled means); NaN for fewer than two values."""
    if len(values) < 2:
        return (values[0] if values else math.nan), math.nan, math.nan
    numbers = np.asarray(values, float)
    resampled = np.random.default_rng(0).choice(numbers, (RESAMPLES, len(numbers))).mean(axis=1)
    low, high = np.percentile(resampled, [2.5, 97.5])
    return float(numbers.mean()), float(low), float(high)


def paired_difference(first: Sequence[Result], second: Sequence[Result], key: str) -> tuple[int, float, float, float]:
    """Number of seeds of which both succeed, and the mean difference of a quantity, first minus second, with its interval."""
    both = [(a, b) for a, b in zip(first, second) if a.outcome == b.outcome == "success"]
    return len(both), *mean_interval([getattr(a, key) - getattr(b, key) for a, b in both])


def table(cells: Sequence[Cell], results: Sequence[Result]) -> Iterator[str]:
    """Lines of Markdown: a row for every world, human and policy."""
    yield "| world | human | policy | success | 95 % | time (s) | acceleration (m/s^2) | human's force (N) | other ends |"
    yield "| --- | --- | --- | --- | --- | --- | --- | --- | --- |"
    groups: dict[tuple[str, str, str], list[Result]] = {}
    for cell, result in zip(cells, results):
        groups.setdefault((cell.world, cell.human, cell.policy), []).append(result)
    for (world, human, policy), group in groups.items():
        good = [result for result in group if result.outcome == "success"]
        low, high = share_interval(len(good), len(group))
        ends = sorted({result.outcome for result in group} - {"success"})
        others = ", ".join(f"{sum(result.outcome == end for result in group)} {end}" for end in ends)
        time, acceleration, force = (
            shown([getattr(result, key) for result in good], digits)
            for key, digits in (("time_s", 1), ("hand_acceleration_m_per_s2", 3), ("hand_force_n", 1))
        )
        yield (
            f"| {world} | {human} | {policy} | {len(good)}/{len(group)} | {100 * low:.0f} to {100 * high:.0f} % "
            f"| {time} | {acceleration} | {force} | {others} |"
        )


def shown(values: Sequence[float], digits: int) -> str:
    """A mean with its interval, as text."""
    mean, low, high = mean_interval(values)
    if math.isnan(mean):
        return "-"
    return f"{mean:.{digits}f}" + ("" if math.isnan(low) else f" ({low:.{digits}f} to {high:.{digits}f})")


def main() -> None:
    """Plays the tournament that the command line asks for."""
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--worlds", nargs="+", choices=WORLDS, default=["room"])
    arguments.add_argument("--humans", nargs="+", choices=HUMANS, default=HUMANS)
    arguments.add_argument("--policies", nargs="+", choices=[*POLICIES, *LEARNED], default=POLICIES)
    arguments.add_argument("--weights", help="the checkpoint of the learned planner, model.ckpt of its authors")
    arguments.add_argument("--seeds", type=int, default=20)
    arguments.add_argument("--processes", type=int, default=1)
    given = arguments.parse_args()
    if set(LEARNED) & set(given.policies) and (given.weights is None or given.worlds != ["room"]):
        arguments.error("the learned planner needs --weights, and knows only the room")
    cells = [
        Cell(world, human, policy, seed, given.weights)
        for world in given.worlds
        for human in given.humans
        for policy in given.policies
        for seed in range(given.seeds)
    ]
    with ProcessPoolExecutor(given.processes) as pool:
        results = list(pool.map(play, cells, chunksize=given.seeds))
    for line in table(cells, results):
        print(line)
    for suffix in ("", "-walls"):
        first, second = f"ic-mpc{suffix}", f"vanilla-mpc{suffix}"
        if not {first, second} <= set(given.policies):
            continue
        print(f"\n{first} minus {second}, where both succeed:")
        for world in given.worlds:
            for human in given.humans:
                played = {
                    policy: [result for cell, result in zip(cells, results) if (cell.world, cell.human, cell.policy) == (world, human, policy)]
                    for policy in (first, second)
                }
                count, *time = paired_difference(played[first], played[second], "time_s")
                if count < 2:
                    print(f"{world}, {human}: n {count}")
                    continue
                _, *acceleration = paired_difference(played[first], played[second], "hand_acceleration_m_per_s2")
                print(
                    f"{world}, {human}: n {count}, time {time[0]:+.2f} s ({time[1]:+.2f} to {time[2]:+.2f}), "
                    f"acceleration {acceleration[0]:+.4f} m/s^2 ({acceleration[1]:+.4f} to {acceleration[2]:+.4f})"
                )


if __name__ == "__main__":
    main()
