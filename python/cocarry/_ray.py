"""Sweeps on a Ray cluster: blocks of consecutive episodes as stateless tasks, their rows written in order."""

from __future__ import annotations

import contextlib
import os
import pathlib
import socket
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from typing import Any

from cocarry import _cocarry
from cocarry._cocarry import StudyError, Table

#: What a block should take, s, and how often its tasks are tried again when their worker dies.
BLOCK_S, RETRIES = 4.0, 3
#: Blocks under way for every processor: one that runs, and one that waits.
IN_FLIGHT = 2
#: How far blocks may be ahead of the first missing one, in blocks under way.
AHEAD = 4
#: How often the processors of the cluster are counted, which may come and go, s.
COUNT_S = 10.0


class _Study:
    """A study as its texts, which workers on other machines read as if they had its files."""

    def __init__(
        self, text: str, file: str, folder: str, seeds: int | None, partners: dict[str, Any], files: list[pathlib.Path]
    ):
        self.text, self.file, self.seeds, self.partners = text, file, seeds, partners
        root = pathlib.Path(folder).resolve()
        near = [path for path in files if path.is_file() and path.resolve().is_relative_to(root)]
        # files elsewhere must be at the same place on every machine
        self.folder = None if near else str(root)
        self.files = {str(path.resolve().relative_to(root)): path.read_bytes() for path in near}

    @contextlib.contextmanager
    def at(self) -> Iterator[str]:
        """A folder with the study's files."""
        if self.folder is not None:
            yield self.folder
            return
        with tempfile.TemporaryDirectory() as folder:
            for name, contents in self.files.items():
                path = pathlib.Path(folder, name)
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_bytes(contents)
            yield folder

    def rows(self, first: int, end: int) -> tuple[bytes, float]:
        """The lines of these episodes, and the time that they took, s."""
        begun = time.perf_counter()
        with self.at() as folder:
            rows = _cocarry.study_rows(
                self.text, file=self.file, folder=folder, seeds=self.seeds, first=first, end=end, **self.partners
            )
        return rows, time.perf_counter() - begun


def _environment() -> tuple[str, str]:
    """The version of the package, and the stamp of the arithmetic."""
    return _cocarry.__version__, _cocarry.arithmetic_stamp()


def sweep(
    text: str,
    file: str,
    folder: str,
    seeds: int | None,
    partners: dict[str, Any],
    out: str | os.PathLike[str] | None,
    overwrite: bool,
    address: str | None,
    progress: bool | Callable[[int, int], object],
    table: bool,
) -> Table | None:
    try:
        import ray
    except ImportError as error:
        raise StudyError('backend = "ray": Ray is not installed; pip install "cocarry[ray]"') from error
    if out is None:
        with tempfile.TemporaryDirectory() as temporary:
            there = pathlib.Path(temporary, "rows.csv")
            return sweep(text, file, folder, seeds, partners, there, overwrite, address, progress, table)
    rows = _cocarry.Rows(text, file=file, folder=folder, seeds=seeds, **partners, out=out, overwrite=overwrite)
    if rows.kept == rows.episodes:
        return rows.finish(table)
    files = [pathlib.Path(name) for name in rows.files(pathlib.Path(folder, "study"))]
    study = _Study(text, file, folder, seeds, partners, files)
    is_ours = not ray.is_initialized()
    if is_ours:
        _reach(address)
        try:
            ray.init(address=address, log_to_driver=False, configure_logging=False)
        except (ConnectionError, ValueError) as error:
            raise StudyError(f"address = {address!r}: no Ray cluster there: {error}") from error
    else:
        _refuse_another(ray, address)
    try:
        _check(ray)
        _run(ray, rows, study, _teller(progress))
    finally:
        if is_ours:
            ray.shutdown()
    return rows.finish(table)


def _reach(address: str | None) -> None:
    """Refuses an address where nobody listens, for which Ray would wait for minutes."""
    host, colon, port = (address or "").removeprefix("ray://").rpartition(":")
    if not colon:
        return
    try:
        socket.create_connection((host, int(port)), timeout=10.0).close()
    except (OSError, ValueError) as error:
        raise StudyError(f"address = {address!r}: no Ray cluster there: {error}") from error


def _refuse_another(ray: Any, address: str | None) -> None:
    """Refuses an address other than that of the cluster to which this process is connected."""
    if address in (None, "auto"):
        return
    here = ray.get_runtime_context().gcs_address
    if address != here:
        raise StudyError(
            f"address = {address!r}: this process is connected to {here}; leave address out, or call ray.shutdown() first"
        )


def _processors(ray: Any) -> int:
    return max(1, int(ray.cluster_resources().get("CPU", 1)))


