"""The sets of public recordings: read by readers of the examiner's own, as arrays and tables."""

from __future__ import annotations

import subprocess
import sys
import tempfile
import tomllib
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyport.examiner import program, scores
from pyport.examiner.real.readers import READERS, Read, numbers, recordings
from pyport.examiner.scores import Array

#: Recordings further apart than this are of different nights, where none says which. [h]
NIGHT_H = 6.0
_ARCSEC = {"deg": 3600.0, "arcmin": 60.0, "arcsec": 1.0}


@dataclass(frozen=True)
class Recordings:
    """n pointings of a set, as the examiner reads them, and what it asks of them.

    `name`: what the set is called.
    `table`, `header`: the recordings as the program is given them.
    `az`, `el`, `x`, `y`: azimuth from north and elevation [rad], offsets across and along [arcsec],
      NaN for none.
    `night`: labels: the sessions, or nights by gaps in time; one where neither is known.
    `group`: which rows share coefficients: an antenna in a session, or all, "".
    `model`: the model that is fitted, in the program's name.
    `hour_angle`: where the model is a wave in it [rad].
    `file`: the file as it was published; None where the set is no single one.
    `facts`: what was published of the set, and how it is looked for.
    `public`: whether it is another telescope's: subsets of a few rows are drawn of those.
    """

    name: str
    table: dict[str, Any]
    header: dict[str, float | str]
    az: Array
    el: Array
    x: Array
    y: Array
    night: NDArray[Any]
    group: NDArray[Any]
    model: str = "altaz"
    hour_angle: Array | None = None
    file: Path | None = None
    facts: tuple[dict[str, Any], ...] = ()
    public: bool = True
    step_arcsec: float = 0.0

    def __len__(self) -> int:
        """Return n."""
        return len(self.el)

    @property
    def names(self) -> tuple[str, ...]:
        """Return the coefficients of the model."""
        return scores.ALTAZ if self.hour_angle is None else scores.HOUR_ANGLE

    def columns(self) -> Array:
        """Return the columns of the model, shape (n, 2, k)."""
        if self.hour_angle is None:
            return scores.altaz(self.az, self.el)
        return scores.hour_angle(self.hour_angle)

    def offsets(self) -> Array:
        """Return the offsets [arcsec], shape (n, 2)."""
        return np.stack([self.x, self.y], axis=1)

    def take(self, rows: NDArray[Any]) -> Recordings:
        """Return some of the rows."""
        return replace(
            self,
            table={name: np.asarray(cells)[rows] for name, cells in self.table.items()},
            **{name: getattr(self, name)[rows] for name in ("az", "el", "x", "y")},
            night=self.night[rows],
            group=self.group[rows],
            hour_angle=None if self.hour_angle is None else self.hour_angle[rows],
            file=None,
        )


def catalogue() -> list[dict[str, Any]]:
    """Return what is known of every set, from the table of published facts."""
    text = (Path(__file__).parent / "published.toml").read_text(encoding="utf-8")
    found: list[dict[str, Any]] = tomllib.loads(text)["set"]
    return found


def read(entry: dict[str, Any], data: Path | None) -> Recordings | str:
    """Return the recordings of a set, or why they are not there."""
    if entry["format"] == "shipped":
        files = [program.shipped(entry["files"][0])]
    elif entry["format"] == "simulated":
        return _finish(entry, *_simulated(), None)
    elif data is None:
        return "no folder of data"
    else:
        files = [data / name for name in entry["files"]]
    missing = [str(file) for file in files if not file.is_file()]
    if missing:
        return f"not there: {', '.join(missing)}"
    reader = READERS[entry["format"]]
    tables, headers = zip(*(reader(file) for file in files), strict=True)
    joined = {
        name: np.concatenate([one[name] for one in tables])
        for name in tables[0]
        if all(name in one for one in tables)
    }
    return _finish(entry, joined, headers[0], files[0] if len(files) == 1 else None)


def _finish(
    entry: dict[str, Any],
    table: dict[str, NDArray[Any]],
    header: dict[str, float | str],
    file: Path | None,
) -> Recordings:
    header = header | entry.get("header", {})
    el = np.radians(numbers(table["el_deg"]))
    turn = np.pi if header.get("azimuth_zero") == "south" else 0.0
    az = np.radians(numbers(table["az_deg"])) + turn
    across, step_x = _angle(table, "d_xel")
    around, step_a = _angle(table, "d_az")
    along, step_y = _angle(table, "d_el")
    x = np.where(np.isfinite(across), across, around * np.cos(el))
    kept = np.isfinite(x) | np.isfinite(along)
    if "set_aside" in table:
        kept &= table["set_aside"] == ""
    night = _nights(table)
    wave = entry.get("model") == "gmrt-paper"
    dropped = entry.get("drop", [])
    table = {name: cells for name, cells in table.items() if name not in dropped}
    group = np.full(len(el), "", dtype="U40")
    if wave:
        group = np.char.add(np.char.add(table["antenna"], "|"), table["session"])
    hour = np.radians(15 * numbers(table["hour_angle_h"])) if wave else None
    found = Recordings(
        entry["name"], table, header, az, el, x, along, night, group,
        model=entry.get("model", "altaz"),
        hour_angle=hour,
        facts=tuple(entry.get("fact", ())),
        public=entry["format"] not in {"shipped", "simulated"},
        step_arcsec=min([one for one in (step_x, step_a, step_y) if one > 0], default=0.0),
    )  # fmt: skip
    return replace(found.take(np.flatnonzero(kept)), file=None if dropped else file)


def _angle(table: dict[str, NDArray[Any]], name: str) -> tuple[Array, float]:
    """Return an offset of the table [arcsec], NaN where it is not measured, and its last digit."""
    for unit, arcsec in _ARCSEC.items():
        if f"{name}_{unit}" in table:
            cells = table[f"{name}_{unit}"].astype(str)
            digits = max(len(one.partition(".")[2]) for one in cells.tolist())
            return numbers(cells) * arcsec, 10.0**-digits * arcsec
    return np.full(len(next(iter(table.values()))), np.nan), 0.0


def _nights(table: dict[str, NDArray[Any]]) -> NDArray[Any]:
    if "session" in table:
        return table["session"]
    if "time_utc" in table:
        time = table["time_utc"].astype("datetime64[ms]")
        order = np.argsort(time, kind="stable")
        gap = np.diff(time[order], prepend=time[order[0]]) / np.timedelta64(1, "h")
        night = np.empty(len(time), dtype=int)
        night[order] = np.cumsum(gap > NIGHT_H)
        return night.astype(str)
    return np.full(len(next(iter(table.values()))), "one")


def _simulated() -> Read:
    """Let the program make its stand-in for a campaign that was never published."""
    with tempfile.TemporaryDirectory() as folder:
        words = [sys.executable, "-m", "pyport", "study", "rt32", "--out", folder, "--quiet"]
        subprocess.run(words, check=True, capture_output=True)  # noqa: S603 - this program
        (file,) = Path(folder).glob("*.csv")
        return recordings(file)
