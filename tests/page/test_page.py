"""The page as bytes: complete, self-contained, escaped, the same every time, bounded in size."""

import base64
import hashlib
import itertools
import json
import re
from html.parser import HTMLParser

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from pages import HOSTILE, recordings

from pyport import page
from pyport.fitting.fit import fit
from pyport.formats.models import load
from pyport.models.terms.editing import edited
from pyport.page import payload as pack
from pyport.page import tables
from pyport.page.markup import tag
from pyport.page.payload import MOST_DRAWN, MOST_STRETCHES, stretches
from pyport.page.picture import _azimuth, columns
from pyport.page.story import Row
from pyport.studies.rt32 import fit_rt32
from pyport.studies.rt32.sky import of_rt32


class Balanced(HTMLParser):
    """Checks that every element that is opened is closed."""

    def __init__(self):
        super().__init__()
        self.open = []
        self.seen = []

    def handle_starttag(self, name, attributes):
        """Remember an element."""
        self.seen.append((name, dict(attributes)))
        if name not in {"meta", "input", "br"}:
            self.open.append(name)

    def handle_endtag(self, name):
        """Close the last one."""
        assert self.open.pop() == name


def test_it_is_one_well_formed_file_that_names_no_other(written):
    """Every element is closed; no attribute refers to anything outside."""
    text = written.read_text()
    parser = Balanced()
    parser.feed(text)

    assert parser.open == []
    links = [attributes.get("href", "#") for _, attributes in parser.seen]
    assert not any("src" in attributes for _, attributes in parser.seen)
    assert all(link.startswith("#") for link in links)
    assert not re.search(r"url\(|@import|https?://(?!www\.w3\.org/2000/svg)", text)


def test_only_its_own_script_may_run(written):
    """The policy holds the hash of the script and allows nothing else."""
    text = written.read_text()
    script = text.rpartition("<script>")[2].rpartition("</script>")[0]
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()

    assert f"default-src 'none'; style-src 'unsafe-inline'; script-src 'sha256-{digest}'" in text


def test_a_hostile_name_is_escaped_wherever_it_stands(written):
    """The antenna's name appears, and never as markup."""
    text = written.read_text()

    assert HOSTILE not in text
    assert "\\u003cscript\\u003edocument" in text


def test_it_says_what_was_found(diagnosis, written):
    """The verdict, the finding and the excluded row are words, there without any script."""
    text = written.read_text()

    assert [one.effect for one in diagnosis.findings] == ["refraction"]
    for words in ("altaz leaves out refraction.", "no offset on either axis", "Correlations"):
        assert words in text


def test_the_same_diagnosis_gives_the_same_bytes(diagnosis, written):
    """Nothing on the page depends on when or where it was made."""
    assert page.html(*page.of_diagnosis(diagnosis)) == written.read_text()


def test_layers_lead_exactly_from_before_to_after(diagnosis):
    """Residuals of the model less what is visible of every effect are those of the joint fit."""
    picture, _ = page.of_diagnosis(diagnosis)
    left = diagnosis.left(diagnosis.after)
    is_y = diagnosis.problem.stack.is_y

    np.testing.assert_allclose(picture.x.after, left[~is_y], atol=1e-12)
    np.testing.assert_allclose(picture.y.after, left[is_y], atol=1e-12)


@pytest.mark.parametrize("add", [(), ("HESA2", "HESA3")])
def test_a_fit_has_a_page_with_its_terms_as_layers(add):
    """Recorded offsets less every term are the residuals of the fit; two may be of one effect."""
    done = fit(recordings(), edited(load("altaz"), add=add))
    picture, story = page.of_fit(done)

    assert [one.name for one in picture.layers] == [
        term.effect.id.replace("_", " ") for term in done.model.terms
    ]
    np.testing.assert_allclose(picture.y.after, done.residual[done.stack.is_y], atol=1e-12)
    np.testing.assert_allclose(picture.y.before, done.recordings.y, atol=1e-12)
    assert "altaz fits to" in page.html(picture, story)


def test_the_rt32s_own_fit_has_a_page_with_its_twelve_parameters():
    """Before less all layers is what is left."""
    done = fit_rt32(recordings(), exact=False, level=0.01)
    picture, story = of_rt32(done, done.sigmas)

    assert len(picture.layers) == len(done.values)
    np.testing.assert_allclose(picture.y.after, done.residual[done.stack.is_y], atol=1e-12)
    assert "The approximate form fits to" in page.html(picture, story)


