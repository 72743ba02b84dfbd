"""The examples run."""

from __future__ import annotations

import csv
import importlib.util
import pathlib
import subprocess
import sys

import pytest

import cocarry

EXAMPLES = pathlib.Path(__file__).parents[1] / "examples"
pytestmark = pytest.mark.skipif(not EXAMPLES.is_dir(), reason="the examples are not next to the tests")


def output(name, *arguments):
    command = [sys.executable, str(EXAMPLES / name), *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


def test_table_ii_is_that_of_reproduce():
    found = [float(cell) for line in output("table_ii.py").splitlines() for cell in line.split()[1:]]
    assert found == pytest.approx([row["ours_mean"] for row in cocarry.reproduce("h2")["rows"]], abs=0.01)


def test_an_own_human_arrives():
    assert output("own_human.py").count("arrived") == 6


def test_an_own_policy_is_compared(tmp_path):
    shown = output("own_policy.py", "--seeds=10", f"--out={tmp_path / 'differences.svg'}")
    assert shown.count("patient(0.3) - mutual") == 8 and shown.count("n 10") == 24
    assert (tmp_path / "differences.svg").read_text().startswith("<svg")


def test_ppo_runs_with_a_tiny_budget():
    pytest.importorskip("stable_baselines3")
    shown = output("ppo.py", "--steps=8192", "--seeds=1", "--humans=2", "--lanes=8", "--checks=1", "--processes=1")
    assert importlib.util.find_spec("torch") and "\nppo " in shown


def test_ppo_of_any_options_trains_and_sees_in_a_view_what_it_was_trained_on(tmp_path, monkeypatch):
    gymnasium = pytest.importorskip("gymnasium")
    budget = ["--steps=2048", "--seeds=1", "--lanes=4", "--rooms=2", "--humans=1"]
    assert "of mutual's" in output("ppo_options.py", *budget, f"--out={tmp_path / 'network.json'}")
    monkeypatch.syspath_prepend(str(EXAMPLES))
    import ppo_options

    class Watched(ppo_options.PpoOptions):
        def decide(self, view):
            found.append((ppo_options.features(*ppo_options.seen(view)), super().decide(view)))
            return found[-1][1]

    layers = ppo_options.load(tmp_path / "network.json")
    worlds = ["free-form", ppo_options.rooms(1, 1)[0], "environment-4"]
    environment = gymnasium.make("cocarry/Options-v0", worlds=worlds, eta=5)
    for world in range(3):
        found = []
        cocarry.Episode(cocarry.Scenario(worlds[world], plant="point", seed=3, eta=5), policy=Watched(layers)).run()
        observation, _ = environment.reset(seed=0, options={"world": world, "seed": 3})
        for seen, decided in found:
            count = seen.shape[1] - 1
            items = ppo_options.features(*ppo_options.split(observation[None]))
            assert (items[:, [*range(count), -1]] == seen).all()
            follow = environment.action_space.n - 1
            observation, _, terminated, *_ = environment.step(follow if decided is None else decided)
        assert terminated and len(found) > 50


def test_ppo_and_sac_carry_with_a_tiny_budget(tmp_path):
    pytest.importorskip("stable_baselines3")
    budget = ["--ppo-steps=4096", "--sac-steps=2400", "--seeds=1", "--humans=2", "--processes=1"]
    shown = output("learn.py", *budget, f"--out={tmp_path / 'carried.csv'}")
    lines = {tuple(line.split()[:2]): line for line in shown.splitlines()}
    assert "100.0 +- 0.0" in lines["built-in", "residual"] and "+0.00 +- 0.00" in lines["built-in", "residual"]
    with (tmp_path / "carried.csv").open(newline="") as file:
        episodes = list(csv.DictReader(file))
    carried = {(e["world"], e["seed"]): float(e["return"]) for e in episodes if e["agent"] == "built-in"}
    assert len(carried) == 8 and len(episodes) == 8 * (4 + 4)
    # whoever ends early has less than the built-in controller
    early = [e for e in episodes if e["outcome"] != "arrived"]
    assert early and all(float(e["return"]) < carried[e["world"], e["seed"]] for e in early)


def test_a_clone_arrives_and_costs_what_mutual_costs():
    shown = output("clone.py", "--episodes=60", "--humans=4", "--epochs=8").splitlines()
    costs = {}
    for line in shown:
        if " arrived " in line:
            name, _, arrived, _, count, _, _, _, cost = line.split()[:9]
            assert arrived.isdecimal() and count.rstrip(",") == "48"
            costs.setdefault(name, []).append((int(arrived), float(cost.rstrip(","))))
    assert len(costs["clone"]) == 2 and all(arrived == 48 for arrived, _ in costs["clone"])
    for (_, clone), (_, mutual), (_, untrained) in zip(costs["clone"], costs["mutual"], costs["untrained"]):
        assert abs(clone - mutual) < 0.02 * mutual
        assert untrained > 1.2 * mutual  # the check would see a network that has learned nothing
