"""Sweeps: many episodes from one study."""

from __future__ import annotations

import os
import pathlib
import sys
from collections.abc import Callable, Mapping
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from typing import Any, Literal, overload

from cocarry import _cocarry, _ray
from cocarry._cocarry import StudyError, Table


@overload
def sweep(
    study: str | os.PathLike[str] | Mapping[str, Any],
    *,
    seeds: int | None = ...,
    shard: tuple[int, int] | None = ...,
    threads: int | None = ...,
    processes: int | None = ...,
    policy: Any = ...,
    human: Any = ...,
    out: str | os.PathLike[str] | None = ...,
    ticks: str | os.PathLike[str] | None = ...,
    overwrite: bool = ...,
    backend: Literal["ray"] | None = ...,
    address: str | None = ...,
    progress: bool | Callable[[int, int], object] = ...,
    table: Literal[True] = ...,
) -> Table: ...
@overload
def sweep(
    study: str | os.PathLike[str] | Mapping[str, Any],
    *,
    seeds: int | None = ...,
    shard: tuple[int, int] | None = ...,
    threads: int | None = ...,
    processes: int | None = ...,
    policy: Any = ...,
    human: Any = ...,
    out: str | os.PathLike[str] | None = ...,
    ticks: str | os.PathLike[str] | None = ...,
    overwrite: bool = ...,
    backend: Literal["ray"] | None = ...,
    address: str | None = ...,
    progress: bool | Callable[[int, int], object] = ...,
    table: Literal[False],
) -> None: ...
def sweep(
    study: str | os.PathLike[str] | Mapping[str, Any],
    *,
    seeds: int | None = None,
    shard: tuple[int, int] | None = None,
    threads: int | None = None,
    processes: int | None = None,
    policy: Any = None,
    human: Any = None,
    out: str | os.PathLike[str] | None = None,
    ticks: str | os.PathLike[str] | None = None,
    overwrite: bool = False,
    backend: Literal["ray"] | None = None,
    address: str | None = None,
    progress: bool | Callable[[int, int], object] = False,
    table: bool = True,
) -> Table | None:
    """Runs every episode of a study and returns a row for each, as ``cocarry sweep`` writes them.

    study: a study file (TOML), its text (with a line break in it), or a mapping with the keys of a study.
    seeds: the largest number of seeds of every run.
    shard: (i, n), the i-th of n parts, from 1.
    threads: default all. The rows do not depend on it.
    processes: run in this many processes instead, each with one thread; for custom partners, which hold Python's lock.
        They and the partners must be importable there (spawn).
    policy, human: custom partners, as of Episode, in all episodes. Every episode has copies of them. The columns
        ``method`` and ``human_model`` are then ``own(NAME)``, and ``checksum`` is empty.
    out: write the rows into this file too, as ``cocarry sweep --output``: Parquet if its name ends in ``.parquet``, else
        CSV. A sweep that was stopped, by Ctrl-C or a power cut, resumes where it stopped. Not with
        custom partners.
    ticks: write every tick of every episode into this new folder, as ``cocarry sweep --ticks``: Parquet files of 100
        episodes each. Needs out.
    overwrite: replace existing outputs, and unfinished ones of another study.
    backend: "ray" runs blocks of episodes on a Ray cluster instead, and writes their rows here. Workers that die are
        replaced; a sweep that was stopped resumes. The rows are those of this machine, byte for byte. Not with custom
        partners. The study's files that are next to it or below are sent along.
    address: of the Ray cluster, as of ``ray.init``; by default RAY_ADDRESS, or a cluster of this machine alone.
    progress: True for a bar, or a callable of the episodes done and all.
    table: False returns None instead of the rows, for studies whose rows do not fit into memory: a million take 1 GB.
        Needs out.

    Raises StudyError with the file, the line, the key, the value and what would be right.
    """
    if not table and out is None:
        raise StudyError("table = False: needs out = a file; there would be no results")
    text, file, folder = _source(study)
    if backend is not None:
        if backend != "ray":
            raise StudyError(f'backend = {backend!r}; it must be "ray" or None')
        if any(given is not None for given in (shard, threads, processes, policy, human, ticks)):
            raise StudyError('backend = "ray": without shard, threads, processes, ticks and custom partners')
        return _ray.sweep(text, file, folder, seeds, out, overwrite, address, progress, table)
    if address is not None:
        raise StudyError('address = the address of a Ray cluster: needs backend = "ray"')
    tell = _bar if progress is True else progress or None
    if processes is None:
        return _cocarry.sweep(
            text, file=file, folder=folder, seeds=seeds, shard=shard, threads=threads, policy=policy, human=human,
            out=out, ticks=ticks, overwrite=overwrite, progress=tell, table=table,
        )
    if processes < 1 or any(given is not None for given in (shard, threads, out, ticks)):
        raise StudyError(
            "processes must be at least 1, without shard, threads, out and ticks: processes have a shard and a thread each"
        )
    parts = max(processes, 1)
    with ProcessPoolExecutor(parts, mp_context=get_context("spawn")) as pool:
        work = [pool.submit(_shard, text, file, folder, seeds, (i + 1, parts), policy, human) for i in range(parts)]
        tables = []
        for part in work:
            tables.append(part.result())
            if tell is not None:
                tell(len(tables), parts)
    return Table.concatenate(tables)


