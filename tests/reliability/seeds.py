"""Good files of every format that pyport reads, to be spoilt."""

from __future__ import annotations

import functools
import json
import tempfile
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path

import numpy as np

import pyport
from pyport.correction.use import PointingModel
from pyport.formats.convert import convert
from pyport.models.terms.field_system import UNITS, UNPUBLISHED
from pyport.recordings import masks
from pyport.recordings.files import read_raw
from pyport.steering import Grid, Table, write_ascii, write_binary
from pyport.watch import Watch
from pyport.watch.follow import Cursor
from pyport.watch.state import save as keep

NIGHT = (
    b"# latitude_deg: 53\n# azimuth_zero: south\n"
    b"az_deg,el_deg,d_xel_arcsec,d_el_arcsec,sigma_el_arcsec,time_utc,source,scan_direction\n"
    b'-90,40,1.5,-2,0.5,2003-06-01T12:00:00Z,"Cyg A, core",1\n10,50,,3,,,3C84,-1\n'
)
PLAIN = (
    b"# latitude_deg: 53\naz_deg,el_deg,d_az_arcsec,d_el_arcsec,time_utc,source,wind_speed_m_s\n"
    + b"".join(
        b"%d,%d,1.5,-2,2003-06-01T12:%02d:00Z,3C84,%d\n" % (n, 20 + n, n, n % 7) for n in range(20)
    )
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
CTL = b"* x\n 1 2014 290 0 0 0\n*\n 35.0 1 0 1 0 0\n0.1 0 0.2 0 0\n"
DAT = (
    b"Mine\n: ALTAZ\n: ROTNL\n-30 14 40.3\n10.5 20.1 10.6 20.2 5 ; x\n;1 2 3 4 5\n"
    b"2 3 nan 4 5\nEND\n"
)
EQUATORIAL = (
    b"Mine\n: EQUAT\n53 05 43.8 2003 6 1\n"
    b"01 02 03.0 20 30 40.0 01 02 05.0 20 30 30.0 03 10.5\n"
    b"05 12 03.0 -10 30 40.0 05 12 05.0 -10 30 30.0 04 10.5\nEND\n"
)
MINE = b"date;AZd;ELd;dX;dE\n2003-06-01T12:00:00;10;30;1;2\n2003-06-01T12:10:00;20;40;3;1\n"
MAP = (
    b'[columns]\naz_deg = "AZd"\nel_deg = "ELd"\nd_xel_arcsec = "-dX"\nd_el_arcsec = "5"\n'
    b'time_utc = "date"\nsession = "date|date"\n'
)
CATALOGUE = b"name,ra_h,dec_deg\n3C84,3.33,41.5\nCyg A,19.99,40.73\n"
KATPOINT_CSV = (
    b"# antenna = x, -30:42:39.8, 21:26:38.0, 1086.6\n"
    b"target, azimuth, elevation, delta_azimuth, delta_elevation, keep\nA, 1, 20, 0.1, 0.2, 1\n"
)
SURVEY = b"name,east_m\nC00,1.5\nC01,-3\n"
FILTER = b'el_deg < 45 and not (source in ("3C84", \'x\') or time_utc >= "2003-06-01")'
TOML_EFFECTS = (
    b'name = "mine"\n[[term]]\neffect = "azimuth_zero"\nvalue_arcsec = 3\n'
    b'[[term]]\neffect = "tilt"\nper = ["antenna"]\nvalue_deg = [0.1, 0.2]\n'
)
TOML_TERMS = (
    b'vocabulary = "tpoint"\n[[term]]\nname = "IA"\nvalue_arcsec = 1.5\nfixed = true\n'
    b"[details]\nx = 1\n"
)
MOD = (
    b"Mine\nT   54   3.1416    0.000   0.0000\n  IA  -292.0063  2.1\n"
    b"& HSCA5CE8 -6.8 2\n= TF 3\nEND\n"
)
KATPOINT = (
    b"-0:04:45.1 0 0:00:08.2 0:01:00.5 0 0 0 0 0.001",
    b"[header]\na = x\n[params]\np1 = 0:00:10.5 ; deg (x)\n",
    b"m000, -30:42:39.8, 21:26:38.0, 1086.6, 13.5, 1 2 3, -0:04:45.1 0 0:00:08.2, 1.22\n",
)
DISCOS = (
    b"<P><Receiver><receiverCode>X</receiverCode><phi>90.0</phi>"
    b"<coefficientNum00>1</coefficientNum00><coefficientVal00>0.1</coefficientVal00>"
    b"</Receiver></P>"
)
SKA = json.dumps(
    {
        "coefficients": {
            name: {"value": 0.5 * (name not in UNPUBLISHED), "units": unit, "used": True}
            for name, unit in UNITS.items()
        }
    }
).encode()
SEAL = json.dumps(
    {
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
).encode()
ANSWERS = json.dumps(
    {"opened_utc": "2026-01-01T00:00:00+00:00", "reports_sha256": {"case-0001": "00"}}
).encode()
REPORT = json.dumps(
    {
        "examined": {"seconds": 1.5, "rows_sha256": "00"},
        "mismatch": True,
        "p_value": 0.01,
        "findings": [
            {
                "effect": "refraction",
                "class": ["refraction"],
                "verdict": "named",
                "where": {
                    "region": [{"column": "el_deg", "low": 5.0, "high": None}],
                    "curve": [{"az_deg": 1.0, "el_deg": 20.0}],
                    "since": "2003-06-01T12:00:00Z",
                },
                "parameters": [{"name": "r", "value": 58.1, "sigma": 0.4, "expected": None}],
                "evidence": {"runner_up": "sag_sine"},
            }
        ],
    }
).encode()
#: Data of the Field System's, and unit responses of its parameters.
XTR = (
    b"$antenna\n TEST azel 1\n$data\n"
    + b"".join(
        b" 1 %d %d %.4f %.4f 0.001 0.001\n" % (23 * n % 360, 10 + 7 * n, 0.01 + n / 900, 0.02)
        for n in range(11)
    )
    + b"$stats\n"
)
GRID = (
    b"phi_deg,param,az_deg,el_deg,dx_per_unit,dy_per_unit\n"
    b"90,P1,30,45,1,0\n90,P1,60,50,1,0\n90,P7,30,45,0,1\n"
)


def table() -> Table:
    """Return a steering table of six directions."""
    zero = np.zeros((3, 2))
    return Table(Grid(np.arange(3.0), np.array([10.0, 20.0])), zero, zero)


def written(write: Callable[[Path], object]) -> bytes:
    """Return the bytes that something writes."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "seed"
        write(path)
        return path.read_bytes()


def parquet(text: bytes = NIGHT) -> bytes:
    """Return recordings as Parquet."""

    def write(path: Path) -> None:
        night = path.with_name("night.csv")
        night.write_bytes(text)
        convert(str(night), path.with_name("seed.parquet"))
        path.with_name("seed.parquet").replace(path)

    return written(write)


def binary() -> bytes:
    """Return a binary table."""
    return written(lambda path: write_binary(table(), path))


def ascii_table() -> bytes:
    """Return an ASCII table."""
    return written(lambda path: write_ascii(table(), path))


def fit() -> bytes:
    """Return what the Field System writes of a fit, models included."""

    def write(path: Path) -> None:
        data, model = path.with_name("a.xtr"), path.with_name("a.ctl")
        data.write_bytes(XTR)
        model.write_bytes(CTL)
        convert(str(data), path.with_name("a.err"), model=str(model))
        path.with_name("a.err").replace(path)

    return written(write)


def completed() -> bytes:
    """Return a model that a fit completed, with errors and covariance."""

    def write(path: Path) -> None:
        watched()[0].save(path.with_suffix(".toml"))
        path.with_suffix(".toml").replace(path)

    return written(write)


def state() -> bytes:
    """Return the state of a watch."""
    return written(lambda path: keep(watched()[1], path, asdict(Cursor())))


@functools.cache
def watched() -> tuple[PointingModel, Watch]:
    """Return a model fitted to recordings, and a watch that they are the past of."""
    rng = np.random.default_rng(0)
    rows = 100
    past = {
        "az_deg": rng.uniform(-170, 170, rows),
        "el_deg": rng.uniform(10, 80, rows),
        "d_xel_arcsec": rng.normal(size=rows),
        "d_el_arcsec": rng.normal(size=rows),
    }
    return pyport.fit(past).model, Watch(past)


def mask() -> bytes:
    """Return a mask of the recordings, with a step that takes another back."""

    def write(path: Path) -> None:
        night = path.with_name("night.csv")
        night.write_bytes(NIGHT)
        raw = read_raw(night)
        masks.add(raw, (4, 5), "cloud")
        masks.add(raw, (5,), "", masks=False)
        masks.path_of(night).replace(path)

    return written(write)
