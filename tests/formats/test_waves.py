"""Fields without a name as another program's waves: the fewest, what they miss, and when not."""

from dataclasses import replace

import numpy as np
import pytest

from pyport.angles import ARCSEC
from pyport.effects.empirical.fields import field
from pyport.formats.model_file import WORDS
from pyport.formats.rest import MOST_LOST, sky, sums, waves
from pyport.models.members import effect_of
from pyport.models.model import Term

AT = sky()[1]


def of(kind, heights, **told):
    """Return a field along elevation with values [arcsec]."""
    k = len(heights)
    bumps = field({"kind": kind, **told}, [1] * k, range(k), np.eye(k).tolist(), "a", "b")
    return Term(bumps, values=tuple(ARCSEC * height for height in heights), fixed=True)


def missed(fields, found, vocabulary):
    """Return the rms over the sky between fields and waves [arcsec]."""
    weight = np.cos(AT.el) / np.cos(AT.el).sum()
    x, y = (
        sum(one.effect.columns(AT)[axis] @ np.array(one.values) for one in fields)
        - sum(WORDS[vocabulary](name).columns(AT)[axis] * size for name, size in found.values)
        for axis in (0, 1)
    )
    return np.sqrt(((x**2 + y**2) * weight).sum()) / ARCSEC


def test_a_wave_over_the_sky_is_one_term():
    """Sin 2A cos E is TPOINT's HESA2CE, with its sign, and nothing is missed."""
    one = of("wave", (0.0, 0.0, 9.0, 0.0), around=2, upward=1)
    found = waves([one], "tpoint", 1e-6, AT)

    ((name, size),) = found.values
    assert (name, found.missed_arcsec) == ("HESA2CE", pytest.approx(0, abs=1e-9))
    assert abs(size) == pytest.approx(9 * ARCSEC)
    assert missed([one], found, "tpoint") == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize("vocabulary", ["tpoint", "field-system", "katpoint"])
def test_bumps_of_azimuth_are_the_fewest_waves(vocabulary):
    """What is missed is said, is less than allowed, and one wave fewer would miss more."""
    one = of("azimuth", np.cos(np.arange(18) * 0.35 * 2 + 1) * 5, width_rad=0.35)
    found = waves([one], vocabulary, 2.0, AT)
    fewer = replace(found, values=found.values[:-1])

    assert found.missed_arcsec == pytest.approx(missed([one], found, vocabulary), rel=1e-6)
    assert found.missed_arcsec <= MOST_LOST * 2.0 < missed([one], fewer, vocabulary)
    assert len(found.values) < 8


@pytest.mark.parametrize(
    ("one", "scatter"),
    [
        (of("azimuth", [0, 9, 0, 0], width_rad=0.1), 1.0),
        (of("sky", [5.0] * 3, width_rad=0.5), 100.0),
        (of("column", [5.0] * 3, name="temperature_c", count=5, values=[1.0, 2.0, 3.0]), 100.0),
        (of("stretch", [5.0], name="el_deg", low_rad=0.4, high_rad=0.9), 100.0),
    ],
)
def test_what_waves_cannot_hold_has_none(one, scatter):
    """Too narrow for nine waves in a turn, over the sky, of the weather, with an edge."""
    assert waves([one], "tpoint", scatter, AT) is None


def test_an_effect_is_written_as_terms_that_add_up_to_it():
    """A receiver on the left platform is IA and ECES, NPAE and TF in TPOINT: nothing is missed."""
    left = effect_of("nasmyth", {"sense": -1})
    term = Term(left, values=(20 * ARCSEC, -7 * ARCSEC))
    found = sums([term], "tpoint", AT)

    assert {name for name, _ in found.values} == {"IA", "ECES", "NPAE", "TF"}
    assert missed([term], found, "tpoint") < 1e-9
    bent = replace(term, effect=effect_of("refraction_curvature", {}), values=(1e-5,))
    assert sums([bent], "tpoint", AT) is None
