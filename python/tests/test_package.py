"""Scenarios, episodes, sweeps, tables, recordings: what a user of the package relies on."""

from __future__ import annotations

import copy
import json
import multiprocessing
import os
import pathlib
import pickle
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import cocarry

PLANTS = ["point", "kinematic", "rapier"]


def example(plant: str = "point", **settings) -> cocarry.Scenario:
    return cocarry.Scenario("environment-4", plant=plant, alpha=0.747, gamma=0.765, **settings)


def program(*arguments: str) -> str:
    command = [sys.executable, "-m", "cocarry", *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


@pytest.mark.parametrize("plant", PLANTS)
def test_an_episode_is_that_of_the_program(plant):
    printed = json.loads(program("run", "environment-4", "--seed", "3", "--plant", plant, "--json"))
    summary = cocarry.Episode(cocarry.Scenario("environment-4", seed=3, plant=plant)).run()
    flat = {**printed, **{k: v for part in printed.values() if isinstance(part, dict) for k, v in part.items()}}
    common = summary.keys() & flat.keys()
    assert len(common) > 15
    assert {key: summary[key] for key in common} == {key: flat[key] for key in common}


def test_settings_are_the_tables():
    table = cocarry.settings()
    assert table["eta"]["default"] == 10.5
    scenario = example("kinematic", eta=5, pose="none", max_steps=7)
    assert scenario.settings["eta"] == 5.0
    assert scenario.settings["pose"] == "none"
    assert cocarry.Episode(scenario).run()["outcome"] == "out-of-time"
    assert set(scenario.settings) <= set(table)
    assert scenario.replace(eta=15).settings["eta"] == 15.0


@pytest.mark.parametrize(
    ("keywords", "message"),
    [
        ({"eta": -1}, r"scenario: eta = -1; it must be a number greater than 0"),
        ({"eta": True}, r"scenario: eta = True; it must be a number"),
        ({"eta": float("nan")}, r"scenario: eta = nan; it must be"),
        ({"max_steps": 0}, r"max_steps = 0; it must be a whole number from 1"),
        ({"method": "mutal"}, r"method = 'mutal'; it must be one of \"mutual\".*did you mean `mutual`\?"),
        ({"human_model": "boltzman(2)"}, r"human_model = 'boltzman\(2\)'; it must be .*did you mean `boltzmann\(RATIONALITY\)`\?"),
        ({"plant": "rapir"}, r"plant = \"rapir\"; it must be one of: .*did you mean `rapier`\?"),
        ({"etta": 1}, r"unknown setting `etta`; expected one of: .*eta"),
        ({"sway_m": 0.02}, r"sway_m needs a human's body.*use plant=\"rapier\""),
        ({"alpha": 0}, r"alpha = 0; it must be a number greater than 0"),
        ({"changes": [(4, 0.5, -1.0)]}, r"gamma of a change = -1"),
        ({"preference_changes": 99}, r"preference_changes = 99; it must be"),
        ({"human_model": "boltzmann(x)"}, r"boltzmann"),
        ({"belief_alpha": "normal(1)"}, r"belief_alpha"),
        ({"belief_samples": np.zeros((3, 5))}, r"shape \[3, 5\].*\(n, 2\) or \(n, 3\)"),
        ({"plant": "moon"}, r"plant = \"moon\"; it must be one of: \"point\""),
    ],
)
def test_bad_settings_say_what_would_be_right(keywords, message):
    with pytest.raises(cocarry.Error, match=message):
        cocarry.Episode(cocarry.Scenario("environment-4", **{"plant": "point", **keywords}))


def test_bad_files_are_named(tmp_path):
    with pytest.raises(cocarry.WorldError, match="did you mean `environment-1`"):
        cocarry.World("environment-9")
    (tmp_path / "w.toml").write_text('name = "w"\nrobot_width_m = -1\nstart_m = [0, 0]\ntarget_m = [9, 0]\n')
    with pytest.raises(cocarry.WorldError, match=r"w\.toml:2"):
        cocarry.World(tmp_path / "w.toml")
    with pytest.raises(cocarry.RobotError, match="nowhere"):
        cocarry.Robot("nowhere.toml")
    with pytest.raises(cocarry.RecordingError, match="nowhere"):
        cocarry.read("nowhere.mcap")
    with pytest.raises(cocarry.SnapshotError, match="not a snapshot"):
        cocarry.Episode.resume(b"nonsense")
    with pytest.raises(cocarry.ScenarioError, match="not a valid scenario"):
        cocarry.Scenario.parse("eta = 1")
    assert issubclass(cocarry.Error, ValueError)


def test_a_map_is_a_world(tmp_path: pathlib.Path) -> None:
    rows = [[0 if c in (0, 15) or r in (0, 7) or (c == 8 and r not in (3, 4)) else 254 for c in range(16)] for r in range(8)]
    pixels = "\n".join(" ".join(map(str, row)) for row in rows)
    (tmp_path / "map.pgm").write_text(f"P2 16 8 255\n{pixels}\n")
    (tmp_path / "map.yaml").write_text("image: map.pgm\nresolution: 0.5\norigin: [0.0, 0.0, 0.0]\n")
    world = cocarry.World.from_map(tmp_path / "map.yaml", (2.0, 2.0), (6.0, 2.5))
    assert world.options() == ["1"]
    assert cocarry.World.parse(world.text).options() == ["1"]
    with pytest.raises(cocarry.WorldError, match="is on an occupied cell"):
        cocarry.World.from_map(tmp_path / "map.yaml", (0.2, 2.0), (6.0, 2.5))


def area(corners: np.ndarray) -> float:
    """The area of a polygon; negative if its corners are clockwise."""
    x, y = corners.T
    return float(0.5 * np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))


