"""How data sets get onto the disk: whole, or not at all; and what recordings' tables have."""

from __future__ import annotations

import importlib
import os
import pathlib
import re
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from cocarry._cocarry import Error, Table

Path: TypeAlias = str | os.PathLike[str]
Floats: TypeAlias = NDArray[np.float64]


class DatasetError(Error):
    """A data set that cannot be written."""


def needed(module: str) -> Any:
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        package = module.partition(".")[0]
        raise ModuleNotFoundError(f'data sets need {package}: pip install "./python[datasets]"', name=error.name) from error


def free(path: pathlib.Path, sign: str, overwrite: bool, what: str) -> None:
    """Refuses a path that is taken; with ``overwrite``, one that is not a data set of this kind (with ``sign`` in it)."""
    if not os.path.lexists(path):
        return
    if not overwrite:
        raise DatasetError(f"{path}: exists already; choose another name, or overwrite=True")
    if path.is_symlink() or not (path / sign).exists():
        raise DatasetError(f"{path}: is not {what} (no `{sign}` in it) and is not overwritten; choose another name")


@contextmanager
def staged(final: pathlib.Path, overwrite: bool, root: pathlib.Path | None = None) -> Iterator[pathlib.Path]:
    """A folder's name in a temporary folder of ``root`` (default: the final one's parent). What is made there gets the
    final name if nothing is raised."""
    root = (root or final.parent).absolute()  # Minari does not write into relative folders
    with written(final):
        root.mkdir(parents=True, exist_ok=True)
        temporary = pathlib.Path(tempfile.mkdtemp(prefix=".cocarry-", dir=root))
    made, old = temporary / f"{final.name}_0", temporary / "old"
    try:
        yield made
        if os.path.lexists(final) and not overwrite:
            raise DatasetError(f"{final}: exists already; choose another name, or overwrite=True")
        with written(final):
            final.parent.mkdir(parents=True, exist_ok=True)
            if overwrite and final.exists():
                os.replace(final, old)
            try:
                os.replace(made, final)
            except OSError:
                if old.exists():
                    os.replace(old, final)
                raise
    finally:
        shutil.rmtree(temporary, ignore_errors=True)


@contextmanager
def written(path: pathlib.Path) -> Iterator[None]:
    """Errors of the file system name the data set."""
    try:
        yield
    except OSError as error:
        raise DatasetError(f"{path}: cannot be written: {error}") from error


class Columns:
    """A table's columns as numbers, NaN where missing; times in ns."""

    def __init__(self, table: Table) -> None:
        self._table = table
        self.names = table.columns
        self.times = [round(time * 1e9) for time in table["time_s"]]

    def numbers(self, *names: str) -> Floats:
        """Columns side by side, (rows, columns); NaN for those that do not exist."""
        known = set(self.names)
        missing = np.full(len(self.times), np.nan)
        columns = [np.asarray(self._table[name], dtype=np.float64) if name in known else missing for name in names]
        return np.stack(columns, axis=1)

    def texts(self, name: str) -> list[Any]:
        return list(self._table[name])

    def items(self, pattern: str) -> list[str]:
        """What the group of the pattern is in the names, in their order, each once."""
        found = (re.fullmatch(pattern, name) for name in self.names)
        return list(dict.fromkeys(match[1] for match in found if match))
