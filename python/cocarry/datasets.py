"""Data sets for other tools: rosbag2 (MCAP) from recordings, Minari from episodes of environments.

They need the extra ``datasets``: ``pip install "./python[datasets]"``. A data set appears under its name when it is
whole. An existing one is refused, unless ``overwrite=True``; it is then replaced when the new one is whole.
"""

from __future__ import annotations

import importlib
import math
import os
import pathlib
import re
import shutil
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from cocarry._cocarry import Error, Recording, RecordingError, Table, __version__, read

__all__ = ["DatasetError", "to_minari", "to_rosbag2"]

_Path: TypeAlias = str | os.PathLike[str]
_Floats: TypeAlias = NDArray[np.float64]
_Messages: TypeAlias = Iterator[tuple[int, Any]]

# Version 8 of the metadata has the profiles of quality of service as text, as readers before version 9 expect them.
_BAG_VERSION = 8
_AXES = ("x", "y", "z")


class DatasetError(Error):
    """A data set that cannot be written."""


def to_rosbag2(recording: Recording | _Path, bag: _Path, *, overwrite: bool = False) -> pathlib.Path:
    """Writes a recording as a rosbag2: the folder ``bag`` with ``metadata.yaml`` and an MCAP file (profile ros2, CDR).

    Stamps are simulated times from 0, axes those of ``world``, units m, rad, s, N and Nm.

    /tf: tf2_msgs/TFMessage, the recording's frames.
    /joint_states: sensor_msgs/JointState, arm and wheels; ``effort`` is empty where the recording has none.
    /odom: nav_msgs/Odometry: the base's pose, and the constant twist, in the base's frame, that leads there from the
        last one. Covariances are 0, as for unknown ones.
    /grip_wrench, /hand_wrench: geometry_msgs/WrenchStamped, with physics: mean force and torque of robot and human on
        the object in the last period, the torque about the grip, in axes of ``world``.
    /path: nav_msgs/Path, the path of the executed option from where it was planned to B, on the floor; poses look to
        the next point.

    ``custom_data`` of the metadata has the recording's provenance and the scenario's text.

    recording: a Recording or its file, of a team with a robot. Returns the folder.

    Raises DatasetError: the folder exists or cannot be written, or the recording is that of a point. RecordingError:
    the recording cannot be read. ModuleNotFoundError: the extra is not installed.
    """
    rosbag2, typesys = _needed("rosbags.rosbag2"), _needed("rosbags.typesys")
    bag = pathlib.Path(bag)
    _free(bag, "metadata.yaml", overwrite, "a rosbag2")
    source = recording if isinstance(recording, Recording) else read(recording)
    if "/tf" not in source.topics:
        raise DatasetError(
            f"{source!r}: has no `/tf`: its team is a point, without frames, joints and forces; "
            'record an episode with plant="kinematic" or plant="rapier"'
        )
    store = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
    topics = _topics(source, store.types)
    profile = _profile()
    with _beside(bag, overwrite) as folder, _written(bag):
        with rosbag2.Writer(folder, version=_BAG_VERSION, storage_plugin=rosbag2.StoragePlugin.MCAP) as writer:
            for key, value in sorted(source.provenance.items()):
                writer.set_custom_data(key, value)
            writer.set_custom_data("scenario", source.scenario.text)
            messages = []
            for topic, (kind, values) in topics.items():
                connection = writer.add_connection(topic, kind, typestore=store, offered_qos_profiles=[profile])
                messages += [(time, connection, store.serialize_cdr(value, kind)) for time, value in values]
            for time, connection, data in sorted(messages, key=lambda message: message[0]):
                writer.write(connection, time, data)
    return bag