def test_a_world_has_its_obstacles() -> None:
    text = """
name = "Shapes"
robot_width_m = 0.5
start_m = [97.0, 0.0]
target_m = [115.0, 0.0]
origin_m = [100.0, 0.0]
[[obstacle]]
name = "box"
shape = "box"
center_m = [101.0, 2.0]
size_m = [4.0, 2.0]
yaw_deg = 30.0
height_m = 1.5
[[obstacle]]
name = "post"
shape = "cylinder"
center_m = [103.0, -3.0]
radius_m = 0.25
height_m = 2.0
[[obstacle]]
name = "triangle"
shape = "polygon"
vertices_m = [[108.0, 0.0], [108.0, 1.0], [107.0, 0.0]]
height_m = 1.0
[[obstacle]]
name = "corner"
shape = "polygon"
vertices_m = [[108.0, 3.0], [111.0, 3.0], [111.0, 4.0], [109.0, 4.0], [109.0, 6.0], [108.0, 6.0]]
height_m = 1.0
[[obstacle]]
name = "frame"
shape = "polygon"
vertices_m = [[106.0, -7.0], [110.0, -7.0], [110.0, -3.0], [106.0, -3.0]]
holes_m = [[[107.0, -6.0], [109.0, -6.0], [109.0, -4.0], [107.0, -4.0]]]
height_m = 1.0
[[obstacle]]
name = "room"
shape = "room"
vertices_m = [[94.0, -9.0], [119.0, -9.0], [119.0, 9.0], [94.0, 9.0]]
height_m = 2.5
[[option]]
name = "all"
openings = []
"""
    world = cocarry.World.parse(text)
    obstacles = {obstacle.name: obstacle for obstacle in world.obstacles}
    assert [*obstacles] == ["box", "post", "triangle", "corner", "frame", "room"]
    box, post, triangle, corner, frame, room = obstacles.values()
    assert [obstacle.shape for obstacle in obstacles.values()] == ["box", "cylinder", *3 * ["polygon"], "room"]
    assert [obstacle.height_m for obstacle in obstacles.values()] == [1.5, 2.0, 1.0, 1.0, 1.0, 2.5]
    # coordinates are relative to origin_m, as those of the start are
    assert world.start.tolist() == [-3.0, 0.0]
    assert box.center.tolist() == [1.0, 2.0] and box.size.tolist() == [4.0, 2.0] and box.yaw_rad == np.radians(30.0)
    assert post.center.tolist() == [3.0, -3.0] and post.radius_m == 0.25 and post.rings == post.parts == ()
    assert box.radius_m is None and post.size is None and post.yaw_rad is None
    assert room.center is None and corner.center is None
    turn = np.array([[np.cos(np.pi / 6), np.sin(np.pi / 6)], [-np.sin(np.pi / 6), np.cos(np.pi / 6)]])
    expected = np.array([(-2.0, -1.0), (2.0, -1.0), (2.0, 1.0), (-2.0, 1.0)]) @ turn + box.center
    np.testing.assert_allclose(box.parts[0], expected, atol=1e-12)
    np.testing.assert_array_equal(box.rings[0], box.parts[0])
    assert sorted(map(tuple, triangle.parts[0])) == [(7.0, 0.0), (8.0, 0.0), (8.0, 1.0)]
    # rings have the obstacle on their left: those round holes count negative
    for obstacle, size, rings in [(box, 8.0, 1), (triangle, 0.5, 1), (corner, 5.0, 1), (frame, 12.0, 2), (room, None, 2)]:
        assert len(obstacle.rings) == rings
        whole = sum(map(area, obstacle.rings))
        assert sum(map(area, obstacle.parts)) == pytest.approx(whole) and min(map(area, obstacle.parts)) > 0
        assert size is None or whole == pytest.approx(size)
    assert min(map(area, room.rings)) == pytest.approx(-25.0 * 18.0)
    with pytest.raises(AttributeError):
        box.yaw_rad = 0.0
    assert copy.deepcopy(world.obstacles)[0].name == pickle.loads(pickle.dumps(box)).name == "box"


