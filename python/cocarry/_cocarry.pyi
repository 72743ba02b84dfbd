"""The native module: documentation and types of its classes and functions."""

import os
import pathlib
from collections.abc import Callable, Sequence
from typing import Any, Literal, TypeAlias, final

import numpy as np
from numpy.typing import NDArray
from typing_extensions import CapsuleType, Self, Unpack, disjoint_base

from cocarry._settings import Settings
from cocarry._world import Obstacle

_Path: TypeAlias = str | os.PathLike[str]
_Floats: TypeAlias = NDArray[np.float64]

__version__: str

class Error(ValueError):
    """An input or a call that cocarry refuses; the base of all others."""

class WorldError(Error):
    """A world that is not valid."""

class RobotError(Error):
    """A robot that is not valid."""

class ScenarioError(Error):
    """A scenario or a setting that is not valid."""

class DecisionError(Error):
    """A decision of a custom policy or human that is not valid."""

class ActionError(Error):
    """An action of an environment that is not valid."""

class SnapshotError(Error):
    """A snapshot that cannot be resumed."""

class RecordingError(Error):
    """A recording that cannot be read, written or drawn."""

class StudyError(Error):
    """A study that is not valid."""

class ClosedError(Error):
    """An object that is closed, in use, or of another process."""

class UnknownKeyError(Error, KeyError):
    """A column or a quantity that there is not; a KeyError, too."""

@final
class World:
    """A world: obstacles, openings, start and target. Shows itself as its map in a notebook.

    Reads a world file (TOML), or takes a built-in world: environment-1 to environment-4, or free-form.

    Raises WorldError with the file, the line, the item and the numbers."""

    def __new__(cls, world: _Path | World | None = None) -> Self:
        ...
    @staticmethod
    def parse(text: str, name: str = "world") -> World:
        """Reads the text of a world file; errors call it ``name``."""
    @staticmethod
    def from_map(
        map: _Path,
        start: tuple[float, float],
        target: tuple[float, float],
        *,
        robot_width_m: float | None = None,
        tolerance_m: float | None = None,
    ) -> World:
        """Reads a map: an occupancy grid (the YAML of ROS's map_server, with a PGM or PNG image) or a floor
        plan (GeoJSON, SVG). A and B are given in metres. ``text`` is the world with the map's outlines.

        Raises WorldError with the file and the value."""
    @property
    def name(self) -> str:
        """Title."""
    @property
    def text(self) -> str:
        """Text of the file."""
    @property
    def start(self) -> _Floats:
        """A, (2,), m."""
    @property
    def target(self) -> _Floats:
        """B, (2,), m."""
    @property
    def bounds(self) -> _Floats:
        """The corners of the smallest rectangle around everything, (2, 2), m."""
    @property
    def obstacles(self) -> list[Obstacle]:
        """The obstacles, in the order of the file."""
    def options(self, risk_weight_m: float = ...) -> list[str]:
        """The names of its options: the openings in the order in which they are passed."""
    def _repr_svg_(self) -> str: ...
    def __reduce__(self) -> Any: ...