def to_minari(
    environment: Any,
    policy: Callable[[Any], Any],
    dataset_id: str,
    *,
    episodes: int,
    seed: int = 0,
    overwrite: bool = False,
    **about: Any,
) -> Any:
    """Runs episodes of a Gymnasium environment, and writes them as a Minari data set, with Minari itself.

    The data set has every observation, action, reward and end; per episode ``seed`` (of ``reset``), ``scenario_world``,
    ``scenario_seed``, ``scenario_alpha``, ``scenario_gamma`` and ``outcome``; and the environment's definition, so
    ``recover_environment()`` makes it again. It lies where Minari looks
    (``MINARI_DATASETS_PATH``), in Minari's format "arrow". That setting belongs to the process: one thread at a time.

    environment: of ``gymnasium.make``, with worlds by name; its spaces are Box or Discrete. It stays open.
    policy: a function of an observation; its action.
    dataset_id: ``namespace/name-v0``. episodes: at least 1. seed: episode i begins with ``reset(seed=seed + i)``.
    about: further keywords of Minari's ``create_dataset_from_buffers``: author, author_email, code_permalink, description.

    Returns the ``minari.MinariDataset``.

    Raises DatasetError with the value and what would be right. ModuleNotFoundError: the extra is not installed.
    Exceptions of the policy are passed on; nothing is written then.
    """
    minari, names, namespaces = _needed("minari"), _needed("minari.dataset.minari_dataset"), _needed("minari.namespace")
    for module in ("pyarrow", "PIL"):  # of Minari's format "arrow"
        _needed(module)
    if episodes < 1:
        raise DatasetError(f"episodes = {episodes}; it must be at least 1")
    if seed < 0:
        raise DatasetError(f"seed = {seed}; it must be at least 0")
    try:
        namespace, _, _ = names.parse_dataset_id(dataset_id)
    except ValueError as error:
        raise DatasetError(f"dataset_id = {dataset_id!r}: {error}") from error
    spec = getattr(environment, "spec", None)
    if spec is None:
        raise DatasetError("the environment has no definition (spec); make it with gymnasium.make")
    for space in (environment.observation_space, environment.action_space):
        if type(space).__name__ not in ("Box", "Discrete"):
            raise DatasetError(f"{spec.id}: its space {space} must be a Box or a Discrete")
    try:
        spec.to_json()
    except (TypeError, ValueError) as error:
        message = f"{spec.id}: its keywords cannot be written: {error}; use texts and numbers, and worlds by name"
        raise DatasetError(message) from error
    about = {
        "algorithm_name": getattr(policy, "__name__", type(policy).__name__),
        "eval_env": spec,
        "requirements": [f"cocarry=={__version__}"],
        **about,
    }

    final = pathlib.Path(minari.storage.get_dataset_path(dataset_id))
    root = pathlib.Path(minari.storage.get_dataset_path(""))
    _free(final, "data", overwrite, "a Minari data set")
    buffers, drawn = [], []
    for index in range(episodes):
        fields, info = _episode(environment, policy, seed + index, f"episode {index}")
        buffers.append(_needed("minari.data_collector").EpisodeBuffer(id=index, seed=seed + index, **fields))
        drawn.append({key: value for key, value in info.items() if isinstance(value, (bool, int, float, str))})
    with _beside(final, overwrite, root) as folder, _datasets_in(folder.parent / "root"), _written(final):
        made = minari.create_dataset_from_buffers(dataset_id, buffers, environment, data_format="arrow", **about)
        made.storage.update_episode_metadata(drawn)
        os.replace(minari.storage.get_dataset_path(dataset_id), folder)
    if namespace is not None and namespace not in namespaces.list_local_namespaces():
        namespaces.create_namespace(namespace)
    return minari.load_dataset(dataset_id)


