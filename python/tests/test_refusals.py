"""What is refused is a cocarry.Error with the argument's name, its value and what would be right; what there is has its documentation."""

from __future__ import annotations

import copy
import gc
import inspect
import pickle
import re
import subprocess
import sys
import weakref

import gymnasium
import numpy as np
import pytest

import cocarry
import cocarry.environments
import cocarry.pettingzoo

WHOLE = "it must be a whole number from 0 to 18446744073709551615"
WRONG_WHOLES = [-1, 2**70, 1.5, "1", True, None, [1], float("nan")]
WRONG_NUMBERS = ["0.7", [0.7], 1j, True, object(), 10**400]
STUDY = {"worlds": "environment-1", "plants": "point", "seeds": 4}


def point(**keywords):
    return cocarry.Scenario("environment-4", plant="point", **keywords)


def refused(act, *parts):
    with pytest.raises(cocarry.Error) as caught:
        act()
    for part in parts:
        assert part in str(caught.value)
    return str(caught.value)


@pytest.mark.parametrize("wrong", WRONG_WHOLES)
def test_whole_numbers(wrong):
    if wrong is not None:
        refused(lambda: cocarry.Episode(point()).run(wrong), "steps = ", "a whole number of at least 0")
        refused(lambda: cocarry.Episode(point()).ticks(wrong), "steps = ")
        refused(lambda: point().replace(seed=wrong), "seed = ", WHOLE)
        refused(lambda: cocarry.sweep(STUDY, threads=wrong), "threads = ", "at least 1")
        refused(lambda: cocarry.sweep(STUDY, seeds=wrong), "seeds = ", "at least 1")
        for key in ("max_steps", "max_episode_steps"):
            refused(lambda key=key: cocarry.environments.OptionsEnv(**{key: wrong}), f"{key} = ", "at least 1")
        refused(lambda: cocarry.environments.OptionsEnv().reset(seed=wrong), "seed = ", WHOLE)
        refused(lambda: cocarry.environments.OptionsVectorEnv(2).reset(seed=[wrong, 1]), "seed = ", WHOLE)
        refused(lambda: cocarry.pettingzoo.parallel_env().reset(seed=wrong), "seed = ", WHOLE)
        refused(lambda: cocarry.environments.OptionsEnv().reset(options={"seed": wrong}), "seed = ", WHOLE)
        refused(lambda: cocarry.pettingzoo.parallel_env(max_cycles=wrong), "max_cycles = ", "at least 1")
    refused(lambda: point(seed=wrong), "seed = ", WHOLE)
    refused(lambda: point(max_steps=wrong), "max_steps = ", "a whole number from 1")
    refused(lambda: cocarry.gumbel(wrong, 3), "seed = ", WHOLE)
    refused(lambda: cocarry.gumbel(1, wrong), "options = ", "from 0 to 1000000")
    refused(lambda: cocarry.environments.OptionsVectorEnv(wrong), "num_envs = ", "from 1 to 100000")
    if not isinstance(wrong, (list, bool)):
        refused(lambda: cocarry.sweep({**STUDY, "seeds": wrong}), "seeds")
        refused(lambda: cocarry.sweep(STUDY, shard=(wrong, 4)), "shard = ", "(i, n)")


@pytest.mark.parametrize("wrong", [*WRONG_NUMBERS, -1.0, float("nan"), float("inf")])
def test_numbers(wrong):
    preference = cocarry.Preference([10.0, 12.0], [0.1, 0.0])
    refused(lambda: point(alpha=wrong), "alpha = ", "greater than 0")
    refused(lambda: point().replace(gamma=wrong), "gamma = ", "greater than 0")
    refused(lambda: point(eta=wrong), "eta = ", "greater than 0")
    refused(lambda: preference.choice(wrong, 0.7), "alpha = ", "greater than 0")
    refused(lambda: preference.subjective_cost(0.7, wrong), "gamma = ", "greater than 0")
    if wrong is not True:
        refused(lambda: point(changes=[(4, wrong, 0.5)]), "change", "alpha")
        refused(lambda: preference.regions([0.5, wrong]), "alpha = ", "upper")
        refused(lambda: preference.choices([wrong], [0.7]), "alpha = ")
    refused(lambda: cocarry.environments.OptionsEnv(alpha=wrong), "alpha = ", "greater than 0")
    refused(lambda: cocarry.environments.OptionsEnv().reset(options={"gamma": wrong}), "gamma = ", "greater than 0")
    refused(lambda: cocarry.environments.CarryEnv(most_step_cost=wrong), "most_step_cost = ", "greater than 0")
    refused(lambda: cocarry.environments.CarryEnv(action_scale=wrong), "action_scale = ", "at most 1")
    refused(lambda: cocarry.environments.CarryEnv(control_weight=wrong), "control_weight = ", "at least 0")
    if not isinstance(wrong, float):
        refused(lambda: cocarry.World().options(wrong), "risk_weight_m = ")
        if not isinstance(wrong, list):
            refused(lambda: cocarry.Preference(wrong, [0.1]), "length_m = ", "a list of numbers")
        refused(lambda: cocarry.Preference([1.0], [0.1], risk_weight_m=wrong), "risk_weight_m = ")
        refused(lambda: cocarry.environments.OptionsEnv(objective_weight=wrong), "objective_weight = ", "finite")
    for policy in (lambda view: view.path(-1), lambda view: view.path("1")):
        refused(cocarry.Episode(point(), policy=policy).step, "option = ")


