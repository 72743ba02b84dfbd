"""What can be known of a custom partner's code: a version, and a digest.

The digest covers the bytecode of functions and classes with their constants, defaults and closures, the state of
objects, and what the code names in its module: functions and classes of the same package likewise, other packages by
their versions, data by value. It is of one minor version of Python, whose bytecode it covers. What only happens when the
code runs, such as a file that it reads, is not covered.
"""

from __future__ import annotations

import hashlib
import sys
import types
from collections.abc import Iterable
from importlib import metadata
from typing import Any


#: Attributes of classes that say nothing about their code. A copy of an object leaves `__slotnames__` in its class.
_NO_CODE = frozenset(
    ["__dict__", "__weakref__", "__doc__", "__module__", "__firstlineno__", "__static_attributes__", "__slotnames__"]
)


class _Digest:
    """A digest of objects, each visited once."""

    def __init__(self, root: str) -> None:
        self.hash = hashlib.sha256(f"{sys.version_info.major}.{sys.version_info.minor}".encode())
        self.root = root
        #: Everything visited stays alive, so that no address is used twice.
        self.known: dict[int, tuple[int, Any]] = {}

    def text(self, *texts: object) -> None:
        for text in texts:
            data = str(text).encode("utf-8", "surrogatepass")
            self.hash.update(len(data).to_bytes(8, "little") + data)

    def add(self, given: Any) -> None:
        if given is None or isinstance(given, (bool, int, float, complex, str, bytes)) or given is Ellipsis:
            self.text(type(given).__name__, repr(given))
            return
        # constants may be one object or several equal ones, as Python compiled or loaded them
        if not isinstance(given, (tuple, frozenset, types.CodeType)):
            if id(given) in self.known:
                self.text("again", self.known[id(given)][0])
                return
            self.known[id(given)] = (len(self.known), given)
        self.text(type(given).__qualname__)
        if isinstance(given, types.ModuleType):
            self.module(given.__name__)
        elif isinstance(given, types.CodeType):
            self.code(given)
        elif isinstance(given, types.FunctionType):
            self.function(given)
        elif isinstance(given, types.MethodType):
            self.all([given.__func__, given.__self__])
        elif isinstance(given, (classmethod, staticmethod)):
            self.add(given.__func__)
        elif isinstance(given, property):
            self.all([given.fget, given.fset, given.fdel])
        elif isinstance(given, type):
            self.type(given)
        elif isinstance(given, (list, tuple)):
            self.all(given)
        elif isinstance(given, dict):
            self.all(part for pair in given.items() for part in pair)
        elif isinstance(given, (set, frozenset)):
            self.text(*sorted(_of(item, self.root) for item in given))
        else:
            self.state(given)

    def all(self, parts: Iterable[Any]) -> None:
        parts = list(parts)
        self.text(len(parts))
        for part in parts:
            self.add(part)

    def is_near(self, module: str) -> bool:
        """Whether a module belongs to the package of the partner."""
        return module.partition(".")[0] == self.root

    def module(self, name: str) -> None:
        self.text("module", name, _version_of(name.partition(".")[0]))

    def code(self, code: types.CodeType) -> None:
        self.text(code.co_code.hex(), *code.co_names, *code.co_varnames, *code.co_freevars)
        self.all(code.co_consts)

    def function(self, function: types.FunctionType) -> None:
        if not self.is_near(function.__module__ or ""):
            self.text(function.__qualname__)
            self.module(function.__module__ or "")
            return
        self.add(function.__code__)
        self.all([function.__defaults__, function.__kwdefaults__])
        cells = function.__closure__ or ()
        self.all(cell.cell_contents for cell in cells if cell != types.CellType())
        named = _names(function.__code__)
        for name in sorted(named & function.__globals__.keys()):
            self.text(name)
            self.add(function.__globals__[name])

    def type(self, given: type) -> None:
        self.text(given.__module__, given.__qualname__)
        if not self.is_near(given.__module__):
            self.module(given.__module__)
            return
        self.all(base for base in given.__mro__[1:] if base is not object)
        for name, part in sorted(vars(given).items()):
            if name not in _NO_CODE:
                self.text(name)
                self.add(part)

    def state(self, given: Any) -> None:
        self.add(type(given))
        if isinstance(given, types.BuiltinFunctionType):
            self.text(given.__module__, given.__qualname__)
            return
        try:
            reduced = given.__reduce_ex__(4)
        except Exception:
            self.text("opaque")
            return
        if isinstance(reduced, str):
            self.text(reduced)
            return
        parts = [list(part) if hasattr(part, "__next__") else part for part in reduced[1:5]]
        self.add(getattr(reduced[0], "__qualname__", ""))
        self.all(parts)


def _names(code: types.CodeType) -> set[str]:
    """The names that code and the code within it read."""
    within = [_names(part) for part in code.co_consts if isinstance(part, types.CodeType)]
    return set(code.co_names).union(*within)


def _version_of(package: str) -> str:
    if package in sys.stdlib_module_names:
        return ""
    loaded = getattr(sys.modules.get(package), "__version__", None)
    if isinstance(loaded, str):
        return loaded
    try:
        return metadata.version(package)
    except Exception:
        return ""


def _of(given: Any, root: str) -> str:
    digest = _Digest(root)
    digest.add(given)
    return digest.hash.hexdigest()


def name_of(given: Any) -> str:
    """The name of a partner: its attribute ``name``, or that of the function or class."""
    own = getattr(given, "name", None)
    if isinstance(own, str) and own:
        return own
    return str(getattr(given, "__name__", None) or type(given).__name__)


def code_of(given: Any, version: str | None = None) -> str:
    """Version and digest of a partner: its attribute ``version`` or ``__version__`` if it has one, then 16 digits."""
    for attribute in ("version", "__version__"):
        found = getattr(given, attribute, None)
        if version is None and isinstance(found, (str, int, float)):
            version = str(found)
    module = getattr(given, "__module__", None) or type(given).__module__
    digest = _of(given, str(module).partition(".")[0])[:16]
    return digest if version is None else f"{version} {digest}"
