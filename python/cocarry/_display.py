"""Tables as notebooks and terminals show them: what varied and what came out, then what was the same in all rows."""

from __future__ import annotations

import html
import math
import textwrap
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cocarry import _cocarry
from cocarry._cocarry import Table

_ROWS = 20
"""Rows shown in a notebook, and of a short table in a terminal."""

_FIRST, _WIDTH, _WIDEST = 5, 80, 40
"""In a terminal: rows shown of a long table, characters of a line, and of a cell."""

_PROVENANCE = ("episode", "episodes", "study", "arithmetic", "checksum", "policy_code", "human_code")
_INPUTS = ("world", "plant", "method", "human_model")
"""Inputs that are shown first."""
_DRAWN = ("seed", "alpha", "gamma", "preference_changes")
_OUTCOMES = (
    "outcome",
    "accumulated_objective_cost_m",
    "accumulated_subjective_cost",
    "accumulated_control_cost",
    "time_s",
    "first_option",
    "last_option",
    "transition_time_s",
    "peak_force_n",
)
"""Outcomes that are shown; a page with all of them would be four screens wide."""


def _missing(column: NDArray[Any]) -> NDArray[np.bool_]:
    if column.dtype.kind == "O":
        return np.array([value is None for value in column], dtype=np.bool_)
    found: NDArray[np.bool_] = np.isnan(column)
    return found


def _values(column: NDArray[Any]) -> int:
    """The number of different values, a missing one among them."""
    missing = _missing(column)
    return len(set(column[~missing].tolist())) + bool(missing.any())


def _is_empty(column: NDArray[Any]) -> bool:
    return len(column) > 0 and bool(_missing(column).all())


def _is_sweep(names: Sequence[str]) -> bool:
    return {*_PROVENANCE, "world", "method", "seed"} <= set(names)


class _Shown:
    """The columns of a table in the order in which they are shown."""

    def __init__(self, table: Table) -> None:
        self.table, self.rows = table, len(table)
        names = table.columns
        self.varied: list[tuple[str, int]] = []
        self.same: list[tuple[str, Any]] = []
        self.columns = {name: table[name] for name in names}
        if not _is_sweep(names):
            self.names = [name for name, column in self.columns.items() if not _is_empty(column)]
            return
        outcomes = _cocarry.quantities("episode")
        others = [name for name in names if name not in (*_PROVENANCE, *_INPUTS, *_DRAWN, *outcomes)]
        for name in (*_INPUTS, *others, *_DRAWN):
            count = _values(self.columns[name])
            if count > 1:
                self.varied.append((name, count))
            elif self.rows and name in (*_INPUTS, "eta", *_DRAWN) and not _is_empty(self.columns[name]):
                self.same.append((name, self.columns[name][0]))
        self.names = [*(name for name, _ in self.varied), *(name for name in _OUTCOMES if not _is_empty(self.columns[name]))]

    def sizes(self) -> str:
        """How many values the varied inputs have: ``world (2), method (3), seed (50)``."""
        drawn = _DRAWN[1:] if any(name == "seed" for name, _ in self.varied) else ()
        return ", ".join(f"{name} ({count})" for name, count in self.varied if name not in drawn)


def text(table: Table) -> str:
    """A line: rows, columns, and for a sweep what varied."""
    sizes = _Shown(table).sizes()
    return f"<cocarry.Table, {len(table)} rows, {len(table.columns)} columns{'; varied: ' if sizes else ''}{sizes}>"


def _cell(value: Any) -> str:
    if value is None:
        return ""
    if not isinstance(value, (float, np.floating)):
        return str(value)
    number = float(value)
    if math.isnan(number):
        return ""
    # six digits tell rows apart, two a p-value; all of them are in the column
    small, large = 0 < abs(number) < 1e-4, 1e5 <= abs(number) < 1e15
    return f"{number:.1e}" if small else f"{number:.0f}" if large else f"{number:.6g}"


def rows(table: Table) -> str:
    """Lines for a terminal: of a comparison, its figures; of other tables, rows, columns, and the first of both."""
    if len(table) <= _ROWS and {*_COMPARED} <= {*table.columns}:
        return "\n".join(_comparison(table))
    shown = _Shown(table)
    count = shown.rows if shown.rows <= _ROWS else _FIRST
    columns = [
        _Column(name, [_cell(value) for value in shown.columns[name][:count]], shown.columns[name].dtype.kind == "O")
        for name in (shown.names if count else [])
    ]
    while columns and _widths(columns, _WIDEST) is None:
        columns.pop()
    lines = [*textwrap.wrap(text(table), _WIDTH, break_on_hyphens=False), *_lines(columns, _WIDEST)]
    if count and (count < shown.rows or len(columns) < len(table.columns)):
        lines.append(f"{count} of {shown.rows} rows, {len(columns)} of {len(table.columns)} columns; table.columns lists all")
    return "\n".join(lines)


