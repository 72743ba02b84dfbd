"""LeRobotDataset v3 from recordings: https://huggingface.co/docs/lerobot/lerobot-dataset-v3."""

from __future__ import annotations

import json
import pathlib
import re
from collections import Counter
from collections.abc import Iterable
from typing import Any

import numpy as np

from cocarry._cocarry import __version__
from cocarry.datasets._files import DatasetError, Path, free, needed, staged, written
from cocarry.datasets._frames import Frames, Signal, Source, all_frames, described, sources

_DATA = "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"
_EPISODES = "meta/episodes/chunk-000/file-000.parquet"
_FILE_MB, _CHUNK_FILES = 100, 1000
_QUANTILES = (0.01, 0.1, 0.5, 0.9, 0.99)
_INDICES = {"timestamp": "float32", "frame_index": "int64", "episode_index": "int64", "index": "int64", "task_index": "int64"}
_COSTS = ("accumulated_objective_cost_m", "accumulated_subjective_cost", "accumulated_control_cost")


def to_lerobot(
    episodes: Iterable[Source],
    folder: Path,
    *,
    task: str | None = None,
    license: str = "mit",
    overwrite: bool = False,
) -> pathlib.Path:
    """Writes episodes as a LeRobotDataset (codebase version v3.0): state, action and metadata, without video.

    A frame is a planning step. What a policy knows is from the beginning of the step; what it did is in the step:

    observation.state: a point's position; a robot's base, as position and the part of its quaternion that turns about z,
        and its joints; with physics also the joints' rates, the object's place, and mean force and torque of the hand on
        the object in the last step (0 before the first).
    observation.environment_state: the observation of ``cocarry/Options-v0``: every option's quantities, phi(k), who leads;
        with a robot also the grasp's goal for the end of the step.
    action: a point's: the action of ``cocarry/Options-v0``, the option on which the robot leads, or the number of options
        where the human leads. A robot's: u, rim speeds and joint rates.
    decision: with a robot, what the action of a point is.
    next.reward: minus the objective cost of the step, J (m). next.done, next.success: at the last frame.

    Numbers are the recording's, in float64; ``timestamp`` is float32, as the format has it. (LeRobot's loader makes
    float32 of numbers.) Names and units are in ``meta/info.json`` and in the data set's card, ``README.md``. The table of
    episodes has ``scenario_text``, the whole scenario, ``scenario_world``, ``scenario_seed``, ``scenario_alpha``,
    ``scenario_gamma``, ``scenario_plant``, ``scenario_method`` (own(NAME) for an Episode with a custom policy), ``outcome``
    and the accumulated costs. Quantiles in ``stats.json`` are means of those of the episodes, weighted by their lengths, as
    LeRobot's own are.

    episodes: Recordings, their files, Scenarios or Episodes that have not begun, which run here. All have teams of one
        kind, with the same planning step, of which a whole number make a second.
    folder: of the data set. task: what the policies are told; default: to carry the object from A to B in the world.
    license: an identifier of the Hugging Face Hub, for the card.

    Returns the folder.

    Raises DatasetError with the episode, the value and what would be right. RecordingError: a recording cannot be read.
    ModuleNotFoundError: the extra is not installed.
    """
    needed("pyarrow")
    folder = pathlib.Path(folder)
    if not re.fullmatch(r"[a-z0-9][a-z0-9.+-]*", license):
        raise DatasetError(f"license = {license!r}; expected an identifier such as mit, apache-2.0 or cc-by-4.0")
    if task is not None and not task.strip():
        raise DatasetError("task: is empty; expected a sentence, as `carry the table to the kitchen`")
    given = sources(episodes)
    free(folder, "meta/info.json", overwrite, "a LeRobot data set")
    with staged(folder, overwrite) as made, written(folder):
        _Writer(made, task).write(given, license)
    return folder


