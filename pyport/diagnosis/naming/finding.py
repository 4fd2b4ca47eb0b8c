"""Findings: what a diagnosis says, as data."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated

import numpy as np

from pyport.angles import ARCSEC, Array
from pyport.thresholds import MOSTLY, NOTICEABLE, STABLE

if TYPE_CHECKING:
    from pyport.fitting.combinations import Combination


@dataclass(frozen=True)
class Stability:
    """How often a name came first.

    Attributes
    ----------
    resampled
        What was drawn: sessions, blocks of time or pointings.
    draws, kept
        How often, and in how many the name, or one of its class, came first.
    names
        Other names that came first, and in how many draws, the most frequent first.
    weak
        In how many a change came first, but the noise could have done it.
    """

    resampled: str
    draws: int
    kept: int
    names: dict[str, int] = field(default_factory=dict)
    weak: int = 0

    @property
    def stable(self) -> bool:
        """Tell whether the name survives."""
        return self.kept >= STABLE * self.draws

    @property
    def nameless(self) -> int:
        """Return in how many draws nothing was worth a name."""
        return self.draws - self.kept - self.weak - sum(self.names.values())

    @property
    def instead(self) -> str | None:
        """Return the name that came first most often where it did not, None for no name."""
        most = max(self.names, key=lambda name: self.names[name], default=None)
        return most if most is not None and self.names[most] >= self.nameless else None

    @property
    def returned(self) -> tuple[str, ...]:
        """Return the other names that came first in a noticeable share of the draws."""
        return tuple(n for n, count in self.names.items() if count >= NOTICEABLE * self.draws)

    def verdict(self, verdict: str) -> str:
        """Return what a verdict becomes: the data decide between names only if they keep doing so.

        A name that is not stable is `ambiguous` with those that came back, or `unknown` where
        mostly none did.
        """
        if self.stable or verdict == "unknown":
            return verdict
        return "unknown" if self.nameless > MOSTLY * self.draws else "ambiguous"

    @property
    def counts(self) -> str:
        """Return how often which name came first."""
        others = [f"{name} in {count}" for name, count in self.names.items()]
        if self.weak:
            others.append(f"not beyond what noise can do in {self.weak}")
        if self.nameless:
            others.append(f"no name in {self.nameless}")
        first = f"the name came back in {self.kept} of {self.draws} draws"
        return ", ".join([first, *others])

    @property
    def words(self) -> str:
        """Return how often the name came back, and what came in its place."""
        said = f"resampling {self.resampled}, {self.counts}"
        return said if self.stable else f"not stable: {said}"


#: Where the fitted terms absorb less than a twentieth of an effect it is not worth a word.
ABSORBED = 0.95


@dataclass(frozen=True)
class Parameter:
    """A fitted number in the unit it is reported in; `expected` where physics fixes it."""

    name: Annotated[str, "of the coefficient; behind it in brackets the antenna or session"]
    value: Annotated[float, "its value"]
    sigma: Annotated[float, "one-sigma error"]
    unit: Annotated[str, "of both"]
    expected: Annotated[float | None, "value that physics fixes"] = None


def beyond(one: Parameter, largest: float) -> bool:
    """Tell whether an angle, or its error, is larger than the largest offset measured [rad]."""
    return one.unit == "arcsec" and max(abs(one.value), one.sigma) * ARCSEC > largest


@dataclass(frozen=True)
class Interval:
    """A stretch of a column that a mismatch is confined to."""

    column: Annotated[str, "of the recordings"]
    low: Annotated[float, "from"]
    high: Annotated[float, "to"]


@dataclass(frozen=True)
class Where:
    """Where a mismatch is: axes, labels, intervals that hold together, a curve, since and until.

    `between` are the last time before it began and the first since.
    """

    axes: tuple[str, ...]
    subset: dict[str, list[str]] = field(default_factory=dict)
    region: tuple[Interval, ...] = ()
    curve: tuple[tuple[float, float], ...] | None = None
    since: str | None = None
    until: str | None = None
    between: tuple[str, str] | None = None


@dataclass(frozen=True)
class HeldOut:
    """Plain rms of predictions of readings that the fit had not seen [rad].

    `noise_floor` is the scatter from pointing to pointing, which no model removes; `fall_sigma` is
    the standard error of `before` less `after`, from how they differ among the stretches that were
    left out, None where there is but one; `gross` counts the readings that were not predicted or
    that both predictions miss by far.
    """

    scheme: str
    before: float
    after: float
    noise_floor: float
    fall_sigma: float | None = None
    gross: int = 0


@dataclass(frozen=True)
class Evidence:
    """How sure a finding is, and what came next to it."""

    p_value: Annotated[float, "chance that noise gains as much anywhere in the search"]
    delta_bic: Annotated[float, "gain in BIC"]
    runner_up: Annotated[str | None, "effect that came next"]
    runner_up_delta_bic: Annotated[float | None, "its gain in BIC"]


@dataclass(frozen=True)
class Finding:
    """One mismatch: what was left out, where, how big, how sure, what else it could be.

    `variant` says which member of a family it is; `visible_rms` and `true_rms`
    [rad] are the effect's rms after and before the fitted terms take their share, the mean of
    each axis taken out; `largest` [rad] is the largest offset that was measured;
    `combination` is what is known of its coefficients where none is known alone;
    `partial` says that it acts on some of the readings of its axes only, of which the rms are;
    `checks` are the ones that were made, with their outcome in words; `stability`
    says how often its name came back on resampled data, None where it has none;
    `curve` is what is visible of the effect in each reading [rad], shape (m,);
    `choice` is the place in the joint fit that it was read from.
    """

    effect: str
    members: tuple[str, ...]
    verdict: str
    sentence: str
    where: Where
    parameters: tuple[Parameter, ...]
    evidence: Evidence
    visible_rms: float
    true_rms: float
    variant: str = ""
    heldout: HeldOut | None = None
    looks_like: str | None = None
    decide_by: str | None = None
    checks: tuple[str, ...] = ()
    stability: Stability | None = None
    curve: Array | None = field(default=None, compare=False, repr=False)
    choice: int | None = field(default=None, compare=False, repr=False)
    largest: float = np.inf
    combination: Combination | None = None
    partial: bool = False

    @property
    def size(self) -> str:
        """Return how much it adds to the residuals, in words."""
        adds = f'adds {self.visible_rms / ARCSEC:.3g}" rms to the residuals'
        if self.partial:
            adds += " where it acts"
        if self.true_rms > self.largest or self.visible_rms >= ABSORBED * self.true_rms:
            return adds
        before = f'{self.true_rms / ARCSEC:.3g}" before the fitted terms absorb the rest'
        return f"{adds} ({before})"
