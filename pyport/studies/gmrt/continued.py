"""What the scans that print has left foretell for the hours that it lost.

An elevation offset is no cosine of hour angle, so which one fits best depends
on the hours. The classical terms along elevation (the encoder's zero, a lean of
the axis, which an antenna's own place is alike, and sag) hold at all hours:
fitted to the scans that are left, they tell the offsets of those that are lost,
and so the cosine that all scans together would have given.
"""

from __future__ import annotations

import numpy as np

from pyport.angles import Array
from pyport.effects import Circumstances
from pyport.formats.models import load
from pyport.recordings import sky
from pyport.studies.gmrt.cosine import Cosine, columns
from pyport.studies.gmrt.tracks import Track, line

#: So many stretches of scans are left out in turn.
_STRETCHES = 8


def continued(
    track: Track, scanned: Array, dec: float, latitude: float
) -> tuple[Cosine, Cosine] | None:
    """Return the cosine that best fits a track gone on, with two covariances.

    None where it would be less sure than the offsets that are left are different.

    Parameters
    ----------
    track
        The scans that are left.
    scanned
        Hour angles of all scans [rad], those that are lost included.
    dec, latitude
        Of the source, and of the site [rad].

    Returns
    -------
    formal, stretches
        One curve: its covariance from the scatter of single scans, and from
        leaving out stretches of scans in turn (a jackknife), which errors that
        last for several scans do not mislead.
    """
    left = _classical(track.hour_angle, dec, latitude)
    best = np.linalg.pinv(columns(scanned)) @ _classical(scanned, dec, latitude)
    design = np.concatenate([left, track.direction[:, None]], axis=1)
    fit = line(design, track.offset)
    size = left.shape[1]
    value = best @ fit.value[:size]
    formal = Cosine(value, best @ fit.covariance[:size, :size] @ best.T)
    if np.sqrt(np.mean(formal.sigma(scanned) ** 2)) > np.ptp(track.offset):
        return None
    root = np.sqrt(fit.weight)
    without = []
    for stretch in np.array_split(np.arange(len(track)), min(_STRETCHES, len(track))):
        kept = np.delete(root, stretch)
        rows = np.delete(design, stretch, axis=0) * kept[:, None]
        wanted = np.delete(track.offset, stretch) * kept
        without.append(best @ np.linalg.lstsq(rows, wanted, rcond=None)[0][:size])
    apart = np.array(without) - np.mean(without, axis=0)
    share = (len(without) - 1) / len(without)
    return formal, Cosine(value, share * apart.T @ apart)


def _classical(hour_angle: Array, dec: float, latitude: float) -> Array:
    """Return the classical model's columns along elevation at hour angles, shape (n, 4)."""
    at = Circumstances(*sky.horizon(hour_angle, np.full(len(hour_angle), dec), latitude))
    along = np.concatenate([term.effect.columns(at)[1] for term in load("altaz").terms], axis=1)
    return along[:, np.any(along != 0, axis=0)]