@final
class Robot:
    """A mobile manipulator: a wheeled base with an arm.

    Reads a robot file (TOML) with its URDF, or takes a built-in robot: carrier (the default), omni-carrier, porter or
    shuttle. A xacro is refused, unless ``xacro`` is set: then the program ``xacro`` expands it, which runs code that is
    in the file. Raises RobotError."""

    def __new__(cls, file: _Path | None = None, *, xacro: bool = False) -> Self:
        ...
    @property
    def name(self) -> str:
        """Name."""
    @property
    def joints(self) -> list[str]:
        """The names of the joints of its arm, from the base on."""
    @property
    def drive(self) -> str:
        """How the base moves: "differential", "skid-steer" or "omnidirectional"."""
    @property
    def postures(self) -> list[str]:
        """The names of its starting postures."""
    @property
    def input_limits(self) -> _Floats:
        """The largest |u|, (base + joints,): rim speeds (m/s), or of an omnidirectional base speed ahead and to the left
        (m/s) and turning rate (rad/s); then joint rates (rad/s, prismatic m/s)."""
    @property
    def joint_limits(self) -> _Floats:
        """The limits of the joints, (joints, 2), rad or m."""
    def grasp(self, configuration: Sequence[float] | _Floats) -> _Floats:
        """world_from_grasp at a configuration, (4, 4).

        configuration: as ``RobotView.configuration``, (3 + joints,): base x, y (m) and yaw (rad), then the joints (rad,
            prismatic m)."""
    def jacobian(self, configuration: Sequence[float] | _Floats) -> _Floats:
        """The Jacobian of the grasp at a configuration, (6, base + joints): the velocity of the grasp is ``jacobian @ u``,
        linear (m/s), then angular (rad/s), in world axes, with the inputs u in the order and units of
        ``input_limits``.

        configuration: as that of ``grasp``."""
    def __copy__(self) -> Robot: ...
    def __deepcopy__(self, _memo: Any = None) -> Robot: ...

@final
class Scenario:
    """The complete definition of an episode: the same scenario gives the same episode, bit for bit.
    Immutable.

    A scenario with the defaults of ``cocarry run``.

    world: a world file, a built-in world (default environment-4) or a World.
    plant: what the controller moves: the planning level alone, exact kinematics, or bodies with dynamics.
    seed: of the human, of the human's preference changes, and of the gait.
    alpha, gamma: the human's perception of distance and risk; drawn from the belief if not given.
    changes: (step, alpha, gamma): preference changes. preference_changes: their number, drawn from the
        seed.
    belief_alpha, belief_gamma: the robot's belief: uniform(LOWER,UPPER) or normal(MEAN,STD,LOWER,UPPER).
    belief_samples: the belief as samples, (n, 2) alpha and gamma, or (n, 3) with weights.
    robot: a robot file, a built-in robot or a Robot. settings: see cocarry.settings().

    Raises ScenarioError with the key, the value and the values allowed; WorldError; RobotError."""

    def __new__(
        cls,
        world: _Path | World | None = None,
        *,
        plant: Literal["point", "kinematic", "rapier"] = "rapier",
        seed: int = 0,
        alpha: float | None = None,
        gamma: float | None = None,
        changes: Sequence[tuple[int, float, float]] | None = None,
        preference_changes: int | str | None = None,
        belief_alpha: str = "uniform(0.55,0.95)",
        belief_gamma: str = "uniform(0.5,1.1)",
        belief_samples: Any = None,
        robot: _Path | Robot | None = None,
        **settings: Unpack[Settings],
    ) -> Self:
        ...
    @staticmethod
    def parse(text: str) -> Scenario:
        """Reads a scenario's text (TOML)."""
    @property
    def text(self) -> str:
        """The scenario as text (TOML), exact to the last bit."""
    def replace(
        self,
        *,
        seed: int | None = None,
        alpha: float | None = None,
        gamma: float | None = None,
        **settings: Unpack[Settings],
    ) -> Scenario:
        """The same scenario with other values. A new seed does not draw another human."""
    @property
    def world(self) -> World:
        """The world."""
    @property
    def robot(self) -> Robot | None:
        """The robot; None on the point plant."""
    @property
    def plant(self) -> str:
        """The plant."""
    @property
    def seed(self) -> int:
        """The seed."""
    @property
    def alpha(self) -> float:
        """The human's alpha at the start."""
    @property
    def gamma(self) -> float:
        """The human's gamma at the start."""
    @property
    def changes(self) -> list[tuple[int, float, float]]:
        """The preference changes: step, alpha, gamma."""
    @property
    def options(self) -> list[str]:
        """The names of the world's options."""
    @property
    def settings(self) -> dict[str, Any]:
        """The settings that the scenario has, by their keys."""
    def __eq__(self, other: object, /) -> bool: ...
    def __copy__(self) -> Scenario: ...
    def __deepcopy__(self, _memo: Any = None) -> Scenario: ...
    def __reduce__(self) -> Any: ...

