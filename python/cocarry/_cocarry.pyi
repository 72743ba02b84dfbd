"""The native module: documentation and types of its classes and functions."""

import os
from collections.abc import Callable, Sequence
from typing import Any, ClassVar, Literal, Self, final

import numpy as np
from numpy.typing import NDArray
from typing_extensions import CapsuleType, Unpack

from cocarry._settings import Settings

type _Path = str | os.PathLike[str]
type _Floats = NDArray[np.float64]

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
    """A decision of an own policy or human that is not valid."""

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
