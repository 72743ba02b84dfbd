"""The frames of a recording for learners: what was known at the beginning of every planning step, and what was done."""

from __future__ import annotations

import os
import pathlib
import tempfile
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np

from cocarry._cocarry import Episode, Recording, Scenario, quantities, read
from cocarry.datasets._files import Columns, DatasetError, Floats, Path

Source: TypeAlias = Recording | Path | Scenario | Episode

_OPTION = {key: unit or "1" for key, (unit, _) in quantities("option").items() if key != "name"}
_OPTION["expected_subjective_cost"] = "cost units"


@dataclass(frozen=True)
class Signal:
    """Numbers of every frame side by side, (frames, names)."""

    names: list[str]
    units: list[str]
    values: Floats

    def joined(self, other: Signal) -> Signal:
        return Signal(self.names + other.names, self.units + other.units, np.hstack([self.values, other.values]))


@dataclass(frozen=True)
class Frames:
    """An episode of n planning steps."""

    name: str
    """In errors."""
    scenario: Scenario
    world: str
    """Its name among worlds or its file's."""
    method: str
    """The scenario's, or own(NAME)."""
    outcome: dict[str, Any]
    step_s: float
    times_s: Floats
    """(n,): the beginnings of the planning steps, simulated, s."""
    state: Signal
    """(n + 1, .) with a robot, (n, .) for a point: where the team is at the beginning of the steps and at the end."""
    options: Signal
    """(n, .): what eq. (6) is a function of, for as many options as asked for; with a robot also the grasp's goal."""
    motion: Signal | None
    """(n, .): u, with a robot."""
    decision: Any
    """(n,), int64: the option on which the robot leads, or the number of options where the human leads."""
    cost_m: Floats
    """(n,): J of the option executed."""
    option_count: int
    """Options that the signal has."""

    @property
    def observed(self) -> Signal:
        """(n + 1, .): state and options, those at the end as in the last step; of a point the options alone."""
        options = Signal(self.options.names, self.options.units, np.vstack([self.options.values, self.options.values[-1:]]))
        return options if self.motion is None else self.state.joined(options)


def sources(episodes: Iterable[Source]) -> list[Source]:
    """A list of the episodes, at least one."""
    if isinstance(episodes, (Recording, Scenario, Episode, str, os.PathLike)):
        raise DatasetError("episodes: expected a list of recordings, scenarios or episodes, not a single one")
    given = list(episodes)
    if not given:
        raise DatasetError("episodes: there are none; expected at least one recording, scenario or episode")
    for index, source in enumerate(given):
        if not isinstance(source, (Recording, Scenario, Episode, str, os.PathLike)):
            kind = type(source).__name__
            raise DatasetError(f"episode {index}: {kind}; expected a Recording, its file, a Scenario or an Episode")
    return given


def all_frames(given: list[Source]) -> Iterator[Frames]:
    """The frames of one episode after the other, each with as many options as that with the most has."""
    options = max(len(_scenario(source).options) for source in given)
    for index, source in enumerate(given):
        if isinstance(source, (Scenario, Episode)):
            with tempfile.TemporaryDirectory() as folder:
                file = pathlib.Path(folder) / "episode.mcap"
                policy = None if isinstance(source, Scenario) else source.policy
                with (Episode(source) if isinstance(source, Scenario) else source).record(file) as episode:
                    episode.run()
                frames = frames_of(f"episode {index}", read(file), options)
                yield frames if policy is None else replace(frames, method=f"own({_name(policy)})")
        elif isinstance(source, Recording):
            yield frames_of(f"episode {index}", source, options)
        else:
            yield frames_of(os.fspath(source), read(source), options)


def _name(partner: Any) -> str:
    return str(getattr(partner, "__name__", type(partner).__name__))


def _scenario(source: Source) -> Scenario:
    if isinstance(source, Scenario):
        return source
    return (source if isinstance(source, (Recording, Episode)) else read(source)).scenario


def frames_of(name: str, recording: Recording, options: int) -> Frames:
    """The frames of a complete recording; ``options`` is the number of options in its signal."""
    outcome = recording.outcome
    if outcome is None:
        raise DatasetError(f"{name}: the recording is incomplete (no `/outcome`); record the episode to its end")
    scenario = recording.scenario
    coordination = Columns(recording.table("/coordination"))
    modes, times = coordination.texts("mode"), coordination.numbers("time_s")[:, 0]
    executed = coordination.numbers("executed_index")[:, 0].astype(np.int64)
    human_leads = np.array([mode == "human-led" for mode in modes])
    if scenario.robot is None:
        state, motion = Signal(["x_m", "y_m"], ["m", "m"], coordination.numbers("x_m", "y_m")), None
    else:
        state, motion = _state(name, recording, scenario.robot.joints, coordination.times), _motion(recording)
    cost = Columns(recording.table("/cost")).numbers("objective_cost_m")[:, 0]
    known = _options(Columns(recording.table("/options")), scenario.options, options, executed)
    known = known.joined(_common(coordination, human_leads))
    if motion is not None:
        goal = ["grasp_goal_x_m", "grasp_goal_y_m", "grasp_goal_yaw_deg"]
        known = known.joined(Signal(goal, ["m", "m", "deg"], Columns(recording.table("/control")).numbers(*goal)))
    found = Frames(
        name=name, scenario=scenario, world=recording.provenance["world"], method=recording.provenance["method"],
        outcome=outcome, times_s=times, state=state, options=known,
        step_s=float(scenario.settings["planning_step_s"]), motion=motion,
        decision=np.where(human_leads, options, executed), cost_m=cost, option_count=options,
    )  # fmt: skip
    _check(found)
    return found


