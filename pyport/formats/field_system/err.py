"""The Field System's err files: data, old model, fit, residuals and new model, in sections."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from decimal import Decimal
from pathlib import Path

import numpy as np

from pyport.angles import DEG, Array
from pyport.errors import BadInput
from pyport.files import write_whole
from pyport.formats.field_system import ctl
from pyport.formats.field_system.fit import Data, ParameterFit, columns, fit, statistics
from pyport.formats.model_file import Entry, ModelFile, rounded, translated
from pyport.recordings.formats.xtr import ANTENNA
from pyport.recordings.interpret import interpret
from pyport.recordings.raw import Raw

_A_LINE = 5
#: Decimals of a degree that a fitted parameter gets.
_DECIMALS = 10
_A_TRIANGLE_LINE = 10


@dataclass(frozen=True)
class Err:
    """What an err file tells."""

    antenna: str  #: the line of the telescope
    observed: Data  #: the data as they came
    uncorrected: Data  #: with what the old model had taken off put back
    #: `old`, `fitted`, `new`: the models: before, what was fitted, and both together.
    old: ModelFile
    fitted: ModelFile
    new: ModelFile
    fit: ParameterFit  #: the fit


def fitted(raw: Raw, file: ModelFile) -> Err:
    """Fit what a model's flags ask for, as the Field System's program `error` does.

    Raises `BadInput`: the data have no errors, or cannot determine the parameters.
    """
    old = translated(file, "field-system")
    values, marks = ctl.numbered(old)
    held = [ctl.is_held(mark, marks) and mark != ctl.FORGOTTEN for mark in marks]
    observed = data_of(raw)
    known = np.array(
        [
            0.0 if mark == ctl.OFF or hold else float(value) * DEG
            for value, mark, hold in zip(values, marks, held, strict=True)
        ]
    )
    phi = float(old.phi_deg)
    across, along = columns(observed, range(1, len(values) + 1), phi)
    back = replace(
        observed, d_az=observed.d_az + across @ known, d_el=observed.d_el + along @ known
    )
    numbers = [
        n
        for n, (mark, hold) in enumerate(zip(marks, held, strict=True), 1)
        if mark in {ctl.FITTED, ctl.ALONE} and not hold
    ]
    if not numbers:
        raise BadInput("no parameter is flagged to be fitted, expected one or more", raw.file)
    try:
        done = fit(back, numbers, phi)
    except BadInput as error:
        raise BadInput(error.message, raw.file) from None
    return Err(
        raw.meta.get(ANTENNA, f"{raw.meta.get('telescope', 'antenna')} azel 1"),
        observed,
        back,
        old,
        _model(old, done, None),
        _model(old, done, held),
        done,
    )


def data_of(raw: Raw) -> Data:
    """Return recordings as the Field System's fit takes them, excluded ones included.

    Raises `BadInput`: an offset or its error is missing.
    """
    rows = replace(raw, columns={k: v for k, v in raw.columns.items() if k != "set_aside"})
    everything = interpret(rows)
    aside = raw.words("set_aside") != "" if "set_aside" in raw.columns else np.zeros(len(raw.line))
    numbers = (everything.x, everything.y, everything.sigma_x, everything.sigma_y)
    if everything.set_aside or any(not np.isfinite(one).all() for one in numbers):
        raise BadInput("an offset or its error is missing, and this fit weighs by them", raw.file)
    cos_el = np.cos(everything.at.el)
    return Data(
        everything.at.az,
        everything.at.el,
        everything.x / cos_el,
        everything.y,
        everything.sigma_x / cos_el,
        everything.sigma_y,
        ~np.asarray(aside, bool),
        sky_noise=_sky_noise(raw.meta.get(ANTENNA, "")),
    )


def _sky_noise(antenna: str) -> bool:
    """Tell whether the noise that is added in azimuth is one on the sky: the antenna's flag."""
    words = antenna.split()
    return len(words) < 3 or not words[2].isdigit() or int(words[2]) % 2 == 1


def _model(old: ModelFile, done: ParameterFit, held: Sequence[bool] | None) -> ModelFile:
    """Return the fitted parameters as a model, with those that were held where that is known."""
    values, marks = ctl.numbered(old)
    new = dict(zip(done.numbers, done.value / DEG, strict=True))
    entries = []
    flags = []
    for number, (value, mark) in enumerate(zip(values, marks, strict=True), 1):
        keep = held is not None and held[number - 1]
        entered = value if keep else rounded(Decimal(repr(float(new.get(number, 0.0)))), _DECIMALS)
        flags.append(ctl.FITTED if number in new else mark if keep else ctl.OFF)
        used = flags[-1] != ctl.OFF
        entries.append(Entry(f"P{number}", entered, "deg", used=used, fixed=keep))
    which, *date = old.details.get("number_and_date", [0] * 7)
    return replace(
        old, entries=tuple(entries), details={"number_and_date": [which + 1, *date], "flags": flags}
    )


