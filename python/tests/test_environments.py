"""Gymnasium's environments and the native vector environment."""

from __future__ import annotations

import copy
import itertools
import multiprocessing
import pickle
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
    ("cocarry/Options-v0", {"worlds": ["environment-4", "free-form"]}),
    ("cocarry/Carry-v0", {"plant": "kinematic", "action": "inputs"}),
    ("cocarry/Carry-v1", {"plant": "kinematic", "action": "inputs"}),
    ("cocarry/Carry-v1", {"plant": "kinematic", "action": "reference"}),
    ("cocarry/Carry-v1", {"plant": "kinematic", "action": "residual", "action_scale": 1.0}),
    ("cocarry/Carry-v1", {"plant": "rapier", "action": "reference", "worlds": "environment-4"}),
]


@pytest.mark.parametrize(("name", "keywords"), VARIANTS)
def test_check_env_passes_without_warnings(name, keywords):
    environment = gymnasium.make(name, disable_env_checker=True, **keywords)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(environment.unwrapped)


@pytest.mark.parametrize("mode", ["rgb_array", "html"])
@pytest.mark.parametrize("name", ["cocarry/Options-v0", "cocarry/Carry-v1"])
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


@pytest.mark.parametrize("changes", [0, "once-or-twice"])
@pytest.mark.parametrize("eta", [5.0, 15.0])
@pytest.mark.parametrize("world", ["environment-1", "environment-4"])
def test_equation_6_through_the_environment_is_mutual(world, eta, changes):
    environment = gymnasium.make("cocarry/Options-v0", worlds=world, eta=eta, preference_changes=changes)
    act = eq6(columns(environment), environment.action_space.n - 1)
    for seed in range(20):
        observation, info = environment.reset(options={"seed": seed})
        total, over = 0.0, False
        while not over:
            observation, reward, terminated, truncated, end = environment.step(act(observation))
            total, over = total + reward, terminated or truncated
        summary = cocarry.Episode(cocarry.Scenario(world, plant="point", seed=seed, eta=eta, preference_changes=changes)).run()
        assert end["summary"] == summary and end["outcome"] == "arrived" and terminated and not truncated
        cost = summary["accumulated_objective_cost_m"] + summary["accumulated_subjective_cost"]
        assert total == pytest.approx(-cost)
        assert (info["seed"], info["world"]) == (seed, 0)


def test_the_reward_of_the_first_carry_is_the_control_cost():
    environment = gymnasium.make("cocarry/Carry-v0", worlds="environment-4", action="reference")
    environment.reset(seed=3)
    total, over = 0.0, False
    while not over:
        _, reward, terminated, truncated, info = environment.step(np.zeros(3))
        total, over = total + reward, terminated or truncated
    assert info["outcome"] == "object-lost" and terminated
    assert total == pytest.approx(-info["summary"]["accumulated_control_cost"])


def test_a_goal_follower_carries():
    environment = gymnasium.make("cocarry/Carry-v1", worlds="environment-4", action="reference", method="human-led")
    read = columns(environment)
    arrived = 0
    for seed in range(5):
        observation, _ = environment.reset(seed=seed)
        over = False
        while not over:
            ahead = [read(observation, f"{key}")[0] for key in ("ahead_x_m", "ahead_y_m")]
            velocity = np.clip(np.array([*ahead, 0.0]) / 0.2, -1, 1) if any(ahead) else np.zeros(3)
            observation, _, terminated, truncated, info = environment.step(velocity)
            over = terminated or truncated
        arrived += info["outcome"] == "arrived"
    print("arrived", arrived)


def test_truncation_is_not_termination():
    environment = gymnasium.make("cocarry/Options-v0", max_steps=5)
    environment.reset(seed=0)
    ends = [environment.step(0)[2:4] for _ in range(5)]
    assert ends == [(False, False)] * 4 + [(False, True)]