def test_a_page_of_many_recordings_stays_small():
    """Of 12 000 recordings a bounded number is drawn, and the page says so."""
    done = fit(recordings(12000), load("altaz"))
    text = page.html(*page.of_fit(done))

    assert f"{MOST_DRAWN:,} of 12,000 recordings are drawn" in text
    assert len(text) < 600_000


@settings(max_examples=40)
@given(
    arrays(float, st.integers(1, 60), elements=st.floats(-1e6, 1e6) | st.just(np.nan)),
    st.sampled_from([0.0, 1e-3, 1.0]),
)
def test_packed_numbers_come_back_to_a_step(values, step):
    """What is unpacked differs by half a unit at most; what is not known stays unknown."""
    packed = pack.numbers(values, step)
    kind = {2: "<u2", 4: "<u4"}[packed["bytes"]]
    codes = np.frombuffer(base64.b64decode(packed["data"]), kind)
    back = packed["low"] + packed["unit"] * codes
    known = np.isfinite(values)

    assert np.array_equal(codes == np.iinfo(kind).max, ~known)
    assert np.all(np.abs(back[known] - values[known]) <= 0.51 * packed["unit"] + 1e-9)


@settings(max_examples=60)
@given(st.text(max_size=40), st.text(max_size=40))
def test_text_and_attributes_come_back_from_the_markup(inside, attribute):
    """Whatever a label holds, an HTML parser reads it back as the text that it was."""
    found = []

    class Reader(HTMLParser):
        def handle_starttag(self, _, attributes):
            found.append(dict(attributes)["title"])

        def handle_data(self, text):
            found.append(text)

    clean = inside.replace("-", "")
    reader = Reader(convert_charrefs=True)
    reader.feed(tag("p", clean, title=attribute))
    reader.close()

    assert found[0] == attribute
    assert "".join(found[1:]) == clean


@given(st.lists(st.floats(0, 1e8), min_size=1, max_size=80))
def test_stretches_hold_every_time_once(times):
    """Stretches are in order, apart from each other, few, and none misses a time."""
    time = np.array(times)
    found = stretches(time)

    assert len(found) <= MOST_STRETCHES
    assert all(a <= b for a, b in found)
    assert all(one[1] < other[0] for one, other in itertools.pairwise(found))
    assert all(sum(a <= t <= b for a, b in found) == 1 for t in times)


def test_the_column_that_residuals_follow_comes_first():
    """A covariate that is behind the residuals stands before one that is not; labels count too."""
    rng = np.random.default_rng(0)
    given_ = recordings(wind_speed_m_s=rng.uniform(0, 10, 240))
    follows = 8.0 * (given_.at.column("wind_speed_m_s") > 5)
    found = columns(given_, (), [follows])

    assert [one.name for one in found[:3]] == ["az", "el", "wind_speed_m_s"]
    assert found[2].title == "wind speed [m/s]"
    assert "antenna" not in [one.name for one in found]


def test_a_stretch_across_the_north_is_drawn_in_one_piece():
    """Azimuths on both sides of the north are counted from the south, and so are regions."""
    az, regions = _azimuth(np.array([350.0, 355, 5, 20]), ((340.0, 380.0, 0), (90.0, 100.0, 1)))

    assert az.tolist() == [-10, -5, 5, 20]
    assert regions == ((-20.0, 20.0, 0), (90.0, 100.0, 1))
    _, whole = _azimuth(np.array([10.0, 100, 190, 300]), ((350.0, 370.0, 0),))
    assert whole == ((350.0, 360.0, 0), (0.0, 10.0, 0))
    assert _azimuth(np.array([10.0, 100, 190, 300]), ((350.0, 10.0, 0),))[1] == whole


def test_the_data_of_the_page_are_json(written):
    """The numbers between their tags are JSON with a column for azimuth and elevation first."""
    text = written.read_text()
    data = json.loads(text.partition('id="data">')[2].partition("</script>")[0])

    assert [one["name"] for one in data["columns"][:2]] == ["az", "el"]
    assert data["total"] == 240


@pytest.mark.parametrize(
    ("value", "sigma", "told"),
    [(1.5, 0.25, "1.50 ± 0.25"), (-1.5, None, "−1.500"), (None, None, "not determined")],
)
def test_a_coefficient_that_was_held_has_its_value(value, sigma, told):
    """Of an antenna among others; one without sigma was held."""
    assert told in str(tables._value(Row("tilt", "A", value, sigma, "arcsec")))