@final
class Episode:
    """A running episode. Iterating takes steps and gives their ticks. Shows itself as the 3-D player in a
    notebook.

    An episode pickles and copies through snapshots, without its recording; a copy continues with the same
    bits.
    One thread at a time uses it; others get ClosedError at once.

    The episode before its first step.

    policy: a custom policy of the robot: a callable or an object with ``decide``, of a RobotView (see
        cocarry.Policy), or a class of such objects. Its answer: an option to lead on, None to follow,
        or a Decision.
    human: a custom human: the same, of a HumanView (see cocarry.Human). Its answer: an option, or a
        HumanDecision.

    Raises ScenarioError: a part of the scenario is not valid. Exceptions of custom partners are raised by
    the step."""

    def __new__(cls, scenario: Scenario, *, policy: Any = None, human: Any = None) -> Self:
        ...
    @staticmethod
    def resume(snapshot: bytes | _Path, *, policy: Any = None, human: Any = None) -> Episode:
        """The episode of a snapshot, its bytes or a file; it continues with the same bits. Raises
        SnapshotError."""
    def step(self) -> str | None:
        """Takes one planning step; returns the outcome once the episode has ended, else None."""
    def run(self, steps: int | None = None) -> dict[str, Any]:
        """Runs to the end, or so many steps, without Python's lock; returns the summary. Ctrl-C stops it."""
    def ticks(self, steps: int | None = None) -> Table:
        """Runs on as ``run`` does; returns a row for every tick. Columns of options and joints are
        ``key[name]``."""
    @property
    def tick(self) -> dict[str, Any]:
        """The quantities of the last step, as ``quantities("tick")`` has them; missing values are None."""
    @property
    def summary(self) -> dict[str, Any]:
        """The figures of the episode so far, as ``quantities("episode")`` has them; missing values are None."""
    @property
    def learned(self) -> dict[str, Any] | None:
        """The belief over this human as of now, as ``/learned`` of a recording has it: means, variances,
        covariance and 95 % intervals of alpha, gamma and eta, information (nats), densities. None without
        ``belief_update="learn"``."""
    def __getitem__(self, key: str, /) -> Any:
        """Return self[key]."""
    def __iter__(self) -> Episode: ...
    def __next__(self) -> dict[str, Any]: ...
    @property
    def scenario(self) -> Scenario:
        """The scenario."""
    @property
    def policy(self) -> Any:
        """The custom policy; None with the scenario's."""
    @property
    def human(self) -> Any:
        """The custom human; None with the scenario's."""
    @property
    def steps(self) -> int:
        """Steps taken."""
    @property
    def outcome(self) -> str | None:
        """How the episode ended; None while it runs."""
    @property
    def position(self) -> _Floats:
        """Position of the team, (2,), m."""
    def snapshot(self) -> bytes:
        """The state as the bytes of a snapshot file."""
    def record(self, file: _Path, *, overwrite: bool = False) -> Episode:
        """Records the steps into an MCAP file, from before the first step until the end or ``close``; returns
        itself.

        Raises RecordingError: the file exists, cannot be written or has another extension than ``.mcap``, or the
        episode has begun."""
    def recording(self) -> bytes:
        """The recording of the episode so far (MCAP). Runs it again from its start, with copies of custom
        partners."""
    def to_html(self, title: str = "episode") -> str:
        """The 3-D player of the episode so far, as one page. Runs the episode again, as ``recording`` does."""
    def _repr_html_(self) -> str | None: ...
    def close(self) -> None:
        """Ends the episode and finishes its recording."""
    def __enter__(self) -> Episode: ...
    def __exit__(self, *_error: object) -> None: ...
    def __copy__(self) -> Episode: ...
    def __deepcopy__(self, _memo: Any = None) -> Episode: ...
    def __reduce__(self) -> Any: ...
    @staticmethod
    def _rebuild(snapshot: bytes, policy: Any, human: Any, first_policy: Any, first_human: Any) -> Episode: ...