def _episode(environment: Any, policy: Callable[[Any], Any], seed: int, name: str) -> tuple[dict[str, list[Any]], dict[str, Any]]:
    """Runs an episode: the fields of a buffer of Minari, and what was drawn for the episode with its outcome."""
    space = environment.action_space
    observation, drawn = environment.reset(seed=seed)
    observations: list[Any] = [observation]
    steps: list[tuple[Any, ...]] = []
    last: dict[str, Any] = {}
    over = False
    while not over:
        given = policy(observation)
        action = np.asarray(given, dtype=space.dtype) if np.can_cast(np.asarray(given).dtype, space.dtype, "same_kind") else given
        if not space.contains(action):
            raise DatasetError(f"{name}, step {len(steps)}: the policy's action {given!r} is not one of {space}")
        observation, reward, terminated, truncated, last = environment.step(action)
        observations.append(observation)
        steps.append((action, reward, terminated, truncated))
        over = terminated or truncated
    fields = dict(zip(("actions", "rewards", "terminations", "truncations"), map(list, zip(*steps))))
    about = {f"scenario_{key}": value for key, value in drawn.items()}
    return {"observations": observations, **fields}, {**about, "outcome": last.get("outcome")}


def _needed(module: str) -> Any:
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        package = module.partition(".")[0]
        raise ModuleNotFoundError(f'data sets need {package}: pip install "./python[datasets]"', name=error.name) from error


def _free(path: pathlib.Path, sign: str, overwrite: bool, what: str) -> None:
    """Refuses a path that is taken; with ``overwrite``, one that is not a data set of this kind (with ``sign`` in it)."""
    if not os.path.lexists(path):
        return
    if not overwrite:
        raise DatasetError(f"{path}: exists already; choose another name, or overwrite=True")
    if path.is_symlink() or not (path / sign).exists():
        raise DatasetError(f"{path}: is not {what} (no `{sign}` in it) and is not overwritten; choose another name")


@contextmanager
def _beside(final: pathlib.Path, overwrite: bool, root: pathlib.Path | None = None) -> Iterator[pathlib.Path]:
    """A folder's name in a temporary folder of ``root`` (default: the final one's parent). What is made there gets the
    final name if nothing is raised."""
    root = (root or final.parent).absolute()  # Minari does not write into relative folders
    with _written(final):
        root.mkdir(parents=True, exist_ok=True)
        temporary = pathlib.Path(tempfile.mkdtemp(prefix=".cocarry-", dir=root))
    made, old = temporary / f"{final.name}_0", temporary / "old"
    try:
        yield made
        if os.path.lexists(final) and not overwrite:
            raise DatasetError(f"{final}: exists already; choose another name, or overwrite=True")
        with _written(final):
            final.parent.mkdir(parents=True, exist_ok=True)
            if overwrite and final.exists():
                os.replace(final, old)
            try:
                os.replace(made, final)
            except OSError:
                if old.exists():
                    os.replace(old, final)
                raise
    finally:
        shutil.rmtree(temporary, ignore_errors=True)


@contextmanager
def _written(path: pathlib.Path) -> Iterator[None]:
    """Errors of the file system name the data set."""
    try:
        yield
    except OSError as error:
        raise DatasetError(f"{path}: cannot be written: {error}") from error


@contextmanager
def _datasets_in(folder: pathlib.Path) -> Iterator[None]:
    """Lets Minari write into a folder."""
    before = os.environ.get("MINARI_DATASETS_PATH")
    os.environ["MINARI_DATASETS_PATH"] = str(folder)
    try:
        yield
    finally:
        if before is None:
            del os.environ["MINARI_DATASETS_PATH"]
        else:
            os.environ["MINARI_DATASETS_PATH"] = before


def _profile() -> Any:
    """The default of publishers: reliable, the last 10."""
    rosbags = _needed("rosbags.interfaces")
    never = rosbags.QosTime(9223372036, 854775807)
    return rosbags.Qos(
        history=rosbags.QosHistory.KEEP_LAST,
        depth=10,
        reliability=rosbags.QosReliability.RELIABLE,
        durability=rosbags.QosDurability.VOLATILE,
        deadline=never,
        lifespan=never,
        liveliness=rosbags.QosLiveliness.AUTOMATIC,
        liveliness_lease_duration=never,
        avoid_ros_namespace_conventions=False,
    )


