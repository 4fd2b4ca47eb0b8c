"""pyport in Python and in notebooks: tables in, answers out that draw themselves.

>>> import pyport
>>> found = pyport.diagnose("gmrt-2003-06-01", model="gmrt-paper")
>>> found.mismatch
True

A table is a file's name, a data frame (pandas), an astropy or Arrow
table, or a dictionary of columns; its columns are called as in a file of
recordings, units and all: `az_deg`, `el_deg`, `d_xel_arcsec`, `d_el_arcsec`.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pyport.answers import Diagnosis, Fit, Look
from pyport.arguments import mapping, number, refusal, several, texts, whole
from pyport.errors import BadInput
from pyport.recordings.from_table import Header, Table, from_table

if TYPE_CHECKING:
    from pyport.correction.use import PointingModel
    from pyport.models.model import Model


def diagnose(
    table: Table,
    model: str | Path | Model | PointingModel = "altaz",
    *,
    refit: str | Collection[str] = "all",
    in_use: bool = False,
    seed: int = 0,
    header: Header | None = None,
) -> Diagnosis:
    """Find, name and model what a pointing model leaves out of recordings.

    Parameters
    ----------
    table
        Recordings: a file, a name of those shipped with pyport, a data frame,
        an astropy or Arrow table, a dictionary of columns.
    model
        The name of a built-in model, a file, or a model.
    refit
        The model's effects that are fitted together with everything under
        test: "all", "none", or their ids.
    in_use
        Whether the offsets are what the model left while it was in use: it is added back.
    seed
        Of everything that is drawn at random: same input and seed, same result.
    header
        What holds for all rows: `latitude_deg`, `longitude_deg`, `height_m`, ...

    Raises
    ------
    BadInput
        The table, the model or `refit` cannot be used; the message says why.
    """
    from pyport.correction.use import model_of
    from pyport.diagnosis.diagnose import diagnose
    from pyport.pipeline import ids_of

    known = model_of(model)
    held = ids_of(known, ",".join(texts("refit", refit)) or "none")
    drawn = whole("seed", seed, 0)
    recordings = from_table(table, header)
    if in_use:
        recordings = known.added_to(recordings)
    return Diagnosis(diagnose(recordings, known, refit=held, seed=drawn))


def fit(
    table: Table,
    model: str | Path | Model | PointingModel = "altaz",
    *,
    add: Sequence[str] = (),
    drop: Sequence[str] = (),
    fix: Mapping[str, Any] | Sequence[str] = (),
    weights: str = "robust",
    per: str | Sequence[str] | None = None,
    in_use: bool = False,
    header: Header | None = None,
) -> Fit:
    """Fit a pointing model to recordings.

    Parameters
    ----------
    table, model, in_use, header
        As in `diagnose`.
    add, drop
        Terms by TPOINT's names, P1..P30, ids of effects or names of coefficients.
    fix
        Terms that are held: name -> Quantity, a bare number in the coefficient's unit, or None
        for what the model gives. Or texts as on the command line, "IE=0".
    weights
        "robust": by the noise that is estimated with the fit; "equal": all alike.
    per
        Labels each value of which has coefficients of its own, by default "antenna".

    Raises
    ------
    BadInput
        The table, the model or a name cannot be used, or there are too few recordings.
    """
    from pyport.correction.use import model_of
    from pyport.fitting.fit import WEIGHTS, fit
    from pyport.models.terms.editing import edited

    if not isinstance(weights, str) or weights not in WEIGHTS:
        raise BadInput(f"weights are {weights!r}, expected {' or '.join(map(repr, WEIGHTS))}")
    if isinstance(fix, Mapping):
        fixed = tuple(_fixed(name, one) for name, one in mapping("fix", fix).items())
    else:
        fixed = texts("fix", fix)
    given, recordings = model_of(model), from_table(table, header)
    if in_use:
        recordings = given.added_to(recordings)
    chosen = edited(
        given.on(recordings.at.mount),
        fix=fixed,
        add=texts("add", add),
        drop=texts("drop", drop),
        per=None if per is None else texts("per", per),
    )
    return Fit(fit(recordings, chosen, weights=weights))


def _fixed(name: str, value: Any) -> str:  # noqa: ANN401 - a Quantity or a number
    """Return a term that is held as the command line has it."""
    if value is None:
        return name
    if getattr(value, "unit", None) is None:
        return f"{name}={number(f'fix: {name}', value, -math.inf)!r}"
    from astropy import units

    try:
        return f"{name}={float(value.to_value(units.arcsec))!r}arcsec"
    except units.UnitConversionError:
        raise BadInput(f"fix: {name} is in {value.unit}, expected an angle") from None
    except TypeError:
        raise refusal(f"fix: {name}", value, "an angle") from None


def look(
    table: Table,
    model: str | Path | Model | PointingModel = "altaz",
    *,
    noise_arcsec: float | None = None,
    count: int = 6,
    elevations: Sequence[float] | None = None,
    sources: bool = False,
    header: Header | None = None,
) -> Look:
    """Tell what recordings could show: coverage, what can be distinguished, what to observe next.

    `noise_arcsec`, `count`, `elevations` [deg] and `sources` are those of `pyport.planning.look`;
    the others as in `diagnose`.

    Raises
    ------
    BadInput
        The table or the model cannot be used.
    """
    from pyport.correction.use import model_of
    from pyport.planning import look

    found = look(
        from_table(table, header),
        model_of(model),
        noise_arcsec=None if noise_arcsec is None else number("noise_arcsec", noise_arcsec, 0),
        count=whole("count", count, 0),
        elevations=None if elevations is None else _between(elevations),
        sources=sources is True,
    )
    return Look(found)


def _between(elevations: Sequence[float]) -> tuple[float, float]:
    """Return two elevations [deg], the lower one first."""
    two = several(elevations)
    if two is None or len(two) != 2:
        raise refusal("elevations", elevations, "two numbers in degrees")
    low, high = (number("elevations", one, -90, 180) for one in two)
    if not low < high:
        raise BadInput(f"elevations: {low:g} is not below {high:g}")
    return low, high


def load_model(model: str | Path | Model, mount: str = "") -> PointingModel:
    """Return a pointing model with coefficients, ready to be asked for offsets.

    Parameters
    ----------
    model
        A file: what `--save` or `save` wrote, TPOINT's .mod, the Field System's .ctl,
        katpoint's, SKA-Mid's .json, DISCOS's .xml; a built-in model of the RT32; a model.
    mount
        What a file does not say of its mount: "xy-ns", "equatorial", ...; a Field System model
        whose phi is not 90 deg needs it.

    Raises
    ------
    BadInput
        There is no such model, it has no coefficients, or is of another mount.
    """
    from pyport.correction.use import PointingModel, model_of
    from pyport.recordings.mounted import stated

    known, kind = model_of(model), stated({"mount": mount})
    return PointingModel(known if kind is None else known.on(kind))