@disjoint_base
class View:
    """What both a custom policy and a custom human see at the beginning of a planning step.

    Every quantity of ``quantities("option")`` is an attribute and an item: an array of one number for each
    option (NaN where missing), as ``view.objective_cost_m``; ``view.name`` is a list of names. ``len`` counts
    the options."""

    @property
    def step(self) -> int:
        """k, from 0."""
    @property
    def time_s(self) -> float:
        """Simulated time, s."""
    @property
    def planning_step_s(self) -> float:
        """Length of a planning step, s."""
    @property
    def world(self) -> World:
        """The world of the episode: the same object in every view of an episode."""
    def path(self, option: int) -> _Floats | None:
        """The remaining path of an option, (n, 2), m, in the world, from the team to the target; None where no path
        leads on. option: an index."""
    @property
    def position(self) -> _Floats:
        """Position of the team, (2,), m."""
    @property
    def executed(self) -> int | None:
        """The executed option; None before the first step."""
    @property
    def mode(self) -> str:
        """Who led in the last planning step: robot-led or human-led."""
    @property
    def hand(self) -> _Floats | None:
        """world_from_hand, (4, 4); the physical plant only."""
    @property
    def hand_wrench(self) -> _Floats | None:
        """Mean force (N) and torque (Nm) of the human on the object in the last planning step, (6,), world axes; the
        physical plant only."""
    def __getattr__(self, key: str, /) -> Any: ...
    def __getitem__(self, key: str, /) -> Any: ...
    def __len__(self) -> int: ...

@final
class RobotView(View):
    """What a custom policy sees at the beginning of a planning step: that of View, and the robot."""

    @property
    def robot(self) -> Robot | None:
        """The robot of the episode: the same object in every view of an episode; None on the point plant."""
    @property
    def stubbornness(self) -> float:
        """phi(k), eq. (5)."""
    @property
    def discomfort(self) -> float:
        """g(k), eq. (5)."""
    @property
    def stance(self) -> str:
        """The human's response to the robot's lead: follow, resist or take-over."""
    @property
    def configuration(self) -> _Floats | None:
        """Base x, y (m) and yaw (rad), then the joints (rad, prismatic m), (3 + joints,); None without a
        robot."""
    @property
    def grasp(self) -> _Floats | None:
        """world_from_grasp, (4, 4); None without a robot."""
    @property
    def object(self) -> _Floats | None:
        """world_from_object, (4, 4), x from the robot's end to the human's; the physical plant only."""
    @property
    def grip_wrench(self) -> _Floats | None:
        """Mean force (N) and torque (Nm) of the robot on the object in the last planning step, (6,), world axes; the
        physical plant only."""

@final
class HumanView(View):
    """What a custom human sees at the beginning of a planning step: that of View, and what only the human knows."""

    @property
    def risk_weight_m(self) -> float:
        """c_r, m."""
    @property
    def seed(self) -> int:
        """The episode's seed."""
    def subjective_cost(self, alpha: float, gamma: float) -> _Floats:
        """J^ of every option with this alpha and gamma, eq. (2), cost units."""
    def gumbel(self) -> _Floats:
        """The Gumbel disturbances that the episode's seed draws for the built-in Boltzmann human, one per
        option."""