def test_time_that_is_charged_for_terminates():
    for keywords, end in (({"max_steps": 3}, (True, False)), ({"max_episode_steps": 3}, (False, True))):
        environment = carry(worlds="environment-4", action="residual", **keywords)
        environment.reset(seed=0)
        steps = [environment.step(np.zeros(environment.action_space.shape)) for _ in range(3)]
        assert [step[2:4] for step in steps] == [(False, False)] * 2 + [end]
        # what is charged is far more than what a step costs
        assert (steps[-1][1] < 100 * steps[0][1]) == end[0]


def singles(name, count, keywords, mode):
    make = lambda: gymnasium.make(name, disable_env_checker=True, **keywords).unwrapped  # noqa: E731
    return SyncVectorEnv([make] * count, autoreset_mode=mode)


@pytest.mark.parametrize("mode", [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP])
@pytest.mark.parametrize("threads", [1, 2, 4])
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
    environment = gymnasium.make("cocarry/Carry-v1", disable_env_checker=True).unwrapped
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
    with pytest.raises(cocarry.Error, match="NEXT_STEP, SAME_STEP or DISABLED"):
        cocarry.environments.OptionsVectorEnv(2, autoreset_mode="Never")
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
    environment = gymnasium.make("cocarry/Carry-v1", worlds="environment-1", plant=plant, robot=robot)
    assert environment.action_space.shape == (10,)
    assert environment.unwrapped.action_limits == pytest.approx(robot.input_limits)
    read = columns(environment)
    before, _ = environment.reset(seed=1)
    # to the left, without turning: the base moves that way as seen from the grasp, which moves with it
    after = environment.step(np.eye(10)[1] * 0.2)[0]
    inputs = [value for name, value in zip(environment.unwrapped.observation_names, after) if name.startswith("last_input")]
    assert inputs == pytest.approx(0.2 * robot.input_limits * np.eye(10)[1])
    assert environment.unwrapped.action_names[:3] == ["input_m_per_s[base ahead]", "input_m_per_s[base left]", "input_rad_per_s[base turning]"]
    assert read(after, "base_y_m")[0] == pytest.approx(read(before, "base_y_m")[0], abs=0.02)


def run(environment, act, *, seed=None, world=0, steps=10_000):
    """The return of an episode, and its last info with the number of steps."""
    observation, info = environment.reset(options={"world": world} if seed is None else {"world": world, "seed": seed})
    total = 0.0
    for step in range(1, steps + 1):
        observation, reward, terminated, truncated, info = environment.step(act(observation, info))
        total += reward
        if terminated or truncated:
            break
    return total, {**info, "steps": step}


def carry(**keywords):
    return cocarry.environments.CarryEnv(**keywords)


def policies(environment, seed):
    """Ways to act, of which most lose the object, or bring it nowhere."""
    space, rng = environment.action_space, np.random.default_rng(seed)
    space.seed(seed)
    built_in = lambda share: lambda _, info: share * info["built_in_action"]  # noqa: E731
    corner = rng.choice([-1.0, 1.0], space.shape)
    count = itertools.count()
    late = lambda _, info: info["built_in_action"] if next(count) < 40 else corner  # noqa: E731
    return {
        "zero": lambda *_: np.zeros(space.shape),
        "random": lambda *_: space.sample(),
        "corner": lambda *_: corner,
        "slow": built_in(0.2),
        "built-in, then a corner": late,
    }


WAYS = ["zero", "random", "corner", "slow", "built-in, then a corner"]
WORLDS = [*[f"environment-{i}" for i in range(1, 5)], "free-form"]


