"""Writes ``_settings.py``, the types of a scenario's settings, from the library's table of settings, and the documentation
in ``_cocarry.pyi`` from that of the native module.

    python -m cocarry._generate python/cocarry
"""

import ast
import inspect
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


def stub(before: str) -> str:
    """The contents of ``_cocarry.pyi``, with the documentation that the native module has."""
    lines = before.splitlines()
    for node, documented in reversed(_documented(before)):
        first = node.body[0]
        doc = inspect.getdoc(documented) or ""
        begin, end = first.lineno - 1, first.end_lineno or first.lineno
        lines[begin:end] = _docstring(doc, " " * first.col_offset)
    return "\n".join(lines) + "\n"


def _documented(text: str) -> list[tuple[ast.ClassDef | ast.FunctionDef, object]]:
    """What has a docstring in a stub, with the object of the native module, from the first line to the last."""
    found: list[tuple[ast.ClassDef | ast.FunctionDef, object]] = []
    for node in ast.parse(text).body:
        if not isinstance(node, (ast.ClassDef, ast.FunctionDef)):
            continue
        documented = getattr(_cocarry, node.name)
        if ast.get_docstring(node) is not None:
            found.append((node, documented))
        for member in node.body if isinstance(node, ast.ClassDef) else []:
            if isinstance(member, ast.FunctionDef) and ast.get_docstring(member) is not None:
                found.append((member, getattr(documented, member.name)))
    return found


def _docstring(doc: str, indent: str) -> list[str]:
    first, *rest = doc.splitlines() or [""]
    lines = [indent + '"""' + first, *(indent + line if line else "" for line in rest)]
    # a last line with the quotes on it has room for them
    if not rest or len(lines[-1]) + 3 <= 120:
        lines[-1] += '"""'
    else:
        lines.append(indent + '"""')
    return lines


def main(folder: pathlib.Path) -> None:
    """Writes both files."""
    (folder / "_settings.py").write_text(text(), encoding="utf-8")
    native = folder / "_cocarry.pyi"
    native.write_text(stub(native.read_text(encoding="utf-8")), encoding="utf-8")


if __name__ == "__main__":
    main(pathlib.Path(sys.argv[1]))
