"""Minari data sets from recordings, and data sets on the command line."""

from __future__ import annotations

import subprocess
import sys

import gymnasium
import minari
import numpy as np
import pyarrow.parquet as parquet
import pytest
import rosbags.rosbag2

import cocarry
import cocarry.environments
from cocarry.datasets import DatasetError, recorded_to_minari, to_lerobot, to_minari

PLANTS = ["point", "kinematic", "rapier"]
ABOUT = {"author": "A. Author", "author_email": "a@example.org", "code_permalink": "https://example.org", "description": "a test"}


@pytest.fixture
def home(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MINARI_DATASETS_PATH", "minari")
    return tmp_path / "minari"


@pytest.mark.filterwarnings("error::UserWarning")
@pytest.mark.parametrize("plant", PLANTS)
def test_minari_has_a_recordings_values_to_the_bit(home, recordings, plant, tmp_path):
    recording = cocarry.read(recordings[plant])
    made = recorded_to_minari([recordings[plant], recording], f"cocarry/{plant}-v0", **ABOUT)
    data = minari.load_dataset(f"cocarry/{plant}-v0")
    assert made.total_episodes == data.total_episodes == 2
    assert data.storage.metadata["author"] == {"A. Author"} and data.storage.metadata["algorithm_name"] == "mutual"
    flat = parquet.read_table(to_lerobot([recording], tmp_path / "flat") / "data")  # tested against the recording itself
    options = np.array(flat["observation.environment_state"].to_pylist())
    state = np.array(flat["observation.state"].to_pylist())
    for index, episode in enumerate(data.iterate_episodes()):
        assert episode.observations.dtype == np.float64
        expected = options if plant == "point" else np.hstack([state, options])
        assert np.array_equal(episode.observations[:-1], expected)
        assert np.array_equal(episode.observations[-1, -options.shape[1] :], options[-1])
        assert np.array_equal(episode.actions, np.array(flat["action"].to_pylist()))
        assert all(data.action_space.contains(action) for action in episode.actions)
        assert np.array_equal(episode.rewards, -recording.table("/cost")["objective_cost_m"])
        count = len(episode.rewards)
        assert episode.terminations.tolist() == [False] * (count - 1) + [True] and not episode.truncations.any()
        about = next(iter(data.storage.get_episode_metadata([index])))
        assert cocarry.Scenario.parse(about["scenario_text"]) == recording.scenario
        assert (about["scenario_alpha"], about["scenario_world"], about["outcome"]) == (0.747, "environment-4", "arrived")
    if plant != "point":  # where the base is at the end
        x = recording.table("/tf")["transforms[robot/base_link].translation.x"]
        assert np.array_equal(episode.observations[:, 0], x)


def eq6(observation):
    *options, phi, leads, takes_over = observation
    options = np.reshape(options, (-1, 7))
    if leads or takes_over:
        return len(options)
    cost = (1 - min(phi, 1)) * options[:, 2] + min(phi, 1) * options[:, 3]
    executed = np.flatnonzero(options[:, 6])
    return int(executed[0] if len(executed) and cost[executed[0]] == cost.min() else cost.argmin())


def test_recordings_and_episodes_of_the_environment_make_the_same_data(home):
    worlds = ["environment-1", "environment-4"]
    environment = gymnasium.make("cocarry/Options-v0", worlds=worlds, eta=5, subjective_weight=0.0)
    played = to_minari(environment, eq6, "cocarry/played-v0", episodes=4, seed=20, **ABOUT)
    abouts = [next(iter(played.storage.get_episode_metadata([index]))) for index in range(4)]
    scenarios = [
        cocarry.Scenario(worlds[a["scenario_world"]], plant="point", seed=a["scenario_seed"], eta=5, alpha=a["scenario_alpha"], gamma=a["scenario_gamma"])
        for a in abouts
    ]
    recorded = recorded_to_minari(scenarios, "cocarry/recorded-v0", **ABOUT)
    assert played.total_steps == recorded.total_steps > 400 and recorded.action_space == played.action_space
    for one, other in zip(played.iterate_episodes(), recorded.iterate_episodes()):
        for field in ("observations", "actions", "rewards", "terminations", "truncations"):
            assert np.array_equal(getattr(one, field), getattr(other, field)), field


def test_an_episode_without_time_is_truncated(home):
    slow = cocarry.Scenario("environment-4", plant="point", max_steps=20)
    episode = next(iter(recorded_to_minari([slow], "cocarry/slow-v0", **ABOUT).iterate_episodes()))
    assert episode.truncations.tolist() == [False] * 19 + [True] and not episode.terminations.any()


def test_a_recorded_data_set_is_whole_or_not_there(home, recordings):
    point = recordings["point"]
    recorded_to_minari([point], "cocarry/run-v0", **ABOUT)
    for episodes, name, message in [
        ([point], "cocarry/run-v0", r"run-v0: exists already; choose another name, or overwrite=True"),
        ([point], "no version", "dataset_id = 'no version': Malformed"),
        ([], "cocarry/new-v0", "there are none"),
        ([point, recordings["rapier"]], "cocarry/new-v0", "its team is another than that of .*, on rapier and point; write a data set for each"),
    ]:
        with pytest.raises(DatasetError, match=message):
            recorded_to_minari(episodes, name, **ABOUT)
    with pytest.raises(cocarry.RecordingError, match="nowhere"):
        recorded_to_minari(["nowhere.mcap"], "cocarry/run-v0", overwrite=True, **ABOUT)
    assert list(minari.list_local_datasets()) == ["cocarry/run-v0"]
    assert recorded_to_minari([point, point], "cocarry/run-v0", overwrite=True, **ABOUT).total_episodes == 2


def command(*arguments):
    line = [sys.executable, "-m", "cocarry.datasets", *map(str, arguments)]
    return subprocess.run(line, capture_output=True, text=True, check=False)


def test_the_command_line_writes_every_format(home, recordings, tmp_path):
    done = command("lerobot", recordings["rapier"], recordings["rapier"], "-o", "flat", "--task", "carry it", "--license", "cc-by-4.0")
    assert (done.returncode, done.stdout, done.stderr) == (0, "wrote flat\n", "")
    assert "license: cc-by-4.0" in (tmp_path / "flat" / "README.md").read_text()
    assert [row["tasks"] for row in parquet.read_table(tmp_path / "flat/meta/episodes").to_pylist()] == [["carry it"]] * 2
    assert command("rosbag2", recordings["rapier"], "-o", "bag").returncode == 0
    with rosbags.rosbag2.Reader(tmp_path / "bag") as reader:
        assert "/hand_wrench" in reader.topics
    done = command("minari", recordings["kinematic"], "-o", "cocarry/run-v0", "--author", "A", "--email", "a@b.org", "--link", "https://c.org", "--description", "d")
    assert done.stdout == "wrote cocarry/run-v0: 1 episode, 180 steps\n"
    assert minari.load_dataset("cocarry/run-v0").storage.metadata["author"] == {"A"}


def test_the_command_line_refuses_with_one_message(home, recordings, tmp_path):
    run = recordings["point"]
    for arguments, message in [
        (("lerobot", "nowhere.mcap", "-o", "x"), "error: nowhere.mcap"),
        (("rosbag2", run, run, "-o", "x"), "error: rosbag2: takes one recording, not 2; write a bag for each"),
        (("rosbag2", run, "-o", "x"), "has no `/tf`: its team is a point"),
        (("minari", run, "-o", "x"), "error: dataset_id = 'x': has no version; expected a name such as cocarry/carried-v0"),
        (("minari", run, "-o", "a/b-v0", "--task", "x"), "error: --task: is for lerobot, not for minari"),
        (("lerobot", run, "-o", "x", "--license", ""), "error: license = ''; expected an identifier"),
        (("csv", run, "-o", "x"), "invalid choice: 'csv'"),
        (("lerobot", run), "required: -o/--output"),
        (("lerobot", "-o", "x"), "required: RECORDING"),
    ]:
        done = command(*arguments)
        assert done.returncode == 2 and message in done.stderr and "Traceback" not in done.stderr and not done.stdout, arguments
    assert list(tmp_path.iterdir()) == []
    shown = command("--help")
    assert shown.returncode == 0 and "LeRobotDataset v3.0" in shown.stdout and "examples:" in shown.stdout