class _Writer:
    """Writes one episode after the other; only their statistics stay in memory."""

    def __init__(self, root: pathlib.Path, task: str | None) -> None:
        self.arrow, self.parquet = needed("pyarrow"), needed("pyarrow.parquet")
        self.root, self.task = root, task
        self.tasks: dict[str, int] = {}
        self.rows: list[dict[str, Any]] = []
        self.first: Frames | None = None
        self.features: dict[str, dict[str, Any]] = {}
        self.frames, self.file, self.bytes = 0, 0, 0
        self.writer: Any = None

    def write(self, given: list[Source], license: str) -> None:
        for name in ("data/chunk-000", "meta/episodes/chunk-000"):
            (self.root / name).mkdir(parents=True)
        try:
            for index, frames in enumerate(all_frames(given)):
                self._add(index, frames)
        finally:
            if self.writer is not None:
                self.writer.close()
        self._write_metadata(license)

    def _add(self, index: int, frames: Frames) -> None:
        if self.first is None:
            self.first, self.features = frames, _features(frames)
        _check_alike(frames, self.first, _features(frames) == self.features)
        count = len(frames.times_s)
        task = self.task or f"Carry the object together with the human from A to B in {frames.scenario.world.name}."
        columns = _columns(frames)
        columns |= {
            "timestamp": (np.arange(count) * frames.step_s).astype(np.float32),
            "frame_index": np.arange(count),
            "episode_index": np.full(count, index),
            "index": self.frames + np.arange(count),
            "task_index": np.full(count, self.tasks.setdefault(task, len(self.tasks))),
        }
        chunk, file = self._append(columns)
        self.rows.append({
            "episode_index": index, "tasks": [task], "length": count,
            "data/chunk_index": chunk, "data/file_index": file,
            "dataset_from_index": self.frames, "dataset_to_index": self.frames + count,
            "meta/episodes/chunk_index": 0, "meta/episodes/file_index": 0,
            **described(frames), "outcome": frames.outcome["outcome"],
            **{key: frames.outcome.get(key) for key in _COSTS},
            **{f"stats/{key}/{name}": value for key, column in columns.items() for name, value in _stats(column).items()},
        })  # fmt: skip
        self.frames += count

    def _append(self, columns: dict[str, Any]) -> tuple[int, int]:
        """Appends a row group, to the next file where this one is full; returns chunk and file."""
        table = self.arrow.table({key: self._array(values) for key, values in columns.items()})
        if self.writer is not None and self.bytes + table.nbytes > _FILE_MB * 2**20:
            self.writer.close()
            self.writer, self.bytes, self.file = None, 0, self.file + 1
        chunk, file = divmod(self.file, _CHUNK_FILES)
        if self.writer is None:
            path = self.root / _DATA.format(chunk_index=chunk, file_index=file)
            path.parent.mkdir(parents=True, exist_ok=True)
            self.writer = self.parquet.ParquetWriter(path, table.schema, compression="snappy")
        self.writer.write_table(table)
        self.bytes += table.nbytes
        return chunk, file

    def _array(self, values: Any) -> Any:
        """A column: numbers, or lists of a fixed length."""
        if values.ndim == 1:
            return self.arrow.array(values)
        return self.arrow.FixedSizeListArray.from_arrays(self.arrow.array(values.reshape(-1)), values.shape[1])

    def _write_metadata(self, license: str) -> None:
        assert self.first is not None
        names = list(self.rows[0])
        table = {name: self.arrow.array([row[name] for row in self.rows], _type(self.arrow, name)) for name in names}
        self.parquet.write_table(self.arrow.table(table), self.root / _EPISODES, compression="snappy")
        self._write_tasks()
        indices: dict[str, dict[str, Any]] = {
            key: {"dtype": dtype, "shape": [1], "names": None} for key, dtype in _INDICES.items()
        }
        indices["timestamp"]["units"] = ["s"]
        robot = self.first.scenario.robot
        info: dict[str, Any] = {
            "codebase_version": "v3.0",
            "robot_type": "point" if robot is None else robot.name,
            "total_episodes": len(self.rows),
            "total_frames": self.frames,
            "total_tasks": len(self.tasks),
            "chunks_size": _CHUNK_FILES,
            "data_files_size_in_mb": _FILE_MB,
            "video_files_size_in_mb": 200,
            "fps": round(1 / self.first.step_s),
            "splits": {"train": f"0:{len(self.rows)}"},
            "data_path": _DATA,
            "video_path": None,
            "features": self.features | indices,
        }
        stats = {key: _pooled([_parts(row, key) for row in self.rows]) for key in info["features"]}
        for name, content in (("info", info), ("stats", stats)):
            (self.root / "meta" / f"{name}.json").write_text(json.dumps(content, indent=4) + "\n", encoding="utf-8")
        (self.root / "README.md").write_text(_card(info, self.rows, self.first, license), encoding="utf-8")

    def _write_tasks(self) -> None:
        """The tasks by their texts, which are the index of the table for pandas."""
        table = self.arrow.table({"task_index": list(self.tasks.values()), "task": list(self.tasks)})
        column = {"metadata": None, "pandas_type": "int64", "numpy_type": "int64"}
        text = {"metadata": None, "pandas_type": "unicode", "numpy_type": "object"}
        about = {
            "index_columns": ["task"],
            "column_indexes": [{"name": None, "field_name": None, **text}],
            "columns": [{"name": "task_index", "field_name": "task_index", **column}, {"name": "task", "field_name": "task", **text}],
            "creator": {"library": "pyarrow", "version": self.arrow.__version__},
            "pandas_version": "2.2.0",
        }
        table = table.replace_schema_metadata({"pandas": json.dumps(about)})
        self.parquet.write_table(table, self.root / "meta/tasks.parquet")


