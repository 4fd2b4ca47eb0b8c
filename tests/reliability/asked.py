"""What a user asks for, to be spoilt: options of commands, arguments of the Python interface."""

from __future__ import annotations

import contextlib
import functools
import io
import os
import random
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
import pyarrow
import seeds
from astropy import units
from astropy.table import Table
from pandas import DataFrame

import pyport
from pyport import cli
from pyport.errors import BadInput
from pyport.recordings.formats.text import read_text

ABOUT_FILE = b"--where\nel_deg < 45\n--set\nlongitude_deg=18\n--from\ncsv\n--mount\naltaz\n"
#: A command: what stands before its options, and options that are right, a word a line.
COMMANDS = {
    "fit": (
        ("fit", "night.csv", "--json", "--model", "altaz"),
        (
            b"--model\naltaz\n--fix\ncollimation=3arcsec\n--add\nsag_sine\n--drop\nskew\n--per\nsource\n"
            b"--weights\nequal\n--level\n0.9\n"
        ),
    ),
    "look": (
        ("look", "night.csv", "--json"),
        b"--model\naltaz\n--noise\n3\n--next\n2\n--sources\n--elevations\n10\n80\n",
    ),
    "targets": (
        ("targets", "night.csv", "--json"),
        (
            b"--count\n3\n--start\n2026-03-01T02:10:00\n--hours\n4\n--elevations\n10\n80\n--slew\n1\n1\n"
            b"--dwell\n60\n--sun\n20\n--format\ncsv\n"
        ),
    ),
    "predict": (("predict", "night.csv", "--json"), b"--against\nnone\n--rehearse\n--seed\n1\n"),
    "apply": (("apply", "model.mod", "night.csv", "--json"), b"--residuals\n"),
    "convert": (("convert", "night.csv", "converted.dat"), b"--to\ncsv\n--leave-out\n"),
    "mask": (("mask", "night.csv", "--json"), b"--lines\n3-5,7\n--reason\ncloud\n"),
    "compare": (("compare", "model.mod", "model.mod", "--json"), b"--beam\n60\n--accept\n"),
    "table": (
        ("table", "-o", "table.txt"),
        (
            b"--az\n0:10:1\n--zd\n10:20:5\n--refraction\nnone\n--format\nbinary\n--azimuth-zero\nsouth\n"
            b"--model\nrt32-3model\n--set\ntemperature_c=1\n"
        ),
    ),
    "lookup": (("lookup", "table.bin"), b"--az\n1\n--zd\n12.5\n--json\n"),
}


def _of_no_file(command: str) -> bool:
    return command in {"table", "lookup"}


def asked_seeds(command: str) -> tuple[bytes, ...]:
    """Return right options of a command: each alone, and all."""
    alone = COMMANDS[command][1]
    return (alone,) if _of_no_file(command) else (alone, ABOUT_FILE, alone + ABOUT_FILE)


def ask(command: str) -> Callable[[Path], None]:
    """Return what takes a file's lines for the options of a command."""

    def read(path: Path) -> None:
        words = read_text(path).splitlines()
        if any("/" in one for one in words):
            raise BadInput("a place elsewhere, which a user may name", path)
        os.chdir(path.parent)
        for old in path.parent.iterdir():
            old.unlink()
        Path("night.csv").write_bytes(seeds.PLAIN)
        Path("model.mod").write_bytes(seeds.MOD)
        Path("table.bin").write_bytes(_table())
        _called([*COMMANDS[command][0], *words])

    return read


_table = functools.cache(seeds.binary)


def _called(words: list[str]) -> None:
    """Call pyport in this process; raise what ends it as a fault, and BadInput for a refusal."""
    said = io.StringIO()
    sys.argv = ["pyport", *words]
    cli._end_with_fault = _raise  # to see what was raised
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(said):
        try:
            cli.main()
        except SystemExit as end:
            if end.code == 2:
                raise BadInput(said.getvalue().removesuffix("\n")) from None
            if end.code != 0:
                raise


def _raise(error: BaseException) -> NoReturn:
    raise error


def _column(rng: random.Random, rows: int) -> Any:
    numbers = np.linspace(20, 80, rows)
    return rng.choice((
        numbers, numbers[:-1], numbers[:0], numbers[:, None], numbers + 1j, numbers.astype("f4"),
        numbers.astype(int), numbers.astype(str), numbers.astype(object), list(numbers),
        numbers * np.nan, numbers * np.inf, numbers.astype("S"), numbers * units.deg,
        numbers * units.m, np.ma.masked_greater(numbers, 50), numbers.astype("M8[s]"),
        numbers.astype("m8[s]"), numbers[::-1], numbers > 50, 1.0, "x", None, [], [None] * rows,
        [[1], [2, 3]], np.float64(3), np.zeros(rows, "f8,f8"), object(), {1: 2}, b"x", range(rows),
        np.broadcast_to(1.0, rows), np.array(["é"] * rows), np.array([b"\xff"] * rows),
    ))  # fmt: skip


