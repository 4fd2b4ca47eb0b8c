"""What tests of several packages share."""

import os
import shutil

import pytest
import rt32
from hypothesis import settings

from pyport.parity.compiled import oracle as compiled
from pyport.parity.compiled import stored
from pyport.pointing import kernel

# how long an example takes says something about the machine's other work, nothing about the program
settings.register_profile("pyport", deadline=None)
settings.load_profile("pyport")

CHROMIUM = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")


@pytest.fixture(scope="module", params=["numpy", "kernel"])
def both_paths(request):
    """Run a module's tests by numpy, and by the compiled kernel where it is installed."""
    if request.param == "kernel" and kernel.KERNEL is None:
        pytest.skip("the kernel is not installed: make wheel")
    with pytest.MonkeyPatch.context() as patch:
        if request.param == "numpy":
            patch.setattr(kernel, "KERNEL", None)
        yield


@pytest.fixture(scope="session")
def same_library():
    """Skip where the C library rounds otherwise than the one that the stored answers come from."""
    made_with = rt32.known("table")[0][1].provenance["maths_library"]
    if stored.maths_library() != made_with:
        pytest.skip("this C library's sines differ in last bits from the stored answers' one")


@pytest.fixture(scope="session")
def oracle():
    """Return the compiled Fortran; skip without compilers, fail where PYPORT_ORACLE=required."""
    if not compiled.available(rt32.DESCRIPTION):
        pytest.skip("no gfortran, C compiler or Python.h on this machine")
    return compiled.of(rt32.DESCRIPTION.path, "reference")


def missing(why):
    """Skip for want of a browser, or fail where one is required."""
    if os.environ.get("PYPORT_BROWSER") == "required":
        pytest.fail(why)
    pytest.skip(why)


@pytest.fixture(scope="session")
def browser():
    """Start a headless Chromium of the system's; skip where there is none."""
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        missing("playwright is not installed (pip install playwright)")
    found = next(filter(None, map(shutil.which, CHROMIUM)), None)
    if found is None:
        missing("Chromium is not installed (sh .ci/install chromium)")
    with sync_playwright() as play:
        started = play.chromium.launch(executable_path=found, args=["--no-sandbox"])
        yield started
        started.close()
