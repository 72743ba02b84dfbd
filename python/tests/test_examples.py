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
