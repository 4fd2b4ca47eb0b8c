"""Panels for print: every one is drawn, with units, the same bytes each time, safe file names."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from pages import recordings

from pyport import page, plots
from pyport.cli.explain import plot
from pyport.fitting.fit import fit
from pyport.formats.models import load
from pyport.plots.style import AFTER, BEFORE, nice

#: Panels of what has no unit.
UNITLESS = {"correlations", "candidates"}


@pytest.fixture(scope="module")
def panels():
    """Return the panels of a fit, of recordings with a column of a hostile name."""
    rng = np.random.default_rng(3)
    given = recordings(
        **{"../../up": rng.normal(size=240), "scan_direction": np.tile([1, -1], 120)}
    )
    return plots.panels(*page.of_fit(fit(given, load("altaz"))))


@pytest.mark.slow
def test_every_panel_is_drawn_with_its_units(panels, tmp_path):
    """Each pair of axes names the unit of the residuals; each panel is written as an SVG."""
    for name, draw in panels.items():
        figure = draw()
        for axes in figure.axes:
            label = axes.get_xlabel() + axes.get_ylabel() + axes.get_title()
            assert "arcsec" in label or name in UNITLESS, name
        assert plots.write(figure, tmp_path / f"{name}.svg").stat().st_size > 1000


def test_every_panel_stands_in_the_manual(panels):
    """The page on pages has a table of them."""
    manual = (Path(__file__).parents[2] / "docs" / "page.md").read_text(encoding="utf-8")
    columns = {f"against-{one}" for one in ("session", "source", "_up", "scan_direction")}

    assert {f"`{name}`" for name in panels.keys() - columns - {"against-temperature_c"}} <= {
        *re.findall(r"`[^`\n]+`", manual)
    }


def test_names_of_panels_are_names_of_files(panels):
    """A column called ../../up leads nowhere."""
    assert "against-_up" in panels
    assert all("/" not in name and "." not in name for name in panels)


@pytest.mark.slow
@pytest.mark.parametrize("kind", sorted(plots.FORMATS))
def test_the_same_panel_gives_the_same_bytes(panels, tmp_path, kind):
    """No date, no version, no random name is stamped on a file."""
    one, other = (
        plots.write(panels["against-el"](), tmp_path / f"{n}.{kind}").read_bytes() for n in (1, 2)
    )

    assert one == other


@pytest.mark.slow
def test_letters_that_the_typeface_lacks_are_taken_from_the_whole_one(panels, tmp_path):
    """A name in Cyrillic letters is in the file."""
    figure = panels["against-el"]()
    plain = plots.write(figure, tmp_path / "plain.pdf").read_bytes()
    figure = panels["against-el"]()
    figure.axes[0].set_title("Источник 1")
    named = plots.write(figure, tmp_path / "named.pdf").read_bytes()

    assert b"+pyportSans" in plain
    assert b"+DejaVuSans" not in plain
    assert b"+DejaVuSans" in named


def test_drawing_leaves_no_trace(panels):
    """The settings of matplotlib are what they were."""
    import matplotlib as mpl

    before = dict(mpl.rcParams)
    panels["distributions"]()

    assert dict(mpl.rcParams) == before


def test_the_colours_differ_in_grey():
    """Before and after can be distinguished on a black and white printer."""
    grey = [
        np.dot([int(c[n : n + 2], 16) for n in (1, 3, 5)], [0.299, 0.587, 0.114])
        for c in (BEFORE, AFTER)
    ]

    assert abs(grey[0] - grey[1]) > 25


@pytest.mark.parametrize(
    ("value", "expected"), [(0.7, 1), (1, 1), (1.2, 2), (30, 50), (7e-3, 1e-2)]
)
def test_nice_numbers(value, expected):
    """1, 2, 5 or 10 times a power of ten, not below the value."""
    assert nice(value) == pytest.approx(expected)


@pytest.mark.slow
def test_the_command_writes_what_it_is_asked_for(tmp_path):
    """Two panels in two formats are four files, listed as JSON; a wrong name is refused."""
    words = ["gmrt-2003-06-02", "--model", "gmrt-paper", "--of", "fit", "--out", str(tmp_path)]
    asked = ["--panel", "sky", "--panel", "against-el", "--format", "png", "--format", "svg"]
    done = CliRunner().invoke(plot, [*words, *asked, "--json"])
    wrong = CliRunner().invoke(plot, [*words, "--panel", "nothing"])

    assert {Path(one).name for one in json.loads(done.output)} == {
        "sky.png",
        "sky.svg",
        "against-el.png",
        "against-el.svg",
    }
    assert len(list(tmp_path.iterdir())) == 4
    assert wrong.exit_code == 2
    assert "no panel 'nothing'" in wrong.output


def test_a_notebook_shows_a_panel_as_a_picture(panels):
    """A figure has its PNG at hand: no interactive matplotlib need be set up."""
    picture = panels["sky"]()._repr_png_()

    assert picture.startswith(b"\x89PNG")
    assert len(picture) > 1000
