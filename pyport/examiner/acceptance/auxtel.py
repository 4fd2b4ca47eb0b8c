"""The Rubin Auxiliary Telescope: published models, one of them long suspected of an overfit."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from pyport.angles import ARCSEC
from pyport.examiner.acceptance.drawn import Line
from pyport.examiner.acceptance.said import diagnosed, said
from pyport.formats.models import load
from pyport.prediction.compare import Comparison, compare
from pyport.prediction.contenders import Night
from pyport.prediction.rehearsal import rehearse
from pyport.recordings import read
from pyport.recordings.raw import FileOptions
from pyport.recordings.schema import Recordings

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


def lines(folder: Path) -> Iterator[Line]:
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
        told = f"{said(found)}; left out {before:.1f} -> {after:.1f} arcsec, noise {floor:.1f}"
        yield Line(f"AuxTel {date}: found", told, "shown", None)
    loose = compare(many, altaz)
    told = ", ".join(
        f"{way} {own:.1f} against {loose.model.unseen[way]:.1f}"
        for way, own in loose.own.unseen.items()
    )
    told = f"{told} arcsec, {loose.outliers} offsets aside"
    yield Line("AuxTel 2021-06-09: left out, model with waves against altaz", told, "shown", None)


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
    told = f"{rms / ARCSEC:.4f} arcsec, published {_SIX_RMS}"
    same = abs(rms / ARCSEC - _SIX_RMS) < 0.001
    yield Line(f"{what}, sky rms", told, "the same", same)


def _overfit(night: str, done: Comparison) -> Iterator[Line]:
    """Yield what the published automatic model, its like and the model with waves predict."""
    (rival,), (held, anew) = done.rivals, done.picked
    terms = f"{rival.terms:.0f} free terms"
    for way, own in done.own.unseen.items():
        left = f"{night}, {way} left out"
        told = f"{own:.2f} arcsec, {terms} picked without them {anew.unseen[way]:.2f}"
        what = f"{left}, model with waves"
        yield Line(what, told, "the better", own < anew.unseen[way])
        told = f"{own:.2f} arcsec, the published {terms}, which saw them, {rival.unseen[way]:.2f}"
        yield Line(what, told, "the better", own < rival.unseen[way])
        told = (
            f"picked once and held {held.unseen[way]:.2f} arcsec, picked without them "
            f"{anew.unseen[way]:.2f}; {done.model.name} {done.model.unseen[way]:.2f}"
        )
        yield Line(f"{left}, what {terms} gain by having seen them", told, "shown", None)
    told = (
        f"{rival.fitted:.2f} arcsec in the fit, largest term {done.cancel[rival.name]:.1f} times "
        "what all add"
    )
    yield Line(f"{night}: the published {terms}", told, "shown", None)
    for other, alone in done.model.nights.items():
        told = (
            f"{done.model.name} {alone:.2f} arcsec, with what the published terms added "
            f"{rival.nights[other]:.2f}, the model with waves {done.own.nights[other]:.2f}"
        )
        yield Line(f"{night}: carried over to {other}", told, "shown", None)


def _rehearsed(night: str, recordings: Recordings, file: Path) -> Iterator[Line]:
    """Yield what picked terms and the model with waves leave where the truth is known."""
    for one in rehearse(recordings, load("altaz"), load(str(file))):
        (picked,) = (name for name in one.fresh if "picked" in name)
        own, claimed = one.fresh["model with waves"], one.claimed["model with waves"]
        told = (
            f"{own:.2f} arcsec (left out {claimed:.2f}), {picked} {one.fresh[picked]:.2f} "
            f"(left out {one.claimed[picked]:.2f}), the published {one.fresh[file.stem]:.2f} "
            f"(left out {one.claimed[file.stem]:.2f})"
        )
        what = f"{night}, were the telescope as {one.truth} says, fresh pointings, model with waves"
        better = own < one.fresh[picked]
        yield Line(what, told, "better than terms picked", better)