def write(err: Err, path: Path) -> None:
    """Write an err file."""
    with write_whole(path) as out:
        out.writelines(f"{line}\n" for line in _lines(err))


def _lines(err: Err) -> Iterator[str]:
    quiet = (0.0, 0.0)
    yield "$antenna"
    yield f"  {err.antenna}"
    yield "$observed "
    yield from _rows(err.observed, err.observed.d_az, err.observed.d_el)
    yield "$observed_stats "
    yield statistics(err.observed, err.observed.d_az, err.observed.d_el, quiet)
    yield "$old_model"
    yield from ctl.to_lines(err.old)
    yield "$uncorrected"
    yield from _rows(err.observed, err.uncorrected.d_az, err.uncorrected.d_el)
    yield "$uncorrected_stats"
    yield statistics(err.observed, err.uncorrected.d_az, err.uncorrected.d_el, quiet)
    yield "$fit_data "
    yield from _with_sigmas(err)
    yield "$fit_stats"
    yield _fit_statistics(err)
    yield "$conditions "
    yield from _conditions(err.fit)
    yield "$correlation"
    yield from _correlation(err.fit)
    yield "$corrected"
    done, data = err.fit, err.observed
    yield from _rows(data, done.left_az, done.left_el, *_errors(err), done.after_az, done.after_el)
    yield "$corrected_stats"
    yield statistics(data, done.left_az, done.left_el, done.noise)
    yield "$new_model"
    yield from ctl.to_lines(err.new)


def _rows(data: Data, d_az: Array, d_el: Array, *more: Array) -> Iterator[str]:
    """Yield a line for each recording: flag, place, offsets, distance on the sky, and more."""
    distance = np.hypot(d_az * np.cos(data.el), d_el)
    table = np.degrees([data.az, data.el, d_az, d_el, distance, *more]).T
    for used, row in zip(data.used, table, strict=True):
        yield f" {int(used)}  {' '.join(f'{value:10.5f}' for value in row)}  "


def _errors(err: Err) -> tuple[Array, Array]:
    """Return the errors that the fit believed in, of azimuth and elevation offsets."""
    data, (az_noise, el_noise) = err.observed, err.fit.noise
    sky = np.cos(data.el) ** 2 if data.sky_noise else 1.0
    return (
        err.fit.scatter[0] * np.sqrt(data.sigma_az**2 + np.sign(az_noise) * az_noise**2 / sky),
        err.fit.scatter[0] * np.sqrt(data.sigma_el**2 + np.sign(el_noise) * el_noise**2),
    )


def _with_sigmas(err: Err) -> Iterator[str]:
    """Yield the fitted model with a line of sigmas below each line of values."""
    sigma = dict(zip(err.fit.numbers, err.fit.sigma / DEG, strict=True))
    lines = list(ctl.to_lines(err.fitted))
    yield from lines[:5]
    for n, values in enumerate(lines[5::2]):
        numbers = range(n * _A_LINE + 1, n * _A_LINE + 1 + len(values.split()))
        yield values
        yield "".join(f"  {sigma.get(k, 0.0):13.10f}" for k in numbers) + " "
        yield "* "


def _fit_statistics(err: Err) -> str:
    done = err.fit
    chi, az_chi, el_chi = done.scatter
    az_noise, el_noise = np.degrees(done.noise)
    return (
        f"     1       {chi:6.3f}  {az_chi:6.3f}  {el_chi:6.3f}       {done.free:4d}"
        f"    {az_noise:10.5f} {el_noise:10.5f}  {done.rounds:4d}"
        f"    {int(err.observed.sky_noise):4d}     "
    )


def _conditions(done: ParameterFit) -> Iterator[str]:
    inflation = dict(zip(done.numbers, done.inflation, strict=True))
    whole = [inflation.get(n, 0.0) for n in range(1, max(done.numbers) + 1)]
    yield "* "
    yield f"   {done.condition:8.2E} "
    yield "* "
    for n in range(0, len(whole), _A_TRIANGLE_LINE):
        yield "".join(f" {one:6.1f}" for one in whole[n : n + _A_TRIANGLE_LINE]) + " "
        yield "* "


def _correlation(done: ParameterFit) -> Iterator[str]:
    place = {number: n for n, number in enumerate(done.numbers)}
    yield "* "
    for row in range(1, max(done.numbers) + 1):
        both = [
            done.correlation[place[row], place[n]] if row in place and n in place else 0.0
            for n in range(1, row + 1)
        ]
        for n in range(0, len(both), _A_TRIANGLE_LINE):
            yield "".join(f" {one:6.3f}" for one in both[n : n + _A_TRIANGLE_LINE]) + " "
        yield "* "
