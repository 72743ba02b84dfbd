"""Results of sweeps: summaries, paired comparisons and pictures."""

from __future__ import annotations

import functools
import math
import os
import pathlib
import warnings
from collections.abc import Callable, Sequence
from typing import Any, Literal, TypeVar

from cocarry import _arguments, _cocarry
from cocarry._cocarry import StudyError, Table

_Path = str | os.PathLike[str]
_Found = TypeVar("_Found")


class Picture:
    """A picture, which a notebook shows."""

    def __init__(self, svg: str, drawn: Callable[[str], bytes] | None = None) -> None:
        #: The picture as SVG.
        self.svg = svg
        self._drawn = drawn

    def save(self, file: _Path, *, overwrite: bool = False) -> pathlib.Path:
        """Writes the picture into a file, and returns its path. The extension selects the format: ``.svg``, ``.pdf`` or
        ``.png``. The last two have their letters as outlines, and are drawn from the results again, 7 inches wide unless
        ``plot`` was given a width; a PNG has 300 pixels an inch.

        Raises StudyError if the file exists already, unless ``overwrite``, or if its name has another extension."""
        path = pathlib.Path(_arguments.file("file", file, StudyError))
        _arguments.flag("overwrite", overwrite, StudyError)
        formats = (".svg", ".pdf", ".png")
        if path.suffix.lower() not in formats:
            raise StudyError(f"{path}: expected one of the extensions {', '.join(formats)}")
        # before it is drawn
        if path.exists() and not overwrite:
            raise StudyError(f"{path}: exists already; overwrite=True replaces it")
        contents = self._contents(path)
        try:
            with path.open("wb" if overwrite else "xb") as opened:
                opened.write(contents)
        except FileExistsError:
            raise StudyError(f"{path}: exists already; overwrite=True replaces it") from None
        except OSError as error:
            raise StudyError(f"{path}: cannot be written: {error}") from error
        return path

    def _contents(self, path: pathlib.Path) -> bytes:
        """The bytes of the file."""
        if path.suffix.lower() == ".svg":
            return self.svg.encode()
        if self._drawn is None:
            raise StudyError(f"{path}: a picture that was not made by plot has the extension .svg only")
        return self._drawn(path.name)

    def _repr_svg_(self) -> str:
        return self.svg

    def __repr__(self) -> str:
        return f"<cocarry.Picture, {len(self.svg)} bytes of SVG>"


def compare(
    *results: Any,
    by: str | None = None,
    over: str | Sequence[str] = (),
    quantities: str | Sequence[str] = (),
) -> Table:
    """Compares results pair by pair: the same world, seed and human, under two methods, policies or other inputs.

    results: tables of ``sweep``, data frames of polars or pandas with all their columns, and files of results. Rows are
        paired across all of them; a row that is there twice counts once.
    by: the input whose values are compared, all others being equal; by default the method, and the choice of the pose.
    over: inputs over which each human's differences are averaged, so that a human counts once: ``over="world"``.
    quantities: columns of figures; by default J (``accumulated_objective_cost_m``) and C (``accumulated_control_cost``).

    Returns a row for every two combinations and every quantity, with: the inputs that both have, as far as they vary;
    ``quantity``, ``first``, ``second``; ``pairs``, the number of seeds with which both arrived; ``difference``, the mean
    of first minus second, with its 95 % interval (``difference_low``, ``difference_high``; Student's t) and ``std``;
    ``effect_size``, the mean over the standard deviation; ``p_value`` of the two-sided paired t-test, and ``p_holm``,
    corrected by Holm's method for all rows; ``share_lower``, the share of pairs in which the first is lower;
    ``arrived_both``, ``arrived_first_only``, ``arrived_second_only`` and ``arrived_none``. Interval, effect size and
    p-values are missing where outcomes do not vary: all humans make the same choices, so there is one outcome, however
    often it was repeated.

    Warns of rows that could not be checked. Raises StudyError with what would be right.
    """
    if by is not None:
        _arguments.word("by", by, "the name of an input, or None", StudyError)
    lists = [_arguments.words(name, given, "a column", StudyError) for name, given in (("over", over), ("quantities", quantities))]
    table, notes = _cocarry.compare(_given(results), by, *lists)
    return _noted(table, notes)


