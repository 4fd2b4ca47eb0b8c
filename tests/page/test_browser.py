"""The page in a browser: it draws, answers the pointer, prints, and fits a phone."""

from dataclasses import replace

import numpy as np
import pytest
from pages import recordings

from pyport import page
from pyport.diagnosis.diagnose import diagnose
from pyport.formats.models import load

pytestmark = pytest.mark.browser

CLOUD = "#against-panels .panel:nth-child(2) .frame:nth-of-type(2) .cloud.after path"


def points(tab, where="#against-panels .cloud.after:not(.dim)"):
    """Return how many points some clouds draw."""
    paths = tab.eval_on_selector_all(
        f"{where} path", "all => all.map(one => one.getAttribute('d'))"
    )
    return sum(path.count("M") for path in paths if path)


def drawn(tab):
    """Return what all panels draw, as text."""
    return tab.eval_on_selector_all(
        "#against-panels .cloud.after path, #sky-panels .vectors.after path",
        "all => all.map(one => one.getAttribute('d')).join(' ')",
    )


def middle(tab, selector):
    """Return the middle of an element on the screen, scrolled into view."""
    found = tab.locator(selector).first
    found.scroll_into_view_if_needed()
    box = found.bounding_box()
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def test_it_draws_every_panel_and_asks_for_nothing(written, look):
    """No console message, no request but the page itself, a drawing in every panel."""
    tab = look(written)
    empty = tab.eval_on_selector_all(".drawing", "all => all.filter(one => !one.firstChild).length")

    assert tab.said == []
    assert empty == 0
    assert points(tab, "#sky-panels .cloud.before:not(.dim)") == 2 * 240


def test_pointing_at_a_recording_tells_it_in_every_panel(written, look):
    """The tip names source, line and place; the same recording is ringed elsewhere."""
    tab = look(written)
    x, y = middle(tab, "#sky-panels svg")
    for step in range(60):
        tab.mouse.move(x - 60 + 2 * step, y + 30)
        if tab.locator(".tip").is_visible():
            break

    assert "source" in tab.locator(".tip b").inner_text()
    assert "line" in tab.locator(".tip").inner_text()
    rings = tab.locator("#against-panels .hot[visibility=visible]")
    assert rings.count() >= 4


def test_a_tap_tells_a_recording_on_a_telephone(written, look):
    """On a touch screen a tap near a point shows the tip, which stays."""
    tab = look(written, width=390, has_touch=True)
    x, y = middle(tab, "#sky-panels svg")
    for step in range(12):
        tab.touchscreen.tap(x - 60 + 10 * step, y + 40)
        if tab.locator(".tip").is_visible():
            break

    assert "source" in tab.locator(".tip b").inner_text()


def test_a_hostile_label_is_text(written, look):
    """An antenna called <script> is shown by its name and does nothing."""
    tab = look(written)

    assert "hacked" not in tab.title()
    assert tab.locator("script").count() == 2
    assert tab.said == []


def test_a_switch_puts_an_effect_back_into_the_residuals(written, look):
    """Off, what is drawn as after is what was there before; on again, it is as it was."""
    tab = look(written)
    told = tab.locator(".told")
    first, text = drawn(tab), told.inner_text()
    tab.locator(".card input").first.uncheck()
    without, other = drawn(tab), told.inner_text()
    tab.locator(".chip input").first.check()

    assert without != first
    assert other != text
    sizes = other.split("elevation ")[-1].split(" arcsec")[0].split(" → ")
    assert sizes[0] == sizes[1]
    assert (drawn(tab), told.inner_text()) == (first, text)


def test_a_box_chooses_points_in_every_panel_and_escape_lets_them_go(written, look):
    """What is dragged over stays bright everywhere and is listed; the rest fades."""
    tab = look(written)
    before = points(tab)
    box = tab.locator("#against-panels svg").nth(1)
    box.scroll_into_view_if_needed()
    place = box.bounding_box()
    tab.mouse.move(place["x"] + 60, place["y"] + 30)
    tab.mouse.down()
    tab.mouse.move(place["x"] + 120, place["y"] + 300, steps=4)
    tab.mouse.up()
    chosen = points(tab)

    assert 0 < chosen < before
    rest = points(tab, "#against-panels .cloud.after.dim")
    assert rest == before - chosen
    assert "chosen" in tab.locator(".told").inner_text()
    assert tab.locator("#chosen tbody tr").count() > 0
    tab.keyboard.press("Escape")
    assert points(tab) == before


@pytest.mark.parametrize("width", [360, 768, 1600])
def test_it_fits_the_screen(written, look, width):
    """Nothing is wider than the screen, and no text of the page is smaller than 10 px."""
    tab = look(written, width=width)

    assert tab.evaluate("document.documentElement.scrollWidth") <= width
    sizes = tab.eval_on_selector_all(
        "svg text, p, td, th, dd, dt",
        "all => all.map(one => parseFloat(getComputedStyle(one).fontSize)"
        " * (one.ownerSVGElement ? one.ownerSVGElement.getBoundingClientRect().width"
        " / one.ownerSVGElement.viewBox.baseVal.width : 1)).filter(size => size > 0)",
    )
    assert min(sizes) > 9.5


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_words_stand_out_from_their_ground(written, look, scheme):
    """Every colour of text has a contrast of 4.5 to the card, in the light and in the dark."""
    tab = look(written, scheme=scheme)
    names = ("--ink", "--soft", "--before", "--after", "--good", "--bad", "--maybe", "--card")
    colours = {
        name: tab.evaluate(
            "name => { const probe = document.createElement('i'); document.body.append(probe);"
            " probe.style.color = `var(${name})`; return getComputedStyle(probe).color; }",
            name,
        )
        for name in names
    }
    ground = luminance(colours.pop("--card"))

    for name, colour in colours.items():
        light, dark = sorted((luminance(colour), ground), reverse=True)
        assert (light + 0.05) / (dark + 0.05) > 4.3, name


def luminance(colour):
    """Return the relative luminance of `rgb(r, g, b)` as the WCAG defines it."""
    parts = [int(part) / 255 for part in colour.strip("rgb()").split(",")]
    linear = [p / 12.92 if p <= 0.03928 else ((p + 0.055) / 1.055) ** 2.4 for p in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def test_show_before_alone(written, look):
    """The segments draw before, after or both."""
    tab = look(written)
    tab.locator(".segments .before").click()

    assert points(tab) == 0
    assert points(tab, "#against-panels .cloud.before:not(.dim)") > 0


def test_where_nothing_is_missing_there_are_residuals_and_no_switches(look, tmp_path):
    """A page without findings has one set of residuals, called so, and no console message."""
    quiet = replace(recordings(), y=np.random.default_rng(2).normal(0, 2.4e-5, 240))
    path = page.write(*page.of_diagnosis(diagnose(quiet, load("altaz"))), tmp_path / "r.html")
    tab = look(path)
    captions = tab.locator("#sky-panels figcaption").all_inner_texts()

    assert tab.said == []
    assert captions == ["residuals", "residuals, over azimuth and elevation"]
    assert tab.locator(".segments, .chip, .card").count() == 0
    assert points(tab) == 2 * 240 * tab.locator("#against-panels svg").count()