_COMPARED = ("quantity", "first", "second", "pairs", "difference", "difference_low", "difference_high", "p_holm")
"""The columns of a comparison that are shown in a terminal, after the inputs that both have."""


class _Column:
    """A column of a terminal: texts can be cut, and are at the left."""

    def __init__(self, head: str, cells: list[str], is_text: bool) -> None:
        # a line break or a control character of a name is none of the terminal's
        self.cells = ["".join(c if c.isprintable() else "?" for c in cell) for cell in (head, *cells)]
        self.is_text = is_text

    def line(self, row: int, width: int) -> str:
        cell = self.cells[row]
        cell = cell if len(cell) <= width else cell[: width - 1] + "…"
        return cell.ljust(width) if self.is_text else cell.rjust(width)


def _widths(columns: Sequence[_Column], least: int) -> list[int] | None:
    """The widths of columns on a line, where texts longer than ``least`` may be cut to that; None if there is no room."""
    widths = [min(_WIDEST, max(map(len, column.cells))) for column in columns]
    while sum(widths) + 2 * (len(widths) - 1) > _WIDTH:
        width, i = max(((width, i) for i, width in enumerate(widths) if columns[i].is_text), default=(0, 0))
        if width <= least:
            return None
        widths[i] -= 1
    return widths


def _lines(columns: Sequence[_Column], least: int) -> list[str]:
    widths = _widths(columns, least) or [_WIDEST] * len(columns)
    count = len(columns[0].cells) if columns else 0
    return ["  ".join(column.line(row, width) for column, width in zip(columns, widths)).rstrip() for row in range(count)]


def _comparison(table: Table) -> list[str]:
    """A few figures of every row, under the names of the quantities."""
    found = {name: table[name] for name in table.columns}
    inputs = [name for name in table.columns[: table.columns.index("quantity")] if name not in _PROVENANCE]
    lines = []
    for quantity in dict.fromkeys(found["quantity"]):
        of_it = [row for row, name in enumerate(found["quantity"]) if name == quantity]
        names = [f"{found['first'][row]} - {found['second'][row]}" for row in of_it]
        ends = [[_short(found[name][row]) for name in ("difference_low", "difference_high")] for row in of_it]
        # names that are those of all rows are told once
        is_one = len(set(names)) == 1
        same = [] if is_one else [_Column("first - second", names, True)]
        same += [_Column(name, [_cell(found[name][row]) for row in of_it], found[name].dtype.kind == "O") for name in inputs]
        figures = [
            _Column("n", [str(int(found["pairs"][row])) for row in of_it], False),
            _Column("difference", [_short(found["difference"][row]) for row in of_it], False),
            _Column("95 % interval", ["-" if "-" in pair else " to ".join(pair) for pair in ends], False),
            _Column("p (Holm)", [_short(found["p_holm"][row], 2) for row in of_it], False),
        ]
        while len(same) > 1 and _widths([*same, *figures], 12) is None:
            same.pop()
        head = _Column(f"{quantity}: {names[0]}" if is_one else str(quantity), [], True)
        lines += [head.line(0, _WIDTH).rstrip(), *_lines([*same, *figures], 12), ""]
    return [*lines, f"{len(table)} rows; {len(table.columns)} columns, table.columns lists all"]


def _short(number: float, digits: int = 4) -> str:
    """A number with a few digits, or a dash where it is missing."""
    if math.isnan(number):
        return "-"
    return f"{number:.0f}" if 1e4 <= abs(number) < 1e9 else f"{number:.{digits}g}"


def page(table: Table) -> str:
    """The first rows as HTML."""
    shown = _Shown(table)
    about = table.metadata
    parts = []
    if shown.varied or shown.same:
        same = ", ".join(f"{name} {_cell(value)}" for name, value in shown.same)
        words = [f"{shown.rows} episodes"]
        words += [f"varied: {shown.sizes()}"] if shown.varied else []
        words += [f"the same in all: {same}"] if same else []
        parts.append(f"<p>{html.escape('; '.join(words))}</p>")
    heads = []
    for name in shown.names:
        known = about.get(name, {})
        title = " ".join(known[key] for key in ("description",) if known.get(key))
        heads.append(f'<th title="{html.escape(title)}">{html.escape(name)}</th>' if title else f"<th>{html.escape(name)}</th>")
    parts.append(f"<table><thead><tr>{''.join(heads)}</tr></thead><tbody>")
    for row in range(min(shown.rows, _ROWS)):
        cells = (html.escape(_cell(shown.columns[name][row])) for name in shown.names)
        parts.append(f"<tr>{''.join(f'<td>{cell}</td>' for cell in cells)}</tr>")
    parts.append("</tbody></table>")
    notes = [f"{_ROWS} of {shown.rows} rows"] if shown.rows > _ROWS else []
    if len(shown.names) < len(table.columns):
        notes.append(f"{len(shown.names)} of {len(table.columns)} columns, <code>table.columns</code> lists all")
    return "".join(parts) + (f"<p>{'; '.join(notes)}</p>" if notes else "")
