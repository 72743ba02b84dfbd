"""The ids of the environments in Gymnasium's registry."""

from __future__ import annotations

from typing import Any

_OLD = {"charges_failure": False, "built_in": False}

IDS: dict[str, tuple[str, dict[str, Any]]] = {
    "cocarry/Options-v0": ("Options", {}),
    "cocarry/Carry-v0": ("Carry", _OLD),
    "cocarry/Carry-v1": ("Carry", {}),
}
"""Every id, with the beginning of its classes' names in ``cocarry.environments`` and their keywords."""


def register(gymnasium: Any) -> None:
    """Registers the ids that are not there; nothing else is imported before an environment is made."""
    for name, (kind, keywords) in IDS.items():
        if name not in gymnasium.registry:
            gymnasium.register(
                name,
                entry_point=f"cocarry.environments:{kind}Env",
                vector_entry_point=f"cocarry.environments:{kind}VectorEnv",
                kwargs=dict(keywords),
            )


def register_if_installed() -> None:
    """The same, if Gymnasium is installed."""
    try:
        import gymnasium
    except ImportError:
        return
    register(gymnasium)