@final
class HandView:
    """What a custom human sees at the beginning of a control period, for the hand."""

    @property
    def time_s(self) -> float:
        """Simulated time, s."""
    @property
    def period(self) -> int:
        """The control period within the planning step, from 0."""
    @property
    def periods(self) -> int:
        """The number of control periods in a planning step."""
    @property
    def control_period_s(self) -> float:
        """Length of a control period, s."""
    @property
    def begun_at(self) -> _Floats:
        """Position of the hand at the beginning of the planning step (x, y), without sway, m."""
    @property
    def hand(self) -> _Floats:
        """Position of the hand (x, y), without sway, m."""
    @property
    def heading_rad(self) -> float:
        """Direction in which the hand faces, without sway: its yaw in the world, rad."""
    @property
    def hand_wrench(self) -> _Floats | None:
        """Mean force (N) and torque (Nm) of the human on the object in this planning step so far, (6,), world axes."""

@final
class Preference:
    """How humans choose between options, if their alpha and gamma are distributed like the belief (Sec. III,
    IV-A).

    Of options with lengths D_o (m) and risks S_o (0 to 1). Raises Error with the value and what would
    be right."""

    def __new__(
        cls,
        length_m: Sequence[float],
        risk: Sequence[float],
        *,
        risk_weight_m: float = 10.0,
        belief_alpha: str = "uniform(0.55,0.95)",
        belief_gamma: str = "uniform(0.5,1.1)",
        belief_samples: Any = None,
    ) -> Self:
        ...
    @staticmethod
    def of(scenario: Scenario) -> Preference:
        """Of a scenario's options from its start, with its belief and c_r."""
    @property
    def length_m(self) -> _Floats:
        """D_o, m."""
    @property
    def risk(self) -> _Floats:
        """S_o."""
    @property
    def probability(self) -> _Floats:
        """P_o, eq. (4)."""
    @property
    def expected_subjective_cost(self) -> _Floats:
        """J~_o of eq. (6), cost units."""
    @property
    def objective_cost_m(self) -> _Floats:
        """J_o, eq. (1), m."""
    def subjective_cost(self, alpha: float, gamma: float) -> _Floats:
        """J^_o of a human, eq. (2), cost units."""
    def choice(self, alpha: float, gamma: float) -> int:
        """The option that a human prefers, eq. (3)."""
    def choices(self, alpha: Sequence[float] | _Floats, gamma: Sequence[float] | _Floats) -> NDArray[np.int64]:
        """The options that humans prefer, for arrays of alpha and gamma."""
    def regions(
        self, alpha: Sequence[float] | None = None, gamma: Sequence[float] | None = None
    ) -> list[tuple[int, _Floats]]:
        """R_o: parts of the plane with their option and outline, (n, 2) of alpha and gamma; by default of the
        belief."""
    def __len__(self) -> int: ...
    def __reduce__(self) -> Any: ...
    @staticmethod
    def _rebuild(state: bytes) -> Preference: ...

@final
class Table:
    """A table of rows. Opens without copies wherever Arrow data do: ``polars.DataFrame(table)``,
    ``pyarrow.table(table)``, ``pandas.DataFrame.from_arrow(table)`` (pandas 3). Shows its first rows in a
    notebook, and as ``print(table)``."""

    @property
    def columns(self) -> list[str]:
        """The names of the columns, which end in their units."""
    @property
    def metadata(self) -> dict[str, dict[str, str]]:
        """Unit and description of the columns that have them."""
    def __len__(self) -> int: ...
    def __getitem__(self, name: str, /) -> NDArray[Any]:
        """Return self[key]."""
    def to_numpy(self) -> dict[str, NDArray[Any]]:
        """All columns."""
    @staticmethod
    def concatenate(tables: Sequence[Table]) -> Table:
        """The rows of tables with the same columns, one after the other."""
    def __arrow_c_stream__(self, requested_schema: object | None = None) -> CapsuleType: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __reduce__(self) -> Any: ...
    def _repr_html_(self) -> str: ...
    @staticmethod
    def _rebuild(names: Any, kinds: Any, cells: Any, about: Any) -> Table: ...

