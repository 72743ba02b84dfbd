"""Data sets, as other tools read them."""

from __future__ import annotations

import hashlib
import math
import sys

import gymnasium
import mcap.reader
import minari
import numpy as np
import pytest
import rosbags.rosbag2
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader
from ruamel.yaml import YAML

import cocarry
import cocarry.environments
from cocarry.datasets import DatasetError, to_minari, to_rosbag2

PLANTS = ["kinematic", "rapier"]


def by_rosbags(bag):
    with AnyReader([bag]) as reader:
        return [(c.topic, time, reader.deserialize(data, c.msgtype)) for c, time, data in reader.messages()]


def by_mcap_ros2(bag):
    with (bag / f"{bag.name}_0.mcap").open("rb") as file:
        reader = mcap.reader.make_reader(file, decoder_factories=[DecoderFactory()])
        return [(channel.topic, message.log_time, value) for _, channel, message, value in reader.iter_decoded_messages()]


READERS = [by_rosbags, by_mcap_ros2]


def vector(value):
    return [value.x, value.y, value.z] + ([value.w] if hasattr(value, "w") else [])


def column(table, name):
    return table[name] if name in table.columns else np.full(len(table), np.nan)


def nanoseconds(stamp):
    return stamp.sec * 10**9 + stamp.nanosec


@pytest.mark.parametrize("read", READERS)
@pytest.mark.parametrize("plant", PLANTS)
def test_other_readers_read_a_recordings_values_from_a_bag(recordings, tmp_path, plant, read):
    bag = to_rosbag2(recordings[plant], tmp_path / "bag")
    recording = cocarry.read(recordings[plant])
    messages = {}
    for topic, time, message in read(bag):
        stamps = [part.header.stamp for part in message.transforms] if topic == "/tf" else [message.header.stamp]
        assert all(nanoseconds(stamp) == time for stamp in stamps)
        messages.setdefault(topic, []).append((time, message))
    sources = {"/tf": "/tf", "/joint_states": "/joints", "/odom": "/tf", "/path": "/scene/path"}
    if plant == "rapier":
        sources |= {"/grip_wrench": "/interaction", "/hand_wrench": "/interaction"}
    assert set(messages) == set(sources)
    for topic, source in sources.items():
        table = recording.table(source)
        assert [time for time, _ in messages[topic]] == [round(time * 1e9) for time in table["time_s"]]
        checks = {"/tf": frames, "/joint_states": joints, "/odom": odometry, "/path": paths}
        for row, (_, message) in enumerate(messages[topic]):
            checks.get(topic, wrench)(table, row, message, topic)
    drive(recording, [message for _, message in messages["/odom"]], exact=plant == "kinematic")


def frames(table, row, message, _topic):
    written = {name.removeprefix("transforms[").removesuffix("].translation.x") for name in table.columns if name.endswith("translation.x")}
    assert len(written) > 10
    assert {part.child_frame_id for part in message.transforms} == written
    for part in message.transforms:
        of = f"transforms[{part.child_frame_id}]."
        assert part.header.frame_id == table[f"{of}parent_frame_id"][row]
        assert vector(part.transform.translation) == [table[f"{of}translation.{axis}"][row] for axis in "xyz"]
        assert vector(part.transform.rotation) == [table[f"{of}rotation.{axis}"][row] for axis in "xyzw"]


def joints(table, row, message, _topic):
    names = [name for name in table.columns if name.startswith("joints[") and name.endswith(".position")]
    assert [f"joints[{name}].position" for name in message.name] == names and len(names) == 9
    for key in ("position", "velocity", "effort"):
        expected = np.array([column(table, f"joints[{name}].{key}")[row] for name in message.name], dtype=float)
        given = np.asarray(getattr(message, key))
        assert len(given) == 0 and np.isnan(expected).all() or np.array_equal(given, expected, equal_nan=True)


def wrench(table, row, message, topic):
    partner = topic[1:5]
    assert message.header.frame_id == "world"
    assert vector(message.wrench.force) == [table[f"{partner}_mean_force_{axis}_n"][row] for axis in "xyz"]
    assert vector(message.wrench.torque) == [table[f"{partner}_mean_torque_{axis}_nm"][row] for axis in "xyz"]


def odometry(table, row, message, _topic):
    of = f"transforms[{message.child_frame_id}]."
    assert message.child_frame_id == "robot/base_link"
    assert message.header.frame_id == table[f"{of}parent_frame_id"][row]
    assert vector(message.pose.pose.position) == [table[f"{of}translation.{axis}"][row] for axis in "xyz"]
    assert vector(message.pose.pose.orientation) == [table[f"{of}rotation.{axis}"][row] for axis in "xyzw"]


def drive(recording, odometry, exact):
    """The twists are those of the wheels: exactly without physics, whose wheels do not slip."""
    control = recording.table("/control")
    rims = (control["left_rim_m_per_s"] + control["right_rim_m_per_s"]) / 2
    twists = np.array([[o.twist.twist.linear.x, o.twist.twist.linear.y, o.twist.twist.angular.z] for o in odometry])
    assert (twists[0] == 0).all() and np.abs(rims).max() > 0.4 and np.abs(twists[:, 2]).max() > 0.1
    assert np.abs(twists[1:, 0] - rims).max() < (1e-9 if exact else 0.2)
    assert np.abs(twists[:, 1]).max() < (1e-9 if exact else 0.1)


