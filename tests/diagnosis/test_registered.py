"""New physics is one function and one registration: every part of the program knows it then."""

import numpy as np
import pytest
from diagnosis.made import recordings
from effects import test_acceptance as harness
from effects.cases import AT, Case
from effects.mount import encoders

from pyport import effects as catalogues
from pyport import page
from pyport.angles import ARCSEC
from pyport.diagnosis.diagnose import diagnose
from pyport.effects import CATALOGUE, Circumstances, Coefficient, Effect, describe
from pyport.effects.base import AXES, stack
from pyport.formats.models import load
from pyport.planning.look import look
from pyport.report.folder import text as in_words
from pyport.report.made import report_of

PER_K = 2.5
EFFECT = "bearing_warp"


def warp(at: Circumstances):
    """Return what a bearing does that warps with its temperature: the dish nods twice a turn."""
    warm = at.numbers("temperature_c") - 10
    return stack(at, (np.sin(at.el) * np.sin(2 * at.az) * warm, np.cos(2 * at.az) * warm))


@pytest.fixture(autouse=True)
def registered():
    """Register the effect, for one test."""
    catalogues.register(
        Effect(
            EFFECT,
            "the azimuth bearing warps with its temperature",
            "a textbook",
            (Coefficient("bearing_warp_per_k"),),
            warp,
            needs=("temperature_c",),
            formula=("d T sin E sin 2A", "d T cos 2A"),
            driver="temperature_c",
            acts_in=AXES,
            pattern="twice per turn of azimuth, with the temperature, in both axes",
        )
    )
    yield
    for mount in catalogues.KINDS.values():
        catalogues.catalogue(mount).pop(EFFECT, None)


def warped(n=240, seed=3, **columns):
    """Return recordings of a telescope whose bearing warps."""
    bend = [lambda at, k=k: PER_K * warp(at)[k][:, 0] for k in (0, 1)]
    return recordings(n, seed, x=bend[0], y=bend[1], **columns)


@pytest.mark.slow
def test_it_is_named_sized_worded_and_drawn():
    """In four nights it is found; the text, the report and the page say what it is."""
    measured = warped()
    found = diagnose(measured, load("altaz"))
    first = found.findings[0]
    text = " ".join(in_words(report_of(found)).split())
    drawn = page.html(*page.of_diagnosis(found))

    assert (first.effect, first.verdict) == (EFFECT, "named")
    assert first.parameters[0].value == pytest.approx(PER_K, abs=4 * first.parameters[0].sigma)
    for said in (text, drawn):
        assert "the azimuth bearing warps with its temperature" in said
    assert "<h3>bearing warp</h3>" in drawn


@pytest.mark.slow
def test_it_is_refused_from_a_single_night():
    """One night has one curve of temperature: whatever else went with the hour looks the same."""
    n = 240
    hours = np.linspace(0, 9, n)
    night = {
        "time": 1.2e9 + 3600 * hours,
        "session": np.full(n, "one"),
        "temperature_c": 16 - 1.5 * hours,
    }
    found = diagnose(warped(n, **night), load("altaz"))
    called = [one.effect for one in found.findings if one.verdict == "named"]

    assert found.findings
    assert EFFECT not in called
    assert any("second night" in (one.decide_by or "") for one in found.findings)


def test_it_is_a_term_of_models_and_listed(tmp_path):
    """In `--add`, in TOML, in the document on the physics, before any fit."""
    path = tmp_path / "model.toml"
    path.write_text(f'[[term]]\neffect = "{EFFECT}"\nvalue_arcsec = 2.5\n')
    at = warped().at
    x, _ = load(str(path)).offsets(at)

    np.testing.assert_allclose(x, PER_K * ARCSEC * warp(at)[0][:, 0])
    assert f"### `{EFFECT}`" in describe.markdown()
    assert describe.entries([EFFECT])[0]["needs"] == ["temperature_c"]
    assert EFFECT in str(look(warped(), load("altaz")).separation)


def test_the_harness_of_all_effects_holds_it():
    """Sign, size, first order, shape, rows on their own, and the column that it lacks."""
    warm = AT.numbers("temperature_c") - 10
    lean = PER_K * ARCSEC * warm
    case = Case(
        EFFECT,
        (PER_K,),
        lambda s: encoders(
            AT.az, AT.el, lean=(s * lean * np.cos(AT.az), -s * lean * np.sin(AT.az))
        ),
    )
    effect = CATALOGUE[EFFECT]

    harness.test_sign_and_size(case)
    harness.test_first_order(case)
    harness.test_rows_stand_alone(effect)
    harness.test_shape_of_the_basis(effect)
    harness.test_missing_column_is_named(effect, "temperature_c")
