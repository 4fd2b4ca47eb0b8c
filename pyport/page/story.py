"""What the page says in words and tables; everything here is text that may hold anything."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Card:
    """One finding: what it is called, how sure, how big, what else it could be.

    `layer` is the number of the effect in the panels that it switches, None for none.
    """

    title: str
    id: str
    verdict: str
    sentence: str
    facts: tuple[tuple[str, str], ...] = ()
    notes: tuple[tuple[str, str], ...] = ()
    layer: int | None = None


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

    One without sigma was held.
    """

    name: str
    group: str
    value: float | None
    sigma: float | None
    unit: str
    found: bool = False


@dataclass(frozen=True)
class Rival:
    """A candidate of a turn: its evidence, and whether it belongs to the class of the winner."""

    effect: str
    variant: str
    scope: str
    gain: float
    coefficients: int
    delta_bic: float
    member: bool = False


@dataclass(frozen=True)
class Turn:
    """A turn of the search: the winner, the chance that noise looks like this, the field."""

    winner: str
    p_value: float
    rivals: tuple[Rival, ...]


@dataclass(frozen=True)
class Source:
    """Where the recordings come from: the file, its hash, header, and the rows set aside."""

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
