"""Data sets for other tools: rosbag2 (MCAP), Minari and LeRobotDataset v3.

They need the extra ``datasets``: ``pip install "./python[datasets]"``. A data set appears under its name when it is
whole. An existing one is refused, unless ``overwrite=True``; it is then replaced when the new one is whole.
On the command line: ``python -m cocarry.datasets --help``.
"""

from cocarry.datasets._files import DatasetError
from cocarry.datasets._lerobot import to_lerobot
from cocarry.datasets._minari import recorded_to_minari, to_minari
from cocarry.datasets._rosbag2 import to_rosbag2

__all__ = ["DatasetError", "recorded_to_minari", "to_lerobot", "to_minari", "to_rosbag2"]
