"""docs/parity.md says what the ports do now."""

from pathlib import Path

import pytest

from pyport.legacy import PARITY
from pyport.parity.described.loading import load
from pyport.parity.document import document
from pyport.parity.run import run

pytestmark = pytest.mark.slow

PAGE = Path(__file__).parents[2] / "docs" / "parity.md"


@pytest.fixture(scope="module")
def page():
    """Return the page as it would be written now, from the stored answers."""
    return document(run(load(PARITY), live=False))


@pytest.mark.usefixtures("same_library")
def test_page_is_not_stale(page):
    """The page in the tree is what `make parity-report` writes."""
    assert PAGE.read_text(encoding="utf-8") == page, "docs/parity.md is stale: make parity-report"
