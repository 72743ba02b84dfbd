"""Tables as notebooks and terminals show them: what varied and what came out, then what was the same in all rows."""

from __future__ import annotations

import html
import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cocarry import _cocarry
from cocarry._cocarry import Table

_ROWS = 20
"""Rows shown in a notebook."""

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
