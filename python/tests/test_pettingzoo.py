"""PettingZoo's environment of two agents."""

from __future__ import annotations

import copy
import pickle
import warnings

import numpy as np
import pytest
from pettingzoo.test import max_cycles_test, parallel_api_test, parallel_seed_test, render_test

import cocarry
import cocarry.pettingzoo


def test_pettingzoos_tests_pass():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        parallel_api_test(cocarry.pettingzoo.parallel_env(), num_cycles=1000)
        parallel_seed_test(cocarry.pettingzoo.parallel_env, num_cycles=200)
        max_cycles_test(cocarry.pettingzoo)

    def declared(render_mode):
        # the test begins with a mode that it assumes everybody has
        return cocarry.pettingzoo.env(render_mode=None if render_mode == "human" else render_mode)

    render_test(declared, custom_tests={"html": lambda page: page.lower().startswith("<!doctype html>")})


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("world", ["environment-1", "environment-4"])
def test_the_papers_partners_through_the_environment_are_the_papers_episode(world, seed):
    """A robot by eq. (6), and a human by eq. (3) and (5)."""
    environment = cocarry.pettingzoo.parallel_env(worlds=world, eta=5.0)
    names = environment.observation_names
    n = environment.action_space("robot").n - 1

    def read(observation, key):
        return np.array([v for name, v in zip(names, observation) if name == key or name.startswith(key + "[")])

    seen, info = environment.reset(options={"seed": seed})
    alpha, gamma = seen["human"][-2:]
    assert (alpha, gamma) == (info["human"]["alpha"], info["human"]["gamma"])
    costs = np.zeros(2)
    while environment.agents:
        robot, human = seen["robot"], seen["human"]
        phi, executed = read(robot, "stubbornness")[0], read(robot, "executed")
        preference = cocarry.Preference(read(human, "length_m"), read(human, "risk"))
        subjective = preference.subjective_cost(alpha, gamma)
        preferred = int(executed.argmax()) if executed.any() and subjective[executed.argmax()] == subjective.min() else int(subjective.argmin())
        takes_over = phi > 1
        cost = (1 - min(phi, 1)) * read(robot, "objective_cost_m") + min(phi, 1) * read(robot, "expected_subjective_cost")
        option = int(executed.argmax()) if executed.any() and cost[executed.argmax()] == cost.min() else int(cost.argmin())
        follows = takes_over or read(robot, "human_leads")[0]
        actions = {"robot": n if follows else option, "human": np.array([preferred, 2 if takes_over else 0])}
        seen, rewards, terminations, _, infos = environment.step(actions)
        costs += rewards["robot"], rewards["human"]
    summary = cocarry.Episode(cocarry.Scenario(world, plant="point", seed=seed, eta=5.0)).run()
    assert infos["robot"]["summary"] == summary and all(terminations.values())
    assert costs == pytest.approx([-summary["accumulated_objective_cost_m"], -summary["accumulated_subjective_cost"]])


def test_wrong_actions_say_what_would_be_right():
    environment = cocarry.pettingzoo.parallel_env()
    good = {"robot": 0, "human": np.array([0, 0])}
    with pytest.raises(cocarry.ClosedError, match=r"call reset\(\) first"):
        environment.step(good)
    environment.reset(seed=0)
    for actions, message in [
        ({"robot": 0}, "no action of 'human'"),
        ({**good, "robot": 99}, "the robot's must be a whole number from 0 to"),
        ({**good, "robot": 0.5}, "the robot's must be a whole number"),
        ({**good, "human": np.array([0, 3])}, "a response from 0 to 2"),
        ({**good, "human": np.array([0.0, np.nan])}, "the human's two"),
        ({**good, "human": None}, "the human's two"),
    ]:
        with pytest.raises(cocarry.ActionError, match=message):
            environment.step(actions)
    environment.step(good)


def test_the_state_is_what_the_human_sees():
    environment = cocarry.pettingzoo.parallel_env()
    seen, info = environment.reset(seed=0)
    assert environment.state_space.contains(environment.state())
    np.testing.assert_array_equal(environment.state(), seen["human"])
    assert environment.state()[-2:].tolist() == [info["human"]["alpha"], info["human"]["gamma"]]
    seen = environment.step({"robot": 0, "human": np.array([0, 0])})[0]
    np.testing.assert_array_equal(environment.state(), seen["human"])
    turns = cocarry.pettingzoo.env()
    turns.reset(seed=0)
    assert turns.state().shape == environment.state_space.shape


def test_actions_that_a_world_does_not_have_are_masked():
    environment = cocarry.pettingzoo.parallel_env(worlds=["environment-4", "free-form"])
    for world in ("environment-4", "free-form"):
        count = len(cocarry.World(world).options())
        _, infos = environment.reset(seed=0, options={"world": world})
        for _ in range(2):
            robot, human = (infos[agent]["action_mask"] for agent in ("robot", "human"))
            assert robot.sum() == count + 1 and robot[-1] == 1 and human[0].sum() == count and human[1].tolist() == [1, 1, 1]
            masks = {"robot": robot, "human": human}
            actions = {agent: environment.action_space(agent).sample(masks[agent]) for agent in environment.agents}
            infos = environment.step(actions)[4]


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda it: pickle.loads(pickle.dumps(it))])
def test_copies_in_mid_episode_go_on_with_the_same_bits(copied):
    environment = cocarry.pettingzoo.parallel_env()
    environment.reset(seed=1)
    act = lambda step: {"robot": step % 5, "human": np.array([step % 4, step // 7 % 3])}  # noqa: E731
    for step in range(9):
        environment.step(act(step))
    other = copied(environment)
    for step in range(9, 60):
        one, two = environment.step(act(step)), other.step(act(step))
        for agent in ("robot", "human"):
            assert one[0][agent].tobytes() == two[0][agent].tobytes()
        assert one[1:4] == two[1:4]
    turns = cocarry.pettingzoo.env()
    turns.reset(seed=2)
    turns.step(0)
    again = copied(turns)
    turns.step(np.array([0, 0])), again.step(np.array([0, 0]))
    np.testing.assert_array_equal(turns.observe("robot"), again.observe("robot"))
