"""Findings: what a diagnosis says, as data."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated

import numpy as np

from pyport.angles import ARCSEC, Array

if TYPE_CHECKING:
    from pyport.diagnosis.stability import Stability
    from pyport.fitting.combinations import Combination

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
    """Where a mismatch is: axes, labels, intervals that hold together, a curve, a beginning."""

    axes: tuple[str, ...]
    subset: dict[str, list[str]] = field(default_factory=dict)
    region: tuple[Interval, ...] = ()
    curve: tuple[tuple[float, float], ...] | None = None
    since: str | None = None


@dataclass(frozen=True)
class HeldOut:
    """Plain rms of predictions of readings that the fit had not seen [rad].

    `noise_floor` is the scatter from pointing to pointing, which no model removes; `gross` counts
    the readings that were not predicted or that both predictions miss by far.
    """

    scheme: str
    before: float
    after: float
    noise_floor: float
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

    @property
    def size(self) -> str:
        """Return how much it adds to the residuals, in words."""
        adds = f'adds {self.visible_rms / ARCSEC:.3g}" rms to the residuals'
        if self.true_rms > self.largest or self.visible_rms >= ABSORBED * self.true_rms:
            return adds
        before = f'{self.true_rms / ARCSEC:.3g}" before the fitted terms absorb the rest'
        return f"{adds} ({before})"