def paths(table, row, message, _topic):
    line = "entities[ahead].lines[0].points"
    expected = []
    while (x := column(table, f"{line}[{len(expected)}].x")[row]) is not None and not math.isnan(x):
        expected.append((x, table[f"{line}[{len(expected)}].y"][row]))
    points = [(pose.pose.position.x, pose.pose.position.y) for pose in message.poses]
    assert points == expected and len(points) >= 2
    for pose, (a, b) in zip(message.poses, zip(points, points[1:])):
        yaw = 2 * math.atan2(pose.pose.orientation.z, pose.pose.orientation.w)
        direction = np.subtract(b, a) / np.linalg.norm(np.subtract(b, a))
        assert [math.cos(yaw), math.sin(yaw)] == pytest.approx(direction)


def test_a_bag_keeps_the_conventions_of_rosbag2(recordings, tmp_path):
    bag = to_rosbag2(cocarry.read(recordings["rapier"]), tmp_path / "bag")
    assert sorted(file.name for file in bag.iterdir()) == ["bag_0.mcap", "metadata.yaml"]
    about = YAML(typ="safe").load(bag / "metadata.yaml")["rosbag2_bagfile_information"]
    with rosbags.rosbag2.Reader(bag) as reader:
        assert about["storage_identifier"] == "mcap" and about["relative_file_paths"] == ["bag_0.mcap"]
        assert about["message_count"] == reader.message_count == sum(topic.msgcount for topic in reader.topics.values()) > 800
        assert cocarry.Scenario.parse(about["custom_data"]["scenario"]) == cocarry.read(recordings["rapier"]).scenario
        assert about["custom_data"]["plant"] == "rapier"
    with (bag / "bag_0.mcap").open("rb") as file:
        reader = mcap.reader.make_reader(file, validate_crcs=True)
        assert reader.get_header().profile == "ros2"
        summary = reader.get_summary()
        assert {schema.encoding for schema in summary.schemas.values()} == {"ros2msg"}
        assert {channel.message_encoding for channel in summary.channels.values()} == {"cdr"}
        assert all("reliability: 1" in channel.metadata["offered_qos_profiles"] for channel in summary.channels.values())
        times = [message.log_time for _, _, message in reader.iter_messages(log_time_order=False)]
        assert times == sorted(times)


def content(folder):
    return {str(file.relative_to(folder)): hashlib.sha256(file.read_bytes()).hexdigest() for file in folder.rglob("*") if file.is_file()}


def test_a_bag_is_whole_or_not_there(recordings, tmp_path, monkeypatch):
    bag = to_rosbag2(recordings["kinematic"], tmp_path / "a" / "bag")
    first = content(bag)
    with pytest.raises(DatasetError, match=r"bag: exists already; choose another name, or overwrite=True"):
        to_rosbag2(recordings["kinematic"], bag)
    assert content(to_rosbag2(recordings["kinematic"], bag, overwrite=True)) == first
    assert to_rosbag2(recordings["rapier"], bag, overwrite=True) == bag and content(bag) != first
    second = content(bag)

    other = tmp_path / "other"
    other.mkdir()
    (other / "thesis.txt").write_text("all of it")
    with pytest.raises(DatasetError, match=r"other: is not a rosbag2 \(no `metadata.yaml` in it\) and is not overwritten"):
        to_rosbag2(recordings["kinematic"], other, overwrite=True)
    with pytest.raises(DatasetError, match="has no `/tf`: its team is a point"):
        to_rosbag2(recordings["point"], tmp_path / "point")
    with pytest.raises(cocarry.RecordingError, match="nowhere"):
        to_rosbag2(tmp_path / "nowhere.mcap", tmp_path / "nothing")
    with pytest.raises(DatasetError, match="cannot be written"):
        to_rosbag2(recordings["kinematic"], recordings["kinematic"] / "bag")

    def full(*_):
        raise OSError("no space left on device")

    monkeypatch.setattr(rosbags.rosbag2.Writer, "close", full)
    for name in (bag, tmp_path / "a" / "new"):
        with pytest.raises(DatasetError, match="cannot be written: no space left"):
            to_rosbag2(recordings["kinematic"], name, overwrite=True)
    assert [entry.name for entry in (tmp_path / "a").iterdir()] == ["bag"] and content(bag) == second
    assert sorted(entry.name for entry in tmp_path.iterdir()) == ["a", "other"]
    assert issubclass(DatasetError, cocarry.Error)


def test_a_missing_extra_is_named(recordings, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "rosbags.rosbag2", None)
    with pytest.raises(ModuleNotFoundError, match=r'need rosbags: pip install "./python\[datasets\]"'):
        to_rosbag2(recordings["kinematic"], tmp_path / "bag")


