"""Answers in Python and in notebooks, which draw themselves and say themselves."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from astropy.units import Quantity
    from matplotlib.figure import Figure

    from pyport.correction.use import PointingModel
    from pyport.diagnosis import diagnose as steps
    from pyport.diagnosis.naming.finding import Finding
    from pyport.fitting import fit as fitting
    from pyport.models.conditions import Value
    from pyport.page.picture import Picture
    from pyport.page.story import Story
    from pyport.planning.look import Look as Found


class Shown:
    """An answer that draws itself in a notebook and says itself at a prompt."""

    def __repr__(self) -> str:
        """Return the answer in words."""
        return self.summary()

    def summary(self) -> str:
        """Return the answer in words, as the command prints it."""
        raise NotImplementedError

    @property
    def drawn(self) -> tuple[Picture, Story]:
        """Return what the page draws and says."""
        raise NotImplementedError

    def page(self, path: str | Path) -> Path:
        """Write the page, one HTML file that needs no network, and return its path."""
        from pyport.page import write

        return write(*self.drawn, Path(path))

    def panels(self) -> list[str]:
        """Return the names of the panels that `plot` draws."""
        from pyport.plots import panels

        return list(panels(*self.drawn))

    def plot(self, panel: str) -> Figure:
        """Return a panel as a matplotlib figure.

        Raises
        ------
        KeyError
            There is no such panel; `panels` has their names.
        """
        from pyport.plots import panels

        return panels(*self.drawn)[panel]()

    def _repr_html_(self) -> str:
        """Return the whole page in a frame, for Jupyter."""
        from pyport.page.document import framed

        return framed(*self.drawn)


@dataclass(frozen=True, repr=False)
class Diagnosis(Shown):
    """What a model leaves out of some recordings.

    Attributes
    ----------
    result
        Everything that was computed: noise, fits, residuals, the turns of the search.
    """

    result: steps.Diagnosis

    @property
    def mismatch(self) -> bool:
        """Tell whether anything is missing from the model."""
        return self.result.mismatch

    @property
    def findings(self) -> tuple[Finding, ...]:
        """Return what was found, strongest first."""
        return self.result.findings

    @property
    def p_value(self) -> float:
        """Return the chance that noise alone looks like this, over the whole search."""
        return self.result.p_value

    @cached_property
    def report(self) -> dict[str, Any]:
        """Return the report as `report.json` holds it."""
        from pyport.report.made import report_of
        from pyport.report.typed import as_json

        report: dict[str, Any] = as_json(report_of(self.result))
        return report

    @cached_property
    def drawn(self) -> tuple[Picture, Story]:
        """Return what the page draws and says."""
        from pyport.page import of_diagnosis

        return of_diagnosis(self.result)

    def summary(self) -> str:
        """Return the diagnosis in words, as the command prints it."""
        from pyport.report.folder import text
        from pyport.report.made import report_of

        return text(report_of(self.result))

    @cached_property
    def model(self) -> PointingModel:
        """Return the model completed by everything that was found."""
        from pyport.correction.use import PointingModel
        from pyport.report.finding import completed

        return PointingModel(completed(self.result))

    def save(self, folder: str | Path) -> Path:
        """Write report.json, rows.csv and report.html into a folder, and return it.

        A path to a .toml takes the completed model alone.
        """
        if Path(folder).suffix.lower() == ".toml":
            self.model.save(folder)
            return Path(folder)
        from pyport.report.folder import write

        page = Path(folder) / "report.html"
        self.page(page)
        write(self.result, Path(folder), beside=[page])
        return Path(folder)


@dataclass(frozen=True, repr=False)
class Fit(Shown):
    """A model fitted to recordings.

    Attributes
    ----------
    result
        Everything that was computed: coefficients, covariance, residuals, weights.
    """

    result: fitting.Fit

    @cached_property
    def coefficients(self) -> dict[str, Value]:
        """Return every coefficient by its name: value, sigma, unit, and what it was before."""
        from pyport.models.complete import label

        return {label(one): one for one in self.model.values}

    @cached_property
    def residuals(self) -> dict[str, Quantity]:
        """Return what is left of each recording: `xel` on the sky, and `el`, NaN for none."""
        from astropy import units

        from pyport.angles import ARCSEC

        stack, left = self.result.stack, np.full((2, len(self.result.recordings)), np.nan)
        left[stack.is_y.astype(int), stack.row] = self.result.residual / ARCSEC
        return {name: one * units.arcsec for name, one in zip(("xel", "el"), left, strict=True)}

    @cached_property
    def rms(self) -> dict[str, Quantity]:
        """Return the rms of what is left, outliers apart.

        `xel` and `el` by the axis; `sky` over both axes by the pointing, as TPOINT counts it.
        """
        from astropy import units

        completed = self.model.model.completed
        made = {} if completed is None else completed.made
        names = {"xel": "rms_xel_arcsec", "el": "rms_el_arcsec", "sky": "sky_rms_arcsec"}
        return {name: made[key] * units.arcsec for name, key in names.items() if key in made}

    @cached_property
    def model(self) -> PointingModel:
        """Return the fitted model, ready to be asked, saved or fitted again."""
        from pyport.correction.use import PointingModel
        from pyport.fitting.fit import completed

        return PointingModel(completed(self.result))

    def save(self, path: str | Path, **options: Any) -> Path:  # noqa: ANN401 - those of the model
        """Write the fitted model by suffix: see `PointingModel.save`."""
        self.model.save(path, **options)
        return Path(path)

    @cached_property
    def report(self) -> dict[str, Any]:
        """Return the fit as `fit.json` holds it."""
        from pyport.fitting.table import as_json

        return as_json(self.result)

    @cached_property
    def drawn(self) -> tuple[Picture, Story]:
        """Return what the page draws and says."""
        from pyport.page import of_fit

        return of_fit(self.result)

    def summary(self) -> str:
        """Return the table of coefficients, as the command prints it."""
        from pyport.fitting.table import text

        return text(self.result)


@dataclass(frozen=True, repr=False)
class Look:
    """What recordings could show, before anything is fitted.

    Attributes
    ----------
    result
        Coverage, what can be distinguished, and what to observe next.
    """

    result: Found

    def __repr__(self) -> str:
        """Return the look in words, as the command prints it."""
        from pyport.planning.summary import text

        return text(self.result)

    @cached_property
    def report(self) -> dict[str, Any]:
        """Return the look as `look.json` holds it."""
        from pyport.planning.summary import as_json

        return as_json(self.result)