@pytest.mark.parametrize("action", ["inputs", "reference", "residual"])
@pytest.mark.parametrize("plant", ["kinematic", "rapier"])
def test_no_episode_that_ends_early_scores_better_than_the_built_in_controller(plant, action):
    """From the start: every episode without arrival scores less than every episode with one, and so than the built-in."""
    worlds = WORLDS if plant == "kinematic" else WORLDS[1::2]
    environment = carry(worlds=worlds, plant=plant, action=action, action_scale=1.0)
    built_in = carry(worlds=worlds, plant=plant, action="residual")
    seen = set()
    for world, seed in itertools.product(range(len(worlds)), range(3 if plant == "kinematic" else 1)):
        carried, ended = run(built_in, lambda *_: np.zeros(built_in.action_space.shape), world=world, seed=seed)
        steps, most = built_in._lanes.bound(0)
        assert ended["outcome"] == "arrived" and carried > -most * steps
        # what a learner sees is the paper's figure: no step of the built-in controller costs the most
        assert carried == pytest.approx(-ended["summary"]["accumulated_control_cost"])
        for way in WAYS:
            score, end = run(environment, policies(environment, seed)[way], world=world, seed=seed)
            seen.add(end.get("outcome"))
            assert environment._lanes.bound(0) == (steps, most)
            if end["outcome"] != "arrived":
                assert score <= -most * steps < carried, (way, worlds[world], seed, end)
            else:
                assert score >= -most * steps
    assert "object-lost" in seen


@pytest.mark.parametrize("keywords", [{}, {"max_steps": 30}, {"objective_weight": 1.0, "subjective_weight": 2.0}, {"most_step_cost": 0.5}])
@pytest.mark.parametrize("plant", ["kinematic", "rapier"])
def test_ending_is_never_better_than_going_on_from_the_same_state(plant, keywords):
    """At every state on the way of a policy that fails: what it gets by its last step, against the built-in from there."""
    worlds = ["environment-1", "environment-4"] if plant == "kinematic" else ["environment-4"]
    for seed in range(4 if plant == "kinematic" else 1):
        environment = carry(worlds=worlds, plant=plant, action="residual", action_scale=1.0, **keywords)
        rng, zero = np.random.default_rng(seed), np.zeros(environment.action_space.shape)
        environment.reset(options={"seed": seed, "world": seed % len(worlds)})
        for step in itertools.count():
            before = copy.deepcopy(environment)
            action = zero if step < 4 * seed else rng.uniform(-1, 1, zero.shape)
            _, reward, terminated, truncated, _ = environment.step(action)
            if terminated or truncated:
                break
        going_on, over = 0.0, False
        while not over:
            _, gained, terminated, truncated, _ = before.step(zero)
            going_on, over = going_on + gained, terminated or truncated
        assert going_on >= reward - 1e-9 * abs(reward), (seed, step)


@pytest.mark.parametrize("plant", ["kinematic", "rapier"])
def test_a_residual_of_zero_is_the_built_in_controller_bit_for_bit(plant):
    environment = carry(worlds="environment-4", plant=plant, action="residual")
    for seed in range(3 if plant == "kinematic" else 1):
        _, info = run(environment, lambda _, info: info["built_in_action"], seed=seed)
        assert not info["built_in_action"].any()
        assert info["summary"] == cocarry.Episode(cocarry.Scenario("environment-4", plant=plant, seed=seed)).run()


def test_random_residuals_last_long_enough_to_learn_from():
    environment = carry(action="residual")
    steps = []
    for seed in range(20):
        environment.action_space.seed(seed)
        steps.append(run(environment, lambda *_: environment.action_space.sample(), seed=seed, world=seed % 4)[1]["steps"])
    assert np.mean(steps) > 50


@pytest.mark.parametrize(("plant", "action"), [("kinematic", "inputs"), ("kinematic", "reference"), ("rapier", "inputs")])
def test_the_built_in_action_carries(plant, action):
    environment = carry(worlds="environment-4", plant=plant, action=action)
    limits = environment.action_limits
    outcomes = []
    for seed in range(5 if plant == "kinematic" else 1):
        observation, info = environment.reset(options={"seed": seed})
        over = False
        while not over:
            assert environment.action_space.contains(info["built_in_action"])
            if action == "inputs":
                share = np.clip(info["built_in_inputs"] / limits, -1, 1)
                np.testing.assert_allclose(info["built_in_action"], share)
            observation, _, terminated, truncated, info = environment.step(info["built_in_action"])
            over = terminated or truncated
        outcomes.append(info["outcome"])
    assert outcomes == ["arrived"] * len(outcomes)
    assert "built_in_action" not in carry(built_in=False).reset(seed=0)[1]


