"""A human and a mobile manipulator that carry an object together but prefer different paths.

The same simulation as the Rust library and program ``cocarry``: the same scenario gives the same bits.
Lengths are in metres, times in seconds, angles in radians unless a name ends in another unit.
Where Gymnasium is installed, its ids ``cocarry/Options-v0`` and ``cocarry/Carry-v1`` are registered.
Modules to import on their own: ``cocarry.environments`` (Gymnasium), ``cocarry.pettingzoo``, ``cocarry.datasets``.

>>> import cocarry
>>> scenario = cocarry.Scenario("environment-4", plant="point", alpha=0.747, gamma=0.765)
>>> cocarry.Episode(scenario).run()["outcome"]
'arrived'
"""

from cocarry._cocarry import (
    ActionError,
    ClosedError,
    DecisionError,
    Episode,
    Error,
    HandView,
    HumanView,
    Preference,
    Recording,
    RecordingError,
    Robot,
    RobotError,
    RobotView,
    Scenario,
    ScenarioError,
    SnapshotError,
    StudyError,
    Table,
    UnknownKeyError,
    World,
    WorldError,
    __version__,
    gumbel,
    quantities,
    read,
    settings,
)
from cocarry._compare import Picture, bench, compare, plot, summary
from cocarry._palette import option_colour
from cocarry._partners import Decision, Human, HumanDecision, Policy
from cocarry._program import fit_eta, fit_risk_weight, reproduce
from cocarry._register import register_if_installed as _register_if_installed
from cocarry._study import sweep
from cocarry._world import Obstacle

__all__ = [
    "ActionError",
    "ClosedError",
    "Decision",
    "DecisionError",
    "Episode",
    "Error",
    "Human",
    "HumanDecision",
    "HandView",
    "HumanView",
    "Obstacle",
    "Picture",
    "Policy",
    "Preference",
    "Recording",
    "RecordingError",
    "Robot",
    "RobotError",
    "RobotView",
    "Scenario",
    "ScenarioError",
    "SnapshotError",
    "StudyError",
    "Table",
    "UnknownKeyError",
    "World",
    "WorldError",
    "__version__",
    "bench",
    "compare",
    "fit_eta",
    "fit_risk_weight",
    "gumbel",
    "option_colour",
    "plot",
    "quantities",
    "read",
    "reproduce",
    "settings",
    "summary",
    "sweep",
]

_register_if_installed()
