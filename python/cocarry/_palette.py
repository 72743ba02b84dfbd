"""The colours of the program's pictures, for figures of your own that shall look like them."""

from __future__ import annotations

from cocarry import _arguments

# crates/output/src/palette.rs has them; a test compares the two
_OPTIONS = ("#0072b2", "#e69f00", "#882255", "#009e73", "#56b4e9", "#d55e00", "#cc79a7", "#111111")


def option_colour(index: int) -> str:
    """The colour of an option in every picture of the program, by its index, as ``#rrggbb``.

    Eight colours that readers with any colour vision can tell apart, the first four in grey as well; they repeat after
    eight options. Raises Error if the index is not a whole number of at least 0.
    """
    return _OPTIONS[_arguments.whole("index", index, 0) % len(_OPTIONS)]
