"""The model with waves, on a grid of directions."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from pyport.angles import ARCSEC, DEG
from pyport.effects.base import Circumstances, MissingColumn
from pyport.errors import BadInput
from pyport.files import write_whole
from pyport.models.model import Model
from pyport.mounts import ALTAZ
from pyport.prediction import shrunk
from pyport.prediction.contenders import Night, OwnChoice
from pyport.recordings.schema import Recordings

#: Steps of the grid.
AZIMUTH_DEG, ELEVATION_DEG = 10, 5
_NAMES = ("az_deg", "el_deg", "d_xel_arcsec", "sigma_xel_arcsec", "d_el_arcsec", "sigma_el_arcsec")


def write_grid(recordings: Recordings, model: Model, path: Path) -> None:
    """Write the model with waves over the elevations that were observed, and its errors.

    The file is one of recordings as any other. An axis that was not measured is left blank.
    Errors are those of the prediction; the scatter of a single pointing comes on top.

    Raises `BadInput`: there are several antennas, the mount is no alt-azimuth one, or a term asks
    for more than a direction.
    """
    if recordings.at.mount is not ALTAZ:
        wrong = f"a mount of {recordings.at.mount.id}, expected an alt-azimuth one for a grid"
        raise BadInput(wrong, recordings.file)
    night = Night.of(recordings)
    found = OwnChoice(night, model).whole
    low, high = recordings.at.el.min() / DEG, recordings.at.el.max() / DEG
    steps = np.arange(np.ceil(low / ELEVATION_DEG), np.floor(high / ELEVATION_DEG) + 1)
    heights = steps * ELEVATION_DEG if len(steps) else np.unique([low, high])
    around = np.arange(0, 360, AZIMUTH_DEG)
    az, el = (one.ravel() * DEG for one in np.meshgrid(around, heights))
    at = Circumstances(az, el, recordings.at.site, mount=recordings.at.mount)
    given = model.offsets(at)
    try:
        columns = [term.effect.columns(at) for term in model.fitted()]
    except MissingColumn as lack:
        raise BadInput(f"{model.name} {lack}: a grid of directions has none") from None
    shapes = shrunk.columns(at)
    cells = []
    for axis in (0, 1):
        own = np.concatenate([np.zeros((len(at), 0)), *(both[axis] for both in columns)], axis=1)
        there = shrunk.Known(own, shapes, np.full(len(at), axis == 1), given[axis])
        value = found.predict(there) + given[axis]
        wide = there.columns()
        sigma = np.sqrt(np.einsum("mk,mk->m", wide @ found.covariance, wide))
        measured = bool(axis) in found.noise
        cells += [
            [f"{one / ARCSEC:.3f}" if measured else "" for one in both] for both in (value, sigma)
        ]
    with write_whole(path) as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(_NAMES)
        places = [[f"{one / DEG:g}" for one in both] for both in (az.round(9), el.round(9))]
        writer.writerows(zip(*places, *cells, strict=True))
