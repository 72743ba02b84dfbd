"""Steps per second of the environments, next to those of table-carrying-ai where it can be imported.

    python python/benches/peers.py

table-carrying-ai (Ng et al., "It Takes Two", ICRA 2023; https://github.com/eleyng/table-carrying-ai) is no package: put a
clone of it on PYTHONPATH, with gym 0.26, pygame, opencv-python-headless, pyyaml and torch installed, which it imports.

The environments do not simulate the same, so this says what a step costs a learner, not who is faster. Only steps are
timed, without resets, in seconds of one core: the best of several rounds of each, which take turns. Measure a release wheel: ``python/check release``.
"""

from __future__ import annotations

import contextlib
import io
import os
import pathlib
import time
import warnings

import gymnasium
import numpy as np

ROUNDS, STEPS = 5, 480
TAKEN = 60  # steps of an episode, before any ends


def single(name, act, **keywords):
    environment = gymnasium.make(name, worlds="environment-4", **keywords)
    rng = np.random.default_rng(0)

    def measure():
        seconds, over = 0.0, True
        for step in range(STEPS):
            if over or step % TAKEN == 0:
                environment.reset(seed=step)
            given = act(environment.action_space, rng)
            begin = time.process_time()
            _, _, terminated, truncated, _ = environment.step(given)
            seconds += time.process_time() - begin
            over = terminated or truncated
        return STEPS / seconds

    return measure


def vector(count):
    environment = gymnasium.make_vec("cocarry/Options-v0", count, worlds="environment-4", threads=1)
    actions = np.full(count, environment.single_action_space.n - 1)

    def measure():
        environment.reset(seed=0)
        begin = time.process_time()
        for _ in range(TAKEN):
            environment.step(actions)
        return TAKEN * count / (time.process_time() - begin)

    return measure


def peer():
    """The peer's environment without a display; None where it is not to be had."""
    os.environ.setdefault("SDL_VIDEODRIVER", "dummy")
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            from cooperative_transport.gym_table import envs
        except ModuleNotFoundError as error:
            return None, error.name
        maps = pathlib.Path(envs.__file__).parents[1] / "config" / "maps" / "rnd_obstacle_v2.yml"
        environment = envs.TableEnv(render_mode="headless", map_config=str(maps))
        environment.reset()
    rng = np.random.default_rng(0)

    def measure():
        seconds = 0.0
        with contextlib.redirect_stdout(io.StringIO()):  # it tells how every episode ends
            for _ in range(STEPS):
                action = rng.uniform(-1, 1, 4).astype(np.float32)
                begin = time.process_time()
                _, _, done, _ = environment.step(action)
                # its last step also writes files and resets
                seconds += 0.0 if done else time.process_time() - begin
        return STEPS / seconds

    return measure, None


def follow(space, _rng):
    return space.n - 1


def small(space, rng):
    return 0.1 * rng.uniform(-1, 1, space.shape)


def ahead(_space, _rng):
    return np.array([0.3, 0.0, 0.0])


def main():
    rows = [
        ("Options-v0", 0.2, single("cocarry/Options-v0", follow), "a point that plans: paths of all options, P_o, phi"),
        ("Options-v0, 64 at once", 0.2, vector(64), "the same"),
        ("Carry-v0, kinematic, inputs", 0.2, single("cocarry/Carry-v0", small), "that, and a mobile manipulator moved by u"),
        ("Carry-v0, kinematic, reference", 0.2, single("cocarry/Carry-v0", ahead, action="reference"), "that, and eq. (7) finds u"),
        (
            "Carry-v0, rapier, inputs", 0.2, single("cocarry/Carry-v0", small, plant="rapier"),
            "the same with rigid bodies, grips and contacts at 240 Hz",
        ),
    ]  # fmt: skip
    measure, missing = peer()
    if measure is None:
        print(f"table-carrying-ai is not here: no module {missing}\n")
    else:
        rows.append(("table-carrying-ai, TableEnv", 1 / 30, measure, "a table in 2-D pushed by two forces, bitmap collisions, drawing"))
    best = [0.0] * len(rows)
    for _ in range(ROUNDS):
        best = [max(value, row[2]()) for value, row in zip(best, rows)]
    print(f"{'':36} {'steps/s':>10} {'s of a step':>12} {'simulated s/s':>14}   what a step simulates")
    for rate, (name, period, _, what) in zip(best, rows):
        print(f"{name:36} {rate:10.0f} {period:12.3f} {rate * period:14.0f}   {what}")


if __name__ == "__main__":
    main()