def _state(name: str, recording: Recording, joints: list[str], begins: list[int]) -> Signal:
    """Base, joints and, with physics, their rates, object and the wrench of the hand; from 0 to the end."""
    frames, arm = Columns(recording.table("/tf")), Columns(recording.table("/joints"))
    if frames.times[:-1] != begins or arm.times != frames.times:
        raise DatasetError(f"{name}: `/tf`, `/joints` and `/coordination` have different times; the recording has gaps")
    lengths = _prismatic(recording)
    base = next(name for name in frames.items(r"transforms\[(.+)\]\.parent_frame_id") if name.startswith("robot/"))
    parts = [_planar(frames, base, "base")]
    units = ["m" if joint in lengths else "rad" for joint in joints]
    names = [f"joint[{joint}]_{unit}" for joint, unit in zip(joints, units)]
    parts.append(Signal(names, units, arm.numbers(*(f"joints[{joint}].position" for joint in joints))))
    if "/interaction" in recording.topics:
        names = [f"joint[{joint}]_{unit}_per_s" for joint, unit in zip(joints, units)]
        rates = arm.numbers(*(f"joints[{joint}].velocity" for joint in joints))
        parts.append(Signal(names, [f"{unit}/s" for unit in units], rates))
        parts.append(_planar(frames, "object", "object"))
        names = [f"hand_mean_{kind}" for kind in ("force_x_n", "force_y_n", "torque_z_nm")]
        wrench = Columns(recording.table("/interaction")).numbers(*names)
        parts.append(Signal(names, ["N", "N", "Nm"], np.vstack([np.zeros(3), wrench])))
    whole = parts[0]
    for part in parts[1:]:
        whole = whole.joined(part)
    return whole


def _planar(frames: Columns, frame: str, name: str) -> Signal:
    """Where a frame is on the floor; its turn about z as a part of its quaternion, without a jump at half a turn."""
    parts = ["translation.x", "translation.y", "rotation.z", "rotation.w"]
    names = [f"{name}_{part}" for part in ("x_m", "y_m", "rotation_z", "rotation_w")]
    return Signal(names, ["m", "m", "1", "1"], frames.numbers(*(f"transforms[{frame}].{part}" for part in parts)))


def _prismatic(recording: Recording) -> set[str]:
    """The joints that move along a line."""
    columns = Columns(recording.table("/control"))
    return set(columns.items(r"joints\[(.+)\]\.rate_m_per_s"))


def _motion(recording: Recording) -> Signal:
    """u: the base's inputs and joint rates."""
    control = Columns(recording.table("/control"))
    assert recording.scenario.robot is not None
    base = {
        "omnidirectional": {"base_ahead_m_per_s": "m/s", "base_left_m_per_s": "m/s", "base_turn_rad_per_s": "rad/s"},
    }.get(recording.scenario.robot.drive, {"left_rim_m_per_s": "m/s", "right_rim_m_per_s": "m/s"})
    lengths = _prismatic(recording)
    rates = [f"joints[{j}].rate_{'m' if j in lengths else 'rad'}_per_s" for j in recording.scenario.robot.joints]
    units = [*base.values(), *("m/s" if rate.endswith("rate_m_per_s") else "rad/s" for rate in rates)]
    names = [*base, *(rate.replace("joints[", "joint[").replace("].rate", "]") for rate in rates)]
    of_base = Columns(recording.table("/base")) if "base_turn_rad_per_s" in base else control
    return Signal(names, units, np.hstack([of_base.numbers(*base), control.numbers(*rates)]))


def _options(table: Columns, names: list[str], count: int, executed: Any) -> Signal:
    """Of every option what the paper's robot knows, as in ``cocarry/Options-v0``; 0 where a value is missing."""
    blocks = np.zeros((len(executed), count, len(_OPTION) + 1))
    for index, name in enumerate(names):
        blocks[:, index, :-1] = np.nan_to_num(table.numbers(*(f"options[{name}].{key}" for key in _OPTION)))
        blocks[1:, index, -1] = executed[:-1] == index  # of the last step
    keys = [*_OPTION, "executed"]
    labels = [f"{key}[{index}]" for index in range(count) for key in keys]
    units = [*_OPTION.values(), "1"] * count
    return Signal(labels, units, blocks.reshape(len(executed), -1))


def _common(coordination: Columns, human_leads: Any) -> Signal:
    phi, threshold = coordination.numbers("stubbornness", "stubbornness_threshold").T
    led = np.concatenate([[False], human_leads[:-1]])
    values = np.column_stack([phi, led, phi > threshold]).astype(np.float64)
    return Signal(["stubbornness", "human_leads", "human_takes_over"], ["1", "1", "1"], values)


def described(frames: Frames) -> dict[str, Any]:
    """What tells the scenario of an episode."""
    scenario = frames.scenario
    return {
        "scenario_world": frames.world,
        "scenario_seed": scenario.seed,
        "scenario_alpha": scenario.alpha,
        "scenario_gamma": scenario.gamma,
        "scenario_plant": scenario.plant,
        "scenario_method": frames.method,
        "scenario_text": scenario.text,
    }


def _check(frames: Frames) -> None:
    count = len(frames.times_s)
    signals = {"state": frames.state, "options": frames.options, **({"u": frames.motion} if frames.motion else {})}
    for key, signal in signals.items():
        if len(signal.values) not in (count, count + 1):
            raise DatasetError(f"{frames.name}: {len(signal.values)} rows of {key} for {count} steps; the recording has gaps")
        bad = np.argwhere(~np.isfinite(signal.values))
        if len(bad):
            row, column = bad[0]
            value = signal.values[row, column]
            raise DatasetError(f"{frames.name}, frame {row}: {signal.names[column]} = {value}; a data set needs finite numbers")
