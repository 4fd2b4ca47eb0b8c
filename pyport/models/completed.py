"""A completed model: what was fitted and found, what it was before, and how well it is known."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from pyport.angles import Array

if TYPE_CHECKING:
    from astropy.units import Quantity


@dataclass(frozen=True)
class Value:
    """A coefficient of a completed model for one set of labels, in its unit.

    Attributes
    ----------
    name, effect, unit
        The coefficient, the effect that it belongs to, and the unit of all its numbers.
    value, sigma, before
        What to enter into the control system; its one-sigma error, None where it was held; what
        the model gave before.
    labels
        The antenna, session, ... that it holds for; empty where it holds everywhere.
    finding
        The number of the finding that it belongs to, from 1; None for a term of the model.
    determined
        False where the recordings leave it open: the value is then one of many.
    """

    name: str
    effect: str
    unit: str
    value: float
    sigma: float | None
    before: float
    labels: Mapping[str, str] = field(default_factory=dict)
    finding: int | None = None
    determined: bool = True

    @property
    def change(self) -> float:
        """Return what the file that was given has to be changed by."""
        return self.value - self.before

    @property
    def quantity(self) -> Quantity:
        """Return the value as astropy's Quantity."""
        from astropy import units

        return units.Quantity(self.value, self.unit)


@dataclass(frozen=True)
class Completed:
    """What is known of a completed model beside its terms.

    Attributes
    ----------
    made
        What made it, and from what: `by`, `recordings`, `sha256`, `rows`, `model`.
    values
        Every coefficient, in the order of the model's terms and their labels.
    covariance
        Of the values in their units, shape (P, P); zero for what was held.
    findings
        As `report.json` spells them.
    unsaved
        Ids of terms that no file can hold: they were made in Python.
    """

    made: Mapping[str, Any]
    values: tuple[Value, ...]
    covariance: Array
    findings: tuple[Mapping[str, Any], ...] = ()
    unsaved: tuple[str, ...] = ()
