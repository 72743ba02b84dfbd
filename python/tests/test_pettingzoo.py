"""PettingZoo's environment of two agents."""

from __future__ import annotations

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
