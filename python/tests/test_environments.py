"""Gymnasium's environments and the native vector environment."""

from __future__ import annotations

import multiprocessing
import subprocess
import sys
import warnings

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode, SyncVectorEnv

import cocarry
import cocarry.environments

VARIANTS = [
    ("cocarry/Options-v0", {}),
    ("cocarry/Carry-v0", {"plant": "kinematic", "action": "inputs"}),
    ("cocarry/Carry-v0", {"plant": "kinematic", "action": "reference"}),
    ("cocarry/Carry-v0", {"plant": "rapier", "action": "reference", "worlds": "environment-4"}),
]


@pytest.mark.parametrize(("name", "keywords"), VARIANTS)
def test_check_env_passes_without_warnings(name, keywords):
    environment = gymnasium.make(name, disable_env_checker=True, **keywords)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(environment.unwrapped)


@pytest.mark.parametrize("mode", ["rgb_array", "html"])
@pytest.mark.parametrize("name", ["cocarry/Options-v0", "cocarry/Carry-v0"])
def test_episodes_are_rendered(name, mode):
    environment = gymnasium.make(name, render_mode=mode)
    environment.reset(seed=1)
    first = environment.render()
    for _ in range(5):
        if any(environment.step(environment.action_space.sample())[2:4]):
            break
    shown = environment.render()
    if mode == "html":
        assert shown.lower().startswith("<!doctype html>")
    else:
        assert shown.ndim == 3 and shown.shape[2] == 3 and shown.dtype == np.uint8
        assert first.shape == shown.shape and (first != shown).any()


def columns(environment):
    """The observation's numbers by quantity."""
    names = environment.unwrapped.observation_names
    return lambda observation, key: np.array([v for n, v in zip(names, observation) if n == key or n.startswith(key + "[")])


def eq6(read, follow):
    def act(observation):
        if read(observation, "human_leads")[0] or read(observation, "human_takes_over")[0]:
            return follow
        phi = min(read(observation, "stubbornness")[0], 1.0)
        cost = (1 - phi) * read(observation, "objective_cost_m") + phi * read(observation, "expected_subjective_cost")
        executed = read(observation, "executed")
        if executed.any() and cost[executed.argmax()] == cost.min():
            return int(executed.argmax())
        return int(cost.argmin())

    return act


@pytest.mark.parametrize("eta", [5.0, 15.0])
@pytest.mark.parametrize("world", ["environment-1", "environment-4"])
def test_equation_6_through_the_environment_is_mutual(world, eta):
    environment = gymnasium.make("cocarry/Options-v0", worlds=world, eta=eta)
    act = eq6(columns(environment), environment.action_space.n - 1)
    for seed in range(20):
        observation, info = environment.reset(options={"seed": seed})
        total, over = 0.0, False
        while not over:
            observation, reward, terminated, truncated, end = environment.step(act(observation))
            total, over = total + reward, terminated or truncated
        summary = cocarry.Episode(cocarry.Scenario(world, plant="point", seed=seed, eta=eta)).run()
        assert end["summary"] == summary and end["outcome"] == "arrived" and terminated and not truncated
        cost = summary["accumulated_objective_cost_m"] + summary["accumulated_subjective_cost"]
        assert total == pytest.approx(-cost)
        assert (info["seed"], info["world"]) == (seed, 0)


def test_the_reward_of_carry_is_the_control_cost():
    environment = gymnasium.make("cocarry/Carry-v0", worlds="environment-4", action="reference")
    environment.reset(seed=3)
    total, over = 0.0, False
    while not over:
        _, reward, terminated, truncated, info = environment.step(np.zeros(3))
        total, over = total + reward, terminated or truncated
    assert info["outcome"] == "object-lost" and terminated
    assert total == pytest.approx(-info["summary"]["accumulated_control_cost"])


def test_a_goal_follower_carries():
    environment = gymnasium.make("cocarry/Carry-v0", worlds="environment-4", action="reference", method="human-led")
    read = columns(environment)
    arrived = 0
    for seed in range(5):
        observation, _ = environment.reset(seed=seed)
        over = False
        while not over:
            ahead = [read(observation, f"{key}")[0] for key in ("ahead_x_m", "ahead_y_m")]
            velocity = np.array([*ahead, 0.0]) / 0.2 if any(ahead) else np.zeros(3)
            observation, _, terminated, truncated, info = environment.step(velocity)
            over = terminated or truncated
        arrived += info["outcome"] == "arrived"
    print("arrived", arrived)


