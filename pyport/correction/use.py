"""Pointing models as a control system uses them: offsets, where to drive, and back to the sky."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from pyport.angles import ARCSEC, DEG, Array
from pyport.arguments import place
from pyport.columns import SPELLED
from pyport.correction.directions import Pointing, directions, formed
from pyport.correction.driving import driven, undone
from pyport.correction.kernel import Kernel, kernel
from pyport.effects import Circumstances, MissingColumn, Site
from pyport.errors import BadInput
from pyport.files import sha256
from pyport.models import complete
from pyport.models.conditions import Columns, Value
from pyport.models.model import INSIDE, Model
from pyport.mounts import ALTAZ, Mount

if TYPE_CHECKING:
    from pyport.formats.rest import Rest

#: Later than any row of recordings.
LATEST = 1e18


class Offsets(NamedTuple):
    """Offsets across elevation (on the sky) and along it, to be added to a direction."""

    d_xel: Any
    d_el: Any


@dataclass(frozen=True, repr=False)
class PointingModel:
    """A pointing model with coefficients, ready to be asked."""

    model: Model  #: its terms
    _ready: dict[tuple[tuple[str, str], ...], Kernel] = field(
        default_factory=dict, compare=False, repr=False
    )

    def __post_init__(self) -> None:
        """Refuse a model without coefficients, or with more of them than offsets were measured."""
        known = self.model.given is not None or any(t.has_values for t in self.model.terms)
        if not known and self.model.terms:
            raise BadInput(f"the model {self.model.name} has no coefficients: fit it first")
        if self.model.completed is not None and (wrong := self.model.completed.undetermined):
            raise BadInput(f"the model {self.model.name} is not determined: {wrong}")

    @property
    def name(self) -> str:
        """Return the model's name."""
        return self.model.name

    @property
    def values(self) -> tuple[Value, ...]:
        """Return its coefficients with errors and what they were, if a fit completed it."""
        return () if self.model.completed is None else self.model.completed.values

    @property
    def findings(self) -> tuple[Any, ...]:
        """Return what a diagnosis added, as `report.json` spells it."""
        return () if self.model.completed is None else self.model.completed.findings

    @property
    def covariance(self) -> Array:
        """Return the covariance of `values` in their units, shape (P, P)."""
        completed = self.model.completed
        return np.zeros((0, 0)) if completed is None else completed.covariance

    def offsets(self, *where: Any, **conditions: Any) -> Offsets:  # noqa: ANN401 - see below
        """Return what has to be added to true directions.

        `where`: azimuth (from north through east) and elevation: Quantities, or bare numbers in
          degrees, scalars or arrays that broadcast. Or an astropy `AltAz` or `SkyCoord`, which
          knows its time and location or is given them. Or a table with the columns of recordings.
        `conditions`: what else the model needs, by name: `time`, `temperature`, `wind_speed`,
          `wind_az`, `antenna`, `session`, `location`, ...; Quantities, or bare numbers in the units
          of the columns of recordings (deg C, m/s, deg, ...).
        Returns `d_xel`, `d_el`: quantities, on the sky across elevation, and along it.
        Raises `BadInput`: the model needs something that was not given; the message names it all.
        """
        from astropy import units

        plain = len(where) == 2 and type(where[0]) is type(where[1]) is float
        if plain and not conditions and math.isfinite(where[0] + where[1]):
            one = self.offsets_rad(where[0] * DEG, where[1] * DEG)
            return Offsets(one[0] / ARCSEC * units.arcsec, one[1] / ARCSEC * units.arcsec)
        there = directions(where, conditions, self.model.site, self._others)
        x, y = self._on_sky(there.az, there.el, there.columns, there.site)
        return Offsets(*(one.reshape(there.shape) / ARCSEC * units.arcsec for one in (x, y)))

    def offsets_rad(self, az_rad: float, el_rad: float, **columns: Any) -> tuple[float, float]:  # noqa: ANN401
        """Return the offsets (across, along elevation) of one direction, all in radians.

        The quickest way to ask: numbers in, numbers out. `columns` are bare numbers and labels
        under the names that recordings have inside the program (`time` in seconds since 1970,
        `temperature_c`, ...).
        """
        if self.model.mount is not ALTAZ or self.model.leans:
            arrays = {key: np.array([one]) for key, one in columns.items()}
            x, y = self._on_sky(np.array([az_rad]), np.array([el_rad]), arrays, self.model.site)
            return float(x[0]), float(y[0])
        ready = self._kernel(tuple((key, columns[key]) for key in self._labels if key in columns))
        if self._by_row:
            columns.setdefault("order", LATEST)
        try:
            return ready.one(az_rad, el_rad, columns, self.model.site)
        except MissingColumn:
            raise self._lacking(set(columns)) from None

    def correct(self, *where: Any, **conditions: Any) -> Any:  # noqa: ANN401 - as it is given
        """Return where to drive the mount for true directions.

        Arguments as for `offsets`. The answer has the form of what was given: azimuth and
        elevation as Quantities, or an `AltAz`.
        """
        there = directions(where, conditions, self.model.site, self._others)
        return formed(there, *driven(there, self._mount(there.mount), self._of))

    def inverse(self, *where: Any, **conditions: Any) -> Any:  # noqa: ANN401 - as it is given
        """Return the true direction that a mount points at, from its readings.

        Arguments as for `offsets`, azimuth and elevation being the mount's. Between the two
        sides of an edge no direction has some readings, and others have two: the nearest is
        given.
        """
        there = directions(where, conditions, self.model.site, self._others)
        return formed(there, *undone(there, self._mount(there.mount), self._of))

    def at(self, there: Circumstances) -> tuple[Array, Array]:
        """Return the offsets of n pointings [rad], shape (n,): along the axes of their mount.

        Across and along elevation, where they are directions alone.
        """
        site = there.site or self.model.site
        if there.mount is ALTAZ:
            return self._on_sky(there.az, there.el, dict(there.columns), site)
        self.model.on(there.mount)  # a model of another mount is refused
        return self._offsets(there.az, there.el, dict(there.columns), site, there.mount)

    def inverse_at(self, there: Circumstances) -> tuple[Array, Array]:
        """Return the true azimuths and elevations of n mount readings [rad], shape (n,)."""
        self.model.on(there.mount)
        site, columns = there.site or self.model.site, dict(there.columns)
        readings = Pointing(there.az, there.el, there.az.shape, columns, site, mount=there.mount)
        return undone(readings, self._mount(there.mount), self._of)

    def met(self, there: Circumstances, file: Path) -> Circumstances:
        """Return the recordings of a file as the model meets them.

        What changed at some row changed in the file that the model was made from: in any other it
        is as it was after the last of those rows, whatever the order of its own.
        """
        if not self._by_row or "order" not in there:
            return there
        made = {} if self.model.completed is None else self.model.completed.made
        if file.is_file() and made.get("sha256") == sha256(file):
            return there
        columns = {name: one for name, one in there.columns.items() if name != "order"}
        return replace(there, columns=columns)

    def columns_needed(self) -> list[str]:
        """Return the columns that the model follows, as they are called inside the program."""
        return [INSIDE.get(name, name) for name in self.needs()]

    def save(
        self,
        path: str | Path,
        *,
        rest_as: str | Path | None = None,
        leave_out: bool = False,
        **conditions: Any,  # noqa: ANN401 - see `offsets`
    ) -> Rest:
        """Write the model: .toml whole, or in another program's format by its suffix.

        `path`: the file: .toml .mod .ctl .txt .xml .json.
        `rest_as`: a CSV file for the corrections, on a grid, by terms that the format cannot name.
        `leave_out`: leave those out.
        `conditions`: what holds for that grid beside directions, such as `temperature_c`.
        Returns what the file does not hold, with its rms.
        Raises `BadInput`: the format cannot hold a term, which is named.
        """
        from pyport.formats.completed import write_model

        rest = None if rest_as is None else place("rest_as", rest_as)
        return write_model(
            self.model,
            place("path", path),
            rest_as=rest,
            leave_out=leave_out,
            conditions=conditions,
        )[2]

    def needs(self) -> list[str]:
        """Return what the model needs to know beside a direction, as the contract names it."""
        labels = (label for label in self._labels if self._varies(label))
        return [*self.model.needs(), *labels]

    def __repr__(self) -> str:
        """Return the coefficients as a table."""
        completed = self.model.completed
        head = [f"{self.name}: {', '.join(one.effect.id for one in self.model.terms)}"]
        more = complete.lines(completed, self.model.terms) if completed else []
        return "\n".join([*head, *more])

    @cached_property
    def _labels(self) -> tuple[str, ...]:
        return tuple(dict.fromkeys(label for term in self.model.terms for label in term.per))

    @cached_property
    def _by_row(self) -> bool:
        """Tell whether a term changes at a row of its recordings, which gave no time."""
        return any("since_row" in term.effect.member for term in self.model.terms)

    def _varies(self, label: str) -> bool:
        """Tell whether coefficients differ between values of a label."""
        found = set()
        for term in self.model.terms:
            if label in term.per:
                found |= {key[term.per.index(label)] for key in term.by}
        return len(found) > 1

    def _kernel(self, labels: tuple[tuple[str, str], ...]) -> Kernel:
        ready = self._ready.get(labels)
        if ready is None:
            ready = self._ready[labels] = kernel(self.model, dict(labels), self.model.site)
        return ready

    def _offsets(
        self, az: Array, el: Array, columns: Columns, site: Site | None, mount: Mount = ALTAZ
    ) -> tuple[Array, Array]:
        if self._by_row and "order" not in columns:
            # what changed at some row of the recordings is as it was after the last of them
            columns = columns | {"order": np.full(len(az), LATEST)}
        known = {key: columns[key] for key in self._labels if key in columns}
        single = {
            key: str(one[0]) for key, one in known.items() if len(one) and (one == one[0]).all()
        }
        try:
            axes = self._mount(mount)
            plain = axes is ALTAZ and site == self.model.site
            if len(single) < len(known) or not plain:
                return self.model.offsets(Circumstances(az, el, site, columns, mount=axes))
            return self._kernel(tuple(single.items())).many(az, el, columns, site)
        except MissingColumn:
            raise self._lacking(set(columns)) from None

    def _of(self, there: Pointing) -> tuple[Array, Array]:
        """Return offsets along the axes of the mount that directions are of."""
        return self._offsets(there.az, there.el, there.columns, there.site, there.mount)

    def _on_sky(
        self, az: Array, el: Array, columns: Columns, site: Site | None
    ) -> tuple[Array, Array]:
        """Return offsets across and along elevation, on whatever mount."""
        x, y = self._offsets(az, el, columns, site)
        try:
            return Circumstances(az, el, site, columns, mount=self.model.mount).along_sky(x, y)
        except MissingColumn:
            raise self._lacking(set(columns)) from None

    def _lacking(self, given: set[str]) -> BadInput:
        """Return an error that names everything that is needed and not given."""
        missing = [
            name for name in self.needs() if name not in {SPELLED.get(one, one) for one in given}
        ]
        names = ", ".join(missing) or "more than was given"
        return BadInput(
            f"the model {self.name} needs {names}: give it by name, as a column or by --set"
        )

    @cached_property
    def _others(self) -> frozenset[str]:
        """Return columns, beyond the contract's too, that terms of this model follow."""
        return frozenset(self.model.needs())

    def _mount(self, stated: Mount) -> Mount:
        """Return the mount that is stated beside directions, or the model's.

        Raises `BadInput`: neither says which way an axis leans.
        """
        mount = self.model.mount if stated is ALTAZ else stated
        if self.model.leans and mount is ALTAZ:
            which = "say of which mount it is: --mount or '# mount:', such as xy-ns or equatorial"
            raise BadInput(f"the first axis of the model {self.name} leans (phi): {which}")
        return mount


def model_of(model: str | Path | Model | PointingModel) -> Model:
    """Return a model by the name of a built-in one, from a file, or as it is.

    Raises `BadInput`: there is no such model or file.
    """
    from pyport.formats.models import load

    if isinstance(model, PointingModel):
        return model.model
    return model if isinstance(model, Model) else load(str(place("model", model)))