def test_ticks_have_the_quantities():
    episode = cocarry.Episode(example())
    with pytest.raises(cocarry.Error, match="no tick before its first step"):
        episode.tick  # noqa: B018
    assert episode.step() is None
    tick = episode.tick
    assert set(tick) == set(cocarry.quantities("tick"))
    assert tick["step"] == 0 and tick["executed"] in example().options
    assert set(tick["options"][0]) == set(cocarry.quantities("option"))
    assert episode["stubbornness"] == tick["stubbornness"]
    with pytest.raises(KeyError, match="expected one of: step"):
        episode["phi"]
    steps = 1 + sum(1 for _ in episode)
    assert steps == episode.summary["steps"] == episode.steps
    assert episode.outcome == "arrived" == episode.step()
    assert set(episode.summary) == set(cocarry.quantities("episode"))


@pytest.mark.parametrize("plant", PLANTS)
def test_snapshots_pickles_and_copies_continue_with_the_same_bits(plant):
    episode = cocarry.Episode(example(plant))
    episode.run(20)
    others = [cocarry.Episode.resume(episode.snapshot()), pickle.loads(pickle.dumps(episode)), copy.deepcopy(episode)]
    for _ in range(5):
        episode.step()
        for other in others:
            other.step()
    assert all(other.snapshot() == episode.snapshot() for other in others)
    assert all(other.tick == episode.tick for other in others)


def test_what_the_robot_has_learned():
    scenario = cocarry.Scenario("environment-4", seed=5, plant="point", belief_update="learn", method="human-led")
    episode = cocarry.Episode(scenario)
    prior = episode.learned
    assert prior["information_nats"] == 0 and prior["region_share"] == 1
    assert set(prior["density"]) == {1}
    episode.run(45)
    resumed = cocarry.Episode.resume(episode.snapshot())
    assert resumed.learned == episode.learned
    for each in (episode, resumed):
        each.run()
    assert resumed.snapshot() == episode.snapshot()
    assert resumed.summary == episode.summary
    learned = episode.learned
    assert learned == resumed.learned
    assert learned["information_nats"] > 0.1 and learned["region_share"] < 1
    # the figures agree with the densities of the cells, to their width
    cells = np.array(learned["density"]).reshape(32, 32)
    middles = [np.linspace(*learned[f"{name}_range"], 65)[1::2] for name in ("alpha", "gamma")]
    weights = cells / cells.sum()
    alpha, gamma = (weights.sum(1 - axis) @ middles[axis] for axis in (0, 1))
    covariance = (middles[0] - alpha) @ weights @ (middles[1] - gamma)
    assert abs(alpha - learned["alpha_mean"]) < 0.005 and abs(gamma - learned["gamma_mean"]) < 0.008
    assert abs(covariance - learned["alpha_gamma_covariance"]) < 0.0005
    assert learned["alpha_interval"][0] < learned["alpha_mean"] < learned["alpha_interval"][1]
    assert learned["gamma_variance"] < prior["gamma_variance"] and learned["eta_mean"] > 0
    assert cocarry.Episode(example()).learned is None


