"""What tests of several packages share."""

import pytest
from hypothesis import settings

from pyport.parity import stored
from pyport.parity.answers import find_oracle, of_legacy
from pyport.parity.points import table

# how long an example takes says something about the machine's other work, nothing about the program
settings.register_profile("pyport", deadline=None)
settings.load_profile("pyport")


@pytest.fixture(scope="session")
def table_answers():
    """Return what the legacy port answers over the whole table, which takes it two seconds."""
    return of_legacy(table())


@pytest.fixture(scope="session")
def same_library():
    """Skip where the C library rounds otherwise than the one that the stored answers come from."""
    made_with = stored.load("table").provenance["maths_library"]
    if stored.maths_library() != made_with:
        pytest.skip("this C library's sines differ in last bits from the stored answers' one")


@pytest.fixture(scope="session")
def oracle():
    """Return the compiled Fortran; skip without it, fail where PYPORT_ORACLE=required."""
    module = find_oracle()
    if module is None:
        pytest.skip("the compiled routines are not installed (pip install ./legacy_fortran)")
    return module
