"""The model with waves over the whole sky, for steering: predicted offsets with their errors."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from pyport.angles import ARCSEC, DEG
from pyport.effects.base import Circumstances, MissingColumn
from pyport.errors import BadInput
from pyport.files import write_whole
from pyport.models.model import Model
from pyport.prediction import shrunk, waves
from pyport.prediction.contenders import Night
from pyport.recordings.schema import Recordings

#: Steps of the grid.
AZIMUTH_DEG, ELEVATION_DEG = 10, 5
_NAMES = ("az_deg", "el_deg", "d_xel_arcsec", "sigma_xel_arcsec", "d_el_arcsec", "sigma_el_arcsec")


def write_grid(recordings: Recordings, model: Model, path: Path) -> None:
    """Write the model with waves over the elevations that were observed, and its errors.

    The file is one of recordings as any other. An axis that was not measured is left blank.
    Errors are those of the prediction; the scatter of a single pointing comes on top.

    Raises `BadInput`: there are several antennas, or a term asks for more than a direction.
    """
    night = Night.of(recordings)
    row = night.stack.row
    known = shrunk.Known(
        night.columns(model),
        waves.columns(recordings.at)[row],
        night.stack.is_y,
        night.value(model),
    )
    found = shrunk.fit(known)
    low, high = recordings.at.el.min() / DEG, recordings.at.el.max() / DEG
    heights = (
        np.arange(np.ceil(low / ELEVATION_DEG), np.floor(high / ELEVATION_DEG) + 1)
        * ELEVATION_DEG
        * DEG
    )
    az, el = (one.ravel() for one in np.meshgrid(np.arange(0, 360, AZIMUTH_DEG) * DEG, heights))
    at = Circumstances(az, el, recordings.at.site, mount=recordings.at.mount)
    given = model.offsets(at)
    try:
        columns = [term.effect.columns(at) for term in model.fitted()]
    except MissingColumn as lack:
        raise BadInput(f"{model.name} {lack}: a grid of directions has none") from None
    shapes = waves.columns(at)
    told = []
    for axis in (0, 1):
        own = np.concatenate([np.zeros((len(at), 0)), *(both[axis] for both in columns)], axis=1)
        there = shrunk.Known(own, shapes, np.full(len(at), axis == 1), given[axis])
        value = found.predict(there) + given[axis]
        wide = there.columns()
        sigma = np.sqrt(np.einsum("mk,mk->m", wide @ found.covariance, wide))
        measured = bool(axis) in found.noise
        told += [
            [f"{one / ARCSEC:.3f}" if measured else "" for one in both] for both in (value, sigma)
        ]
    with write_whole(path) as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(_NAMES)
        places = [[f"{one / DEG:g}" for one in both] for both in (az.round(9), el.round(9))]
        writer.writerows(zip(*places, *told, strict=True))
