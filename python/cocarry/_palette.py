"""The colours of the program's pictures, for figures of your own that shall look like them."""

from __future__ import annotations

from cocarry import _arguments, _cocarry

_OPTIONS = _cocarry.option_colours()


def option_colour(index: int) -> str:
    """The colour of an option in every picture of the program, by its index, as ``#rrggbb``.

    Eight colours that readers with any colour vision can tell apart, the first four in grey as well; they repeat after
    eight options. Raises Error if the index is not a whole number of at least 0.
    """
    return _OPTIONS[_arguments.whole("index", index, 0) % len(_OPTIONS)]
