"""Real recordings of two telescopes whose models were published by others."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from pyport.angles import ARCSEC, Array
from pyport.diagnosis.diagnose import Diagnosis, diagnose
from pyport.diagnosis.naming import words as explained
from pyport.effects import CATALOGUE
from pyport.examiner.acceptance.drawn import Line
from pyport.formats.models import load
from pyport.prediction.compare import Comparison, compare
from pyport.prediction.contenders import Night
from pyport.prediction.rehearsal import rehearse
from pyport.recordings import read
from pyport.recordings.raw import FileOptions
from pyport.recordings.schema import Recordings


def diagnosed(recordings: Recordings, model: str) -> Diagnosis:
    """Return the diagnosis of some recordings beside a model or a file of one."""
    return diagnose(recordings, load(model))


def said(found: Diagnosis) -> str:
    """Return what a diagnosis finds, in short."""
    words = [
        f"{one.effect} ({one.variant})" if one.variant else one.effect for one in found.findings
    ]
    return ", ".join(words) or "nothing"


_SITE = {"longitude_deg": "-70.7477"}
_FEW = "AT_point_file_20200315T022713.dat"
_MANY = "AT_point_data_20210609_tw003.dat"
_GOOD = "AT_point_data_20220406_tw004_corr.dat"
#: The published models of the first night, of the last with a few terms, and of many.
_FAUTO, _SIX, _FIFTEEN = (
    *("at_20200314_fauto.mod", "at_20220406_ia_ie_an_aw_tx10_ca.mod"),
    "at_20220406_fauto.mod",
)
#: The published sky rms of the six terms. [arcsec]
_SIX_RMS = 3.1416


def auxtel_lines(folder: Path) -> Iterator[Line]:
    """Yield what was published of each night, refitted, and what each model predicts."""
    few, many, good = (read(folder / one, FileOptions(_SITE)) for one in (_FEW, _MANY, _GOOD))
    altaz = load("altaz")
    yield from _published(good, folder / _SIX)
    first = compare(few, altaz, [load(str(folder / _FAUTO))], [good])
    yield from _overfit("AuxTel 2020-03-14", first)
    yield from _rehearsed("AuxTel 2020-03-14", few, folder / _FAUTO)
    last = compare(good, altaz, [load(str(folder / _FIFTEEN))])
    # Of this night nothing was promised: it stands beside the other one.
    for line in _overfit("AuxTel 2022-04-06", last):
        yield replace(line, wanted="shown", passed=None)
    for date, recordings in (("2020-03-14", few), ("2021-06-09", many), ("2022-04-06", good)):
        found = diagnosed(recordings, "altaz")
        before, after, floor = (
            one / ARCSEC
            for one in (found.heldout.before, found.heldout.after, found.heldout.noise_floor)
        )
        value = f"{said(found)}; left out {before:.1f} -> {after:.1f} arcsec, noise {floor:.1f}"
        yield Line(f"AuxTel {date}: found", value, "shown", None)
    loose = compare(many, altaz)
    value = ", ".join(
        f"{way} {own:.1f} against {loose.model.unseen[way]:.1f}"
        for way, own in loose.own.unseen.items()
    )
    value = f"{value} arcsec, {loose.outliers} offsets aside"
    yield Line("AuxTel 2021-06-09: left out, model with waves against altaz", value, "shown", None)


def _published(recordings: Recordings, file: Path) -> Iterator[Line]:
    """Yield how far a plain fit of published terms is from their published values."""
    model, night = load(str(file)), Night.of(recordings)
    columns, left = night.columns(model), night.value(model)
    # The model gives its published values before the fit: what is fitted are changes of them.
    change = np.linalg.lstsq(columns, left, rcond=None)[0]
    left = left - columns @ change
    rms = float(np.sqrt(2 * np.mean(left**2)))
    sigma = rms * np.sqrt(np.diag(np.linalg.inv(columns.T @ columns)))
    off = float(np.max(np.abs(change) / sigma))
    what = "AuxTel 2022-04-06: published six terms"
    yield Line(f"{what} are off by at most", f"{off:.3f} sigma", "1 sigma", off <= 1)
    value = f"{rms / ARCSEC:.4f} arcsec, published {_SIX_RMS}"
    same = abs(rms / ARCSEC - _SIX_RMS) < 0.001
    yield Line(f"{what}, sky rms", value, "the same", same)


def _overfit(night: str, done: Comparison) -> Iterator[Line]:
    """Yield what the published automatic model, its like and the model with waves predict."""
    (rival,), (held, anew) = done.rivals, done.picked
    terms = f"{rival.terms:.0f} free terms"
    for way, own in done.own.unseen.items():
        left = f"{night}, {way} left out"
        value = f"{own:.2f} arcsec, {terms} picked without them {anew.unseen[way]:.2f}"
        what = f"{left}, model with waves"
        yield Line(what, value, "the better", own < anew.unseen[way])
        value = f"{own:.2f} arcsec, the published {terms}, which saw them, {rival.unseen[way]:.2f}"
        yield Line(what, value, "the better", own < rival.unseen[way])
        value = (
            f"picked once and held {held.unseen[way]:.2f} arcsec, picked without them "
            f"{anew.unseen[way]:.2f}; {done.model.name} {done.model.unseen[way]:.2f}"
        )
        yield Line(f"{left}, what {terms} gain by having seen them", value, "shown", None)
    value = (
        f"{rival.fitted:.2f} arcsec in the fit, largest term {done.cancel[rival.name]:.1f} times "
        "what all add"
    )
    yield Line(f"{night}: the published {terms}", value, "shown", None)
    for other, alone in done.model.nights.items():
        value = (
            f"{done.model.name} {alone:.2f} arcsec, with what the published terms added "
            f"{rival.nights[other]:.2f}, the model with waves {done.own.nights[other]:.2f}"
        )
        yield Line(f"{night}: carried over to {other}", value, "shown", None)


def _rehearsed(night: str, recordings: Recordings, file: Path) -> Iterator[Line]:
    """Yield what picked terms and the model with waves leave where the truth is known."""
    for one in rehearse(recordings, load("altaz"), load(str(file))):
        (picked,) = (name for name in one.fresh if "picked" in name)
        own, claimed = one.fresh["model with waves"], one.claimed["model with waves"]
        value = (
            f"{own:.2f} arcsec (left out {claimed:.2f}), {picked} {one.fresh[picked]:.2f} "
            f"(left out {one.claimed[picked]:.2f}), the published {one.fresh[file.stem]:.2f} "
            f"(left out {one.claimed[file.stem]:.2f})"
        )
        what = f"{night}, were the telescope as {one.truth} says, fresh pointings, model with waves"
        better = own < one.fresh[picked]
        yield Line(what, value, "better than terms picked", better)


#: The Large Millimeter Telescope's list has no line of names.
_LMT_COLUMNS = (
    *("date_utc", "ut_h", "obsnum", "source", "az_deg", "el_deg"),
    *("d_xel_arcsec", "sigma_xel_arcsec", "d_el_arcsec", "sigma_el_arcsec"),
)
_LMT_SITE = {"latitude_deg": "18.9857", "longitude_deg": "-97.3148"}
#: What was published for the LMT: coefficients [arcsec] by axis, in the order of the effects.
_LMT_TERMS = {
    "xel": (("collimation", "skew", "azimuth_zero", "tilt"), (-0.329, 25.016, 774.087)),
    "el": (
        ("elevation_zero", "refraction", "sag_cosine", "sag_sine", "tilt"),
        (216.482, 42.089, -23.064, 84.802),
    ),
}
_LMT_RMS = {"xel": 2.0077, "el": 3.7337}


def lines(data: Path) -> Iterator[Line]:
    """Yield the figures of both telescopes' recordings in a folder of data."""
    yield from lmt(data / "lmt" / "PointingData.csv")
    yield from auxtel_lines(data / "auxtel")