class _Columns:
    """A table's columns as numbers, NaN where missing; times in ns."""

    def __init__(self, table: Table) -> None:
        self._table = table
        self.names = table.columns
        self.times = [round(time * 1e9) for time in table["time_s"]]

    def numbers(self, *names: str) -> _Floats:
        """Columns side by side, (rows, columns); NaN for those that do not exist."""
        known = set(self.names)
        missing = np.full(len(self.times), np.nan)
        columns = [np.asarray(self._table[name], dtype=np.float64) if name in known else missing for name in names]
        return np.stack(columns, axis=1)

    def texts(self, name: str) -> list[Any]:
        return list(self._table[name])

    def items(self, pattern: str) -> list[str]:
        """What the group of the pattern is in the names, in their order, each once."""
        found = (re.fullmatch(pattern, name) for name in self.names)
        return list(dict.fromkeys(match[1] for match in found if match))


def _topics(recording: Recording, types: Any) -> dict[str, tuple[str, _Messages]]:
    """The topics of a bag with their types, times (ns) and messages."""
    frames = _Columns(recording.table("/tf"))
    topics = {
        "/tf": ("tf2_msgs/msg/TFMessage", _transforms(frames, types)),
        "/joint_states": ("sensor_msgs/msg/JointState", _joints(_Columns(recording.table("/joints")), types)),
        "/odom": ("nav_msgs/msg/Odometry", _odometry(frames, types)),
    }
    if "/interaction" in recording.topics:
        forces = _Columns(recording.table("/interaction"))
        for partner in ("grip", "hand"):
            topics[f"/{partner}_wrench"] = ("geometry_msgs/msg/WrenchStamped", _wrenches(forces, partner, types))
    if "/scene/path" in recording.topics:
        topics["/path"] = ("nav_msgs/msg/Path", _paths(_Columns(recording.table("/scene/path")), types))
    return topics


