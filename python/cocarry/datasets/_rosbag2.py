"""Bags of ROS 2 from recordings."""

from __future__ import annotations

import math
import pathlib
import re
from collections.abc import Iterator
from typing import Any, TypeAlias

import numpy as np

from cocarry._cocarry import Recording, RecordingError, read
from cocarry.datasets._files import Columns, DatasetError, Floats, Path, free, needed, staged, written

_Messages: TypeAlias = Iterator[tuple[int, Any]]

# Version 8 of the metadata has the profiles of quality of service as text: readers before version 9 expect it.
_BAG_VERSION = 8
_AXES = ("x", "y", "z")


def to_rosbag2(recording: Recording | Path, bag: Path, *, overwrite: bool = False) -> pathlib.Path:
    """Writes a recording as a rosbag2: the folder ``bag`` with ``metadata.yaml`` and an MCAP file (profile ros2, CDR).

    Stamps are simulated times from 0, axes those of ``world``, units m, rad, s, N and Nm.

    /tf: tf2_msgs/TFMessage, the recording's frames.
    /joint_states: sensor_msgs/JointState, arm and wheels; ``effort`` is empty where the recording has none.
    /odom: nav_msgs/Odometry: the base's pose, and the constant twist, in the base's frame, that leads there from the
        last one. Covariances are 0, as for unknown ones.
    /grip_wrench, /hand_wrench: geometry_msgs/WrenchStamped, with physics: mean force and torque of robot and human on
        the object in the last planning step, the torque about the grip, in axes of ``world``.
    /path: nav_msgs/Path, the path of the executed option from where it was planned to B, on the floor; poses look to
        the next point.

    ``custom_data`` of the metadata has the recording's provenance and the scenario's text.

    recording: a Recording or its file, of a team with a robot. Returns the folder.

    Raises DatasetError: the folder exists or cannot be written, or the recording is that of a point. RecordingError:
    the recording cannot be read. ModuleNotFoundError: the extra is not installed.
    """
    rosbag2, typesys = needed("rosbags.rosbag2"), needed("rosbags.typesys")
    bag = pathlib.Path(bag)
    free(bag, "metadata.yaml", overwrite, "a rosbag2")
    source = recording if isinstance(recording, Recording) else read(recording)
    if "/tf" not in source.topics:
        raise DatasetError(
            f"{source!r}: has no `/tf`: its team is a point, without frames, joints and forces; "
            'record an episode with plant="kinematic" or plant="rapier"'
        )
    store = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
    topics = _topics(source, store.types)
    profile = _profile()
    with staged(bag, overwrite) as folder, written(bag):
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


def _profile() -> Any:
    """The default of publishers: reliable, the last 10."""
    rosbags = needed("rosbags.interfaces")
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


def _topics(recording: Recording, types: Any) -> dict[str, tuple[str, _Messages]]:
    """The topics of a bag with their types, times (ns) and messages."""
    frames = Columns(recording.table("/tf"))
    topics = {
        "/tf": ("tf2_msgs/msg/TFMessage", _transforms(frames, types)),
        "/joint_states": ("sensor_msgs/msg/JointState", _joints(Columns(recording.table("/joints")), types)),
        "/odom": ("nav_msgs/msg/Odometry", _odometry(frames, types)),
    }
    if "/interaction" in recording.topics:
        forces = Columns(recording.table("/interaction"))
        for partner in ("grip", "hand"):
            topics[f"/{partner}_wrench"] = ("geometry_msgs/msg/WrenchStamped", _wrenches(forces, partner, types))
    if "/scene/path" in recording.topics:
        topics["/path"] = ("nav_msgs/msg/Path", _paths(Columns(recording.table("/scene/path")), types))
    return topics


def _header(types: Any, time: int, frame: str) -> Any:
    stamp = types["builtin_interfaces/msg/Time"](sec=time // 1_000_000_000, nanosec=time % 1_000_000_000)
    return types["std_msgs/msg/Header"](stamp=stamp, frame_id=frame)


def _vector(types: Any, kind: str, values: Any) -> Any:
    return types[f"geometry_msgs/msg/{kind}"](**dict(zip("xyzw", (float(value) for value in values))))


def _frame(frames: Columns, frame: str) -> tuple[list[Any], Floats]:
    """The parents of a frame, and its positions and quaternions (x, y, z, w), (rows, 7)."""
    of = f"transforms[{frame}]."
    places = [f"{of}translation.{axis}" for axis in _AXES] + [f"{of}rotation.{axis}" for axis in "xyzw"]
    return frames.texts(f"{of}parent_frame_id"), frames.numbers(*places)


def _names_of_frames(frames: Columns) -> list[str]:
    return frames.items(r"transforms\[(.+)\]\.parent_frame_id")


def _transforms(frames: Columns, types: Any) -> _Messages:
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


def _joints(joints: Columns, types: Any) -> _Messages:
    names = joints.items(r"joints\[(.+)\]\.position")
    values = {key: joints.numbers(*(f"joints[{name}].{key}" for name in names)) for key in ("position", "velocity", "effort")}
    for row, time in enumerate(joints.times):
        given = {key: numbers[row] for key, numbers in values.items()}
        arrays = {key: np.empty(0) if np.isnan(numbers).all() else numbers for key, numbers in given.items()}
        yield time, types["sensor_msgs/msg/JointState"](header=_header(types, time, ""), name=names, **arrays)


def _odometry(frames: Columns, types: Any) -> _Messages:
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


def _wrenches(forces: Columns, partner: str, types: Any) -> _Messages:
    names = [f"{partner}_mean_force_{axis}_n" for axis in _AXES] + [f"{partner}_mean_torque_{axis}_nm" for axis in _AXES]
    values = forces.numbers(*names)
    for row, time in enumerate(forces.times):
        wrench = types["geometry_msgs/msg/Wrench"](
            force=_vector(types, "Vector3", values[row, :3]), torque=_vector(types, "Vector3", values[row, 3:])
        )
        yield time, types["geometry_msgs/msg/WrenchStamped"](header=_header(types, time, "world"), wrench=wrench)


def _paths(scene: Columns, types: Any) -> _Messages:
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
