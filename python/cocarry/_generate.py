"""Writes ``_settings.py``, the types of a scenario's settings, from the library's table of settings.

    python -m cocarry._generate python/cocarry/_settings.py
"""

import pathlib
import sys

from cocarry import _cocarry


def text() -> str:
    """The contents of ``_settings.py``."""
    lines = [
        '"""The settings of a scenario. Written by ``python -m cocarry._generate`` from the library\'s table; not by hand."""',
        "",
        "from typing import Literal, TypedDict",
        "",
        "",
        "class Settings(TypedDict, total=False):",
        '    """Keywords of Scenario: every setting of an episode."""',
    ]
    for key, about in _cocarry.settings().items():
        words = about["words"]
        kind = f"Literal[{', '.join(map(repr, words))}]" if words else about["type"]
        default = "" if about["default"] is None else f" Default: {about['default']}."
        lines += ["", f"    {key}: {kind}", f'    """{about["about"]}.{default}"""']
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    pathlib.Path(sys.argv[1]).write_text(text(), encoding="utf-8")