def test_scenarios_worlds_and_tables_pickle():
    scenario = example("kinematic", eta=7)
    assert pickle.loads(pickle.dumps(scenario)) == scenario == cocarry.Scenario.parse(scenario.text)
    assert pickle.loads(pickle.dumps(cocarry.World())).name == cocarry.World().name
    table = cocarry.Episode(example()).ticks(5)
    assert pickle.loads(pickle.dumps(table)) == table
    with pytest.raises(cocarry.ScenarioError):
        pickle.loads(pickle.dumps(scenario).replace(b"eta = 7", b"eta =-7"))


def test_closed_and_busy_episodes_are_refused():
    with cocarry.Episode(example()) as episode:
        episode.step()
    for use in (episode.step, episode.snapshot, lambda: episode.tick, lambda: episode.summary, lambda: next(iter(episode))):
        with pytest.raises(cocarry.ClosedError, match="closed"):
            use()
    episode.close()
    assert "closed" in repr(episode)

    def meddles(view):
        cell["episode"].step()

    cell = {}
    cell["episode"] = cocarry.Episode(example(), policy=lambda view: meddles(view) if cell else None)
    with pytest.raises(cocarry.ClosedError, match="is in a step"):
        cell["episode"].step()


@pytest.mark.parametrize("plant", PLANTS)
def test_recordings_are_those_of_the_program(plant, tmp_path):
    program("run", "environment-4", "--alpha", "0.747", "--gamma", "0.765", "--plant", plant, "--record", str(tmp_path / "a.mcap"))
    with cocarry.Episode(example(plant)).record(tmp_path / "b.mcap") as episode:
        episode.run()
    assert (tmp_path / "a.mcap").read_bytes() == (tmp_path / "b.mcap").read_bytes() == episode_recording(plant)
    recording = cocarry.read(tmp_path / "b.mcap")
    assert recording.replay()["verdict"] == "identical"
    assert recording.scenario == example(plant)
    assert recording.outcome["outcome"] == "arrived"
    table = recording.table("/coordination")
    assert len(table) == recording.topics["/coordination"]
    assert np.all(np.diff(table["time_s"]) > 0)
    assert recording.to_html().startswith("<!doctype html>")
    with pytest.raises(cocarry.RecordingError, match=r"b.mcap: exists already; choose another name, or give overwrite=True"):
        cocarry.Episode(example(plant)).record(tmp_path / "b.mcap")
    for name in ("c.bag", "c"):
        with pytest.raises(cocarry.RecordingError, match=f"{name}: expected the extension .mcap"):
            cocarry.Episode(example(plant)).record(tmp_path / name)
        assert not (tmp_path / name).exists()
    with pytest.raises(cocarry.RecordingError, match="has no channel `/nothing`; it has"):
        recording.table("/nothing")


def episode_recording(plant):
    episode = cocarry.Episode(example(plant))
    episode.run()
    return episode.recording()


def test_an_interrupted_recording_is_whole(tmp_path):
    with cocarry.Episode(example()).record(tmp_path / "a.mcap") as episode:
        episode.run(10)
    assert cocarry.read(tmp_path / "a.mcap").outcome["outcome"] == "interrupted"
    assert cocarry.read(tmp_path / "a.mcap").replay()["verdict"] == "identical"


def test_notebooks_show_episodes_worlds_and_tables():
    episode = cocarry.Episode(example())
    assert episode._repr_html_() is None
    episode.run(10)
    assert episode._repr_html_().startswith("<iframe srcdoc=")
    assert "</script>" in episode.to_html("ten steps")
    assert cocarry.World()._repr_svg_().startswith("<svg")
    assert '<th title="k, from 0">step</th>' in episode.ticks(3)._repr_html_()


