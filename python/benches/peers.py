"""Steps per second of the environments, next to those of table-carrying-ai and Overcooked-AI where they can be imported.

    python python/benches/peers.py

table-carrying-ai (Ng et al., "It Takes Two", ICRA 2023; https://github.com/eleyng/table-carrying-ai) is no package: put a
clone of it on PYTHONPATH, with gym 0.26, pygame, opencv-python-headless, pyyaml and torch installed, which it imports.
Overcooked-AI (Carroll et al., NeurIPS 2019; https://github.com/HumanCompatibleAI/overcooked_ai) is on PyPI: overcooked-ai,
and imports scipy, tqdm, ipython and ipywidgets.

The environments do not simulate the same, so this says what a step costs a learner, not who is faster. Only steps are
timed, without resets, in seconds of one core: the best of several rounds of each, which take turns. Measure a release wheel: ``python/wheel``.
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

import cocarry.environments  # noqa: F401  # registers them

ROUNDS, STEPS = 5, 480
TAKEN = 60  # steps of an episode, before any ends


def single(name, act, **keywords):
    environment = gymnasium.make(name, worlds="environment-4", **keywords)
    rng = np.random.default_rng(0)

    def measure(turn):
        seconds, over = 0.0, True
        for step in range(STEPS):
            if over or step % TAKEN == 0:
                environment.reset(seed=turn * STEPS + step)
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

    def measure(turn):
        environment.reset(seed=turn * count)
        begin = time.process_time()
        for _ in range(TAKEN):
            environment.step(actions)
        return TAKEN * count / (time.process_time() - begin)

    return measure


def table_carrying():
    """TableEnv without a display; None, and the module that is missing, where it is not to be had."""
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

    def measure(_turn):
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


def overcooked():
    """Two cooks that act at random, with the observations of learners; None, and what is missing, as above."""
    np.Inf = np.inf  # its 1.1.0 takes the name that NumPy 2 has removed
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            from overcooked_ai_py.mdp import actions, overcooked_env, overcooked_mdp
        except ModuleNotFoundError as error:
            return None, error.name
        world = overcooked_mdp.OvercookedGridworld.from_layout_name("cramped_room")
        environment = overcooked_env.OvercookedEnv.from_mdp(world, horizon=STEPS + 1, info_level=0)
        environment.lossless_state_encoding_mdp(environment.state)
    rng = np.random.default_rng(0)

    def measure(_turn):
        environment.reset()
        seconds = 0.0
        for _ in range(STEPS):
            joint = [actions.Action.INDEX_TO_ACTION[i] for i in rng.integers(0, len(actions.Action.ALL_ACTIONS), 2)]
            begin = time.process_time()
            state, _, _, _ = environment.step(joint)
            environment.lossless_state_encoding_mdp(state)
            seconds += time.process_time() - begin
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
        ("Options-v0, 512 at once", 0.2, vector(512), "the same"),
        ("Carry-v1, kinematic, inputs", 0.2, single("cocarry/Carry-v1", small), "that, and a mobile manipulator moved by u"),
        ("Carry-v1, kinematic, reference", 0.2, single("cocarry/Carry-v1", ahead, action="reference"), "that, and eq. (7) finds u"),
        (
            "Carry-v1, rapier, inputs", 0.2, single("cocarry/Carry-v1", small, plant="rapier"),
            "the same with rigid bodies, grips and contacts at 100 Hz",
        ),
    ]  # fmt: skip
    peers = [
        ("table-carrying-ai, TableEnv", 1 / 30, table_carrying, "a table in 2-D pushed by two forces, bitmap collisions, drawing"),
        ("Overcooked-AI, cramped_room", None, overcooked, "two cooks on a grid of 5 x 4 cells, observed as masks"),
    ]
    for name, period, make, what in peers:
        measure, missing = make()
        if measure is None:
            print(f"{name}: not here: no module {missing}")
        else:
            rows.append((name, period, measure, what))
    best = [0.0] * len(rows)
    for turn in range(ROUNDS):
        # other people every time; the first episodes of an environment are slower, as nobody was anywhere yet
        best = [max(value, row[2](turn)) for value, row in zip(best, rows)]
    print(f"{'':36} {'steps/s':>10} {'s of a step':>12} {'simulated s/s':>14}   what a step simulates")
    for rate, (name, period, _, what) in zip(best, rows):
        # a step on a grid lasts no time
        step, simulated = ("-", "-") if period is None else (f"{period:.3f}", f"{rate * period:.0f}")
        print(f"{name:36} {rate:10.0f} {step:>12} {simulated:>14}   {what}")


if __name__ == "__main__":
    main()