@pytest.mark.parametrize("wrong", [5, None, b"text", ["point"]])
def test_other_arguments(wrong, tmp_path):
    refused(lambda: cocarry.Scenario("environment-4", plant=wrong), "plant = ", '"kinematic"')
    refused(lambda: cocarry.Scenario.parse(wrong), "text = ")
    refused(lambda: cocarry.World.parse(wrong), "text = ")
    refused(lambda: cocarry.quantities(wrong), "of = ", "tick, option, episode")
    refused(lambda: point(belief_alpha=wrong), "belief_alpha = ", "uniform(LOWER,UPPER)")
    refused(lambda: cocarry.Episode(point()).to_html(wrong), "title = ")
    if wrong is not None and not isinstance(wrong, bytes):
        refused(lambda: cocarry.Scenario(wrong), "world = ", "environment-1")
        refused(lambda: cocarry.World(wrong), "world = ", "environment-1")
        refused(lambda: cocarry.Robot(wrong), "file = ", '"carrier"')
        refused(lambda: cocarry.read(wrong), "file = ")
        refused(lambda: cocarry.Episode(point()).record(wrong), "file = ")
    refused(lambda: cocarry.Episode(point()).record(tmp_path / "a.mcap", overwrite=wrong), "overwrite = ", "True or False")
    refused(lambda: cocarry.Episode(wrong), "scenario = ", "cocarry.Scenario")
    refused(lambda: cocarry.Preference.of(wrong), "scenario = ", "cocarry.Scenario")
    if wrong is not None:
        refused(lambda: point(belief_samples=wrong), "belief_samples = ", "(n, 2) or (n, 3)")


def test_arguments_of_results_and_sweeps(tmp_path):
    rows = cocarry.sweep(STUDY)
    for wrong in (2**70, "12", 1.5, None, True, -1, 61):
        refused(lambda wrong=wrong: cocarry.plot(rows, kind="map", cells=wrong), "cells = ", "a whole number from 2 to 60")
    refused(lambda: cocarry.sweep(STUDY, seeds=0), "seeds = 0", "at least 1")
    for wrong in (2**70, "2", 1.5, True, 0):
        refused(lambda wrong=wrong: cocarry.sweep(STUDY, processes=wrong), "processes = ", "a whole number from 1")
    for wrong in (5, b"method", [5], float("nan")):
        refused(lambda wrong=wrong: cocarry.plot(rows, kind=wrong), "kind = ", "one of: means, differences, map")
        refused(lambda wrong=wrong: cocarry.plot(rows, quantity=wrong), "quantity = ", "a column")
        refused(lambda wrong=wrong: cocarry.plot(rows, width=wrong), "width = ", '"3.5in" or "1200px"')
        refused(lambda wrong=wrong: cocarry.compare(rows, by=wrong), "by = ", "an input")
        refused(lambda wrong=wrong: cocarry.compare(rows, over=wrong), "over = ", "a list")
        refused(lambda wrong=wrong: cocarry.compare(rows, quantities=wrong), "quantities = ", "a column")
        refused(lambda wrong=wrong: cocarry.reproduce(wrong), "claim = ")
    for kind in ("means", "differences", "map"):
        known = "it must be one of: " + ("accumulated_objective_cost_m, " if kind != "differences" else "steps, time_s, ")
        refused(lambda kind=kind: cocarry.plot(rows, kind=kind, quantity="x"), 'quantity = "x"; ' + known)
        refused(lambda kind=kind: cocarry.plot(rows, kind=kind, quantity="final_discomfor"), "did you mean `final_discomfort`?")
    for wrong, said in [("3.5", "inches or pixels, as in 3.5in or 1200px"), ("1in", "from 2in to 20in"), ("7000px", "from 300px to 6000px")]:
        refused(lambda wrong=wrong: cocarry.plot(rows, width=wrong), f'width = "{wrong}": ', said)
    for wrong in (5, None, "a\0b", [1]):
        refused(lambda wrong=wrong: cocarry.fit_eta(wrong), "switches = ", "a file")
        refused(lambda wrong=wrong: cocarry.fit_risk_weight(wrong), "answers = ", "a file")
        refused(lambda wrong=wrong: cocarry.Picture("<svg/>").save(wrong), "file = ", "a file")
        refused(lambda wrong=wrong: cocarry.sweep(wrong), "study = ", "a study file, its text or a mapping")
        if wrong is not None:
            refused(lambda wrong=wrong: cocarry.sweep(STUDY, out=wrong), "out = ", "a file")
    for wrong in (1, "yes", None):
        refused(lambda wrong=wrong: cocarry.sweep(STUDY, out=tmp_path / "a.csv", overwrite=wrong), "overwrite = ", "True or False")
        refused(lambda wrong=wrong: cocarry.environments.CarryEnv(built_in=wrong), "built_in = ", "True or False")


