"""Data sets of Minari, from episodes of environments and from recordings."""

from __future__ import annotations

import os
import pathlib
import warnings
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from cocarry._cocarry import __version__
from cocarry.datasets._files import DatasetError, free, needed, staged, written
from cocarry.datasets._frames import Frames, Source, all_frames, described, sources


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
    minari = _minari(dataset_id)
    if episodes < 1:
        raise DatasetError(f"episodes = {episodes}; it must be at least 1")
    if seed < 0:
        raise DatasetError(f"seed = {seed}; it must be at least 0")
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

    home = _Home(minari, dataset_id, overwrite)
    buffers, drawn = [], []
    for index in range(episodes):
        fields, info = _episode(environment, policy, seed + index, f"episode {index}")
        buffers.append(needed("minari.data_collector").EpisodeBuffer(id=index, seed=seed + index, **fields))
        drawn.append({key: value for key, value in info.items() if isinstance(value, (bool, int, float, str))})
    return home.write(buffers, drawn, {"env": environment, **about})


def recorded_to_minari(episodes: Iterable[Source], dataset_id: str, *, overwrite: bool = False, **about: Any) -> Any:
    """Writes recordings, or episodes that run here, as a Minari data set, with Minari itself.

    A step is a planning step. A team that is a point has the observations and actions of ``cocarry/Options-v0`` (the
    option on which the robot leads, or their number where the human leads). A robot's observations are the numbers of
    ``observation.state`` and then of ``observation.environment_state`` of ``to_lerobot``, its actions are u: rim speeds (m/s)
    and joint rates (rad/s, prismatic m/s). The numbers are the recording's, in float64; at the end of an episode the options
    are those of its last step, and so is all of a point's observation.
    Rewards are minus the objective cost of the step, J (m). An episode is truncated when its steps ran out, else
    terminated. Per episode: ``scenario_text`` (the whole scenario), ``scenario_world``, ``scenario_seed``,
    ``scenario_alpha``, ``scenario_gamma``, ``scenario_plant``, ``scenario_method`` (own(NAME) for an Episode with a custom
    policy) and ``outcome``.

    episodes: Recordings, their files, Scenarios or Episodes that have not begun; teams of one kind.
    dataset_id: ``namespace/name-v0``. about: as of ``to_minari``.

    Returns the ``minari.MinariDataset``. It has no environment to recover; the names of the numbers of an observation are
    ``names`` of the features of ``to_lerobot``.

    Raises DatasetError with the episode, the value and what would be right. RecordingError: a recording cannot be read.
    ModuleNotFoundError: the extra is not installed.
    """
    minari, spaces = _minari(dataset_id), needed("gymnasium.spaces")
    home = _Home(minari, dataset_id, overwrite)
    given = sources(episodes)
    buffers, abouts = [], []
    first: Frames | None = None
    for index, frames in enumerate(all_frames(given)):
        first = first or frames
        of, other = ((f.scenario.plant, f.observed.names) for f in (frames, first))
        if of != other:
            message = f"its team is another than that of {first.name}, on {of[0]} and {other[0]}; write a data set for each"
            raise DatasetError(f"{frames.name}: {message}")
        buffers.append(needed("minari.data_collector").EpisodeBuffer(id=index, **_steps(frames)))
        abouts.append({**described(frames), "outcome": frames.outcome["outcome"]})
    assert first is not None
    if first.scenario.robot is None:
        actions = spaces.Discrete(first.option_count + 1)
    else:
        limits = first.scenario.robot.input_limits
        actions = spaces.Box(-limits, limits, dtype=np.float64)
    observations = spaces.Box(-np.inf, np.inf, (len(first.observed.names),), dtype=np.float64)
    about = {"requirements": [f"cocarry=={__version__}"], "algorithm_name": first.method, **about}
    return home.write(buffers, abouts, {"observation_space": observations, "action_space": actions, **about})


def _steps(frames: Frames) -> dict[str, Any]:
    """The fields of a buffer of Minari."""
    count = len(frames.times_s)
    ends = np.arange(count) == count - 1
    is_truncated = frames.outcome["outcome"] == "out-of-time"
    return {
        "observations": list(frames.observed.values),
        "actions": list(frames.decision if frames.motion is None else frames.motion.values),
        "rewards": (-frames.cost_m).tolist(),
        "terminations": (ends & (not is_truncated)).tolist(),
        "truncations": (ends & is_truncated).tolist(),
    }


def _minari(dataset_id: str) -> Any:
    """The module, and what its format "arrow" needs, if the identifier is one."""
    minari, names = needed("minari"), needed("minari.dataset.minari_dataset")
    for module in ("pyarrow", "PIL"):
        needed(module)
    try:
        names.parse_dataset_id(dataset_id)
    except ValueError as error:
        raise DatasetError(f"dataset_id = {dataset_id!r}: {error}") from error
    except TypeError:  # Minari takes names without a version apart as None
        message = "has no version; expected a name such as cocarry/carried-v0"
        raise DatasetError(f"dataset_id = {dataset_id!r}: {message}") from None
    return minari


class _Home:
    """Where a data set is going to lie."""

    def __init__(self, minari: Any, dataset_id: str, overwrite: bool) -> None:
        self.minari, self.dataset_id, self.overwrite = minari, dataset_id, overwrite
        self.final = pathlib.Path(minari.storage.get_dataset_path(dataset_id))
        self.root = pathlib.Path(minari.storage.get_dataset_path(""))
        free(self.final, "data", overwrite, "a Minari data set")

    def write(self, buffers: list[Any], drawn: list[dict[str, Any]], about: dict[str, Any]) -> Any:
        minari, name = self.minari, self.dataset_id
        with staged(self.final, self.overwrite, self.root) as folder, _datasets_in(folder.parent / "root"), written(self.final):
            with warnings.catch_warnings():
                if "env" not in about:  # there is none
                    warnings.filterwarnings("ignore", r"(`eval_env` is set to None|env_spec is None)", UserWarning)
                made = minari.create_dataset_from_buffers(name, buffers, data_format="arrow", **about)
            made.storage.update_episode_metadata(drawn)
            os.replace(minari.storage.get_dataset_path(name), folder)
        namespaces = needed("minari.namespace")
        namespace, _, _ = needed("minari.dataset.minari_dataset").parse_dataset_id(name)
        if namespace is not None and namespace not in namespaces.list_local_namespaces():
            namespaces.create_namespace(namespace)
        return minari.load_dataset(name)


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
