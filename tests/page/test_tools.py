"""What one does with the page, in a browser: find one's way, take things along, fit again."""

import csv
import json
import shlex

import numpy as np
import pytest
from click.testing import CliRunner
from pages import recordings

import pyport
from pyport import page
from pyport.angles import ARCSEC
from pyport.cli import pyport as program
from pyport.fitting.fit import fit
from pyport.formats.models import load
from pyport.recordings import write

pytestmark = pytest.mark.browser

#: Main-thread seconds that opening may take, by recordings, and choosing some of them.
OPENS_S, CHOOSES_S = {5000: 1.0, 50000: 3.0}, 0.2


@pytest.fixture(scope="module")
def night(tmp_path_factory):
    """Return a folder with a night, and the page of its fit with all readings alike."""
    folder = tmp_path_factory.mktemp("night")
    write(recordings(), folder / "night.csv")
    done = pyport.fit(folder / "night.csv", "altaz", weights="equal")
    page.write(*done.drawn, folder / "report.html")
    return folder


def drag(tab, selector, low=(0.2, 0.2), high=(0.5, 0.8)):
    """Drag a box over a share of a panel."""
    panel = tab.locator(selector).first
    panel.scroll_into_view_if_needed()
    box = panel.bounding_box()
    at = [(box["x"] + a * box["width"], box["y"] + b * box["height"]) for a, b in (low, high)]
    tab.mouse.move(*at[0])
    tab.mouse.down()
    tab.mouse.move(*at[1], steps=3)
    tab.mouse.up()


def taken(tab, button):
    """Return the name and the text of what a button downloads."""
    with tab.expect_download() as caught:
        tab.get_by_role("button", name=button, exact=True).first.click()
    return caught.value.suggested_filename, caught.value.path().read_text()


def values(tab):
    """Return the values of the terms that were fitted again, NaN for none."""
    cells = tab.locator("#refit-table tbody tr td:nth-child(4)")
    return [float(text) for text in cells.evaluate_all("all => all.map(c => c.dataset.value)")]


def test_the_contents_lead_to_every_section(written, look):
    """Each link names a section that is there; following it brings that to the top."""
    tab = look(written)
    names = tab.locator("nav a").evaluate_all("all => all.map(a => a.getAttribute('href'))")
    sections = tab.locator("section").evaluate_all("all => all.map(s => '#' + s.id)")
    tab.locator("nav a[href='#parameters']").click()

    assert names == sections
    assert len(names) > 6
    assert 0 <= tab.locator("#parameters h2").bounding_box()["y"] < 200


def test_the_sky_is_in_the_first_screen(written, look):
    """Without scrolling, on a screen of 1280 x 900: the residual vectors beside the verdict."""
    tab = look(written, width=1280)
    box = tab.locator("#first-sky svg").bounding_box()

    assert box["y"] + box["height"] < 900
    assert "M" in tab.locator("#first-sky .vectors path").nth(2).get_attribute("d")


def test_the_bulls_eye_and_how_many_within(night, look):
    """The rings and the curve say the rms, half and nine tenths of the residuals."""
    tab = look(night / "report.html")
    left = pyport.fit(night / "night.csv", "altaz", weights="equal").result
    size = np.zeros(240)
    np.add.at(size, left.stack.row, (left.residual / ARCSEC) ** 2)
    rms, (half, most) = np.sqrt(size.mean()), np.quantile(np.sqrt(size), [0.5, 0.9])
    eye, curve = tab.locator("#spread-panels figure .axis").all_text_contents()[:2]

    assert float(eye.split()[1].rstrip(",")) == pytest.approx(rms, rel=0.02)
    assert float(curve.split()[2].rstrip(",")) == pytest.approx(half, rel=0.05)
    assert float(curve.split()[6]) == pytest.approx(most, rel=0.05)
    drag(tab, "#spread-panels svg", (0.5, 0.1), (0.9, 0.5))
    assert "chosen" in tab.locator(".told").inner_text()


