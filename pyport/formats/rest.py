"""What another program's file cannot hold of a model: its size, and a grid of corrections."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from pyport.angles import ARCSEC, DEG, Array
from pyport.effects import Circumstances
from pyport.errors import BadInput
from pyport.files import write_whole
from pyport.formats.model_file import ModelFile
from pyport.formats.waves import Waves
from pyport.models.conditions import columns_of
from pyport.models.model import Model

#: Steps of a correction grid, and the sky that it covers [deg].
GRID_STEP_DEG, LOWEST_DEG = 2.0, 2.0


@dataclass(frozen=True)
class Rest:
    """What a format cannot hold of a model."""

    names: tuple[str, ...] = ()  #: the terms, and the RT32's exact form where the model has it
    #: Their rms on the sky, both axes together, None where it depends on more than directions.
    rms_arcsec: float | None = 0.0
    grid: Path | None = None  #: where they were written to, None where they were left out
    #: What stands in the file for fields without a name.
    waves: Waves = field(default_factory=Waves)

    @property
    def words(self) -> str:
        """Return it as a sentence, "" for nothing."""
        if not self.names:
            return self.waves.words
        size = ""
        if self.rms_arcsec is not None:
            size = f", {self.rms_arcsec:.3g} arcsec rms over the sky"
        where = "left out" if self.grid is None else f"in {self.grid}"
        return f"{where}: {', '.join(self.names)}{size}"


def sky() -> tuple[tuple[Array, Array], Circumstances]:
    """Return the directions of a correction grid [deg], shape (n,), and the same as pointings."""
    az_deg, el_deg = (
        one.ravel()
        for one in np.meshgrid(
            np.arange(0.0, 360.0, GRID_STEP_DEG),
            np.arange(LOWEST_DEG, 90.0, GRID_STEP_DEG),
            indexing="ij",
        )
    )
    return (az_deg, el_deg), Circumstances(az_deg * DEG, el_deg * DEG)


def rest_of(
    model: Model,
    file: ModelFile,
    lost: Sequence[str],
    path: Path | None,
    conditions: Mapping[str, Any],
) -> Rest:
    """Return what a file lacks of a model, and write it where a path is given.

    Raises `BadInput`: it has to be written and depends on more than directions.
    """
    if not lost:
        return Rest()
    (az_deg, el_deg), all_sky = sky()
    needed = {name for term in model.terms for name in term.effect.needs}
    told = columns_of(conditions, needed)
    columns = {name: np.broadcast_to(one, len(all_sky)) for name, one in told.items()}
    at = replace(all_sky, site=model.site, columns=columns)
    try:
        x, y = (
            one - other
            for one, other in zip(model.offsets(at), file.model("held").offsets(at), strict=True)
        )
    except BadInput as error:
        if path is None:
            return Rest(tuple(lost), None)
        wanted = "a grid of directions tells none: --set COLUMN=VALUE gives one value for all"
        raise BadInput(f"{error.message}; {wanted}", path) from None
    weight = np.cos(at.el)
    rms = float(np.sqrt(((x**2 + y**2) * weight).sum() / weight.sum())) / ARCSEC
    if path is not None:
        _write_grid(path, az_deg, el_deg, (x / ARCSEC, y / ARCSEC), lost, conditions)
    return Rest(tuple(lost), rms, path)


def _write_grid(
    path: Path,
    az_deg: Array,
    el_deg: Array,
    offsets_arcsec: tuple[Array, Array],
    names: Sequence[str],
    conditions: Mapping[str, Any],
) -> None:
    """Write corrections on a grid, as recordings are written."""
    with write_whole(path) as out:
        out.write(f"# corrections: {', '.join(names)}\n# azimuth_zero: north\n")
        out.writelines(f"# {name}: {value}\n" for name, value in conditions.items())
        out.write("az_deg,el_deg,d_xel_arcsec,d_el_arcsec\n")
        for row in zip(az_deg, el_deg, *offsets_arcsec, strict=True):
            out.write(f"{row[0]:g},{row[1]:g},{row[2]:.6f},{row[3]:.6f}\n")
