"""Finds, names and models what a radio telescope's pointing model leaves out."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pyport.api import diagnose as diagnose
    from pyport.api import fit as fit
    from pyport.api import load_model as load_model
    from pyport.api import look as look
    from pyport.watch import Watch as Watch

__version__ = "0.1.0"

_LAZY = dict.fromkeys(("diagnose", "fit", "load_model", "look"), "api") | {"Watch": "watch"}


def __getattr__(name: str) -> Any:  # noqa: ANN401 - whatever the name stands for
    """Import what is asked for when it is asked for: `import pyport` itself stays light."""
    if name not in _LAZY:
        raise AttributeError(f"module 'pyport' has no attribute {name!r}")
    import importlib

    return getattr(importlib.import_module(f"pyport.{_LAZY[name]}"), name)


def __dir__() -> list[str]:
    """Return the public names, those not imported yet among them."""
    return sorted({"__version__", *_LAZY})