def test_lists_are_numbers_too():
    samples = [[0.6, 0.7], [0.8, 0.9]]
    scenario = point(belief_samples=samples)
    assert scenario == point(belief_samples=np.array(samples)) == point(belief_samples=np.array(samples, dtype=object))
    assert cocarry.Preference([10, 12], (0.1, 0)).choices([0.7], np.array([0.7], dtype=np.float32)).tolist() == [1]
    assert point(seed=np.int32(7)) == point(seed=7)


def test_a_mistyped_keyword_has_a_suggestion():
    for wrong, right in [("alfa", "alpha"), ("gama", "gamma"), ("etta", "eta"), ("plants", "plant"), ("sed", "seed"), ("worlds", "world")]:
        refused(lambda wrong=wrong: cocarry.Scenario("environment-4", **{wrong: 1}), f"unknown setting `{wrong}`", f"did you mean `{right}`?")


def test_the_built_in_robot_has_a_name(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert cocarry.Robot("carrier").joints == cocarry.Robot().joints
    assert cocarry.Scenario(plant="kinematic", robot="carrier") == cocarry.Scenario(plant="kinematic")
    names = ["`carrier`", "`omni-carrier`", "`porter`", "`shuttle`"]
    refused(lambda: cocarry.Robot("carier"), "carier: neither a file nor a built-in robot", *names, "did you mean `carrier`?")
    refused(lambda: cocarry.Scenario(robot="omnicarrier"), "did you mean `omni-carrier`?")
    refused(lambda: cocarry.Robot("carier.toml"), "carier.toml: ")


@pytest.mark.parametrize("name", ["omni-carrier", "porter", "shuttle"])
def test_a_built_in_robot_is_that_of_its_exported_files(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    robot = cocarry.Robot(name)
    scenario = cocarry.Scenario(plant="rapier", robot=name)
    assert scenario == cocarry.Scenario(plant="rapier", robot=robot) and scenario.robot.joints == robot.joints
    subprocess.run([sys.executable, "-m", "cocarry", "export", name], check=True, capture_output=True)
    assert scenario == cocarry.Scenario(plant="rapier", robot=f"{name}.toml")
    # a file of that name comes first
    (tmp_path / name).rename(tmp_path / "meshes") if (tmp_path / name).exists() else None
    (tmp_path / name).write_text("not a robot")
    refused(lambda: cocarry.Robot(name), name)


def test_errors_are_of_the_documented_kind():
    for keywords in ({"seed": -1}, {"alpha": "x"}, {"gamma": [1]}, {"changes": 3}, {"plant": 5}, {"belief_alpha": 5}):
        with pytest.raises(cocarry.ScenarioError, match=f"{next(iter(keywords))} = "):
            cocarry.Scenario("environment-4", **keywords)
    for keywords in ({"seed": -1}, {"alpha": "x"}, {"gamma": "x"}):
        with pytest.raises(cocarry.ScenarioError, match=f"{next(iter(keywords))} = "):
            point().replace(**keywords)
    with pytest.raises(cocarry.ScenarioError, match="text = 5"):
        cocarry.Scenario.parse(5)
    for keywords in ({"threads": -1}, {"threads": 0}, {"threads": "2"}, {"seeds": -1}, {"shard": 3}, {"shard": (3, 2)}):
        with pytest.raises(cocarry.StudyError, match=f"{next(iter(keywords))} = "):
            cocarry.sweep(STUDY, **keywords)


def test_what_a_table_and_an_episode_do_not_have():
    table = cocarry.sweep(STUDY)
    for wrong, said in [(3, "column = 3; it must be the name of a column"), ("walked", "unknown column `walked`; expected one of: episode, ")]:
        with pytest.raises(cocarry.UnknownKeyError) as caught:
            table[wrong]
        assert str(caught.value).startswith(said) and isinstance(caught.value, KeyError)
        assert str(pickle.loads(pickle.dumps(caught.value))) == str(caught.value)
    refused(lambda: table["walkd_m"], "did you mean `walked_m`?")
    episode = cocarry.Episode(point())
    episode.step()
    refused(lambda: episode[1], "quantity = 1; it must be the name of a quantity")
    refused(lambda: episode["stubbornes"], "unknown quantity `stubbornes`; expected one of: ", "did you mean `stubbornness`?")
    refused(lambda: cocarry.Table.concatenate(3), "tables = 3; it must be a list of cocarry.Table")
    refused(lambda: cocarry.Table.concatenate(table), "tables = <cocarry.Table, ", "it must be a list of cocarry.Table")
    refused(lambda: cocarry.Table.concatenate([table, 1]), "tables[1] = 1; it must be a cocarry.Table")
    refused(lambda: cocarry.Table.concatenate([]), "there are no tables")
    assert len(cocarry.Table.concatenate((table, table))) == 2 * len(table)


def test_a_scenario_shows_six_digits():
    shown = repr(cocarry.Scenario("environment-4", plant="point"))
    numbers = re.findall(r"(?:alpha|gamma) ([\d.]+)", shown)
    assert len(numbers) == 2 and all(len(number.replace(".", "").lstrip("0")) <= 6 for number in numbers), shown
    assert "alpha 0.7, gamma 1.1>" in repr(point(alpha=0.7, gamma=1.1))


class Keeps(cocarry.Policy):
    """A policy that holds its episode."""

    def decide(self, view):
        return None

    def __deepcopy__(self, memo):
        return Keeps()


@pytest.mark.parametrize("steps", [0, 3])
def test_a_policy_that_holds_its_episode_is_collected(steps):
    policy = Keeps()
    policy.episode = cocarry.Episode(point(), policy=policy, human=lambda view, policy=policy: 0 if policy else 1)
    policy.episode.run(steps)
    assert policy.episode.policy is policy
    gone = weakref.ref(policy)
    del policy
    gc.collect()
    assert gone() is None


@pytest.mark.parametrize("copied", [copy.copy, copy.deepcopy, lambda it: pickle.loads(pickle.dumps(it))])
def test_preferences_are_copied(copied):
    for preference in [
        cocarry.Preference([10.0, 12.0], [0.1, 0.0], risk_weight_m=5.0, belief_samples=[[0.6, 0.7, 2.0], [0.8, 0.9, 1.0]]),
        cocarry.Preference.of(point(risk_weight_m=7.0)),
    ]:
        other = copied(preference)
        for key in ("length_m", "risk", "probability", "expected_subjective_cost", "objective_cost_m"):
            np.testing.assert_array_equal(getattr(other, key), getattr(preference, key))
        assert len(other.regions()) == len(preference.regions())


def public(of, name):
    yield name, of
    for key in vars(of) if inspect.isclass(of) else ():
        if not key.startswith("_"):
            yield f"{name}.{key}", getattr(of, key)


def test_everything_public_has_its_documentation():
    modules = [cocarry, cocarry.environments, cocarry.pettingzoo]
    named = [pair for module in modules for name in module.__all__ for pair in public(getattr(module, name), f"{module.__name__}.{name}")]
    inherited = {"metadata"}
    fields = {f"cocarry.{name}.{field}" for name in ("Decision", "HumanDecision") for field in getattr(cocarry, name).__dataclass_fields__}
    flags = {"cocarry.Policy.human_leads_first", "cocarry.Policy.predicts"}
    bare = [name for name, it in named if not inspect.getdoc(it) and name not in fields | flags and name.split(".")[-1] not in inherited]
    assert len(named) > 100 and [name for name in bare if not name.endswith("__version__")] == []
    assert "alpha, gamma: the human's perception" in inspect.getdoc(cocarry.Scenario)


def test_environments_of_one_world_or_many():
    refused(lambda: cocarry.environments.OptionsEnv(worlds=5), "worlds = 5; it must be a world or a list of worlds")
    refused(lambda: cocarry.environments.CarryEnv(action="velocity"), "action = 'velocity'; it must be one of: inputs, reference, residual")
    assert gymnasium.make("cocarry/Options-v0", worlds=cocarry.World("environment-1")).unwrapped.action_space.n > 1
    for make in (
        lambda **keywords: gymnasium.make("cocarry/Options-v0", **keywords),
        lambda **keywords: gymnasium.make_vec("cocarry/Options-v0", num_envs=2, **keywords),
        cocarry.pettingzoo.parallel_env,
    ):
        refused(lambda make=make: make(world="environment-4"), "world = 'environment-4': unknown keyword `world`; did you mean `worlds`?")
        refused(lambda make=make: make(plant="rapier"), "plant = 'rapier': this environment is of the planning level")
