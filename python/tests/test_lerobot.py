"""LeRobot data sets, as pyarrow, lerobot-doctor and LeRobot's own loader read them."""

from __future__ import annotations

import json
import pathlib
import subprocess
import sys

import gymnasium
import numpy as np
import pyarrow.parquet as parquet
import pytest
from ruamel.yaml import YAML

import cocarry
import cocarry.environments
from cocarry.datasets import DatasetError, to_lerobot

PLANTS = ["point", "kinematic", "rapier"]


@pytest.fixture(scope="module")
def data_sets(recordings, tmp_path_factory):
    """For every plant a data set of a recording's file, a Recording and a scenario in another world that runs here."""
    made = {}
    for plant, file in recordings.items():
        other = cocarry.Scenario("environment-1", plant=plant, seed=3)
        sources = [file, cocarry.read(file), other]
        made[plant] = to_lerobot(sources, tmp_path_factory.mktemp(plant) / "data")
    return made


def info(folder):
    return json.loads((folder / "meta" / "info.json").read_text())


def frames(folder):
    table = parquet.read_table(folder / "data")
    return {name: np.array(table[name].to_pylist()) for name in table.column_names}


def episode(folder, index):
    found = frames(folder)
    return {name: values[found["episode_index"] == index] for name, values in found.items()}


def names(folder, feature):
    return info(folder)["features"][feature]["names"]


def number(found, folder, feature, name):
    return found[feature][:, names(folder, feature).index(name)]


@pytest.mark.parametrize("plant", PLANTS)
def test_frames_have_a_recordings_values_to_the_bit(recordings, data_sets, plant):
    folder, recording = data_sets[plant], cocarry.read(recordings[plant])
    coordination, cost = recording.table("/coordination"), recording.table("/cost")
    count = len(coordination)
    for index in (0, 1):
        found = episode(folder, index)
        assert len(found["index"]) == count > 100
        assert found["index"].tolist() == list(range(index * count, (index + 1) * count))
        assert found["frame_index"].tolist() == list(range(count))
        assert np.allclose(found["timestamp"], coordination["time_s"], atol=1e-5)
        assert np.array_equal(found["next.reward"], -cost["objective_cost_m"])
        assert found["next.done"].tolist() == found["next.success"].tolist() == [False] * (count - 1) + [True]
        led = coordination["mode"] == "human-led"
        decision = np.where(led, len(recording.scenario.options), coordination["executed_index"])
        assert np.array_equal(found["action" if plant == "point" else "decision"], decision) and len(set(decision)) > 1
        options(recording, folder, found)
        if plant == "point":
            assert np.array_equal(found["observation.state"], np.column_stack([coordination["x_m"], coordination["y_m"]]))
        else:
            robot(recording, folder, found)


def options(recording, folder, found):
    table, coordination = recording.table("/options"), recording.table("/coordination")
    for index, option in enumerate(recording.scenario.options):
        for key in ("length_m", "risk", "objective_cost_m", "expected_subjective_cost", "probability", "misaligned"):
            expected = np.array(table[f"options[{option}].{key}"], dtype=float)
            given = number(found, folder, "observation.environment_state", f"{key}[{index}]")
            assert np.array_equal(given, np.nan_to_num(expected))
    assert np.array_equal(number(found, folder, "observation.environment_state", "stubbornness"), coordination["stubbornness"])


def robot(recording, folder, found):
    count, joints = len(found["index"]), recording.scenario.robot.joints
    control, tf, arm = (recording.table(topic) for topic in ("/control", "/tf", "/joints"))
    rims = [control["left_rim_m_per_s"], control["right_rim_m_per_s"]]
    rates = [control[f"joints[{joint}].rate_rad_per_s"] for joint in joints]
    assert np.array_equal(found["action"], np.column_stack(rims + rates)) and len(joints) == 7
    expected = {
        "base_x_m": tf["transforms[robot/base_link].translation.x"],
        "base_rotation_w": tf["transforms[robot/base_link].rotation.w"],
        **{f"joint[{joint}]_rad": arm[f"joints[{joint}].position"] for joint in joints},
    }
    if recording.provenance["plant"] == "rapier":
        force = recording.table("/interaction")["hand_mean_force_x_n"]
        expected |= {
            "object_y_m": tf["transforms[object].translation.y"],
            "hand_mean_force_x_n": np.concatenate([[0], force]),  # that of the period before
            **{f"joint[{joint}]_rad_per_s": arm[f"joints[{joint}].velocity"] for joint in joints},
        }
    for name, values in expected.items():
        assert np.array_equal(number(found, folder, "observation.state", name), values[:count]), name
        assert name.startswith("joint") or values.std() > 0
    # the base is where u leads it
    assert np.abs(np.diff(number(found, folder, "observation.state", "base_x_m"))).max() > 0.05
    assert np.array_equal(number(found, folder, "observation.environment_state", "grasp_goal_x_m"), control["grasp_goal_x_m"])


