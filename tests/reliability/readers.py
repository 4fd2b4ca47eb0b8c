"""Every reader of pyport: where its code is, good files to start from, and how it is called."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pyport.effects import Circumstances
from pyport.fitting.models import load
from pyport.formats.convert import convert
from pyport.formats.terms.ska_mid import UNITS, UNPUBLISHED
from pyport.recordings import masks, read
from pyport.recordings.antennas import read_survey
from pyport.recordings.formats import csv
from pyport.recordings.scans.measure import measure
from pyport.recordings.where import where
from pyport.steering import Grid, Table, offsets_at, read_table, write_ascii, write_binary
from pyport.steering.lookup import answers
from pyport.trials.published import read_seal

NIGHT = (
    b"# latitude_deg: 53\n# azimuth_zero: south\n"
    b"az_deg,el_deg,d_xel_arcsec,d_el_arcsec,sigma_el_arcsec,time_utc,source,scan_direction\n"
    b'-90,40,1.5,-2,0.5,2003-06-01T12:00:00Z,"Cyg A, core",1\n10,50,,3,,,3C84,-1\n'
)
ECSV = (
    b"# %ECSV 1.0\n# ---\n# datatype:\n# - {name: az, unit: deg, datatype: float64}\n"
    b"# - {name: el_deg, datatype: float64}\n# - {name: d_el, unit: arcsec, datatype: float64}\n"
    b"# - {name: source, datatype: string}\n# meta: !!omap\n# - {latitude_deg: '53'}\n"
    b"# delimiter: ','\n# schema: astropy-2.0\naz,el_deg,d_el,source\n1,30,2.5,3C84\n2,40,,x\n"
)
SCANS = (
    b"scan,antenna,time_utc,power,expected_utc,scan_axis,scan_direction,"
    b"scan_rate_arcmin_per_min,az_deg,el_deg\n"
    + b"".join(
        b"1,C00,2003-06-01T18:%02d:%02d,%.3f,2003-06-01T18:40:00,az,1,20,52.75,60\n"
        % (39 + n // 60, n % 60, 5 + np.exp(-(((n - 60) / 30) ** 2)))
        for n in range(0, 120, 4)
    )
)
CTL = b"* x\n 1 2014 290 0 0 0\n*\n 35.0 1 0 1 1 1\n0.1 0 0.2 0.3 0.4\n"
SKA = {
    "coefficients": {
        name: {"value": 0.5 * (name not in UNPUBLISHED), "units": unit, "used": True}
        for name, unit in UNITS.items()
    }
}
SEAL = {
    "schema": "pyport.sealed/1",
    "name": "a-set",
    "solver_sha256": "00",
    "examiner_sha256": "00",
    "thresholds": {"null_claims_most": 0.05},
    "cases": [
        {
            "case": "case-0001",
            "recordings_sha256": "00",
            "truth_commitment": "00",
            "arguments": ["--model", "none"],
        }
    ],
}
AT = Circumstances(np.array([0.1, 2.0]), np.array([0.3, 1.2]))


@dataclass(frozen=True)
class Reader:
    """A reader: the suffix of its files, good ones, what reads them, and which modules that is."""

    name: str
    suffix: str
    seeds: tuple[bytes, ...]
    read: Callable[[Path], object]
    modules: tuple[str, ...]


def recordings(path: Path) -> None:
    """Read recordings, and write them as CSV."""
    read(path)
    convert(str(path), path.with_name("converted.csv"))


def model(path: Path) -> None:
    """Read a model, and let it predict."""
    load(str(path)).offsets(AT)


def description(path: Path) -> None:
    """Take a file's text for katpoint's description of a model."""
    load(csv.read_text(path)).offsets(AT)


def filtered(path: Path) -> None:
    """Take a file's text for a filter of recordings."""
    night = path.with_name("night.csv")
    night.write_bytes(NIGHT)
    where(read(night), csv.read_text(path))


def mask(path: Path) -> None:
    """Take a file for the mask beside recordings."""
    night = path.with_name("night.csv")
    night.write_bytes(NIGHT)
    path.replace(masks.path_of(night))
    try:
        read(night)
    finally:
        masks.path_of(night).unlink()


def table(path: Path) -> None:
    """Read a steering table, and look its first direction up."""
    found = read_table(path)
    offsets_at(found, found.grid.az_deg[0], found.grid.zd_deg[0])


def places(path: Path) -> None:
    """Take a file for the directions that a table is asked for."""
    list(answers(_table(), csv.read_text(path).splitlines(), path.name))


def _table() -> Table:
    zero = np.zeros((3, 2))
    return Table(Grid(np.arange(3.0), np.array([10.0, 20.0])), zero, zero)


def _written(write: Callable[[Path], object]) -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "seed"
        write(path)
        return path.read_bytes()


def _parquet() -> bytes:
    def write(path: Path) -> None:
        night = path.with_name("night.csv")
        night.write_bytes(NIGHT)
        convert(str(night), path.with_name("seed.parquet"))
        path.with_name("seed.parquet").replace(path)

    return _written(write)


def _modules(names: Iterable[str]) -> tuple[str, ...]:
    return tuple(f"pyport.{name}" for name in names)


