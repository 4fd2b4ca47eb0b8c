"""What the page says in words and tables; everything here is text that may hold anything."""

from __future__ import annotations

from dataclasses import dataclass

from pyport.effects.empirical.drivers import unit_in_words
from pyport.effects.empirical.fields import UNKNOWN
from pyport.models.complete import has_before
from pyport.models.model import Model


@dataclass(frozen=True)
class Card:
    """One finding: what it is called, how sure, how big, what else it could be.

    `layer` is the number of the effect in the panels that it switches, None for none.
    """

    title: str
    verdict: str
    sentence: str
    facts: tuple[tuple[str, str], ...]
    notes: tuple[tuple[str, str], ...]
    layer: int | None


@dataclass(frozen=True)
class Bar:
    """Rms before and after [arcsec] beside the noise floor, of everything or of one antenna."""

    name: str
    before: float
    after: float
    floor: float | None = None


@dataclass(frozen=True)
class Row:
    """A coefficient: value and sigma in its unit; no value where the data leave it open.

    One without sigma was held. `before` is what the model that was given had, None where that
    had no values at all.
    """

    name: str
    group: str
    value: float | None
    sigma: float | None
    unit: str
    found: bool = False
    before: float | None = None


def rows_of(model: Model) -> tuple[Row, ...]:
    """Return the coefficients of a completed model."""
    if model.completed is None:
        return ()
    values = model.completed.values
    with_before = has_before(values)
    return tuple(
        Row(
            one.name,
            " ".join(one.labels.values()),
            one.value if one.determined else None,
            one.sigma,
            unit_in_words(one.unit) + (", fixed" if one.sigma is None else ""),
            one.finding is not None,
            one.before if with_before else None,
        )
        for one in values
        if one.effect != UNKNOWN
    )


def sky_rms(model: Model) -> tuple[tuple[str, str, str], ...]:
    """Return the rms on the sky as TPOINT counts it: both axes together, by the star."""
    made = {} if model.completed is None else model.completed.made
    if not made.get("stars"):
        return ()
    said = f"arcsec as TPOINT counts it, {made['stars']} pointings"
    if "sky_rms_arcsec" in model.details:
        said += f"; the model's file says {model.details['sky_rms_arcsec']:.4f}"
    return (("sky rms", f"{made['sky_rms_arcsec']:.4f}", said),)


@dataclass(frozen=True)
class Rival:
    """A candidate of a turn: its evidence, and whether it belongs to the class of the winner."""

    effect: str
    variant: str
    scope: str
    coefficients: int
    delta_bic: float
    member: bool


@dataclass(frozen=True)
class Turn:
    """A turn of the search: the winner, the chance that noise looks like this, the field."""

    winner: str
    p_value: float
    rivals: tuple[Rival, ...]


@dataclass(frozen=True)
class Source:
    """Where the recordings come from: the file, its hash, header, and the excluded rows."""

    file: str
    sha256: str | None
    meta: tuple[tuple[str, str], ...]
    set_aside: tuple[tuple[int, str], ...]


@dataclass(frozen=True)
class Story:
    """Everything on the page that is no panel."""

    kind: str
    source: Source
    model: str
    headline: str
    lead: str
    good: bool
    facts: tuple[tuple[str, str, str], ...]
    cards: tuple[Card, ...] = ()
    warnings: tuple[str, ...] = ()
    bars: tuple[Bar, ...] = ()
    bars_how: str = ""
    rows: tuple[Row, ...] = ()
    correlation: tuple[tuple[str, ...], tuple[tuple[float, ...], ...]] = ((), ())
    condition: float | None = None
    turns: tuple[Turn, ...] = ()
    limits: tuple[tuple[str, float], ...] = ()
    untestable: tuple[tuple[str, str], ...] = ()
    outliers: tuple[tuple[int, str], ...] = ()
    noise: tuple[str, ...] = ()
    dropped: tuple[tuple[str, str], ...] = ()
    model_file: str | None = None