def _shard(
    text: str, file: str, folder: str, seeds: int | None, shard: tuple[int, int], policy: Any, human: Any
) -> Table:
    table = _cocarry.sweep(text, file=file, folder=folder, seeds=seeds, shard=shard, threads=1, policy=policy, human=human)
    assert table is not None
    return table


def _source(study: str | os.PathLike[str] | Mapping[str, Any]) -> tuple[str, str, str]:
    """The text of a study, its name in errors, and the folder of the files that it names."""
    if isinstance(study, Mapping):
        return _toml(study), "study", "."
    if isinstance(study, str) and "\n" in study:
        return study, "study", "."
    path = pathlib.Path(study)
    try:
        return path.read_text(encoding="utf-8"), str(path), str(path.parent)
    except (OSError, UnicodeDecodeError) as error:
        raise StudyError(f"{path}: cannot be read: {error}; expected a study file, its text or a mapping") from error


def _toml(study: Mapping[str, Any]) -> str:
    """A mapping as TOML: tables after plain values."""

    def value(given: Any) -> str:
        if isinstance(given, bool):
            return str(given).lower()
        if isinstance(given, str):
            return '"' + "".join(_escaped(c) for c in given) + '"'
        if isinstance(given, os.PathLike):
            return value(os.fspath(given))
        if isinstance(given, Mapping):
            return "{ " + ", ".join(f"{value(str(k))} = {value(v)}" for k, v in given.items()) + " }"
        if isinstance(given, (list, tuple)) or hasattr(given, "tolist"):
            items = given.tolist() if hasattr(given, "tolist") else given
            return "[" + ", ".join(map(value, items)) + "]" if isinstance(items, (list, tuple)) else value(items)
        if isinstance(given, (int, float)):
            return repr(given)
        raise StudyError(f"study: {given!r} is not a value of a study; expected numbers, texts, booleans, lists or mappings")

    return "\n".join(f"{value(str(key))} = {value(given)}" for key, given in study.items()) + "\n"


def _escaped(character: str) -> str:
    if character in '"\\':
        return "\\" + character
    return character if character.isprintable() else f"\\U{ord(character):08x}"


def _bar(done: int, count: int) -> None:
    """A progress bar: in notebooks and terminals the line is written over."""
    width = 40
    full = width * done // max(count, 1)
    end = "\n" if done == count else ""
    print(f"\r[{'#' * full}{'.' * (width - full)}] {done} of {count}", end=end, file=sys.stderr, flush=True)
