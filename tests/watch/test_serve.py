"""The live page: what it sends, to whom, and that a browser draws it as the log grows."""

import json
import os
import urllib.error
import urllib.request

import pytest
from drawn_nights import text, world, write

from pyport.recordings.from_table import from_table
from pyport.watch import Watch
from pyport.watch.live import live
from pyport.watch.run import Options, Process
from pyport.watch.serve import Live, serve

pytest.importorskip("uvicorn", reason="the extra `serve` is not installed")

#: Tests that run side by side serve from ports of their own.
PORT = 18765 + 10 * int(os.environ.get("PYTEST_XDIST_WORKER", "gw0").removeprefix("gw"))


@pytest.fixture(scope="module")
def watch():
    """Return a watch in whose night a tilt came."""
    drawn = world()
    made = Watch(drawn.past, header=drawn.header)
    list(made.replay(from_table(drawn.watched, drawn.header).take(slice(0, 45))))
    return made


@pytest.fixture(scope="module")
def page(watch):
    """Serve its page."""
    shown = Live()
    shown.show(live(watch))
    served = serve(shown, port=PORT)
    yield served, shown
    served.stop()


def ask(path, **headers):
    """Return status, headers and text of a request."""
    request = urllib.request.Request(f"http://127.0.0.1:{PORT}{path}", headers=headers)
    try:
        with urllib.request.urlopen(request, timeout=5) as answer:  # noqa: S310 - likewise
            return answer.status, answer.headers, answer.read().decode()
    except urllib.error.HTTPError as error:
        return error.code, error.headers, error.read().decode()


@pytest.mark.usefixtures("page")
def test_what_is_shown_is_what_the_watch_knows(watch):
    """Alarms, running terms with errors, the evidence, and where to point next."""
    told = json.loads(ask("/state.json")[2])

    assert told["alarms"][0]["effect"] == "tilt"
    night = sum(one.time > watch.recent[-1].time - 43200 for one in watch.recent)
    assert len(told["recent"]) == len(told["running"]) == night
    lean = told["running"][-1]
    for name, one in zip(("north", "east"), watch.standing[0].parameters, strict=True):
        assert abs(lean[name][0] - one["value"]) < 4 * lean[name][1]
    assert all(10 <= one["el_deg"] <= 85 for one in told["next"])


def test_while_an_alarm_is_named_the_next_pointing_decides():
    """The directions are those in which the likeliest names differ most."""
    drawn = world()
    made = Watch(drawn.past, header=drawn.header)
    list(made.replay(from_table(drawn.watched, drawn.header).take(slice(0, 20))))

    assert made.standing[0].state == "raised"
    assert "differ there by" in live(made)["next"][0]["why"]


@pytest.mark.usefixtures("page")
def test_the_page_is_its_own_and_closed():
    """No script from elsewhere, no frame, no guess of types."""
    status, headers, body = ask("/")

    assert status == 200
    assert "watch.js" in body
    assert "default-src 'none'" in headers["content-security-policy"]
    assert headers["x-content-type-options"] == "nosniff"


@pytest.mark.usefixtures("page")
@pytest.mark.parametrize(
    "headers",
    [
        {"Host": "evil.example"},
        {"Host": f"evil.example:{PORT}"},
        {"Origin": "http://evil.example"},
        {"Sec-Fetch-Site": "cross-site"},
    ],
)
def test_other_sites_are_refused(headers):
    """A rebound name, another origin, a request from another site's page."""
    assert ask("/state.json", **headers)[0] == 403
    assert ask("/events", **headers)[0] == 403


@pytest.mark.usefixtures("page")
@pytest.mark.parametrize("method", ["POST", "PUT", "DELETE"])
def test_nothing_can_be_written(method):
    """The page only reads."""
    request = urllib.request.Request(f"http://127.0.0.1:{PORT}/state.json", b"{}", method=method)
    with pytest.raises(urllib.error.HTTPError, match="405"):
        urllib.request.urlopen(request, timeout=5)  # noqa: S310 - likewise


@pytest.mark.browser
def test_a_browser_draws_the_night_as_it_goes_on(tmp_path, browser):
    """A log grows, an alarm appears, a name like markup stays text, a reload shows it all."""
    drawn = world()
    write(tmp_path / "past.csv", drawn.past, drawn.header)
    above, rows = text(drawn.watched, drawn.header)
    log = tmp_path / "night.csv"
    log.write_text("".join(above + rows[:14]))
    shown = Live()
    options = Options(log, "altaz", tmp_path / "out", history=str(tmp_path / "past.csv"))
    process = Process(options, lambda _: None, lambda _: None)
    process.show = lambda one: shown.show(live(one) | {"antenna": "<img src=x onerror=alert(1)>"})
    served = serve(shown, port=PORT + 1)
    try:
        list(process.step())
        tab = browser.new_page()
        faults = []
        tab.on("pageerror", lambda error: faults.append(str(error)))
        tab.goto(served.address)
        tab.wait_for_selector("#state:text-matches('^14 p')")
        assert tab.locator("#alarms li").count() == 0
        with log.open("a") as file:
            file.writelines(rows[14:45])
        list(process.step())
        tab.wait_for_selector("#alarms li")
        assert "the azimuth axis leans" in tab.locator("#alarms li").first.inner_text()
        assert tab.locator("#sky line").count() == len(live(process.watch)["recent"]) > 5
        assert tab.locator("#zeros polyline").count() == 2
        tab.reload()
        tab.wait_for_selector("#alarms li")
        assert faults == []
        assert tab.locator("img").count() == 0
    finally:
        served.stop()
