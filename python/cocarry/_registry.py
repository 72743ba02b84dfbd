"""Policies and humans that installed packages register, by entry point."""

from __future__ import annotations

from importlib.metadata import EntryPoint, entry_points
from typing import Any

from cocarry._cocarry import DecisionError
from cocarry._identity import code_of

#: The groups of entry points, by what they register.
GROUPS = {"policy": "cocarry.policies", "human": "cocarry.humans"}


def registered(what: str) -> dict[str, EntryPoint]:
    """The registered policies (``"policy"``) or humans (``"human"``), by name. Of two packages that register one name,
    the first one found counts, as Python finds modules."""
    found: dict[str, EntryPoint] = {}
    for point in entry_points(group=GROUPS[what]):
        found.setdefault(point.name, point)
    return found


def load(what: str, name: str) -> Any:
    """The registered policy or human of that name. Raises DecisionError."""
    known = registered(what)
    if name not in known:
        there = ", ".join(sorted(known)) or "none is"
        own = {
            "policy": 'a method of the program belongs to the scenario: Scenario(..., method="mutual")',
            "human": 'a human model of the program belongs to the scenario: Scenario(..., human_model="boltzmann(2)")',
        }
        raise DecisionError(
            f"{what} = {name!r}; it must be a callable, an object with a method decide(view), a class of such objects, or the "
            f"name of one that a package registers ({there}); {own[what]}"
        )
    try:
        return known[name].load()
    except Exception as error:
        raise DecisionError(f"{what} = {name!r}: {known[name].value} cannot be loaded: {error!r}") from error


def listed() -> list[tuple[str, str]]:
    """The names of the registered policies, each with the package that it is from."""

    def about(point: EntryPoint) -> str:
        return f"of the package {point.dist.name} {point.dist.version}" if point.dist is not None else f"of {point.value}"

    return [(name, about(point)) for name, point in sorted(registered("policy").items())]


def version(what: str, name: str) -> str | None:
    """The version of the package of a registered policy or human."""
    point = registered(what).get(name)
    return point.dist.version if point is not None and point.dist is not None else None


def code(name: str) -> str:
    """Version and digest of a registered policy."""
    return code_of(load("policy", name), version("policy", name))