STUDY = {"worlds": ["environment-1", "environment-4"], "plants": "point", "methods": ["mutual", "without-model"], "seeds": 6}


def test_a_sweep_is_that_of_the_program(tmp_path):
    study = tmp_path / "study.toml"
    study.write_text('worlds = ["environment-1", "environment-4"]\nplants = "point"\nmethods = ["mutual", "without-model"]\nseeds = 6\n')
    program("sweep", str(study), "--output", str(tmp_path / "rows.csv"))
    import polars

    ours, theirs = polars.DataFrame(cocarry.sweep(study)), polars.read_csv(tmp_path / "rows.csv", infer_schema_length=None)
    assert ours.columns == theirs.columns
    for column in theirs.columns:
        ours_cast = ours[column].cast(polars.String).fill_null("")
        if ours[column].dtype.is_numeric():
            assert (ours[column].cast(polars.Float64).fill_null(0) == theirs[column].cast(polars.Float64).fill_null(0)).all(), column
        else:
            assert (ours_cast == theirs[column].cast(polars.String).fill_null("")).all(), column


def test_rows_do_not_depend_on_threads_shards_or_processes():
    whole = cocarry.sweep(STUDY)
    assert len(whole) == 24 and whole == cocarry.sweep(STUDY, threads=1)
    parts = [cocarry.sweep(STUDY, shard=(i, 3)) for i in (1, 2, 3)]
    assert cocarry.Table.concatenate(parts) == whole
    assert cocarry.sweep(STUDY, processes=2) == whole


def test_tables_open_in_polars_pandas_and_pyarrow():
    import pandas
    import polars
    import pyarrow

    table = cocarry.sweep(STUDY)
    arrow = pyarrow.table(table)
    assert arrow.num_rows == 24 and arrow.schema.field("walked_m").metadata[b"unit"] == b"m"
    assert polars.DataFrame(table)["outcome"].to_list() == arrow["outcome"].to_pylist() == ["arrived"] * 24
    # pandas 2, the last for Python 3.10, has no from_arrow
    frame = pandas.DataFrame.from_arrow(table) if hasattr(pandas.DataFrame, "from_arrow") else arrow.to_pandas()
    assert frame["steps"].tolist() == table["steps"].tolist()
    columns = table.to_numpy()
    assert list(columns) == table.columns
    assert columns["walked_m"].dtype == np.float64 and np.isnan(columns["peak_force_n"]).all()
    with pytest.raises(KeyError, match="expected one of: episode"):
        table["walked"]
    assert table.metadata["walked_m"]["unit"] == "m"


def test_bad_studies_are_located():
    with pytest.raises(cocarry.StudyError, match=r"study:2: seeds = 0"):
        cocarry.sweep('worlds = "environment-1"\nseeds = 0\n')
    with pytest.raises(cocarry.StudyError, match="nowhere.toml"):
        cocarry.sweep("nowhere.toml")
    with pytest.raises(cocarry.StudyError, match=r"shard = \(3, 2\)"):
        cocarry.sweep(STUDY, shard=(3, 2))
    with pytest.raises(cocarry.StudyError, match="not a value of a study"):
        cocarry.sweep({"worlds": object()})


def test_progress_is_told(capsys):
    told = []
    cocarry.sweep(STUDY, progress=lambda done, count: told.append((done, count)))
    assert told[-1] == (24, 24)
    cocarry.sweep(STUDY, progress=True)
    assert "24 of 24" in capsys.readouterr().err


def interrupt(act):
    """Sends Ctrl-C half a second into `act`; returns how long it then took to stop."""
    sent = []

    def send():
        time.sleep(0.5)
        sent.append(time.monotonic())
        os.kill(os.getpid(), signal.SIGINT)

    thread = threading.Thread(target=send)
    thread.start()
    try:
        with pytest.raises(KeyboardInterrupt):
            act()
            time.sleep(1)
    finally:
        thread.join()
    return time.monotonic() - sent[0]