@final
class Recording:
    """A recording (MCAP). Shows itself as the 3-D player in a notebook."""

    @property
    def provenance(self) -> dict[str, str]:
        """Its origin: crate_version, arithmetic (its stamp), seed, world, plant and method, by key."""
    @property
    def topics(self) -> dict[str, int]:
        """The number of messages by topic."""
    @property
    def outcome(self) -> dict[str, Any] | None:
        """The figures of the episode; None in an incomplete recording."""
    @property
    def scenario(self) -> Scenario:
        """The scenario."""
    def table(self, topic: str) -> Table:
        """The messages on a topic, one a row, after their simulated time (s). Raises RecordingError."""
    def replay(self) -> dict[str, Any]:
        """Runs the scenario again and compares every message: verdict, same_messages, difference.

        The decisions of custom partners are repeated from the recording's log."""
    def to_html(self, title: str | None = None) -> str:
        """The 3-D player, as one page."""
    def _repr_html_(self) -> str: ...

@final
class Lanes:
    """Environments side by side."""

    def __new__(
        cls,
        num_envs: int,
        task: str,
        scenarios: Sequence[Scenario],
        *,
        preference_changes: int | str | None = None,
        alpha: float | None = None,
        gamma: float | None = None,
        weights: tuple[float, float, float] | None = None,
        max_steps: int | None = None,
        max_episode_steps: int | None = None,
        prices_ending: bool = False,
        most_step_cost: float | None = None,
        action_scale: float | None = None,
        tells_built_in: bool = False,
        autoreset: str | None = None,
        threads: int | None = None,
    ) -> Self: ...
    def seed(self, index: int, seed: int) -> None: ...
    def reset(
        self,
        mask: Sequence[bool] | None = None,
        *,
        world: int | str | None = None,
        seed: int | None = None,
        alpha: float | None = None,
        gamma: float | None = None,
    ) -> None: ...
    def step(self, actions: NDArray[Any]) -> None: ...
    @property
    def observations(self) -> _Floats: ...
    @property
    def rewards(self) -> _Floats: ...
    @property
    def terminated(self) -> NDArray[np.bool_]: ...
    @property
    def truncated(self) -> NDArray[np.bool_]: ...
    @property
    def layout(self) -> list[tuple[str, str, tuple[float, float]]]: ...
    @property
    def action_layout(self) -> list[tuple[str, str]]: ...
    @property
    def worlds(self) -> list[str]: ...
    @property
    def limits(self) -> _Floats: ...
    @property
    def options(self) -> int: ...
    @property
    def action_masks(self) -> NDArray[np.int8]: ...
    def built_in(self, index: int) -> list[_Floats] | None: ...
    def bound(self, index: int) -> tuple[int, float] | None: ...
    def save(self) -> bytes: ...
    def restore(self, state: bytes) -> None: ...
    def episode(self, index: int) -> dict[str, Any]: ...
    def scenario(self, index: int) -> Scenario | None: ...
    def costs(self, index: int) -> tuple[float, float, float]: ...
    def recording(self, index: int, actions: Sequence[Sequence[float]]) -> bytes: ...
    def summary(self, index: int) -> dict[str, Any] | None: ...
    def last_observation(self, index: int) -> _Floats: ...

def settings() -> dict[str, dict[str, Any]]:
    """Every setting of an episode: type, about, allowed values, default and words."""

def quantities(of: str) -> dict[str, tuple[str, str]]:
    """Every quantity of a ``"tick"``, an ``"option"`` or an ``"episode"``: its unit and its description."""

def gumbel(seed: int, options: int) -> _Floats:
    """The Gumbel disturbances that the Boltzmann human of a seed draws, one for every option."""

def option_colours() -> list[str]:
    """The colours of options in pictures, as ``#rrggbb``; they repeat after the last."""

def read(file: _Path) -> Recording:
    """Opens a recording (MCAP). Raises RecordingError with the file, the place and what would be right."""