ABOUT = {"author": "A. Author", "author_email": "a@example.org", "code_permalink": "https://example.org", "description": "a test"}
ENVIRONMENTS = [
    ("cocarry/Options-v0", {"worlds": ["environment-1", "environment-4"], "eta": 5}),
    ("cocarry/Carry-v0", {"worlds": "environment-4", "action": "inputs", "max_steps": 30}),
    ("cocarry/Carry-v0", {"worlds": "environment-4", "action": "reference", "plant": "rapier", "max_steps": 5}),
]


class Draws:
    """A policy that draws actions, the same ones again for the same seed."""

    def __init__(self, space):
        self.space, self.draw = space, np.random.default_rng(7)

    def __call__(self, observation):
        assert observation.dtype == np.float64
        if isinstance(self.space, gymnasium.spaces.Discrete):
            return int(self.draw.integers(self.space.n))
        return self.draw.uniform(-0.2, 0.2, self.space.shape)


@pytest.fixture
def home(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MINARI_DATASETS_PATH", "minari")
    return tmp_path / "minari"


@pytest.mark.filterwarnings("error::UserWarning")
@pytest.mark.parametrize(("name", "keywords"), ENVIRONMENTS)
def test_minari_loads_the_episodes_and_makes_the_environment_again(home, name, keywords):
    environment = gymnasium.make(name, **keywords)
    policy = Draws(environment.action_space)
    made = to_minari(environment, policy, "cocarry/draws-v0", episodes=3, seed=11, **ABOUT)
    data = minari.load_dataset("cocarry/draws-v0")
    assert made.total_episodes == data.total_episodes == 3 and list(minari.list_local_datasets()) == ["cocarry/draws-v0"]
    assert data.storage.metadata["author"] == {"A. Author"} and data.storage.metadata["algorithm_name"] == "Draws"

    again, draws = data.recover_environment(), Draws(environment.action_space)
    assert again.spec.kwargs == environment.spec.kwargs
    steps = 0
    for index, episode in enumerate(data.iterate_episodes()):
        about = next(iter(data.storage.get_episode_metadata([index])))
        observation, info = again.reset(seed=about["seed"])
        assert about["seed"] == 11 + index
        told = {f"scenario_{key}": value for key, value in info.items() if key != "action_mask"}
        assert told.items() <= about.items() and "alpha" in info
        assert np.array_equal(episode.observations[0], observation)
        for step, action in enumerate(episode.actions):
            assert np.array_equal(action, draws(observation))
            observation, reward, terminated, truncated, info = again.step(action)
            assert np.array_equal(episode.observations[step + 1], observation)
            assert episode.rewards[step] == reward
            assert (episode.terminations[step], episode.truncations[step]) == (terminated, truncated)
        assert terminated or truncated
        assert about["outcome"] == info["outcome"]
        steps += len(episode.actions)
    assert steps == data.total_steps


def test_a_minari_data_set_is_whole_or_not_there(home):
    environment = gymnasium.make("cocarry/Options-v0", worlds="environment-4", eta=5)

    def follow(_observation):
        return environment.action_space.n - 1

    to_minari(environment, follow, "cocarry/follow-v0", episodes=1, **ABOUT)
    first = content(home)
    calls = []

    def breaks(observation):
        calls.append(observation)
        if len(calls) == 200:
            raise FileNotFoundError("my weights")
        return 0

    with pytest.raises(DatasetError, match=r"follow-v0: exists already; choose another name, or overwrite=True"):
        to_minari(environment, follow, "cocarry/follow-v0", episodes=1, **ABOUT)
    with pytest.raises(FileNotFoundError, match="my weights"):
        to_minari(environment, breaks, "cocarry/follow-v0", episodes=3, overwrite=True, **ABOUT)
    for wrong in (99, 0.5, None, "left", np.nan):
        with pytest.raises(DatasetError, match=r"episode 0, step 0: the policy's action .* is not one of Discrete\(5\)"):
            to_minari(environment, lambda _, wrong=wrong: wrong, "cocarry/new-v0", episodes=1)
    for keywords, message in [
        ({"episodes": 0}, "episodes = 0; it must be at least 1"),
        ({"episodes": 1, "seed": -1}, "seed = -1; it must be at least 0"),
        ({"episodes": 1, "dataset_id": "no version"}, "dataset_id = 'no version': Malformed dataset ID"),
    ]:
        with pytest.raises(DatasetError, match=message):
            to_minari(environment, follow, **{"dataset_id": "cocarry/new-v0", **keywords})
    with pytest.raises(DatasetError, match="has no definition"):
        to_minari(cocarry.environments.OptionsEnv(), follow, "cocarry/new-v0", episodes=1)
    with pytest.raises(DatasetError, match="keywords cannot be written: .*; use texts and numbers, and worlds by name"):
        to_minari(gymnasium.make("cocarry/Options-v0", worlds=cocarry.World()), follow, "cocarry/new-v0", episodes=1)
    assert content(home) == first

    made = to_minari(environment, follow, "cocarry/follow-v0", episodes=2, overwrite=True, **ABOUT)
    assert made.total_episodes == minari.load_dataset("cocarry/follow-v0").total_episodes == 2
    assert [entry.name for entry in home.iterdir()] == ["cocarry"]
