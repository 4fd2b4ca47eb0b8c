"""A headless Chromium for the tests of the page, and the pages that they look at."""

import pytest
from pages import HOSTILE, recordings

from pyport import page
from pyport.diagnosis.diagnose import diagnose
from pyport.formats.models import load


@pytest.fixture(scope="session")
def diagnosis():
    """Return a diagnosis of recordings whose antenna bears a hostile name."""
    return diagnose(recordings(antenna=HOSTILE), load("altaz"))


@pytest.fixture(scope="session")
def written(diagnosis, tmp_path_factory):
    """Return the path of the page of that diagnosis."""
    return page.write(*page.of_diagnosis(diagnosis), tmp_path_factory.mktemp("page") / "r.html")


@pytest.fixture
def look(browser):
    """Return a function that opens a page and says what its console said."""
    opened = []

    def open_page(path, width=1200, scheme="light", **options):
        tab = browser.new_page(
            viewport={"width": width, "height": 900}, color_scheme=scheme, **options
        )
        tab.said = []
        tab.on("console", lambda message: tab.said.append(message.text))
        tab.on("pageerror", lambda error: tab.said.append(str(error)))
        tab.on("request", lambda request: tab.said.append(f"asked for {request.url}"))
        tab.goto(path.as_uri())
        tab.wait_for_selector("html[data-ready]", state="attached", timeout=20000)
        tab.said.remove(f"asked for {path.as_uri()}")
        opened.append(tab)
        return tab

    yield open_page
    for tab in opened:
        tab.close()