def readers() -> dict[str, Reader]:
    """Return all readers by name."""
    raw = ("recordings.interpret", "recordings.raw", "recordings.columns")
    lines = ("formats.lines",)
    sections = ("formats.field_system.sections", *lines)
    terms = ("formats.model_file", *lines)
    all_of_them = (
        ("csv", ".csv", (NIGHT,), recordings, ("recordings.formats.csv", *raw)),
        ("ecsv", ".ecsv", (ECSV,), recordings, ("recordings.formats.tables", *raw)),
        ("parquet", ".parquet", (_parquet(),), recordings, ("recordings.formats.tables", *raw)),
        (
            "tpoint-dat",
            ".dat",
            (
                (
                    b"Mine\n: ALTAZ\n: ROTNL\n-30 14 40.3\n10.5 20.1 10.6 20.2 5 ; x\n"
                    b";1 2 3 4 5\n2 3 nan 4 5\nEND\n"
                ),
            ),
            recordings,
            ("formats.tpoint_dat", *lines, *raw),
        ),
        (
            "fs-xtr",
            ".xtr",
            (b"$antenna\n TEST azel 1\n$data\n 1 10.5 20.1 0.01 0.02 0.001 0.001\n$stats\n",),
            recordings,
            ("formats.field_system.xtr", *sections, *raw),
        ),
        (
            "fs-err",
            ".err",
            (
                b"$antenna\n TEST azel 1\n$observed\n 1 10.5 20.1 0.01 0.02 0.03\n"
                b"$new_model\n" + CTL,
            ),
            recordings,
            ("formats.field_system.xtr", *sections, *raw),
        ),
        (
            "katpoint-csv",
            ".csv",
            (
                (
                    b"# antenna = x, -30:42:39.8, 21:26:38.0, 1086.6\n"
                    b"target, azimuth, elevation, delta_azimuth, delta_elevation, keep\n"
                    b"A, 1, 20, 0.1, 0.2, 1\n"
                ),
            ),
            recordings,
            ("formats.katpoint_csv", *lines, *raw),
        ),
        ("scans", ".csv", (SCANS,), measure, ("recordings.scans.measure", "recordings.scans.beam")),
        (
            "survey",
            ".csv",
            (b"name,east_m\nC00,1.5\nC01,-3\n",),
            read_survey,
            ("recordings.antennas",),
        ),
        ("mask", ".mask", (b"+ 4 #6de07f3b | cloud\n+ 5-5 #0 |\n",), mask, ("recordings.masks",)),
        (
            "filter",
            ".txt",
            (b'el_deg < 45 and not (source in ("3C84", \'x\') or time_utc >= "2003-06-01")',),
            filtered,
            ("recordings.where",),
        ),
        (
            "toml-effects",
            ".toml",
            (
                (
                    b'name = "mine"\n[[term]]\neffect = "azimuth_zero"\nvalue_arcsec = 3\n'
                    b'[[term]]\neffect = "tilt"\nper = ["antenna"]\nvalue_deg = [0.1, 0.2]\n'
                ),
            ),
            model,
            ("fitting.models",),
        ),
        (
            "toml-terms",
            ".toml",
            (
                (
                    b'vocabulary = "tpoint"\n[[term]]\nname = "IA"\nvalue_arcsec = 1.5\n'
                    b"fixed = true\n"
                    b"[details]\nx = 1\n"
                ),
            ),
            model,
            ("formats.toml_model", *terms),
        ),
        (
            "tpoint-mod",
            ".mod",
            (
                (
                    b"Mine\nT   54   3.1416    0.000   0.0000\n  IA  -292.0063  2.1\n"
                    b"& HSCA5CE8 -6.8 2\n= TF 3\nEND\n"
                ),
            ),
            model,
            ("formats.tpoint_mod", *terms),
        ),
        ("fs-ctl", ".ctl", (CTL,), model, ("formats.field_system.ctl", *terms)),
        (
            "katpoint",
            ".txt",
            (
                b"-0:04:45.1 0 0:00:08.2 0:01:00.5 0 0 0 0 0.001\n",
                b"[header]\na = x\n[params]\np1 = 0:00:10.5 ; deg (x)\n",
            ),
            model,
            ("formats.katpoint_model", *terms),
        ),
        (
            "katpoint-description",
            ".txt",
            (b"-0:04:45.1 0 0:00:08.2 0:01:00.5",),
            description,
            ("formats.katpoint_model", *terms),
        ),
        (
            "ska-mid",
            ".json",
            (json.dumps(SKA).encode(),),
            model,
            ("formats.ska_mid", *terms),
        ),
        (
            "discos",
            ".xml",
            (
                (
                    b"<P><Receiver><receiverCode>X</receiverCode><phi>90.0</phi>"
                    b"<coefficientNum00>1</coefficientNum00>"
                    b"<coefficientVal00>0.1</coefficientVal00>"
                    b"</Receiver></P>"
                ),
            ),
            model,
            ("formats.discos", *terms),
        ),
        (
            "table-binary",
            ".bin",
            (_written(lambda path: write_binary(_table(), path)),),
            table,
            ("steering.binary", "steering.lookup"),
        ),
        (
            "table-ascii",
            ".txt",
            (_written(lambda path: write_ascii(_table(), path)),),
            table,
            ("steering.ascii", "steering.lookup"),
        ),
        ("table-places", ".txt", (b"1 10\n0.5 12.5\n",), places, ("steering.lookup",)),
        ("seal", ".json", (json.dumps(SEAL).encode(),), read_seal, ("trials.published",)),
    )
    return {
        name: Reader(name, suffix, seeds, call, _modules(modules))
        for name, suffix, seeds, call, modules in all_of_them
    }