@pytest.mark.parametrize("index", [0, 2])
def test_a_points_frames_are_those_of_the_environment(data_sets, index):
    found = episode(data_sets["point"], index)
    about = parquet.read_table(data_sets["point"] / "meta" / "episodes").to_pylist()[index]
    keywords = {"worlds": about["scenario_world"], "subjective_weight": 0.0} | ({"eta": 5} if index == 0 else {})
    environment = gymnasium.make("cocarry/Options-v0", **keywords)
    drawn = {"seed": about["scenario_seed"], "alpha": about["scenario_alpha"], "gamma": about["scenario_gamma"]}
    observation, _ = environment.reset(options=drawn)
    for step, action in enumerate(found["action"]):
        assert np.array_equal(found["observation.environment_state"][step], observation), step
        observation, reward, terminated, truncated, _ = environment.step(action)
        assert reward == found["next.reward"][step]
        assert (terminated or truncated) == found["next.done"][step]


@pytest.mark.parametrize("plant", PLANTS)
def test_an_episodes_row_tells_its_scenario(recordings, data_sets, plant):
    rows = parquet.read_table(data_sets[plant] / "meta" / "episodes").to_pylist()
    expected = cocarry.read(recordings[plant])
    assert [row["scenario_world"] for row in rows] == ["environment-4", "environment-4", "environment-1"]
    assert cocarry.Scenario.parse(rows[0]["scenario_text"]) == expected.scenario
    assert (rows[0]["scenario_alpha"], rows[0]["scenario_gamma"], rows[0]["scenario_method"]) == (0.747, 0.765, "mutual")
    for key in ("outcome", "accumulated_objective_cost_m", "accumulated_subjective_cost"):
        assert rows[0][key] == expected.outcome[key]
    assert rows[2]["scenario_seed"] == 3
    ran = cocarry.Episode(cocarry.Scenario.parse(rows[2]["scenario_text"])).run()
    assert rows[2]["accumulated_objective_cost_m"] == ran["accumulated_objective_cost_m"]
    assert rows[2]["length"] == ran["steps"] and rows[2]["dataset_to_index"] == info(data_sets[plant])["total_frames"]


def test_metadata_have_units_rate_and_tasks(data_sets):
    folder = data_sets["rapier"]
    about = info(folder)
    assert (about["codebase_version"], about["fps"], about["robot_type"]) == ("v3.0", 5, cocarry.Robot().name)
    assert (about["total_episodes"], about["total_tasks"], about["splits"]) == (3, 2, {"train": "0:3"})
    state = about["features"]["observation.state"]
    units = dict(zip(state["names"], state["units"]))
    assert units["base_x_m"] == "m" and units["joint[elbow_flex_joint]_rad_per_s"] == "rad/s" and units["hand_mean_torque_z_nm"] == "Nm"
    _, front, card = (folder / "README.md").read_text().split("---\n", 2)
    assert YAML(typ="safe").load(front)["license"] == "mit"
    for key, feature in about["features"].items():
        assert len(feature["names"] or [0]) == feature["shape"][0]
        if feature["names"]:
            assert len(feature["units"]) == len(feature["names"])
            lines = [f"| `{key}` | {i} | `{n}` | {u} |" for i, (n, u) in enumerate(zip(feature["names"], feature["units"]))]
            assert all(line in card for line in lines)
    tasks = parquet.read_table(folder / "meta" / "tasks.parquet").to_pandas()
    assert [text.rsplit("in ")[-1] for text in tasks.index] == ["Environment 4.", "Environment 1."]
    assert tasks["task_index"].tolist() == [0, 1]
    assert set(frames(folder)["task_index"]) == {0, 1}


