"""What Python adds to a step, alongside the Rust loop in the same run: ``python python/benches/overhead.py``.

The Rust loop is ``Episode.run``, which takes many steps in a call. Measure a release wheel: ``python/wheel``.
Every figure is the least of several repetitions, us per step; of CPU time, so that a busy machine disturbs little,
except where there are two threads.
"""

from __future__ import annotations

import time

import gymnasium
import numpy as np

import cocarry
import cocarry.environments

REPETITIONS = 15


def least(*measures) -> list[float]:
    """The least time of a step of each, us. They take turns, so that a busy machine disturbs all alike."""
    found: list[list[float]] = [[] for _ in measures]
    for _ in range(REPETITIONS):
        for times, measure in zip(found, measures):
            seconds, steps = measure()
            times.append(1e6 * seconds / steps)
    return [min(times) for times in found]


def loop(plant: str, count: int):
    def measure():
        episodes = [cocarry.Episode(cocarry.Scenario("environment-4", plant=plant, seed=seed)) for seed in range(count)]
        begin = time.process_time()
        for episode in episodes:
            episode.run()
        return time.process_time() - begin, sum(episode.steps for episode in episodes)

    return measure


def steps(plant: str, count: int):
    def measure():
        episodes = [cocarry.Episode(cocarry.Scenario("environment-4", plant=plant, seed=seed)) for seed in range(count)]
        begin = time.process_time()
        for episode in episodes:
            while episode.step() is None:
                pass
        return time.process_time() - begin, sum(episode.steps for episode in episodes)

    return measure


def eq6(view):
    if view.mode == "human-led" or view.stance == "take-over":
        return None
    cost = (1 - view.stubbornness) * view.objective_cost_m + view.stubbornness * view.expected_subjective_cost
    return view.executed if view.executed is not None and cost[view.executed] == cost.min() else int(cost.argmin())


def own(count: int):
    def measure():
        episodes = [
            cocarry.Episode(cocarry.Scenario("environment-4", plant="point", seed=seed), policy=eq6) for seed in range(count)
        ]
        begin = time.process_time()
        for episode in episodes:
            episode.run()
        return time.process_time() - begin, sum(episode.steps for episode in episodes)

    return measure


TAKEN = 60  # steps of an environment, before any episode ends


def follow(count: int):
    """The Rust loop of the same steps as an environment's whose action is always to follow."""

    def measure():
        episodes = [
            cocarry.Episode(cocarry.Scenario("environment-4", plant="point", seed=seed, method="human-led"))
            for seed in range(count)
        ]
        begin = time.process_time()
        for episode in episodes:
            episode.run(TAKEN)
        return time.process_time() - begin, sum(episode.steps for episode in episodes)

    return measure


def vector(count: int, threads: int, copy: bool):
    environment = gymnasium.make_vec("cocarry/Options-v0", count, worlds="environment-4", threads=threads, copy=copy)
    actions = np.full(count, environment.single_action_space.n - 1)

    clock = time.process_time if threads == 1 else time.perf_counter

    def measure():
        environment.reset(seed=0)
        begin = clock()
        for _ in range(TAKEN):
            environment.step(actions)
        return clock() - begin, TAKEN * count

    return measure


def single():
    environment = gymnasium.make("cocarry/Options-v0", worlds="environment-4").unwrapped
    action = environment.action_space.n - 1

    def measure():
        seconds = 0.0
        for seed in range(20):
            environment.reset(options={"seed": seed})
            begin = time.process_time()
            for _ in range(TAKEN):
                environment.step(action)
            seconds += time.process_time() - begin
        return seconds, 20 * TAKEN

    return measure


def main() -> None:
    rows = []
    for plant, count in (("point", 20), ("kinematic", 3), ("rapier", 2)):
        rows.append((f"Episode.step, {plant}", *least(loop(plant, count), steps(plant, count))))
    rows.append(("custom policy (eq. 6), point", *least(loop("point", 20), own(20))))
    rows.append(("Options-v0, single", *least(follow(20), single())))
    for threads in (1, 2):
        name = f"Options-v0, 64 at once, {threads} thread{'s (wall)' if threads > 1 else ''}"
        rows.append((name, *least(follow(64), vector(64, threads, copy=True))))
    print(f"{'':40} {'Rust loop':>10} {'Python':>10} {'added':>9}   us per step")
    for name, rust, python in rows:
        print(f"{name:40} {rust:10.2f} {python:10.2f} {python - rust:9.2f}   {100 * (python / rust - 1):+.1f} %")


if __name__ == "__main__":
    main()
