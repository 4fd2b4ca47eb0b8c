"""The examples of CONTRIBUTING.md run as they stand there, in the modules they are added to."""

import __future__

import gzip
import importlib
import re
import textwrap
from pathlib import Path

import numpy as np
import pytest
from astropy.io import fits

from pyport import page
from pyport.effects import Circumstances, Site
from pyport.effects.telescope import thermal
from pyport.errors import BadInput
from pyport.fitting.fit import fit
from pyport.formats.models import load
from pyport.recordings.files import read
from pyport.recordings.formats import tables
from pyport.recordings.schema import Table

GUIDE = (Path(__file__).parents[1] / "CONTRIBUTING.md").read_text(encoding="utf-8")


def blocks(recipe):
    """Return the Python of a recipe, block by block."""
    text = GUIDE.split(f"## Add {recipe}\n")[1].split("\n## ")[0]
    found = re.findall(r"^   ```python\n(.*?)^   ```", text, re.DOTALL | re.MULTILINE)
    return [textwrap.dedent(one) for one in found]


def added(module, code):
    """Return the names of a module once the code stands in it."""
    names = dict(vars(module))
    there = __future__.annotations.compiler_flag
    exec(compile(code, "CONTRIBUTING.md", "exec", there), names)  # noqa: S102 - our own guide
    return names


def test_the_effect_of_the_guide_is_one():
    """The wind at twice ten metres a second lifts four times as much, most at the horizon."""
    function, registration, *_ = blocks("an effect")
    names = added(thermal, function)
    effect = eval(registration.strip().rstrip(","), names)  # noqa: S307 - our own guide
    el = np.array([0.0, 1.0])
    at = Circumstances(el, el, Site(0.9), {"wind_speed_m_s": np.full(2, 20.0)})
    across, along = effect.columns(at)

    assert not across.any()
    assert along[:, 0] == pytest.approx(4 * np.cos(el))


@pytest.fixture
def fits_tables():
    """Return the reader and the writer of the guide."""
    reader, writer, *_ = blocks("a format")
    names = added(tables, reader + writer)
    return names["read_fits"], names["write_fits"]


def test_the_format_of_the_guide_reads_what_it_writes(fits_tables, tmp_path):
    """Numbers, labels and the header come back."""
    reader, writer = fits_tables
    table = Table(
        meta={"telescope": "RT32", "azimuth_zero": "north"},
        columns={"az_deg": np.array([10.0, 350.0]), "source": np.array(["3C84", ""])},
    )
    writer(table, tmp_path / "x.fits")
    raw = reader(tmp_path / "x.fits")

    assert raw.columns["az_deg"].tolist() == [10.0, 350.0]
    assert [str(one) for one in raw.columns["source"]] == ["3C84", ""]
    assert raw.meta["azimuth_zero"] == "north"


@pytest.mark.parametrize(
    ("column", "unit", "reason"),
    [
        ("D_EL", "furlong", "column 'd_el_deg' is in furlong, expected deg"),
        ("TEMPERATURE_C", "kg", "expected deg_C"),
    ],
)
def test_the_format_of_the_guide_refuses_units(fits_tables, tmp_path, column, unit, reason):
    """In one line, in small letters as in large ones."""
    path = tmp_path / "x.fits"
    fits.BinTableHDU.from_columns([fits.Column(column, "D", unit, array=[1.0])]).writeto(path)

    with pytest.raises(BadInput, match=reason):
        fits_tables[0](path)


def test_the_format_of_the_guide_refuses_what_is_none(fits_tables, tmp_path):
    """Text, half a file, a packed one, and letters that FITS cannot hold."""
    reader, writer = fits_tables
    path = tmp_path / "x.fits"
    table = Table(meta={"note": "T\u00fcbingen"}, columns={"az_deg": np.arange(2000.0)})
    with pytest.raises(BadInput, match="note has letters that FITS"):
        writer(table, path)
    with pytest.raises(BadInput, match="note has letters that FITS"):
        writer(Table(meta={"note": "two\nlines"}, columns=table.columns), path)
    writer(Table(meta={}, columns=table.columns), path)
    half = path.read_bytes()[:9000]
    packed = gzip.compress(path.read_bytes())
    for spoilt in (b"az,el\n1,2\n", half, b"", packed):
        path.write_bytes(spoilt)
        with pytest.raises(BadInput) as refused:
            reader(path)
        assert "\n" not in str(refused.value)


@pytest.mark.slow
def test_the_panel_of_the_guide_draws_what_counts():
    """Residuals in their unit, before and after, and a line for each."""
    (function, *_), night = blocks("a panel"), read("gmrt-2003-06-01")
    picture, _ = page.of_fit(fit(night, load("gmrt-paper")))
    (axes,) = added(importlib.import_module("pyport.plots.panels"), function)["quantiles"](
        picture
    ).axes
    before, _, after, _ = axes.get_lines()
    side = dict(picture.sides())["elevation"]

    assert "[arcmin]" in axes.get_ylabel()
    assert len(before.get_ydata()) == len(after.get_ydata()) == (side.share > 0).sum()
    assert np.std(after.get_ydata()) < np.std(before.get_ydata())