def _signals(frames: Frames) -> dict[str, Signal]:
    found = {"observation.state": frames.state, "observation.environment_state": frames.options}
    return found | ({"action": frames.motion} if frames.motion is not None else {})


def _columns(frames: Frames) -> dict[str, Any]:
    count = len(frames.times_s)
    last = np.arange(count) == count - 1
    columns: dict[str, Any] = {key: signal.values[:count] for key, signal in _signals(frames).items()}
    columns["action" if frames.motion is None else "decision"] = frames.decision
    columns["next.reward"] = -frames.cost_m
    columns["next.done"] = last
    columns["next.success"] = last & (frames.outcome["outcome"] == "arrived")
    return columns


def _features(frames: Frames) -> dict[str, dict[str, Any]]:
    """The features of a frame, without those that every data set has; ``units`` are next to the names."""
    features = {
        key: {"dtype": "float64", "shape": [len(signal.names)], "names": signal.names, "units": signal.units}
        for key, signal in _signals(frames).items()
    }

    def single(dtype: str, name: str, unit: str) -> dict[str, Any]:
        return {"dtype": dtype, "shape": [1], "names": [name], "units": [unit]}

    features["action" if frames.motion is None else "decision"] = single("int64", "option_or_follow", "1")
    features["next.reward"] = single("float64", "minus_objective_cost_m", "m")
    features["next.done"] = single("bool", "done", "1")
    features["next.success"] = single("bool", "arrived", "1")
    return features


def _check_alike(frames: Frames, first: Frames, has_same_features: bool) -> None:
    rate = 1 / frames.step_s
    if round(rate) < 1 or abs(rate - round(rate)) > 1e-9:
        raise DatasetError(
            f"{frames.name}: planning_step_s = {frames.step_s:g}; LeRobot needs a whole number of frames per second, "
            "as with 0.1, 0.2, 0.25 or 0.5"
        )
    if frames.step_s != first.step_s:
        raise DatasetError(f"{frames.name}: planning_step_s = {frames.step_s:g}; that of {first.name} is {first.step_s:g}")
    of, other = (f.scenario.robot.name if f.scenario.robot else "point" for f in (frames, first))
    if (frames.scenario.plant, of) != (first.scenario.plant, other) or not has_same_features:
        raise DatasetError(
            f"{frames.name}: its team is {of} on the plant {frames.scenario.plant}; that of {first.name} is {other} on "
            f"{first.scenario.plant}; write a data set for each"
        )


def _type(arrow: Any, name: str) -> Any:
    """The type of a column of the table of episodes; None where the values say it."""
    if name == "scenario_seed":
        return arrow.uint64()
    return arrow.float64() if name in _COSTS else None


