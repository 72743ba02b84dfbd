"""The Python on the book's page and in the README runs."""

from __future__ import annotations

import os
import pathlib
import re

import pytest

HERE = pathlib.Path(__file__).parents[1]
BESIDE = [HERE.parent / "book" / "src" / "python.md", HERE / "README.md", HERE.parent / "README.md"]
PAGES = sorted(pathlib.Path(os.environ["PAGES"]).glob("*.md")) if "PAGES" in os.environ else BESIDE


@pytest.mark.parametrize("page", PAGES, ids=lambda page: f"{page.parent.name}/{page.name}")
def test_the_blocks_of_a_page_run_in_order(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MINARI_DATASETS_PATH", "minari")
    text = page.read_text(encoding="utf-8")
    blocks = list(re.finditer(r"^```python\n(.*?)^```", text, re.MULTILINE | re.DOTALL))
    assert blocks
    session = {"__name__": "page"}
    for block in blocks:
        line = text.count("\n", 0, block.start(1))
        exec(compile("\n" * line + block[1], str(page), "exec"), session)


def test_the_readme_of_the_wheel_names_no_file_next_to_it():
    text = next(page for page in (*PAGES, HERE / "README.md") if page.name == "README.md" and page.parent != HERE.parent).read_text(encoding="utf-8")
    assert [link for link in re.findall(r"\]\(([^)]+)\)", text) if not link.startswith("https://")] == []


def test_the_examples_that_pages_name_are_there():
    named = {name for page in PAGES for name in re.findall(r"python/examples/(\w+\.py)", page.read_text(encoding="utf-8"))}
    assert "own_human.py" in named
    assert named <= {path.name for path in (HERE / "examples").glob("*.py")}


def test_the_settings_are_written_from_the_table():
    import cocarry._generate
    import cocarry._settings

    written = pathlib.Path(cocarry._settings.__file__).read_text(encoding="utf-8")
    assert written == cocarry._generate.text(), "run: python -m cocarry._generate python/cocarry"


def test_the_stub_has_the_documentation_of_the_native_module():
    import cocarry._generate

    written = pathlib.Path(cocarry.__file__).with_name("_cocarry.pyi").read_text(encoding="utf-8")
    assert written == cocarry._generate.stub(written), "run: python -m cocarry._generate python/cocarry"
