"""The typed report: what is written, what the manual lists, and that both are the same."""

import dataclasses
import json
import re
from collections.abc import Iterator
from pathlib import Path
from types import UnionType
from typing import Any, get_args, get_origin, get_type_hints

import numpy as np
import pytest

import pyport
from pyport.report.keys import keys, markdown
from pyport.report.typed import Report, as_json

MANUAL = Path(__file__).parents[2] / "docs" / "report.md"
#: What stands in a file only where there is something to say.
WHERE_THERE = {"array", "reduction"}


def wrong(told: Any, kind: Any, path: str) -> Iterator[str]:
    """Yield where JSON is not what a type says."""
    if get_origin(kind) is UnionType:
        if told is not None:
            yield from wrong(
                told, next(one for one in get_args(kind) if one is not type(None)), path
            )
    elif dataclasses.is_dataclass(kind):
        hints = get_type_hints(kind)
        named = {
            one.name.rstrip("_"): hints[one.name]
            for one in dataclasses.fields(kind)
            if one.metadata.get("written", True)
        }
        yield from (f"{path}.{one}" for one in (told.keys() ^ named.keys()) - WHERE_THERE)
        for name in told.keys() & named.keys():
            yield from wrong(told[name], named[name], f"{path}.{name}")
    elif get_origin(kind) in {tuple, list}:
        for n, one in enumerate(told):
            yield from wrong(one, get_args(kind)[0], f"{path}[{n}]")
    elif get_origin(kind) is dict:
        for name, one in told.items():
            yield from wrong(one, get_args(kind)[1], f"{path}.{name}")
    elif kind is not Any and not isinstance(
        told, (int, float, type(None)) if kind is float else kind
    ):
        yield f"{path}: {told!r}"


@pytest.fixture(scope="module")
def report() -> dict[str, Any]:
    """Return the report of a drawn night whose dish sags."""
    rng = np.random.default_rng(5)
    az, el = rng.uniform(0, 360, 120), rng.uniform(15, 85, 120)
    table = {
        "az_deg": az,
        "el_deg": el,
        "d_xel_arcsec": rng.normal(0, 3, 120),
        "d_el_arcsec": 40 * np.sin(np.radians(el)) + rng.normal(0, 3, 120),
    }
    return pyport.diagnose(table, "altaz").report


@pytest.mark.slow
def test_a_report_is_of_its_types(report: dict[str, Any]) -> None:
    """Every key of a real report stands in the typed one, with its type, and none is missing."""
    assert report["findings"]
    assert list(wrong(report, Report, "report")) == []


def test_what_is_of_another_type_is_seen(report: dict[str, Any]) -> None:
    """A key that is missing, new or of another type is found by the test above."""
    spoilt = json.loads(json.dumps(report))
    del spoilt["p_value"]
    spoilt["findings"][0]["evidence"]["delta_bic"] = "large"
    spoilt["noise"]["news"] = 1

    assert sorted(wrong(spoilt, Report, "report")) == [
        "report.findings[0].evidence.delta_bic: 'large'",
        "report.noise.news",
        "report.p_value",
    ]


def test_the_manual_lists_the_keys() -> None:
    """The page of keys is the one that `pyport dev keys` writes."""
    assert MANUAL.read_text("utf-8") == markdown()


def test_no_key_is_without_a_meaning() -> None:
    """Every key is listed once, in words."""
    paths = [path for path, _, _ in keys()]

    assert len(paths) == len(set(paths))
    assert all(meaning for _, _, meaning in keys())


def test_what_is_not_finite_is_null() -> None:
    """JSON has no NaN: a number that is not known is null, and a tuple a list."""
    assert as_json((1.0, float("nan"), {"a": float("inf")})) == [1.0, None, {"a": None}]


def test_one_function_makes_null_of_what_is_not_finite() -> None:
    """Beside it one below the report, where it cannot be had; the examiner borrows nothing."""
    package = Path(pyport.__file__).parent
    own = re.compile(r"if (math|np)\.isfinite\(\w+(\.\w+|\[\w+\])*\) else None")
    found = {
        one.relative_to(package).as_posix()
        for one in package.rglob("*.py")
        if "examiner" not in one.parts and own.search(one.read_text("utf-8"))
    }

    assert found == {"report/typed.py", "fitting/table.py"}
