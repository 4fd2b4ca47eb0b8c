"""Finds, names and models what a radio telescope's pointing model leaves out."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pyport.api import diagnose, fit, look

__version__ = "0.1.0"
__all__ = ["__version__", "diagnose", "fit", "look"]

_LAZY = frozenset({"diagnose", "fit", "look"})


def __getattr__(name: str) -> Any:  # noqa: ANN401 - whatever the name stands for
    """Import what is asked for when it is asked for: `import pyport` itself stays light."""
    if name not in _LAZY:
        raise AttributeError(f"module 'pyport' has no attribute {name!r}")
    from pyport import api

    return getattr(api, name)


def __dir__() -> list[str]:
    """Return the public names, those not imported yet among them."""
    return sorted(__all__)