@pytest.mark.parametrize("dtype", [np.float32, np.float64, np.int64])
def test_single_and_vector_environments_take_the_same_types(dtype):
    single, vector = (make("cocarry/Carry-v1", action="residual") for make in (gymnasium.make, gymnasium.make_vec))
    first, second = single.reset(seed=3)[0], vector.reset(seed=3)[0][0]
    action = np.full(single.action_space.shape, 0.25 if dtype != np.int64 else 1, dtype=dtype)
    for _ in range(3):
        np.testing.assert_array_equal(first, second)
        first, second = single.step(action)[0], vector.step(action[np.newaxis])[0][0]
    options, many = gymnasium.make("cocarry/Options-v0").unwrapped, gymnasium.make_vec("cocarry/Options-v0", 2)
    options.reset(seed=3), many.reset(seed=3)
    if dtype == np.int64:
        for kind in (np.int8, np.uint8, np.int32, np.uint64):
            np.testing.assert_array_equal(options.step(kind(1))[0], many.step(np.ones(2, dtype=kind))[0][0])


def test_actions_outside_the_box_are_refused():
    environment = gymnasium.make("cocarry/Carry-v1").unwrapped
    environment.reset(seed=0)
    action = np.zeros(environment.action_space.shape)
    action[4] = 1.0 + 1e-9
    with pytest.raises(cocarry.ActionError, match=r"action\[4\] \(input_rad_per_s\[.*\]\) is 1.000000001; it must be from -1 to 1"):
        environment.step(action)
    vector = gymnasium.make_vec("cocarry/Carry-v0", 2)
    vector.reset(seed=0)
    with pytest.raises(cocarry.ActionError, match=r"action\[0\] of environment 1 \(input_m_per_s\[left rim\]\) is -3; it must be from -1 to 1"):
        vector.step(np.array([np.zeros(9), np.full(9, -3.0)]))
    clipped = gymnasium.wrappers.ClipAction(gymnasium.make("cocarry/Carry-v1"))
    clipped.reset(seed=0)
    clipped.step(np.full(9, 40.0))


IDS = """
import gymnasium
{before}
for name in ("cocarry/Options-v0", "cocarry/Carry-v1"):
    environment = gymnasium.make("{module}" + name)
    environment.reset(seed=0)
    environment.step(environment.action_space.sample())
    gymnasium.make_vec("{module}" + name, 2).reset(seed=0)
"""


@pytest.mark.parametrize(("before", "module"), [("import cocarry", ""), ("", "cocarry:"), ("import cocarry.environments", "")])
def test_ids_are_registered(before, module):
    subprocess.run([sys.executable, "-c", IDS.format(before=before, module=module)], check=True)


def test_the_package_works_without_gymnasium():
    text = "import sys; sys.modules['gymnasium'] = None; import cocarry; cocarry.World()"
    subprocess.run([sys.executable, "-c", text], check=True)


def test_every_number_has_its_unit(tmp_path):
    command = [sys.executable, "-m", "cocarry", "export", "porter"]
    subprocess.run(command, cwd=tmp_path, capture_output=True, check=True)
    robot = cocarry.Robot(tmp_path / "porter.toml")
    environment = carry(robot=robot, worlds="environment-1")
    named = dict(zip(environment.observation_names, environment.observation_units))
    assert len(named) == environment.observation_space.shape[0] == len(environment.observation_units)
    slides = [joint for joint in robot.joints if f"joint_m[{joint}]" in named]
    assert len(slides) == 1
    for joint in robot.joints:
        unit, ending = ("m", "m") if joint in slides else ("rad", "rad")
        assert named[f"joint_{ending}[{joint}]"] == unit
        assert named[f"last_input_{ending}_per_s[{joint}]"] == f"{unit}/s"
        assert f"input_{ending}_per_s[{joint}]" in environment.action_names
    assert len(environment.action_names) == environment.action_space.shape[0]
    options = cocarry.environments.OptionsEnv()
    units = {name.split("[")[0]: unit for name, unit in zip(options.observation_names, options.observation_units)}
    assert units["length_m"] == "m" and units["risk"] == "1" and units["expected_subjective_cost"] == "cost units"
    assert {unit for e in (environment, options) for unit in e.observation_units} <= {"m", "rad", "m/s", "rad/s", "N", "Nm", "1", "cost units"}