def test_statistics_are_those_of_the_frames(data_sets):
    stats = json.loads((data_sets["kinematic"] / "meta" / "stats.json").read_text())
    found = frames(data_sets["kinematic"])
    assert set(stats) == set(found) == set(info(data_sets["kinematic"])["features"])
    for key, values in found.items():
        numbers = values.reshape(len(values), -1).astype(float)
        for name in ("min", "max", "mean", "std"):
            np.testing.assert_allclose(stats[key][name], getattr(numbers, name)(axis=0), rtol=1e-9, atol=1e-12)
        assert stats[key]["count"] == [len(values)]
    rows = parquet.read_table(data_sets["kinematic"] / "meta" / "episodes").to_pylist()
    last = episode(data_sets["kinematic"], 2)["action"]
    assert np.array_equal(rows[2]["stats/action/q90"], np.quantile(last, 0.9, axis=0))


@pytest.mark.parametrize("plant", PLANTS)
def test_lerobot_doctor_accepts_it(data_sets, plant):
    pytest.importorskip("lerobot_doctor")
    command = [sys.executable, "-c", "from lerobot_doctor.cli import main; main()", str(data_sets[plant]), "--ci"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    report = json.loads(done.stdout)
    assert done.returncode == 0 and report["overall_severity"] in ("PASS", "WARN")
    assert {check["severity"] for check in report["checks"] if "Metadata" in check["name"] or "Temporal" in check["name"]} == {"PASS"}


@pytest.mark.parametrize("plant", PLANTS)
def test_lerobots_loader_loads_it(data_sets, plant, tmp_path, monkeypatch):
    pytest.importorskip("lerobot", reason="the loader needs lerobot: pip install -r python/tests/lerobot.txt")
    monkeypatch.setenv("HF_HUB_OFFLINE", "1")
    monkeypatch.setenv("HF_HOME", str(tmp_path))
    from lerobot.datasets.lerobot_dataset import LeRobotDataset

    folder = data_sets[plant]
    loaded = LeRobotDataset(repo_id="cocarry/test", root=folder, delta_timestamps={"action": [0.0, 0.2]})
    found = frames(folder)
    assert (len(loaded), loaded.num_episodes, loaded.fps) == (len(found["index"]), 3, 5)
    # LeRobot makes float32 of numbers; what it loaded is float64
    stored = loaded.hf_dataset.with_format("arrow")[:]
    for row in (0, 7, len(loaded) - 1):
        item = loaded[row]
        for key in ("observation.state", "observation.environment_state", "next.reward"):
            assert np.array_equal(item[key].numpy(), found[key][row].astype(np.float32))
            assert np.array_equal(np.array(stored[key].to_pylist())[row], found[key][row])
        assert np.array_equal(item["action"][0].numpy().squeeze(), found["action"][row].astype(item["action"].numpy().dtype))
    assert loaded[0]["task"] == "Carry the object together with the human from A to B in Environment 4."
    assert loaded.meta.episodes[2]["scenario_world"] == "environment-1"
    np.testing.assert_allclose(loaded.meta.stats["action"]["mean"], found["action"].reshape(len(loaded), -1).mean(axis=0))


def test_own_policies_and_tasks_are_written(tmp_path):
    episodes = [cocarry.Episode(cocarry.Scenario("environment-4", plant="point", seed=seed), policy=lambda view: 0) for seed in (1, 2)]
    made = to_lerobot(iter(episodes), tmp_path / "own", task="carry the table", license="cc-by-4.0")
    rows = parquet.read_table(made / "meta" / "episodes").to_pylist()
    assert [row["tasks"] for row in rows] == [["carry the table"]] * 2 and rows[0]["scenario_method"].startswith("own")
    assert set(frames(made)["action"]) == {0}
    assert "license: cc-by-4.0" in (made / "README.md").read_text()


def test_a_data_set_is_whole_or_not_there(recordings, data_sets, tmp_path):
    made = to_lerobot([recordings["point"]], tmp_path / "a" / "data")
    before = {file: file.read_bytes() for file in made.rglob("*") if file.is_file()}
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "thesis.txt").write_text("all of it")
    broken = tmp_path / "broken.mcap"
    broken.write_bytes(recordings["point"].read_bytes()[:20000])
    point, new = recordings["point"], tmp_path / "a" / "new"
    slow = cocarry.Scenario("environment-4", plant="point", planning_step_s=0.3)
    fast = cocarry.Scenario("environment-4", plant="point", planning_step_s=0.1)
    for episodes, folder, keywords, message in [
        ([point], made, {}, "data: exists already; choose another name, or overwrite=True"),
        ([point], tmp_path / "other", {"overwrite": True}, r"other: is not a LeRobot data set \(no `meta/info.json` in it\)"),
        ([], new, {}, "episodes: there are none"),
        (point, new, {}, "episodes: expected a list of recordings, scenarios or episodes, not a single one"),
        ([point, 7], new, {}, "episode 1: int; expected a Recording, its file, a Scenario or an Episode"),
        ([point, recordings["rapier"]], new, {}, r"run.mcap: its team is Carrier on the plant rapier; that of .* is point on point; write a data set"),
        ([slow], new, {}, r"episode 0: planning_step_s = 0.3; LeRobot needs a whole number of frames per second, as with 0.1"),
        ([point, fast], new, {}, r"episode 1: planning_step_s = 0.1; that of .*run.mcap is 0.2"),
        ([point], new, {"license": "My License"}, "license = 'My License'; expected an identifier such as mit"),
        ([point], new, {"task": " "}, "task: is empty"),
        ([point], recordings["point"] / "x", {}, "cannot be written"),
    ]:
        with pytest.raises(DatasetError, match=message):
            to_lerobot(episodes, folder, **keywords)
    with pytest.raises(cocarry.RecordingError, match="nowhere"):
        to_lerobot([point, tmp_path / "nowhere.mcap"], made, overwrite=True)
    with pytest.raises(cocarry.Error, match="broken"):
        to_lerobot([point, broken], made, overwrite=True)
    assert [path.name for path in (tmp_path / "a").iterdir()] == ["data"]
    assert {file: file.read_bytes() for file in made.rglob("*") if file.is_file()} == before
    to_lerobot([data for data in (point, point)], made, overwrite=True)
    assert info(made)["total_episodes"] == 2
    assert sorted(str(file.relative_to(made)) for file in made.rglob("*") if file.is_file()) == sorted([
        "README.md", "data/chunk-000/file-000.parquet", "meta/episodes/chunk-000/file-000.parquet", "meta/info.json",
        "meta/stats.json", "meta/tasks.parquet",
    ])  # fmt: skip
    again = to_lerobot([point], pathlib.Path(tmp_path / "again"))
    assert {file.relative_to(again): file.read_bytes() for file in again.rglob("*") if file.is_file()} == {
        file.relative_to(made): content for file, content in before.items()
    }


def test_full_files_are_followed_by_the_next(recordings, tmp_path, monkeypatch):
    import cocarry.datasets._lerobot as writer

    monkeypatch.setattr(writer, "_FILE_MB", 0.08)
    monkeypatch.setattr(writer, "_CHUNK_FILES", 2)
    made = to_lerobot([recordings["point"]] * 5, tmp_path / "many")
    files = sorted(str(file.relative_to(made)) for file in (made / "data").rglob("*.parquet"))
    assert files == [f"data/chunk-{chunk:03d}/file-{file:03d}.parquet" for chunk, file in [(0, 0), (0, 1), (1, 0), (1, 1), (2, 0)]]
    for row in parquet.read_table(made / "meta" / "episodes").to_pylist():
        name = info(made)["data_path"].format(chunk_index=row["data/chunk_index"], file_index=row["data/file_index"])
        assert row["episode_index"] in parquet.read_table(made / name)["episode_index"].to_pylist()


def test_a_missing_extra_is_named(recordings, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(ModuleNotFoundError, match=r'need pyarrow: pip install "./python\[datasets\]"'):
        to_lerobot([recordings["point"]], tmp_path / "new")