def test_ctrl_c_stops_runs_and_sweeps():
    slow = cocarry.Scenario("environment-4", plant="rapier", speed_m_per_s=0.01, planning_step_s=0.05)
    episode = cocarry.Episode(slow)
    assert interrupt(episode.run) < 5
    assert episode.outcome is None
    episode.step()
    study = {"worlds": "environment-4", "plants": "rapier", "seeds": 1000}
    assert interrupt(lambda: cocarry.sweep(study)) < 10


def test_other_threads_run_during_a_run():
    counted = 0
    done = threading.Event()

    def count():
        nonlocal counted
        while not done.is_set():
            counted += 1
            time.sleep(0.001)

    def counted_in_a_run():
        episode = cocarry.Episode(example("rapier"))
        before = counted
        episode.run()
        return counted - before

    thread = threading.Thread(target=count)
    thread.start()
    try:
        # how often a busy machine lets the other thread in is its own affair
        assert any(counted_in_a_run() > 5 for _ in range(100))
    finally:
        done.set()
        thread.join()


def _run(episode):
    return episode.run()["steps"]


@pytest.mark.parametrize("method", ["fork", "spawn", "forkserver"])
def test_other_processes_run_episodes(method):
    episode = cocarry.Episode(example())
    episode.step()
    with multiprocessing.get_context(method).Pool(2) as pool:
        steps = pool.map_async(_run, [episode, episode]).get(60)
    assert steps == [episode.run()["steps"]] * 2


def test_preference_is_the_papers():
    scenario = cocarry.Scenario("environment-1", plant="point")
    preference = cocarry.Preference.of(scenario)
    assert preference.probability.sum() == pytest.approx(1)
    rng = np.random.default_rng(0)
    alpha, gamma = rng.uniform(0.55, 0.95, 20_000), rng.uniform(0.5, 1.1, 20_000)
    shares = np.bincount(preference.choices(alpha, gamma), minlength=len(preference)) / 20_000
    np.testing.assert_allclose(shares, preference.probability, atol=0.012)
    costs = np.mean([preference.subjective_cost(a, g) for a, g in zip(alpha[:4000], gamma[:4000])], axis=0)
    np.testing.assert_allclose(costs, preference.expected_subjective_cost, rtol=0.01)
    areas = np.zeros(len(preference))
    for option, outline in preference.regions():
        x, y = outline.T
        areas[option] += abs(np.dot(x, np.roll(y, 1)) - np.dot(y, np.roll(x, 1))) / 2
    np.testing.assert_allclose(areas / areas.sum(), preference.probability, atol=0.01)
    with pytest.raises(cocarry.Error, match="risk has 2"):
        cocarry.Preference([1.0], [2.0])
    with pytest.raises(cocarry.Error, match="length_m has 1 numbers and risk 2"):
        cocarry.Preference([1.0], [0.1, 0.2])


def test_claims_and_fits_are_the_programs():
    assert cocarry.reproduce("h1")["table"] == "I"
    with pytest.raises(cocarry.Error, match="claim = 'table-2'; it must be one of h1, h2, h3, guide"):
        cocarry.reproduce("table-2")
    listed = program("reproduce", "--help").partition("Commands:")[2].partition("\n\n")[0]
    claims = [line.split()[0] for line in listed.splitlines() if line.startswith("  ") and line[2] != " "]
    assert [claim for claim in claims if claim != "help"] == list(cocarry._program._CLAIMS)
    with pytest.raises(cocarry.Error, match="nowhere.csv"):
        cocarry.fit_eta("nowhere.csv")
    data = pathlib.Path(__file__).parents[2] / "docs" / "data"
    fit = cocarry.fit_risk_weight(data / "paper-h1-answers.csv", resamples=40, normalise=True) if (data / "paper-h1-answers.csv").exists() else None
    assert fit is None or fit


def test_robots_have_limits():
    robot = cocarry.Robot()
    assert robot.input_limits.shape == (2 + len(robot.joints),)
    assert robot.joint_limits.shape == (len(robot.joints), 2)
    assert cocarry.Scenario(plant="kinematic", posture=robot.postures[-1]).robot.name == robot.name