def going_on(environment, steps=40, seed=0):
    """What an environment does from here, with every number's bits."""
    space = environment.action_space
    space.seed(seed)
    bits = []
    for _ in range(steps):
        observation, reward, terminated, truncated, _ = environment.step(space.sample())
        bits.append((observation.tobytes(), np.asarray(reward).tobytes(), np.asarray(terminated).tobytes(), np.asarray(truncated).tobytes()))
        if np.any(terminated) | np.any(truncated) and np.ndim(reward) == 0:
            bits.append(environment.reset()[0].tobytes())
    return bits


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda it: pickle.loads(pickle.dumps(it))])
@pytest.mark.parametrize("kind", ["single", "wrapped", "vector"])
@pytest.mark.parametrize(("name", "keywords"), VARIANTS)
def test_copies_in_mid_episode_go_on_with_the_same_bits(name, keywords, kind, copied):
    steps = 10 if keywords.get("plant") == "rapier" else 40
    if kind == "vector":
        environment = gymnasium.make_vec(name, 3, autoreset_mode=AutoresetMode.SAME_STEP, threads=2, **keywords)
    else:
        made = gymnasium.make(name, **keywords)
        environment = made if kind == "wrapped" else made.unwrapped
    before = copied(environment)
    environment.reset(seed=5), before.reset(seed=5)
    assert going_on(copied(environment), steps) == going_on(before, steps)
    going_on(environment, 7, seed=1)
    other = copied(environment)
    assert going_on(environment, steps) == going_on(other, steps)


def test_a_damaged_state_is_refused():
    environment = cocarry.environments.OptionsEnv()
    environment.reset(seed=0)
    state = environment.__getstate__()
    for bad in (b"", state["_lanes"][:-40], cocarry.environments.OptionsVectorEnv(2).__getstate__()["_lanes"]):
        with pytest.raises(cocarry.Error, match="not valid|damaged|not a snapshot"):
            cocarry.environments.OptionsEnv.__new__(cocarry.environments.OptionsEnv).__setstate__({**state, "_lanes": bad})


@pytest.mark.parametrize(("name", "keywords"), VARIANTS[:4])
def test_disabled_autoreset_is_that_of_single_environments(name, keywords):
    ours = gymnasium.make_vec(name, 3, autoreset_mode=AutoresetMode.DISABLED, **keywords)
    theirs = singles(name, 3, keywords, AutoresetMode.DISABLED)
    assert ours.metadata["autoreset_mode"] == AutoresetMode.DISABLED
    np.testing.assert_array_equal(ours.reset(seed=2)[0], theirs.reset(seed=2)[0])
    ours.action_space.seed(1)
    resets = 0
    while resets < 4:
        actions = ours.action_space.sample()
        mine, other = ours.step(actions), theirs.step(actions)
        for one, two in zip(mine[:4], other[:4]):
            np.testing.assert_array_equal(one, two)
        ended = mine[2] | mine[3]
        if ended.any():
            resets += 1
            with pytest.raises(cocarry.ClosedError, match=r"over; call reset"):
                ours.step(actions)
            mine, other = (them.reset(options={"reset_mask": ended.copy()}) for them in (ours, theirs))
            np.testing.assert_array_equal(mine[0], other[0])
            for key in ("world", "world_name", "alpha", "_alpha", "action_mask"):
                if key in other[1]:
                    np.testing.assert_array_equal(mine[1][key][ended], other[1][key][ended])
    for wrong in (np.zeros(3, dtype=bool), np.ones(2, dtype=bool), [1, 0, 0]):
        with pytest.raises(cocarry.Error, match="reset_mask"):
            ours.reset(options={"reset_mask": wrong})


