"""Writes the reference of the Python package: python3 site/python.py FOLDER.

The package is imported without its native module, whose place its stub takes: documentation and types stand there, and
stubtest holds it against the module (python/check).
"""

import pathlib
import shutil
import sys
import tempfile
import urllib.parse

import pdoc

SITE = pathlib.Path(__file__).resolve().parent
MODULES = ["cocarry", "cocarry.environments", "cocarry.pettingzoo", "cocarry.datasets"]

with tempfile.TemporaryDirectory() as name:
    folder = pathlib.Path(name)
    package = folder / "cocarry"
    shutil.copytree(SITE.parent / "python/cocarry", package, ignore=shutil.ignore_patterns("*.so"))
    stub = (package / "_cocarry.pyi").read_text()
    # annotations stay text; what modules use while they are imported has a value
    title, rest = stub.split("\n", 1)
    (package / "_cocarry.py").write_text(f'{title}\nfrom __future__ import annotations\n{rest}\n__version__ = ""\n')
    sys.path.insert(0, name)

    import cocarry._cocarry as native

    quantities, native.quantities = native.quantities, lambda *_: {}
    import cocarry.datasets  # noqa: F401 - pydoc documents it, too
    import cocarry.environments as environments

    native.quantities = quantities
    # what the environments have in common
    for base in [environments._Resumable, environments._Env, environments._VectorEnv]:
        environments.__all__.append(base.__name__)
        base.__doc__ = f"{base.__doc__}\n\n@public"
    icon = "data:image/svg+xml," + urllib.parse.quote((SITE / "theme/favicon.svg").read_text())
    pdoc.render.configure(docformat="google", show_source=False, favicon=icon)
    pdoc.pdoc(*MODULES, output_directory=pathlib.Path(sys.argv[1]))