def player(recording: bytes, title: str) -> str:
    """The 3-D player of a recording's bytes."""

def picture(recording: bytes, width: int) -> NDArray[np.uint8]:
    """The last picture of a recording's bytes, (height, width, 3)."""

def program(arguments: Sequence[str]) -> int:
    """Runs the command-line program with these arguments; returns its exit code."""

#: Name, code and object of a policy or human of a sweep; the last two are None for one of the program.
_Partner = tuple[str, str | None, Any]

def study_rows(
    text: str,
    *,
    file: str,
    folder: str,
    seeds: int | None,
    first: int,
    end: int,
    policies: Sequence[_Partner] = ...,
    humans: Sequence[_Partner] = ...,
) -> bytes:
    """The lines of results of the episodes from ``first`` to before ``end``, as ``cocarry sweep`` writes them.

    Raises StudyError."""

def study_episodes(
    text: str,
    *,
    file: str,
    folder: str,
    seeds: int | None,
    policies: Sequence[_Partner],
    humans: Sequence[_Partner],
) -> int:
    """The number of episodes of a study."""

def check_partner(what: str, given: Any) -> None:
    """The check that an object can decide."""

def rows_table(lines: bytes) -> Table:
    """The table of lines of results, as `study_rows` returns them."""

def compare(
    results: Sequence[Any], by: str | None, over: Sequence[str], quantities: Sequence[str]
) -> tuple[Table, list[str]]:
    """The paired comparisons of results, and notes on them."""

def summary(results: Sequence[Any]) -> tuple[Table, list[str]]:
    """Means and intervals of every combination of results, and notes on them."""

def bench(folder: _Path, results: Sequence[Any], worlds: bool) -> tuple[Table, list[str]]:
    """The score card of results of the benchmark in a folder, or its results world by world, and notes on them."""

def plot(
    results: Sequence[Any],
    kind: str,
    quantity: str,
    by: str | None,
    cells: int,
    width: str | None,
    file: _Path,
) -> tuple[bytes, list[str]]:
    """The bytes of a picture of results, in the format of a file of that name, and notes on them."""

def arithmetic_stamp() -> str:
    """The stamp of this machine's arithmetic: a digest of a fixed list of results."""

@final
class Rows:
    """The results of a study whose episodes run elsewhere: a file that grows in the order of episodes. A file that
    has all of them already is complete, unless ``overwrite``.

    Raises StudyError, also if the file is that of another study, is no CSV file of results, or is written by another
    process."""

    def __new__(
        cls,
        text: str,
        *,
        file: str,
        folder: str,
        seeds: int | None,
        out: _Path,
        overwrite: bool,
        policies: Sequence[_Partner] = ...,
        humans: Sequence[_Partner] = ...,
    ) -> Rows: ...
    @property
    def kept(self) -> int:
        """The number of episodes whose rows are there."""
    @property
    def episodes(self) -> int:
        """The number of episodes."""
    def files(self, path: _Path) -> list[pathlib.Path]:
        """The files that the study reads, if the study file is ``path``."""
    def append(self, rows: bytes) -> None:
        """Appends the lines of the next episodes. Raises StudyError if one is not the next, or damaged."""
    def finish(self, table: bool) -> Table | None:
        """Runs the episodes that are missing, gives the file its name, and returns the rows if ``table``.

        Raises StudyError."""

def sweep(
    text: str,
    *,
    file: str,
    folder: str,
    seeds: int | None = None,
    shard: tuple[int, int] | None = None,
    threads: int | None = None,
    policies: Sequence[_Partner] = ...,
    humans: Sequence[_Partner] = ...,
    out: _Path | None = None,
    ticks: _Path | None = None,
    overwrite: bool = False,
    progress: Callable[[int, int], object] | None = None,
    table: bool = True,
) -> Table | None:
    """Runs the episodes of a study's text; see cocarry.sweep."""
