"""The commands whose results are JSON: the paper's claims and fits, run by the program in a separate process."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from typing import Any

from cocarry import _arguments
from cocarry._cocarry import Error


def _run(*arguments: str) -> dict[str, Any]:
    command = [sys.executable, "-m", "cocarry", *arguments, "--json"]
    for argument in arguments:
        if "\0" in argument or not argument.isprintable():
            raise Error(f"{argument!r} is not an argument of the program: it has characters that are not printed")
    done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        message = done.stderr.strip() or f"the program ended with code {done.returncode}"
        raise Error(message.removeprefix("error: "))
    found = json.loads(done.stdout)
    assert isinstance(found, dict)
    return found


def _flags(options: dict[str, Any]) -> list[str]:
    """Keywords as the program's flags: ``risk_weight=12`` is ``--risk-weight 12``, True a flag without value."""
    flags: list[str] = []
    for key, given in options.items():
        flag = "--" + key.replace("_", "-")
        for value in given if isinstance(given, (list, tuple)) else [given]:
            if value is None or value is False:
                continue
            flags += [flag] if value is True else [flag, os.fspath(value) if hasattr(value, "__fspath__") else str(value)]
    return flags


#: The claims of ``cocarry reproduce`` whose results are JSON.
_CLAIMS = ("h1", "h2", "h3", "guide", "h4", "contacts", "slots", "cycles", "starts", "all")


def reproduce(claim: str, **options: Any) -> dict[str, Any]:
    """Reproduces a claim of the paper: ``h1`` (Table I), ``h2`` (II), ``h3`` (III), ``cycles``, or a study that is not in the
    paper: ``guide``, ``h4``, ``contacts``, ``slots`` or ``starts``. ``all`` writes a report with all of them into the folder
    ``output``.

    Options are those of ``cocarry reproduce CLAIM --help``, with underscores: ``reproduce("h2", seed=1)``.
    Returns what ``--json`` prints. Raises Error with the program's message.
    """
    expected = f"one of {', '.join(_CLAIMS)}"
    if _arguments.word("claim", claim, expected, Error) not in _CLAIMS:
        raise Error(f"claim = {claim!r}; it must be {expected}")
    return _run("reproduce", claim, *_flags(options))


def fit_risk_weight(answers: str | os.PathLike[str], **options: Any) -> dict[str, Any]:
    """Fits c_r (m) to participants' percentages; a CSV file with participant, world, option and percent.

    Options are those of ``cocarry fit risk-weight --help``, with underscores. Returns what ``--json`` prints.
    Raises Error with file, line, value and what would be right.
    """
    return _run("fit", "risk-weight", _arguments.file("answers", answers), *_flags(options))


def fit_eta(switches: str | os.PathLike[str], **options: Any) -> dict[str, Any]:
    """Fits eta to the steps at which participants asked to switch; a CSV file with participant, world, option, step.

    Options are those of ``cocarry fit eta --help``, with underscores. Returns what ``--json`` prints.
    Raises Error with file, line, value and what would be right.
    """
    return _run("fit", "eta", _arguments.file("switches", switches), *_flags(options))
