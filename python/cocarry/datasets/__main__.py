"""Recordings as data sets on the command line: ``python -m cocarry.datasets lerobot *.mcap -o carried``."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from cocarry._cocarry import Error
from cocarry.datasets import DatasetError, recorded_to_minari, to_lerobot, to_rosbag2

_ABOUT = """\
Writes recordings of cocarry (MCAP) as a data set for other tools:

  rosbag2  a bag of ROS 2 from one recording: a folder with metadata.yaml and an MCAP file (profile ros2, CDR)
  lerobot  a LeRobotDataset v3.0 for training policies, without video: a folder
  minari   a data set of Minari for offline learning: a name such as cocarry/carried-v0, which lies where Minari looks
           (MINARI_DATASETS_PATH)

It needs the package's extra: pip install "./python[datasets]"
"""
_EXAMPLES = """\
examples:
  python -m cocarry.datasets rosbag2 run.mcap -o bag
  python -m cocarry.datasets lerobot runs/*.mcap -o carried --task "carry the table" --license cc-by-4.0
  python -m cocarry.datasets minari runs/*.mcap -o cocarry/carried-v0 --author "A. Author"
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs the command with the process's arguments, or these; returns its exit code: 0, or 2 for what is refused."""
    parser = argparse.ArgumentParser(
        prog="python -m cocarry.datasets", description=_ABOUT, epilog=_EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter, allow_abbrev=False,
    )  # fmt: skip
    parser.add_argument("format", metavar="FORMAT", choices=["rosbag2", "lerobot", "minari"], help="rosbag2, lerobot or minari")
    parser.add_argument("recordings", metavar="RECORDING", nargs="+", help="a recording; each is an episode")
    parser.add_argument("-o", "--output", metavar="OUT", required=True, help="the data set: a folder, or Minari's name of it")
    parser.add_argument("--overwrite", action="store_true", help="replace a data set of the same kind")
    parser.add_argument("--task", metavar="TEXT", help="lerobot: what policies are told")
    parser.add_argument("--license", metavar="ID", help="lerobot: the license in the card [default: mit]")
    for key, what in (("author", "who made it"), ("email", "how to reach them"), ("link", "the code's address")):
        parser.add_argument(f"--{key}", metavar="TEXT", help=f"minari: {what}")
    parser.add_argument("--description", metavar="TEXT", help="minari: what it is")
    given = parser.parse_args(arguments)

    own = {"lerobot": ("task", "license"), "minari": ("author", "email", "link", "description")}
    for kind, flags in own.items():
        wrong = next((flag for flag in flags if getattr(given, flag) is not None and given.format != kind), None)
        if wrong is not None:
            parser.error(f"--{wrong}: is for {kind}, not for {given.format}")
    try:
        where = _write(given)
    except (Error, ModuleNotFoundError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    print(f"wrote {where}")
    return 0


def _write(given: argparse.Namespace) -> str:
    if given.format == "rosbag2":
        if len(given.recordings) > 1:
            raise DatasetError(f"rosbag2: takes one recording, not {len(given.recordings)}; write a bag for each")
        return str(to_rosbag2(given.recordings[0], given.output, overwrite=given.overwrite))
    if given.format == "lerobot":
        about = {"license": given.license} if given.license is not None else {}
        return str(to_lerobot(given.recordings, given.output, task=given.task, overwrite=given.overwrite, **about))
    about = {
        "author": given.author, "author_email": given.email, "code_permalink": given.link, "description": given.description,
    }  # fmt: skip
    stated = {key: value for key, value in about.items() if value is not None}
    made = recorded_to_minari(given.recordings, given.output, overwrite=given.overwrite, **stated)
    return f"{given.output}: {_counted(made.total_episodes, 'episode')}, {_counted(made.total_steps, 'step')}"


def _counted(number: int, noun: str) -> str:
    return f"{number} {noun}{'' if number == 1 else 's'}"


if __name__ == "__main__":
    sys.exit(main())