def test_hysteresis_is_drawn_against_the_move_before(look, tmp_path):
    """A lag of the drive is a step at no move: the medians on its sides differ by twice it."""
    made = recordings(600)
    step = (np.diff(made.at.az, prepend=np.nan) + np.pi) % (2 * np.pi) - np.pi
    step[np.diff(made.at.column("time"), prepend=0) > 86400] = np.nan
    made.y[:] += 30 * ARCSEC * np.sign(np.nan_to_num(step))
    tab = look(page.write(*page.of_fit(fit(made, load("altaz"))), tmp_path / "r.html"))
    panel = tab.locator("#spread-panels figure", has_text="azimuth moved since")
    path = panel.locator(".median.after").nth(1).get_attribute("d")
    heights = [float(part.split()[1]) for part in path[1:].split("L")]
    third = len(heights) // 3

    assert panel.count() == 1
    assert panel.locator("figcaption").inner_text() == "hysteresis in azimuth"
    assert min(heights[:third]) - max(heights[-third:]) > 8


def test_the_model_the_rows_and_the_figures_can_be_taken_along(night, look, tmp_path):
    """A model that `load_model` reads, a table of residuals, panels with their style in them."""
    tab = look(night / "report.html")
    name, text = taken(tab, "model")
    (tmp_path / name).write_text(text)
    done = pyport.fit(night / "night.csv", "altaz", weights="equal")
    kept = pyport.load_model(tmp_path / name)

    assert name == "night.toml"
    assert [one.value for one in kept.values] == [one.value for one in done.model.values]
    name, text = taken(tab, "rows")
    rows = list(csv.DictReader(text.splitlines()))
    told = np.array([float(row["residual_elevation_after_arcsec"]) for row in rows])
    stack = done.result.stack
    assert (name, len(rows)) == ("night-rows.csv", 240)
    np.testing.assert_allclose(told, done.result.residual[stack.is_y] / ARCSEC, atol=0.02)
    name, text = taken(tab, "SVG")
    assert name.endswith(".svg")
    parsed = (
        "text => new DOMParser().parseFromString(text, 'image/svg+xml').documentElement.nodeName"
    )
    assert tab.evaluate(parsed, text) == "svg"
    assert "stroke:rgb" in text
    name, text = taken(tab, "figures")
    assert text.count("<svg") == tab.locator("main .drawing svg").count()
    assert tab.said == [one for one in tab.said if "blob:" in one]


def test_the_page_fits_again_as_its_command_does(night, look):
    """Masked, held and left out: the copied commands give the same numbers to a millionth."""
    tab = look(night / "report.html")
    tab.get_by_role("button", name="fit", exact=True).click()
    first = pyport.fit(night / "night.csv", "altaz", weights="equal")
    np.testing.assert_allclose(values(tab), [one.value for one in first.model.values], rtol=1e-6)
    drag(tab, "#against-panels svg")
    tab.get_by_role("button", name="mask the chosen recordings").click()
    tab.locator("select[aria-label^=skew]").select_option("held")
    tab.locator("select[aria-label^=collimation]").select_option("left out")
    words = tab.locator(".command").inner_text().splitlines()
    for line in words:
        asked = shlex.split(line)[1:]
        model = str(night / "night.toml")
        first.save(model)
        here = {"night.csv": str(night / "night.csv"), "night.toml": model}
        asked = [here.get(one, one) for one in asked]
        done = CliRunner().invoke(program, [*asked, "--json"])
        assert done.exit_code == 0, done.output
    told = {one["name"]: one["value"] for one in json.loads(done.output)["parameters"]}
    shown = dict(zip([one.name for one in first.model.values], values(tab), strict=True))
    masked = int(tab.locator(".told-again").inner_text().split("; ")[1].split()[0])
    counted, _, every, *rest = tab.locator("#bar .told").inner_text().split(" ")
    (night / "night.csv.mask").unlink()

    assert 5 < masked < 200
    assert int(counted) == int(every) - masked
    assert " ".join(rest).startswith("recordings, the others masked: rms ")
    assert shown.pop("collimation") == 0
    assert shown.pop("skew") == first.coefficients["skew[W06]"].value
    assert "collimation" not in told
    for name, value in shown.items():
        assert told[name] == pytest.approx(value, rel=1e-6, abs=1e-6)