def _header(types: Any, time: int, frame: str) -> Any:
    stamp = types["builtin_interfaces/msg/Time"](sec=time // 1_000_000_000, nanosec=time % 1_000_000_000)
    return types["std_msgs/msg/Header"](stamp=stamp, frame_id=frame)


def _vector(types: Any, kind: str, values: Any) -> Any:
    return types[f"geometry_msgs/msg/{kind}"](**dict(zip("xyzw", (float(value) for value in values))))


def _frame(frames: _Columns, frame: str) -> tuple[list[Any], _Floats]:
    """The parents of a frame, and its positions and quaternions (x, y, z, w), (rows, 7)."""
    of = f"transforms[{frame}]."
    places = [f"{of}translation.{axis}" for axis in _AXES] + [f"{of}rotation.{axis}" for axis in "xyzw"]
    return frames.texts(f"{of}parent_frame_id"), frames.numbers(*places)


def _names_of_frames(frames: _Columns) -> list[str]:
    return frames.items(r"transforms\[(.+)\]\.parent_frame_id")


def _transforms(frames: _Columns, types: Any) -> _Messages:
    poses = [(name, *_frame(frames, name)) for name in _names_of_frames(frames)]
    for row, time in enumerate(frames.times):
        transforms = [
            types["geometry_msgs/msg/TransformStamped"](
                header=_header(types, time, parents[row]),
                child_frame_id=name,
                transform=types["geometry_msgs/msg/Transform"](
                    translation=_vector(types, "Vector3", values[row, :3]),
                    rotation=_vector(types, "Quaternion", values[row, 3:]),
                ),
            )
            for name, parents, values in poses
            if parents[row] is not None
        ]
        yield time, types["tf2_msgs/msg/TFMessage"](transforms=transforms)


def _joints(joints: _Columns, types: Any) -> _Messages:
    names = joints.items(r"joints\[(.+)\]\.position")
    values = {key: joints.numbers(*(f"joints[{name}].{key}" for name in names)) for key in ("position", "velocity", "effort")}
    for row, time in enumerate(joints.times):
        given = {key: numbers[row] for key, numbers in values.items()}
        arrays = {key: np.empty(0) if np.isnan(numbers).all() else numbers for key, numbers in given.items()}
        yield time, types["sensor_msgs/msg/JointState"](header=_header(types, time, ""), name=names, **arrays)


def _odometry(frames: _Columns, types: Any) -> _Messages:
    # the links come from the root on
    base = next((name for name in _names_of_frames(frames) if name.startswith("robot/")), None)
    if base is None:
        raise RecordingError("`/tf` has no frame of a robot; expected robot/LINK")
    parents, values = _frame(frames, base)
    previous = None
    unknown = np.zeros(36)
    for row, time in enumerate(frames.times):
        x, y, _, qx, qy, qz, qw = values[row]
        pose = (x, y, math.atan2(2 * (qw * qz + qx * qy), 1 - 2 * (qy * qy + qz * qz)))
        ahead, left, turn = (0.0, 0.0, 0.0)
        if previous is not None and time > previous[0]:
            ahead, left, turn = _twist(previous[1], pose, (time - previous[0]) / 1e9)
        previous = (time, pose)
        twist = types["geometry_msgs/msg/Twist"](
            linear=_vector(types, "Vector3", (ahead, left, 0)), angular=_vector(types, "Vector3", (0, 0, turn))
        )
        yield time, types["nav_msgs/msg/Odometry"](
            header=_header(types, time, parents[row]),
            child_frame_id=base,
            pose=types["geometry_msgs/msg/PoseWithCovariance"](pose=_pose(types, values[row]), covariance=unknown),
            twist=types["geometry_msgs/msg/TwistWithCovariance"](twist=twist, covariance=unknown),
        )


def _twist(a: tuple[float, float, float], b: tuple[float, float, float], seconds: float) -> tuple[float, float, float]:
    """The constant twist (ahead, left, turning; m/s, rad/s) from one pose (x, y, yaw) to another: the logarithm in SE(2)."""
    x, y = b[0] - a[0], b[1] - a[1]
    cos, sin = math.cos(a[2]), math.sin(a[2])
    ahead, left = cos * x + sin * y, cos * y - sin * x
    turn = math.remainder(b[2] - a[2], math.tau)
    half = turn / 2
    scale = half / math.tan(half) if abs(half) > 1e-9 else 1.0
    return (scale * ahead + half * left) / seconds, (scale * left - half * ahead) / seconds, turn / seconds


def _wrenches(forces: _Columns, partner: str, types: Any) -> _Messages:
    names = [f"{partner}_mean_force_{axis}_n" for axis in _AXES] + [f"{partner}_mean_torque_{axis}_nm" for axis in _AXES]
    values = forces.numbers(*names)
    for row, time in enumerate(forces.times):
        wrench = types["geometry_msgs/msg/Wrench"](
            force=_vector(types, "Vector3", values[row, :3]), torque=_vector(types, "Vector3", values[row, 3:])
        )
        yield time, types["geometry_msgs/msg/WrenchStamped"](header=_header(types, time, "world"), wrench=wrench)


def _paths(scene: _Columns, types: Any) -> _Messages:
    line = "entities[ahead].lines[0].points"
    count = len(scene.items(re.escape(line) + r"\[(\d+)\]\.x"))
    xs, ys = (scene.numbers(*(f"{line}[{point}].{axis}" for point in range(count))) for axis in ("x", "y"))
    for row, time in enumerate(scene.times):
        given = ~np.isnan(xs[row])
        x, y = xs[row, given], ys[row, given]
        headings = np.arctan2(np.diff(y), np.diff(x)) if len(x) > 1 else np.zeros(len(x))
        headings = np.append(headings, headings[-1:])[: len(x)]
        header = _header(types, time, "world")
        poses = [
            types["geometry_msgs/msg/PoseStamped"](
                header=header, pose=_pose(types, (px, py, 0, 0, 0, math.sin(yaw / 2), math.cos(yaw / 2)))
            )
            for px, py, yaw in zip(x, y, headings)
        ]
        yield time, types["nav_msgs/msg/Path"](header=header, poses=poses)


def _pose(types: Any, values: Any) -> Any:
    return types["geometry_msgs/msg/Pose"](
        position=_vector(types, "Point", values[:3]), orientation=_vector(types, "Quaternion", values[3:])
    )
