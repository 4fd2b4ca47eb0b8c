"""Saved models that were spoilt: one clear line when they are read, no wrong offsets afterwards."""

import copy
import re

import numpy as np
import pytest

from pyport import api
from pyport.errors import BadInput
from pyport.toml_text import toml_spelled

TERM = {
    "effect": "unknown",
    "per": ["antenna"],
    "variant": "waves",
    "finding": 1,
    "member": {
        "bumps": {"kind": "waves", "each": [[1, 0], [2, 1]]},
        "axes": [0, 1],
        "which": [0, 3],
        "directions": [[1.0, 0.0], [0.0, 1.0]],
        "family": "a field",
        "variant": "waves",
    },
    "coefficients": [
        {"name": f"field_{n}", "value": 1.5, "sigma": 0.1, "before": 0.0, "unit": "arcsec"}
        for n in (1, 2)
    ],
}
MODEL = {
    "schema": "pyport.model/1",
    "name": "saved",
    "site": {"latitude_deg": 53.0, "longitude_deg": 18.0, "height_m": 100.0},
    "mount": "altaz",
    "made": {"by": "pyport", "rows": 10},
    "term": [TERM],
    "covariance": {"lower_triangle": [[0.01], [0.0, 0.01]]},
}
BUMPS = "term", 0, "member", "bumps"
COEFFICIENT = "term", 0, "coefficients", 0


def saved(folder, place=(), value=None):
    """Write a saved model, with another value at a place; return its file."""
    whole = one = copy.deepcopy(MODEL)
    for key in place[:-1]:
        one = one[key]
    if place:
        one[place[-1]] = value
    path = folder / "saved.toml"
    path.write_text(toml_spelled(whole))
    return path


def offsets(path):
    """Return the offsets of a model over the sky."""
    return api.load_model(path).offsets(np.linspace(0, 360, 5), np.linspace(5, 85, 5))


def test_the_model_is_one(tmp_path):
    """Unspoilt it has offsets."""
    assert np.isfinite([one.value for one in offsets(saved(tmp_path))]).all()


@pytest.mark.parametrize(
    ("place", "value", "says"),
    [
        (("schema",), "pyport.model/2", "schema is 'pyport.model/2', expected 'pyport.model/1'"),
        (("mount",), "hexapod", "hexapod"),
        (("site", "latitude_deg"), float("nan"), "latitude_deg has nan, expected a number"),
        (("site", "latitude_deg"), 530.0, "latitude_deg is 530.0, expected one from -90 to 90"),
        ((*COEFFICIENT, "value"), float("nan"), "field_1 has nan, expected a number"),
        ((*COEFFICIENT, "sigma"), float("inf"), "field_1 has inf, expected a number"),
        ((*COEFFICIENT, "unit"), "mas", "field_1 is in 'mas'"),
        (("term", 0, "coefficients"), [], "0 coefficients, expected 2"),
        (("term", 0, "finding"), float("inf"), "not a model as pyport writes it"),
        (("covariance", "lower_triangle"), [[float("nan")], [0.0, 1.0]], "what is no number"),
        (("covariance", "lower_triangle"), [[1.0]], "no lower triangle of 2 rows"),
        (("term", 0, "member", "which"), [0, 99], "tells no member"),
        (("term", 0, "member", "directions"), [[1.0, 0.0]], "tells no member"),
        (("term", 0, "member", "axes"), [0], "tells no member"),
        ((*BUMPS, "each"), [[1, 0], [2, "x"]], "tells no member"),
        ((*BUMPS, "each"), [[1, 0], [2, 1e308]], "more bumps than any recordings"),
        (BUMPS, {"kind": "sky"}, "tells no member"),
        (BUMPS, {"kind": "azimuth", "width_rad": float("inf")}, "tells no member"),
        (BUMPS, {"kind": "wave", "around": 1, "upward": 1e308}, "more bumps than any recordings"),
        (BUMPS, {"kind": "curve", "name": 3, "low": 0, "high": 1, "order": 4}, "names of columns"),
    ],
    ids=str,
)
def test_spoilt_model_is_one_line(tmp_path, place, value, says):
    """Refused when it is read, with the file and what is wrong."""
    path = saved(tmp_path, place, value)
    with pytest.raises(BadInput, match=re.escape(says)) as refused:
        offsets(path)

    assert str(path) in str(refused.value)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("share", np.linspace(0.02, 0.98, 25).tolist())
def test_truncated_model_is_one_line(tmp_path, share):
    """Cut anywhere it is refused: no part of a model is a model."""
    path = saved(tmp_path)
    text = path.read_text()
    path.write_text(text[: int(share * len(text))])

    with pytest.raises(BadInput) as refused:
        offsets(path)
    assert str(path) in str(refused.value)
