"""Whether the compiled kernel is there; nothing else is imported to find out.

It is a distribution of its own, `pyport-pointing-kernel`, that `make wheel` builds from
`kernel_src`. PYPORT_KERNEL=off leaves it out, PYPORT_KERNEL=required insists on it, and the name
of an instruction set, such as AVX2, lets it use no newer one.
"""

from __future__ import annotations

import os
from types import ModuleType

#: What `module.c` must offer; raised with it, so that an older kernel is left out.
INTERFACE = 5


def _installed() -> ModuleType | None:
    """Return the kernel, None where it is not installed or not wanted."""
    wish = os.environ.get("PYPORT_KERNEL", "")
    if wish == "off":
        return None
    try:
        import pyport_kernel as found
    except ImportError:
        if wish == "required":
            raise
        return None
    if getattr(found, "INTERFACE", 1) == INTERFACE:
        if wish in found.levels():
            found.choose(wish)
        return found
    if wish == "required":
        raise ImportError("pyport-pointing-kernel is of another version")
    return None


#: The kernel, None where numpy does the work.
KERNEL = _installed()
