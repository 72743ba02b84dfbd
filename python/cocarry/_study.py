"""Sweeps: many episodes from one study."""

from __future__ import annotations

import os
import pathlib
import sys
from collections.abc import Callable, Mapping
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from typing import Any, Literal, overload

from cocarry import _arguments, _cocarry, _identity, _ray, _registry
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
    policy, human: in place of the study's methods and human models: a custom one, as of Episode; the name of a built-in
        one, or of one that a package registers; or a list of them, or a mapping with their names, in which a built-in one
        keeps its own: ``{"mine": mine, "mutual": "mutual"}``. All are run with the same seeds. Every episode has copies of the custom ones. Their names are in the columns ``method`` and
        ``human_model``, and what is known of their code, a version and a digest, in ``policy_code`` and ``human_code``.
        The name is the attribute ``name``, or that of the function or class; the version is the attribute ``version``.
    out: write the rows into this file too, as ``cocarry sweep --output``: Parquet if its name ends in ``.parquet``, else
        CSV. A sweep that was stopped, by Ctrl-C or a power cut, resumes where it stopped, if neither the study nor the
        code of custom partners has changed. A CSV file that has all rows of this study already is not run again.
    ticks: write every tick of every episode into this new folder, as ``cocarry sweep --ticks``: Parquet files of 100
        episodes each. Needs out.
    overwrite: replace existing outputs, and unfinished ones of another study.
    backend: "ray" runs blocks of episodes on a Ray cluster instead, and writes their rows here. Workers that die are
        replaced; a sweep that was stopped resumes. The rows are those of this machine, byte for byte. The study's files
        that are next to it or below are sent along, and custom partners as Ray pickles them: those of an installed
        package must be installed there, too.
    address: of the Ray cluster, as of ``ray.init``; by default RAY_ADDRESS, or a cluster of this machine alone.
    progress: True for a bar, or a callable of the episodes done and all.
    table: False returns None instead of the rows, for studies whose rows do not fit into memory: a million take 1 GB.
        Needs out.

    Raises StudyError with the file, the line, the key, the value and what would be right.
    """
    if seeds is not None:
        _arguments.whole("seeds", seeds, 1, error=StudyError)
    for name, given_flag in (("overwrite", overwrite), ("table", table)):
        _arguments.flag(name, given_flag, StudyError)
    for name, given_file in (("out", out), ("ticks", ticks)):
        if given_file is not None:
            _arguments.file(name, given_file, StudyError)
    if not isinstance(progress, bool) and not callable(progress):
        raise StudyError(f"progress = {progress!r}; it must be True, False or a callable of the episodes done and all")
    if not table and out is None:
        raise StudyError("table = False: needs out = a file; there would be no results")
    text, file, folder = _source(study)
    if backend is not None:
        if not isinstance(backend, str) or backend != "ray":
            raise StudyError(f'backend = {backend!r}; it must be "ray" or None')
        if any(given is not None for given in (shard, threads, processes, ticks)):
            raise StudyError('backend = "ray": without shard, threads, processes and ticks')
    elif address is not None:
        raise StudyError('address = the address of a Ray cluster: needs backend = "ray"')
    partners: dict[str, Any] = {"policies": _partners("policy", policy), "humans": _partners("human", human)}
    if backend is not None:
        return _ray.sweep(text, file, folder, seeds, partners, out, overwrite, address, progress, table)
    tell = _bar if progress is True else progress or None
    if processes is None:
        return _cocarry.sweep(
            text, file=file, folder=folder, seeds=seeds, shard=shard, threads=threads, **partners,
            out=out, ticks=ticks, overwrite=overwrite, progress=tell, table=table,
        )
    _arguments.whole("processes", processes, 1, 10_000, StudyError)
    if any(given is not None for given in (shard, threads, ticks)):
        raise StudyError("processes: without shard, threads and ticks; processes have a thread each")
    source = {"text": text, "file": file, "folder": folder, "seeds": seeds}
    return _in_processes(processes, source, partners, out, overwrite, tell, table)


def _in_processes(
    processes: int,
    source: dict[str, Any],
    partners: dict[str, Any],
    out: str | os.PathLike[str] | None,
    overwrite: bool,
    tell: Callable[[int, int], object] | None,
    table: bool,
) -> Table | None:
    """Runs blocks of episodes in processes, and joins their rows in order."""
    rows = _cocarry.Rows(**source, **partners, out=out, overwrite=overwrite) if out is not None else None
    done = rows.kept if rows is not None else 0
    count = rows.episodes if rows is not None else _cocarry.study_episodes(**source, **partners)
    # enough blocks that a stopped sweep loses little, and that no process waits for long
    size = max(1, min(1000 if rows is not None else count, -(-(count - done) // (4 * processes))))
    blocks = [(first, min(first + size, count)) for first in range(done, count, size)]
    lines = []
    with ProcessPoolExecutor(processes, mp_context=get_context("spawn")) as pool:
        work = [pool.submit(_block, source, partners, first, end) for first, end in blocks]
        try:
            for (_, end), block in zip(blocks, work):
                found = block.result()
                if rows is not None:
                    rows.append(found)
                else:
                    lines.append(found)
                if tell is not None:
                    tell(end, count)
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    return rows.finish(table) if rows is not None else _cocarry.rows_table(b"".join(lines))


def _block(source: dict[str, Any], partners: dict[str, Any], first: int, end: int) -> bytes:
    return _cocarry.study_rows(**source, **partners, first=first, end=end)


#: Name, code and object of a policy or human; the last two are None for one of the program.
Partner = tuple[str, str | None, Any]


def _partners(what: str, given: Any) -> list[Partner]:
    """The policies or humans that ``sweep`` is given; none for those of the study."""
    if given is None:
        return []
    if isinstance(given, Mapping):
        return _named(what, given)
    if not isinstance(given, (list, tuple)):
        return [_partner(what, given)]
    if not given:
        raise StudyError(f"{what} = an empty list; it must have at least one, or be None for those of the study")
    return [_partner(what, one) for one in given]


def _named(what: str, given: Mapping[Any, Any]) -> list[Partner]:
    """The policies or humans of a mapping, by their names."""
    if not given:
        raise StudyError(f"{what} = an empty mapping; it must have at least one, or be None for those of the study")
    found = []
    for name, one in given.items():
        _arguments.word(f"a name in {what}", name, "a text", StudyError)
        if isinstance(one, str) and one != name:
            raise StudyError(
                f"{what} = a mapping: {name!r} is {one!r}; it must be a custom one, since one that is given by its name keeps "
                f"that: {{{one!r}: {one!r}}}"
            )
        found.append(_partner(what, one) if isinstance(one, str) else _custom(what, one, name))
    return found


def _partner(what: str, given: Any) -> Partner:
    if not isinstance(given, str):
        return _custom(what, given, _identity.name_of(given))
    _arguments.word(what, given, "a custom one or a name", StudyError)
    if given not in _registry.registered(what):
        return given, None, None
    return _custom(what, _registry.load(what, given), given, _registry.version(what, given))


def _custom(what: str, given: Any, name: str, version: str | None = None) -> Partner:
    _cocarry.check_partner(what, given)
    return name, _identity.code_of(given, version), given


def _source(study: str | os.PathLike[str] | Mapping[str, Any]) -> tuple[str, str, str]:
    """The text of a study, its name in errors, and the folder of the files that it names."""
    if isinstance(study, Mapping):
        return _toml(study), "study", "."
    if isinstance(study, str) and "\n" in study:
        return study, "study", "."
    try:
        path = pathlib.Path(_arguments.file("study", study, StudyError))
    except StudyError:
        raise StudyError(f"study = {study!r}; it must be a study file, its text or a mapping") from None
    try:
        return path.read_text(encoding="utf-8"), str(path), str(path.parent)
    except (OSError, UnicodeDecodeError) as error:
        raise StudyError(f"{path}: cannot be read: {error}; expected a study file, its text or a mapping") from error


def _toml(study: Mapping[str, Any]) -> str:
    """A mapping as TOML: tables after plain values."""

    def value(given: Any, key: object) -> str:
        if isinstance(given, bool):
            return str(given).lower()
        if isinstance(given, str):
            return '"' + "".join(_escaped(c) for c in given) + '"'
        if isinstance(given, os.PathLike):
            return value(os.fspath(given), key)
        if isinstance(given, Mapping):
            return "{ " + ", ".join(f"{value(str(k), k)} = {value(v, k)}" for k, v in given.items()) + " }"
        if isinstance(given, (list, tuple)) or hasattr(given, "tolist"):
            items = given.tolist() if hasattr(given, "tolist") else given
            return "[" + ", ".join(value(item, key) for item in items) + "]" if isinstance(items, (list, tuple)) else value(items, key)
        if isinstance(given, (int, float)):
            return repr(given)
        raise StudyError(f"{key} = {given!r} is not a value of a study; expected numbers, texts, booleans, lists or mappings")

    return "\n".join(f"{value(str(key), key)} = {value(given, key)}" for key, given in study.items()) + "\n"


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