def test_truncation_is_not_termination():
    environment = gymnasium.make("cocarry/Options-v0", max_steps=5)
    environment.reset(seed=0)
    ends = [environment.step(0)[2:4] for _ in range(5)]
    assert ends == [(False, False)] * 4 + [(False, True)]


def singles(name, count, keywords, mode):
    make = lambda: gymnasium.make(name, disable_env_checker=True, **keywords).unwrapped  # noqa: E731
    return SyncVectorEnv([make] * count, autoreset_mode=mode)


@pytest.mark.parametrize("mode", [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP])
@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize(("name", "keywords", "steps"), [(n, k, 400 if n.startswith("cocarry/O") else 60) for n, k in VARIANTS])
def test_the_vector_environment_equals_single_ones(name, keywords, steps, mode, threads):
    count = 5 if name.startswith("cocarry/O") else 2
    ours = gymnasium.make_vec(name, count, autoreset_mode=mode, threads=threads, **keywords)
    theirs = singles(name, count, keywords, mode)
    assert ours.metadata["autoreset_mode"] == mode
    assert ours.single_observation_space == theirs.single_observation_space
    assert ours.single_action_space == theirs.single_action_space
    ours.action_space.seed(0)
    rng = np.random.default_rng(0)
    mine, info = ours.reset(seed=7)
    other, info_other = theirs.reset(seed=7)
    np.testing.assert_array_equal(mine, other)
    np.testing.assert_array_equal(info["alpha"], info_other["alpha"])
    ends = 0
    for _ in range(steps):
        actions = ours.action_space.sample()
        if name.startswith("cocarry/O"):
            actions[rng.random(count) < 0.9] = ours.single_action_space.n - 1
        mine, other = ours.step(actions), theirs.step(actions)
        for one, two in zip(mine[:4], other[:4]):
            assert one.tobytes() == np.asarray(two, one.dtype).tobytes()
        ended = mine[2] | mine[3]
        ends += ended.sum()
        if ended.any() and mode == AutoresetMode.SAME_STEP:
            for i in np.flatnonzero(ended):
                np.testing.assert_array_equal(mine[4]["final_obs"][i], other[4]["final_obs"][i])
                assert mine[4]["final_info"]["outcome"][i] == other[4]["final_info"]["outcome"][i]
        elif ended.any():
            np.testing.assert_array_equal(mine[4]["outcome"], other[4]["outcome"])
    assert ends > count


def test_arrays_may_be_shared():
    vector = gymnasium.make_vec("cocarry/Options-v0", 4, copy=False)
    first, _ = vector.reset(seed=0)
    second = vector.step(np.zeros(4, dtype=np.int64))[0]
    assert first is second
    vector = gymnasium.make_vec("cocarry/Options-v0", 4)
    first, _ = vector.reset(seed=0)
    assert first is not vector.step(np.zeros(4, dtype=np.int64))[0]


@pytest.mark.parametrize(
    ("act", "message"),
    [
        (lambda e: e.step(99), r"whole number\(s\) \(int64\) from 0 to"),
        (lambda e: e.step(-1), r"whole number"),
        (lambda e: e.step(0.5), r"whole number"),
        (lambda e: e.step(np.zeros(3, dtype=np.int64)), r"whole number"),
        (lambda e: e.reset(options={"sed": 1}), r"unknown option 'sed'; expected one of: world, seed, alpha, gamma"),
        (lambda e: e.reset(options={"world": 9}), r"world = 9; it must be a whole number from 0 to 3"),
        (lambda e: e.reset(options={"alpha": -1.0}), r"alpha = -1"),
    ],
)
def test_wrong_actions_say_what_would_be_right(act, message):
    environment = gymnasium.make("cocarry/Options-v0", disable_env_checker=True).unwrapped
    with pytest.raises(cocarry.ClosedError, match=r"call reset\(\) first"):
        environment.step(0)
    environment.reset(seed=0)
    with pytest.raises(cocarry.Error, match=message):
        act(environment)
    environment.step(0)
    environment.close()
    with pytest.raises(cocarry.ClosedError, match="closed"):
        environment.step(0)