def test_worlds_are_chosen_by_name():
    world = cocarry.World.parse(cocarry.World("environment-2").text, "mine")
    for make in (cocarry.environments.OptionsEnv, cocarry.environments.OptionsVectorEnv):
        environment = make(worlds=["environment-1", "environment-4", world])
        for name, index in (("environment-4", 1), ("mine", 2), (0, 0), (np.int64(2), 2)):
            info = environment.reset(seed=0, options={"world": name})[1]
            assert np.all(np.asarray(info["world"]) == index)
            assert np.asarray(info["world_name"]).ravel()[0] == ["environment-1", "environment-4", "mine"][index]
        for wrong in ("environment-3", "environment-5", -1, 1.0, True, 3, None, 2**70, [0]):
            if wrong is not None:
                with pytest.raises(cocarry.Error, match=r"world = .*; it must be a whole number from 0 to 2, or one of `environment-1`"):
                    environment.reset(options={"world": wrong})
    with pytest.raises(cocarry.Error, match="did you mean `environment-4`"):
        environment.reset(options={"world": "env4"})


def test_actions_that_a_world_does_not_have_are_masked():
    worlds = ["environment-4", "free-form"]
    counts = [len(cocarry.World(world).options()) for world in worlds]
    assert counts[0] != counts[1]
    most = max(counts)
    environment = cocarry.environments.OptionsEnv(worlds=worlds)
    vector = cocarry.environments.OptionsVectorEnv(2, worlds=worlds)
    read = columns(environment)
    for world, count in enumerate(counts):
        expected = np.array([action < count or action == most for action in range(most + 1)])
        observation, info = environment.reset(seed=0, options={"world": world})
        for _ in range(2):
            assert info["action_mask"].dtype == np.int8 and (info["action_mask"] == expected).all()
            assert (environment.action_masks() == expected).all()
            assert (read(observation, "available") == expected[:most]).all()
            assert expected[environment.action_space.sample(info["action_mask"])]
            observation, _, _, _, info = environment.step(environment.action_space.sample(info["action_mask"]))
        many = vector.reset(seed=0, options={"world": world})[1]
        assert (many["action_mask"] == expected).all() and many["_action_mask"].all()
        assert (vector.step(np.full(2, most))[4]["action_mask"] == expected).all()
        assert (vector.action_masks() == expected).all()
    alike = cocarry.environments.OptionsEnv()
    assert not any(name.startswith("available") for name in alike.observation_names)
    assert alike.reset(seed=0)[1]["action_mask"].tolist() == [1] * alike.action_space.n


@pytest.mark.parametrize("mode", [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP])
def test_gymnasiums_keywords_work(mode):
    single = gymnasium.make("cocarry/Options-v0", max_episode_steps=3)
    single.reset(seed=0)
    assert [single.step(0)[3] for _ in range(3)] == [False, False, True]
    # a limit from outside is not an end of the task: nothing is charged
    for environment in (
        gymnasium.make_vec("cocarry/Carry-v1", 1, max_episode_steps=3, action="residual"),
        gymnasium.make("cocarry/Carry-v1", max_episode_steps=3, action="residual"),
    ):
        environment.reset(seed=0)
        zero = np.zeros(environment.action_space.shape)
        steps = [environment.step(zero) for _ in range(3)]
        assert [bool(np.all(step[3])) for step in steps] == [False, False, True]
        assert all(float(np.asarray(step[1]).item()) > -5 for step in steps)
    vector = gymnasium.make_vec("cocarry/Options-v0", 2, max_episode_steps=3, render_mode="rgb_array", autoreset_mode=mode)
    single = gymnasium.make("cocarry/Options-v0", render_mode="rgb_array").unwrapped
    vector.reset(seed=4), single.reset(seed=5)
    for _ in range(2):
        vector.step(np.zeros(2, dtype=np.int64)), single.step(0)
    pictures = vector.render()
    assert len(pictures) == 2 and (pictures[1] == single.render()).all()
    for _ in range(3):
        vector.step(np.zeros(2, dtype=np.int64))
    assert vector.render()[0].shape[2] == 3
    with pytest.raises(cocarry.Error, match="one of: rgb_array, html"):
        gymnasium.make_vec("cocarry/Options-v0", 2, render_mode="human")
