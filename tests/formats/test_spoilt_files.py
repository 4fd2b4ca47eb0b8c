"""Spoilt files of every format: read, or refused in one line; never anything else."""

import json

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from pyport.effects import Circumstances
from pyport.errors import BadInput
from pyport.formats import models
from pyport.models.terms.field_system import UNITS, UNPUBLISHED
from pyport.recordings import read

TABLES = {
    "a.dat": "Mine\n: ALTAZ\n: ROTNL\n-30 14 40.3\n10.5 20.1 10.6 20.2 5 ; x\n;1 2 3 4 5\nEND\n",
    "a.xtr": "$antenna\n TEST azel 1\n$data\n 1 10.5 20.1 0.01 0.02 0.001 0.001\n$stats\n",
    "a.err": "$antenna\n TEST azel 1\n$observed\n 1 10.5 20.1 0.01 0.02 0.03\n$old_model\n",
    "a.csv": "# antenna = x, -30:42:39.8, 21:26:38.0, 1086.6\n"
    "target, azimuth, elevation, delta_azimuth, delta_elevation\nA, 1, 20, 0.1, 0.2\n",
}
MODELS = {
    "a.mod": "Mine\nT   54   3.1416    0.000   0.0000\n  IA  -292.0063  2.1\n"
    "& HSCA5CE8 -6.8 2\nEND\n",
    "a.ctl": "* x\n 1 2014 290 0 0 0\n*\n 35.0 1 0 1 1 1\n0.1 0 0.2 0.3 0.4\n",
    "a.txt": "-0:04:45.1 0 0:00:08.2 0:01:00.5 0 0 0 0 0.001\n",
    "a.cfg": "[header]\na = x\n[params]\np1 = 0:00:10.5 ; deg (x)\n",
    "a.json": json.dumps(
        {
            "coefficients": {
                name: {"value": 0.5 * (name not in UNPUBLISHED), "units": unit, "used": True}
                for name, unit in UNITS.items()
            }
        }
    ),
    "a.xml": "<P><Receiver><receiverCode>X</receiverCode><phi>90.0</phi>"
    "<coefficientNum00>1</coefficientNum00><coefficientVal00>0.1</coefficientVal00>"
    "</Receiver></P>",
    "a.toml": 'vocabulary = "tpoint"\n[[term]]\nname = "IA"\nvalue_arcsec = 1.5\nfixed = true\n',
}
AT = Circumstances(np.array([0.1, 2.0]), np.array([0.3, 1.2]))

#: Cut, double or replace something at a place.
spoils = st.lists(
    st.tuples(
        st.sampled_from(["cut", "double", "put"]),
        st.floats(0, 1),
        st.integers(1, 12),
        st.one_of(
            st.sampled_from(["\n", " ", ",", "nan", "-", "1e999", "$", "#", ";", "\0", "é", "="]),
            st.text(max_size=3),
        ),
    ),
    min_size=1,
    max_size=4,
)


def spoilt(text, changes):
    """Return a text with some changes."""
    for kind, share, length, piece in changes:
        place = int(share * len(text))
        if kind == "cut":
            text = text[:place] + text[place + length :]
        elif kind == "double":
            text = text[:place] + text[place : place + length] * 2 + text[place + length :]
        else:
            text = text[:place] + piece + text[place + length :]
    return text


def attempt(action, path):
    """Do something; a refusal must name the file, on one line."""
    try:
        action()
    except BadInput as refused:
        assert "\n" not in str(refused)  # noqa: PT017 - most spoilt files are refused
        assert str(path) in str(refused) or refused.file is None  # noqa: PT017


@pytest.mark.parametrize("name", [*TABLES, *MODELS])
@settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(changes=spoils)
def test_spoilt_files(tmp_path, name, changes):
    """One line, or recordings, or a model that gives offsets."""
    path = tmp_path / name
    text = spoilt({**TABLES, **MODELS}[name], changes)
    path.write_text(text, encoding="utf-8", errors="replace")

    if name in TABLES:
        attempt(lambda: read(path), path)
    else:
        attempt(lambda: models.read(path).model("spoilt").offsets(AT), path)


@pytest.mark.parametrize("name", [*TABLES, *MODELS])
def test_what_is_spoilt_was_good(tmp_path, name):
    """Each of them unspoilt."""
    path = tmp_path / name
    path.write_text({**TABLES, **MODELS}[name])

    if name in TABLES:
        assert len(read(path)) == 1
    else:
        assert models.read(path).entries


@pytest.mark.parametrize("name", [*TABLES, *MODELS])
@pytest.mark.parametrize("content", [b"", b"\n\n", b"\xff\xfe\0", b"\0" * 5])
def test_empty_and_binary_files_are_refused(tmp_path, name, content):
    """By file and line."""
    path = tmp_path / name
    path.write_bytes(content)

    with pytest.raises(BadInput, match="expected"):
        read(path) if name in TABLES else models.read(path)
