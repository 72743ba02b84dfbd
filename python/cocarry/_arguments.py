"""Arguments of the package's Python functions: each is refused with its name, its value and what it must be."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Any

from cocarry._cocarry import Error

MAX_WHOLE = 2**64 - 1


def whole(name: str, given: Any, low: int, high: int = MAX_WHOLE, error: type[Error] = Error) -> int:
    """A whole number from ``low`` to ``high``."""
    is_whole = hasattr(given, "__index__") and not isinstance(given, bool) and getattr(given, "ndim", None) in (None, 0)
    if not is_whole or not low <= given.__index__() <= high:
        expected = f"of at least {low}" if high == MAX_WHOLE and low else f"from {low} to {high}"
        raise error(f"{name} = {given!r}; it must be a whole number {expected}")
    return int(given)


def flag(name: str, given: Any, error: type[Error] = Error) -> bool:
    """A flag."""
    if not isinstance(given, bool):
        raise error(f"{name} = {given!r}; it must be True or False")
    return given


def _is_text(given: Any) -> bool:
    """Whether it is a text that UTF-8 has, without lone surrogates."""
    return isinstance(given, str) and not any("\ud800" <= character <= "\udfff" for character in given)


def word(name: str, given: Any, expected: str, error: type[Error] = Error) -> str:
    """A text."""
    if not _is_text(given):
        raise error(f"{name} = {given!r}; it must be {expected}")
    return str(given)


def words(name: str, given: Any, expected: str, error: type[Error] = Error) -> list[str]:
    """A text or a list of texts."""
    items = [given] if isinstance(given, str) else given
    if not isinstance(items, Sequence) or isinstance(items, (bytes, bytearray)) or not all(map(_is_text, items)):
        raise error(f"{name} = {given!r}; it must be {expected}, or a list of them")
    return list(items)


def file(name: str, given: Any, error: type[Error] = Error) -> str:
    """The path of a file."""
    try:
        path = os.fspath(given)
        if _is_text(path) and "\0" not in path:
            return str(path)
    except TypeError:
        pass
    raise error(f"{name} = {given!r}; it must be a file: a str or a path") from None


def mapping(name: str, given: Any, error: type[Error] = Error) -> Mapping[Any, Any]:
    """A mapping."""
    if not isinstance(given, Mapping):
        raise error(f"{name} = {given!r}; it must be a mapping")
    return given