def lmt(file: Path) -> Iterator[Line]:
    """Yield the published terms, refitted, and what is said of the tilt of each axis."""
    recordings = read(file, FileOptions(_LMT_SITE, _LMT_COLUMNS))
    for axis, (names, published) in _LMT_TERMS.items():
        values, covariance, rms = _fitted(recordings, names, axis)
        sigma = np.sqrt(np.diag(covariance))
        off = np.abs(values[: len(published)] - published) / sigma[: len(published)]
        what = f"LMT, {axis}: published terms are off by at most"
        yield Line(what, f"{off.max():.2f} sigma", "1 sigma", bool(off.max() <= 1))
        value = f"{rms:.4f} arcsec, published {_LMT_RMS[axis]}"
        yield Line(f"LMT, {axis}: rms", value, "the same", abs(rms - _LMT_RMS[axis]) < 0.01)
    found = diagnosed(recordings, "altaz")
    apart = [one for one in found.two_axes if one.chosen.candidate.effect.id == "tilt"]
    value = explained.two_axes_sentence(apart[0]) if apart else "nothing"
    far = bool(apart) and apart[0].found.sigmas >= 3
    yield Line("LMT: diagnose says of the tilts of both axes", value, "apart by 3 sigma", far)
    yield Line("LMT: diagnose finds", said(found), "shown", None)


def _fitted(
    recordings: Recordings, names: tuple[str, ...], axis: str
) -> tuple[Array, Array, float]:
    """Return values and covariance [arcsec] and rms of a plain fit of some effects to one axis."""
    at = recordings.at
    which = 0 if axis == "xel" else 1
    columns = np.concatenate([CATALOGUE[name].columns(at)[which] for name in names], axis=1)
    data = (recordings.x, recordings.y)[which] / ARCSEC
    units = np.array([c.scale for name in names for c in CATALOGUE[name].coefficients]) / ARCSEC
    columns = columns * units
    values, *_ = np.linalg.lstsq(columns, data, rcond=None)
    left = data - columns @ values
    spare = len(data) - columns.shape[1]
    covariance = np.linalg.inv(columns.T @ columns) * float(left @ left) / spare
    return values, covariance, float(np.sqrt(np.mean(left**2)))