def _stats(values: Any) -> dict[str, list[Any]]:
    """Statistics over the frames, for every number of a feature."""
    numbers = np.asarray(values, dtype=np.float64).reshape(len(values), -1)
    found = {"min": numbers.min(axis=0), "max": numbers.max(axis=0), "mean": numbers.mean(axis=0), "std": numbers.std(axis=0)}
    found |= {f"q{round(100 * q):02d}": np.quantile(numbers, q, axis=0) for q in _QUANTILES}
    return {"count": [len(numbers)], **{name: value.tolist() for name, value in found.items()}}


def _parts(row: dict[str, Any], key: str) -> dict[str, Any]:
    start = f"stats/{key}/"
    return {name.removeprefix(start): np.array(value) for name, value in row.items() if name.startswith(start)}


def _pooled(episodes: list[dict[str, Any]]) -> dict[str, list[Any]]:
    """Statistics of all episodes from those of each."""
    counts = np.concatenate([episode["count"] for episode in episodes])
    shares = (counts / counts.sum())[:, np.newaxis]
    stacked = {name: np.stack([episode[name] for episode in episodes]) for name in episodes[0] if name != "count"}
    mean = (shares * stacked["mean"]).sum(axis=0)
    variance = (shares * (stacked["std"] ** 2 + (stacked["mean"] - mean) ** 2)).sum(axis=0)
    found = {"min": stacked["min"].min(axis=0), "max": stacked["max"].max(axis=0), "mean": mean, "std": np.sqrt(variance)}
    found |= {name: (shares * stacked[name]).sum(axis=0) for name in stacked if name.startswith("q")}
    return {"count": [int(counts.sum())], **{name: value.tolist() for name, value in found.items()}}


def _card(info: dict[str, Any], rows: list[dict[str, Any]], first: Frames, license: str) -> str:
    """The data set's card."""
    outcomes = Counter(row["outcome"] for row in rows)
    features = []
    for key, feature in info["features"].items():
        names, units = feature["names"] or [key], feature.get("units", ["1"])
        for index, (name, unit) in enumerate(zip(names, units)):
            features.append(f"| `{key}` | {index} | `{name}` | {unit} | {feature['dtype']} |")
    newline = "\n"
    return f"""---
license: {license}
task_categories:
- robotics
tags:
- LeRobot
- cocarry
- simulation
- human-robot-collaboration
configs:
- config_name: default
  data_files: data/*/*.parquet
---

# A human and a robot carry an object together

Simulated with cocarry {__version__} on the plant `{first.scenario.plant}`, team: {info["robot_type"]}. {len(rows)} episode{"" if len(rows) == 1 else "s"},
{info["total_frames"]} frames at {info["fps"]} per second of simulated time (a frame is a planning step of {first.step_s:g} s).
Outcomes: {", ".join(f"{name} {count}" for name, count in sorted(outcomes.items()))}.
Worlds: {", ".join(sorted({row["scenario_world"] for row in rows}))}. Methods: {", ".join(sorted({row["scenario_method"] for row in rows}))}.

- **License:** {license}
- **Format:** LeRobotDataset {info["codebase_version"]}, without video.

## Features

Observations are from the beginning of a planning step; actions are those in that step. Axes are those of the world, z up.
Rotations are parts of the quaternion about z. `[i]` is the i-th option. The action `option_or_follow` (feature `{"action" if first.motion is None else "decision"}`)
is the option on which the robot leads, or the number of options where the human leads. `next.reward` is minus the objective
cost J of the step.

| feature | index | name | unit | type |
| --- | --- | --- | --- | --- |
{newline.join(features)}

## Episodes

`meta/episodes` has for every episode `scenario_text` (the whole scenario: `cocarry.Scenario.parse` runs it again),
`scenario_world`, `scenario_seed`, `scenario_alpha` and `scenario_gamma` (the human's perception of distance and risk),
`scenario_plant`, `scenario_method`, `outcome`, and the accumulated objective (m), subjective and control cost.
"""
