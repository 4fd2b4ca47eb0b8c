"""What tests of several packages share."""

import pytest

from pyport.parity.answers import find_oracle


@pytest.fixture(scope="session")
def oracle():
    """Return the compiled Fortran; skip without it, fail where PYPORT_ORACLE=required."""
    module = find_oracle()
    if module is None:
        pytest.skip("the compiled routines are not installed (pip install ./legacy_fortran)")
    return module
