"""The published table, printed again."""

import json
import re

import numpy as np
import pytest
from click.testing import CliRunner

from pyport.cli.fit import command as fit_command
from pyport.cli.study import rt32 as rt32_command
from pyport.studies.rt32 import METHODS, box_step, fit_rt32
from pyport.studies.rt32 import document as table
from pyport.studies.rt32.fit import honest_sigmas


def test_table_says_what_the_published_one_says(document, honest):
    """Counts, rms, and for each parameter value and sigma in arcseconds and degrees."""
    text = table.text(document, honest)
    lines = {line[:2].strip(): line for line in text.splitlines()}

    assert "SIMULATED" in text.splitlines()[0]
    assert "5615 offsets (2758 of altitude, 2857 of azimuth)" in text
    assert f"{document.inside.sum()} points fitted" in text
    assert "0.0170 deg, subtracted" in text
    for k in range(12):
        pairs = re.findall(r"([-\d.]+)\+/- *([\d.]+)", lines[str(k + 1)])
        arcsec, degrees = np.array(pairs, float)
        both = document.values[k], document.sigmas[k]
        np.testing.assert_allclose(arcsec, np.degrees(both) * 3600, atol=0.06)
        np.testing.assert_allclose(degrees, np.degrees(both), atol=1e-6)


def test_an_open_parameter_has_no_number(campaign):
    """Without azimuth offsets the azimuth's parameters are said to be open."""
    altitudes = campaign.take(np.isfinite(campaign.y))
    fit = fit_rt32(altitudes, exact=False)
    text = table.text(fit, honest_sigmas(fit))

    assert text.count("not determined by these recordings") == 5
    assert "nan" not in text + table.correlations(fit) + table.compared(
        [fit], [fit.sigmas * np.nan]
    )


@pytest.mark.slow
def test_json_holds_what_the_table_prints(campaign):
    """Every number is there and the simulation is not passed over."""
    fit = fit_rt32(campaign, box=box_step(campaign, "fit"))
    report = json.loads(json.dumps(table.as_json(fit, honest_sigmas(fit))))

    assert report["simulated"] is True
    assert [one["name"] for one in report["parameters"]][-1] == "box_step"
    assert np.shape(report["correlation"]) == (13, 13)


@pytest.mark.slow
def test_fit_command_prints_the_table(short, tmp_path):
    """`pyport fit --method` prints the table and leaves the JSON."""
    arguments = [str(short), "--model", "rt32-approximate", "--method", "soft-l1"]
    done = CliRunner().invoke(fit_command, [*arguments, "--out", str(tmp_path)])

    assert done.exit_code == 0
    assert "approximate form, method soft-l1" in done.output
    assert "correlations" in done.output
    assert json.loads((tmp_path / "fit.json").read_text())["method"] == "soft-l1"


def test_fit_command_refuses_other_models(short):
    """The document's method fits the RT32's models only."""
    arguments = [str(short), "--model", "altaz", "--method", "document"]
    done = CliRunner().invoke(fit_command, arguments)

    assert done.exit_code == 2
    assert "rt32-exact or rt32-approximate" in done.output


@pytest.mark.slow
def test_rt32_command_does_all_of_it(short, tmp_path):
    """Table, correlations, every method and the three figures come from one command."""
    done = CliRunner().invoke(rt32_command, [str(short), "--out", str(tmp_path)])

    assert done.exit_code == 0
    for method in METHODS:
        assert method in done.output
    assert sorted(p.name for p in tmp_path.iterdir()) == [f"figure-{n}.png" for n in (3, 4, 5)]