def test_a_term_that_was_held_is_freed(night, look, tmp_path):
    """Held at 3 arcsec in the fit of the page, fitted in the page: as the command has it."""
    held = pyport.fit(night / "night.csv", "altaz", fix=["collimation=3"], weights="equal")
    tab = look(page.write(*held.drawn, tmp_path / "held.html"))
    tab.locator("select[aria-label^=collimation]").select_option("fitted")
    line = tab.locator(".command").inner_text()
    free = pyport.fit(night / "night.csv", "altaz", weights="equal")
    names = [one.name for one in held.model.values]
    shown = dict(zip(names, values(tab), strict=True))
    held.save(tmp_path / "night.toml")
    here = {"night.csv": str(night / "night.csv"), "night.toml": str(tmp_path / "night.toml")}
    asked = [here.get(one, one) for one in shlex.split(line)[1:]]
    done = CliRunner().invoke(program, [*asked, "--json"])

    assert line.endswith("--weights equal --drop collimation --add collimation")
    told = {one["name"]: one["value"] for one in json.loads(done.output)["parameters"]}
    for one in free.model.values:
        assert shown[one.name] == pytest.approx(one.value, rel=1e-6)
        assert told[one.name] == pytest.approx(one.value, rel=1e-6)


def test_what_is_fitted_again_is_drawn_and_taken_back(night, look):
    """Without sag and refraction's help the elevation residuals grow; then all is as it was."""
    tab = look(night / "report.html")
    before = tab.locator(".told").inner_text()
    tab.locator("select[aria-label^=sag]").select_option("left out")
    grown = tab.locator(".told").inner_text()
    tab.get_by_role("button", name="back to the page's values").click()

    assert float(grown.split("→ ")[-1].split()[0]) > float(before.split("→ ")[-1].split()[0])
    assert tab.locator(".told").inner_text() == before
    tab.get_by_role("button", name="copy the command").click()
    assert "pyport fit night.csv" in tab.evaluate("getSelection().toString()")


def test_a_term_that_the_rest_draws_is_not_determined(written, look):
    """A finding's page can be fitted again too; two columns that are one have no values."""
    tab = look(written)
    found = tab.evaluate("document.querySelectorAll('#refit-table tbody tr').length")
    tab.get_by_role("button", name="fit", exact=True).click()

    assert found == 8
    assert np.isfinite(values(tab)).all()
    assert tab.said == []


def test_correlations_of_many_terms_scroll_in_their_box(look, tmp_path):
    """Forty names are wider than a telephone: the matrix scrolls, the page does not."""
    names = [f"H{result}{wave}A{k}" for result in "ES" for wave in "SC" for k in range(1, 10)]
    wide = pyport.fit(
        recordings(600), "altaz", add=[one for one in names if one not in ("HESA", "HECA")]
    )
    tab = look(page.write(*wide.drawn, tmp_path / "r.html"), width=390)
    box = tab.locator(".heat").locator("..")

    assert tab.evaluate("document.documentElement.scrollWidth") <= 390
    assert box.evaluate("one => one.scrollWidth > one.clientWidth")


def test_it_prints_on_few_pages(written, look):
    """A diagnosis on A4: six at most, without what only a screen can do."""
    tab = look(written)
    pdf = tab.pdf(format="A4")

    assert 2 <= pdf.count(b"/Type /Page\n") + pdf.count(b"/Type /Page ") <= 6


@pytest.mark.parametrize("n", OPENS_S)
def test_many_recordings_open_and_are_chosen_quickly(n, browser, tmp_path):
    """Seconds of the page's thread, whatever else the machine does; what is left out is said."""
    done = fit(recordings(n), load("altaz"), weights="equal")
    path = page.write(*page.of_fit(done), tmp_path / "r.html")
    tab = browser.new_page(viewport={"width": 1280, "height": 900})
    session = tab.context.new_cdp_session(tab)
    session.send("Performance.enable", {"timeDomain": "threadTicks"})

    def spent():
        told = session.send("Performance.getMetrics")["metrics"]
        return next(one["value"] for one in told if one["name"] == "TaskDuration")

    tab.goto(path.as_uri())
    tab.wait_for_selector("html[data-ready]", state="attached")
    opened = spent()
    panel = tab.locator("#against-panels svg").nth(1)
    panel.scroll_into_view_if_needed()
    box = panel.bounding_box()
    tab.mouse.move(box["x"] + 60, box["y"] + 30)
    tab.mouse.down()
    start = spent()
    tab.mouse.move(box["x"] + 120, box["y"] + 300)
    tab.mouse.up()
    chosen = spent() - start
    said = tab.locator("#sky .how").inner_text()
    tab.close()

    assert 0.01 < opened < OPENS_S[n]
    assert chosen < 2 * CHOOSES_S
    assert f"of {n:,} recordings are drawn" in said