def summary(*results: Any) -> Table:
    """Means over humans of every combination of results, which are given as to ``compare``.

    Returns a row for each, with the inputs that vary; ``n`` and ``arrived``, numbers of episodes; and for every outcome
    of those that arrived ``_mean``, ``_std``, and the 95 % interval ``_low`` to ``_high``, which is missing where all
    humans make the same choices. Raises StudyError.
    """
    table, notes = _cocarry.summary(_given(results))
    return _noted(table, notes)


def bench(folder: _Path, *results: Any, worlds: bool = False) -> Table:
    """The score card of results of the benchmark's studies, which are given as to ``compare``.

    folder: the benchmark's, as ``cocarry bench FOLDER`` writes it.
    worlds: a row for every world and policy instead, with the best known result.

    Returns a row for every set and policy, best first, with ``score`` and its 95 % interval over the worlds (``score_low``,
    ``score_high``), shares in percent and means. Raises StudyError if results are not of the benchmark, of all episodes of
    a set, of this version, and as their sweep wrote them.
    """
    _arguments.flag("worlds", worlds, StudyError)
    table, notes = _cocarry.bench(_arguments.file("folder", folder, StudyError), _given(results), worlds)
    return _noted(table, notes)


def plot(
    *results: Any,
    kind: Literal["means", "differences", "map"] = "means",
    quantity: str = "accumulated_objective_cost_m",
    by: str | None = None,
    cells: int = 12,
    width: str | None = None,
) -> Picture:
    """Draws results, which are given as to ``compare``, as ``cocarry plot`` does.

    kind: ``"means"`` with 95 % intervals; ``"differences"`` between what is compared ``by`` an input, paired by seed;
        ``"map"``: means over the humans' alpha and gamma, each in ``cells`` intervals.
    quantity: the column that is drawn.
    width: of the picture, in inches or pixels: ``"3.5in"``, ``"1200px"``. Type is at least 7 pt from 3.5 inches on. By
        default an SVG has 720 pixels, and a PDF or PNG that is saved 7 inches.

    ``plot(...).save("means.pdf")`` writes it as SVG, PDF or PNG. Raises StudyError.
    """
    _arguments.word("kind", kind, "one of: means, differences, map", StudyError)
    _arguments.word("quantity", quantity, "a column", StudyError)
    if by is not None:
        _arguments.word("by", by, "the name of an input, or None", StudyError)
    if width is not None:
        _arguments.word("width", width, 'a text, inches or pixels, as in "3.5in" or "1200px"', StudyError)
    count = _arguments.whole("cells", cells, 2, 60, StudyError)
    arguments = (_given(results), kind, quantity, by, count, width)
    svg, notes = _cocarry.plot(*arguments, "picture.svg")
    return _noted(Picture(svg.decode(), functools.partial(_drawn, arguments)), notes)


def _drawn(arguments: tuple[list[Any], str, str, str | None, int, str | None], file: str) -> bytes:
    """The bytes of a picture in the format of the file's extension; its notes were told before."""
    return _cocarry.plot(*arguments, file)[0]


def _noted(found: _Found, notes: list[str]) -> _Found:
    """What was found, after warnings of the notes."""
    for note in notes:
        warnings.warn(note, stacklevel=3)
    return found


def _given(results: Sequence[Any]) -> list[Any]:
    return [_one(one) for one in results]


def _one(result: Any) -> Any:
    if isinstance(result, Table):
        return result
    if isinstance(result, (str, os.PathLike)):
        return _arguments.file("results", result, StudyError)
    return _frame(result)


def _frame(frame: Any) -> tuple[list[str], list[list[str]]]:
    """Names and cells of a data frame, as texts."""
    names = getattr(frame, "column_names", None) or getattr(frame, "columns", None)
    if names is None or not hasattr(frame, "__getitem__"):
        raise StudyError(
            f"results: {type(frame).__name__} is not a table of sweep, a data frame or a file; expected one of these"
        )
    lists = []
    for name in names:
        column = frame[name]
        listed = next((getattr(column, a) for a in ("to_list", "to_pylist", "tolist") if hasattr(column, a)), None)
        lists.append([_cell(value) for value in (listed() if listed is not None else column)])
    return [str(name) for name in names], lists


def _cell(value: Any) -> str:
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return ""
    return str(value).lower() if isinstance(value, bool) else str(value)