def _check(ray: Any) -> None:
    """Refuses a cluster with another version of the package, or another arithmetic, on any of its nodes."""
    from ray.util.scheduling_strategies import NodeAffinitySchedulingStrategy

    ours = _environment()
    remote = ray.remote(_environment)
    nodes = [node for node in ray.nodes() if node["Alive"] and node["Resources"].get("CPU", 0) > 0]
    asked = {
        f"{node['NodeManagerHostname']} ({node['NodeID'][:8]})": remote.options(
            num_cpus=1, max_retries=0, scheduling_strategy=NodeAffinitySchedulingStrategy(node["NodeID"], soft=False)
        ).remote()
        for node in nodes
    }
    if not asked:
        raise StudyError("the Ray cluster has no node with a processor")
    for name, answer in asked.items():
        try:
            theirs = ray.get(answer)
        except ray.exceptions.RayError as error:
            raise StudyError(f"node {name}: cocarry does not run there: {_reason(error)}") from error
        for what, there, here in zip(("version", "arithmetic"), theirs, ours):
            if there != here:
                raise StudyError(f"node {name}: {what} {there}; here it is {here}, and rows of both cannot be joined")


def _run(ray: Any, rows: Any, study: _Study, tell: Callable[[int, int, int], None]) -> None:
    """Runs all missing episodes, and appends their rows in order."""
    next_row, count = rows.kept, rows.episodes
    processors, counted = _processors(ray), time.monotonic()
    task = ray.remote(study.__class__.rows).options(num_cpus=1, max_retries=RETRIES)
    try:
        shared = ray.put(study)
    except TypeError as error:  # of what cannot be pickled
        raise StudyError(f'backend = "ray": a custom policy or human cannot be sent to workers: {_reason(error)}') from error
    # one episode at first, which tells how many make a block
    per_episode: float | None = None
    submitted, size = next_row, 1
    running: dict[Any, tuple[int, int]] = {}
    ready: dict[int, tuple[bytes, int]] = {}
    tell(next_row, count, processors)
    try:
        while next_row < count:
            if time.monotonic() - counted > COUNT_S:
                processors, counted = _processors(ray), time.monotonic()
            ahead = len(running) + len(ready)
            while submitted < count and len(running) < IN_FLIGHT * processors and ahead < AHEAD * IN_FLIGHT * processors:
                # the last blocks are small, so that all processors end together
                last = max(1, (count - submitted) // (2 * processors))
                end = min(submitted + min(size, max(last, size // 8)), count)
                running[task.remote(shared, submitted, end)] = (submitted, end)
                submitted, ahead = end, ahead + 1
            done, _ = ray.wait(list(running), num_returns=1, timeout=1.0)
            for answer in done:
                first, end = running.pop(answer)
                try:
                    lines, seconds = ray.get(answer)
                except ray.exceptions.RayTaskError as error:
                    raise StudyError(f"episodes {first} to {end - 1}: {_reason(error)}") from error
                except ray.exceptions.RayError as error:
                    raise StudyError(
                        f"episodes {first} to {end - 1}: their worker died {RETRIES + 1} times, the last time of: "
                        f"{_reason(error)}; the rows before them are kept, and the same call goes on from there"
                    ) from error
                ready[first] = (lines, end)
                now = seconds / (end - first)
                per_episode = now if per_episode is None else 0.5 * (per_episode + now)
                size = max(1, min(int(BLOCK_S / max(per_episode, 1e-9)), 8 * size))
            while next_row in ready:
                lines, next_row = ready.pop(next_row)
                rows.append(lines)
            tell(next_row, count, processors)
    finally:
        for answer in running:
            ray.cancel(answer, force=True)


def _reason(error: Exception) -> str:
    """The line that says what happened."""
    cause = getattr(error, "cause", None) or error
    lines = [line.strip() for line in str(cause).splitlines() if line.strip()]
    return lines[-1] if lines else type(error).__name__


def _teller(progress: bool | Callable[[int, int], object]) -> Callable[[int, int, int], None]:
    begun, kept, shown = time.monotonic(), None, -1

    def tell(done: int, count: int, processors: int) -> None:
        nonlocal kept, shown
        kept = done if kept is None else kept
        if done == shown or not progress:
            return
        shown = done
        if progress is not True:
            progress(done, count)
            return
        rate = (done - kept) / max(time.monotonic() - begun, 1e-9)
        left = f", {(count - done) / rate:.0f} s left" if rate > 0 else ""
        full = 40 * done // max(count, 1)
        bar = f"\r[{'#' * full}{'.' * (40 - full)}] {done} of {count}, {rate:.0f}/s on {processors} processors{left}   "
        print(bar, end="\n" if done == count else "", file=sys.stderr, flush=True)

    return tell