@pytest.mark.parametrize("action", [np.full(9, np.nan), np.zeros(3), np.zeros((2, 9)), "go", None, np.full(9, np.inf)])
def test_wrong_motions_say_what_would_be_right(action):
    environment = gymnasium.make("cocarry/Carry-v0", disable_env_checker=True).unwrapped
    environment.reset(seed=0)
    with pytest.raises(cocarry.ActionError, match="all finite, 9 for each of 1 environment"):
        environment.step(action)


def test_wrong_environments_say_what_would_be_right():
    for keywords, message in [
        ({"worlds": []}, "no world"),
        ({"worlds": "environment-9"}, "no such world"),
        ({"eta": -1}, "eta = -1; it must be"),
        ({"render_mode": "human"}, "one of: rgb_array, html"),
        ({"max_steps": 0}, "at least 1"),
        ({"objective_weight": float("nan")}, "finite"),
    ]:
        with pytest.raises(cocarry.Error, match=message):
            cocarry.environments.OptionsEnv(**keywords)
    with pytest.raises(cocarry.Error, match='plant="kinematic" or plant="rapier"'):
        cocarry.environments.CarryEnv(plant="point")
    with pytest.raises(cocarry.Error, match="NEXT_STEP or SAME_STEP"):
        cocarry.environments.OptionsVectorEnv(2, autoreset_mode="Disabled")
    with pytest.raises(cocarry.Error, match="1 to 100000"):
        cocarry.environments.OptionsVectorEnv(0)
    with pytest.raises(gymnasium.error.Error):
        gymnasium.make("cocarry/Options-v9")
    over = cocarry.environments.OptionsEnv(max_steps=1)
    over.reset(seed=0)
    over.step(0)
    with pytest.raises(cocarry.ClosedError, match=r"the episode is over; call reset\(\)"):
        over.step(0)


def _step(vector):
    try:
        vector.step(np.zeros(vector.num_envs, dtype=np.int64))
    except cocarry.ClosedError as error:
        return str(error)
    return "stepped"


def _in_child(vector, queue):
    queue.put(_step(vector))


def test_a_forked_vector_environment_fails_at_once():
    vector = gymnasium.make_vec("cocarry/Options-v0", 4, threads=2).unwrapped
    vector.reset(seed=0)
    context = multiprocessing.get_context("fork")
    queue = context.Queue()
    child = context.Process(target=_in_child, args=(vector, queue))
    child.start()
    assert "spawn or forkserver" in queue.get(timeout=20)
    child.join(20)
    assert _step(vector) == "stepped"


def test_gymnasiums_asynchronous_environments_work():
    make = lambda: gymnasium.make("cocarry/Options-v0")  # noqa: E731
    vector = gymnasium.vector.AsyncVectorEnv([make, make])
    vector.reset(seed=0)
    vector.step(np.zeros(2, dtype=np.int64))
    vector.close()


@pytest.mark.parametrize("plant", ["kinematic", "rapier"])
def test_an_omnidirectional_base_has_three_inputs(plant, tmp_path):
    command = [sys.executable, "-m", "cocarry", "export", "omni-carrier"]
    subprocess.run(command, cwd=tmp_path, capture_output=True, check=True)
    robot = cocarry.Robot(tmp_path / "omni-carrier.toml")
    assert robot.drive == "omnidirectional" and cocarry.Robot().drive == "differential"
    environment = gymnasium.make("cocarry/Carry-v0", worlds="environment-1", plant=plant, robot=robot)
    assert environment.action_space.shape == (10,)
    assert environment.unwrapped.action_limits == pytest.approx(robot.input_limits)
    read = columns(environment)
    before, _ = environment.reset(seed=1)
    # to the left, without turning: the base moves that way as seen from the grasp, which moves with it
    after = environment.step(np.eye(10)[1] * 0.2)[0]
    assert read(after, "last_input")[1] == pytest.approx(0.2 * robot.input_limits[1])
    assert np.abs(read(after, "last_input")).sum() == pytest.approx(0.2 * robot.input_limits[1])
    assert read(after, "base_y_m")[0] == pytest.approx(read(before, "base_y_m")[0], abs=0.02)
