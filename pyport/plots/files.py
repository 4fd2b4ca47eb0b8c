"""Figures into files: the same figure gives the same bytes."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from pyport.files import write_whole

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: Format -> what else would be stamped on a file, and is not.
FORMATS: dict[str, dict[str, Any]] = {
    "pdf": {"CreationDate": None, "ModDate": None, "Producer": None, "Creator": None},
    "png": {"Software": None},
    "svg": {"Date": None, "Creator": None},
}
DPI = 200


def write(figure: Figure, path: Path) -> Path:
    """Write a figure in the format that the suffix says, whole or not at all.

    Its axes are laid out once and stay where they are.
    """
    import matplotlib as mpl

    kind = path.suffix[1:]
    # Text stays text: it can be found, copied and set in the paper's own type.
    settings = {"svg.fonttype": "none", "svg.hashsalt": "pyport", "pdf.fonttype": 42}
    layout = figure.get_layout_engine()
    if layout is not None:  # saving would draw all of it twice, and lay it out each time
        layout.execute(figure)
        figure.set_layout_engine("none")
    with mpl.rc_context(cast(Any, settings)), write_whole(path, "wb") as file:
        figure.savefig(file, format=kind, dpi=DPI, metadata=FORMATS[kind])
    return path