def _table_of(rng: random.Random) -> Any:
    rows = rng.choice((0, 1, 2, 20, 20, 20))
    table: Any = {
        "az_deg": np.linspace(-170, 170, rows),
        "el_deg": np.linspace(10, 80, rows) % 70 + 10,
        "d_xel_arcsec": np.sin(np.arange(rows)),
        "d_el_arcsec": np.cos(np.arange(rows)),
    }
    for _ in range(rng.choice((0, 1, 1, 2))):
        others = ("time_utc", "antenna", "session", "source", "sigma_el_deg", "temperature_c",
                  "scan_direction", "mine", "", "az_rad", 5, None)  # fmt: skip
        table[rng.choice((*table, *others))] = _column(rng, rows)
    kind = rng.choice((dict, dict, DataFrame, Table, pyarrow.table))
    if kind is not dict:
        try:
            table = kind(table)
        except Exception:  # noqa: BLE001 - no such table can be made
            return table
    return rng.choice((table,) * 9 + (_anything(rng),))


def _anything(rng: random.Random) -> Any:
    texts = ("", "x", "altaz", "none", "IE", "tilt", "equal", "robust", "antenna", "nowhere.csv",
             "gmrt-2003-03-31", "é\0", "x" * 5000, "tilt=3arcsec", "all", "2026-03-01")  # fmt: skip
    plain = (None, True, False, 0, -1, 3, 10**30, 1e308, np.nan, np.inf, -0.0, 1j, b"x", object(),
             float, len, Path("nowhere"), Path())  # fmt: skip
    arrays = (np.zeros((2, 2)), np.array(1.0), np.zeros(0), np.array(["x"]), np.array(None),
              3 * units.arcsec, 3 * units.m, np.arange(3) * units.deg, np.float32(2))  # fmt: skip
    inside = rng.choice((*texts, *plain, *arrays))
    boxes: tuple[Any, ...] = ([inside], (inside, 1), [], {}, {"tilt": inside}, {1: inside},
                              {"latitude_deg": inside}, range(3), (10, 80))  # fmt: skip
    return rng.choice((rng.choice(texts), rng.choice(plain), rng.choice(arrays), rng.choice(boxes)))


def call(path: Path) -> None:
    """Draw a call of the Python interface from a file's bytes."""
    os.chdir(path.parent)
    rng = random.Random(path.read_bytes())  # noqa: S311 - no secret
    model, watch = seeds.watched()
    given = {
        pyport.fit: ("add", "drop", "fix", "weights", "per", "header"),
        pyport.look: ("noise_arcsec", "count", "elevations", "sources", "header"),
        pyport.diagnose: ("refit", "seed", "header"),
        pyport.Watch: ("pointings_per_false_alarm", "header"),
        pyport.load_model: (),
        model.offsets: ("time", "temperature", "antenna", "location", "mine"),
        model.correct: ("time", "temperature", "antenna", "location", "mine"),
        model.inverse: ("time", "temperature", "antenna", "location", "mine"),
        model.save: ("rest_as", "leave_out", "temperature_c"),
        watch.update: (),
    }
    what = rng.choice(tuple(given))
    names = rng.sample(given[what], min(rng.choice((0, 0, 1, 2)), len(given[what])))
    words = {name: _anything(rng) for name in names}
    if what in {pyport.fit, pyport.look, pyport.diagnose, pyport.Watch}:
        table = _table_of(rng)
        if what in {pyport.diagnose, pyport.Watch} and not words and rng.random() < 0.95:
            table = _anything(rng)  # a right one takes a thousand times as long
        first = [table, rng.choice(("altaz", "altaz", "none", model, _anything(rng)))]
    elif what == watch.update:
        row = {"az_deg": 3.0, "el_deg": 40.0, "d_xel_arcsec": 0.5, "d_el_arcsec": 1.0}
        first = [rng.choice((row | {rng.choice(tuple(row)): _anything(rng)}, _anything(rng)))]
    elif what in {pyport.load_model, model.save}:
        first = [_anything(rng)]
    else:
        right = [np.linspace(20, 80, 20), 40.0]
        first = [rng.choice((*right, _column(rng, 20), _anything(rng))) for _ in range(2)]
    what(*first, **words)
