"""The command-line program ``cocarry``, the same as the Rust one."""

import signal
import sys

from cocarry import _cocarry


def main() -> int:
    """Runs the program with the process's arguments; returns its exit code."""
    # Python's handler only takes a note of Ctrl-C, which nobody would read until the program ends
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return _cocarry.program(["cocarry", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
