"""The commands that torture.py kills: how each is called for an old and for a new answer."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from pyport.examiner.sealed import files
from pyport.examiner.sealed.protocol import Spec
from pyport.formats.convert import convert

ROWS = 60


def _nothing(_: Path) -> None:
    """Prepare nothing."""


@dataclass(frozen=True)
class Victim:
    """A command and its kills.

    Attributes
    ----------
    name
        What it is called in the table of kills.
    old, new
        Its words for an old and for a new answer, but for the last one.
    out
        The file or folder that it writes, the last word.
    share
        Of all kills, in parts.
    resumes
        Whether run once more after a kill it gives the new answer.
    prepare
        Puts what it needs into the folder of its answer.
    """

    name: str
    old: tuple[str, ...]
    new: tuple[str, ...]
    out: str
    share: float
    resumes: bool = True
    prepare: Callable[[Path], None] = _nothing


def specs() -> list[Spec]:
    """Return the cases of the set whose solving is killed."""
    return [
        Spec("null", "null", rows=ROWS, noise="white"),
        Spec("one", "one", "refraction", 1.0, ROWS),
        Spec("unknown", "unknown", "mixed_wave", 1.0, ROWS),
    ]


def victims(folder: Path) -> dict[str, Victim]:
    """Return the commands to kill by name; makes the files that they read."""
    paths = []
    for number, name in enumerate(("old", "new")):
        night = folder / "given" / name / "night.csv"
        paths.append(str(night))
        if not night.exists():
            case = Spec("one", "one", "refraction", 1.0, ROWS * (1 + number)).make(number)
            files.write_recordings(case, night)
            for part in ("C00", "C01"):
                place = night.parent / "set" / f"antenna={part}"
                place.mkdir(parents=True)
                convert(str(night), place / "night.parquet")
    old, new = paths
    sets = [str(Path(path).parent / "set") for path in paths]
    few = ("--az", "0:10:1")
    binary = ("table", "--format", "binary")
    recordings = {"csv": 8, "ecsv": 8, "parquet": 8, "dat": 8}
    models = {"mod": 3, "toml": 3, "json": 3, "xml": 3, "ctl": 3}
    model = _model(folder)

    def beside(place: Path) -> None:
        shutil.copyfile(new, place / "night.csv")

    found = [
        Victim("table", ("table", *few, "-o"), ("table", "-o"), "table.txt", 16),
        Victim("table, binary", (*binary, *few, "-o"), (*binary, "-o"), "table.bin", 16),
        *(
            Victim(f"convert to {kind}", ("convert", old), ("convert", new), f"night.{kind}", share)
            for kind, share in recordings.items()
        ),
        *(
            Victim(
                f"model to {kind}",
                ("convert", "--leave-out", model["old"]),
                ("convert", "--leave-out", model["new"]),
                f"model.{kind}",
                share,
            )
            for kind, share in models.items()
        ),
        Victim(
            "fit",
            ("fit", "--model", "altaz", old, "--out"),
            ("fit", "--model", "altaz", new, "--out"),
            "answer",
            16,
        ),
        Victim("look", ("look", old, "--out"), ("look", new, "--out"), "answer", 8),
        Victim(
            "mask",
            ("mask", "--lines", "20"),
            ("mask", "--lines", "21"),
            "night.csv",
            6,
            resumes=False,  # a second call would be a second step
            prepare=beside,
        ),
        Victim(
            "plot",
            ("plot", old, "--panel", "sky", "--panel", "azel", "--of", "fit", "--out"),
            ("plot", new, "--panel", "sky", "--panel", "azel", "--of", "fit", "--out"),
            "answer",
            6,
        ),
        Victim(
            "effects",
            ("dev", "effects", "-o"),
            ("dev", "effects", "--markdown", "-o"),
            "effects.md",
            4,
        ),
        Victim("diagnose", ("diagnose", old, "--out"), ("diagnose", new, "--out"), "answer", 20),
        Victim(
            "diagnose a data set",
            ("diagnose", sets[0], "--out"),
            ("diagnose", sets[1], "--out"),
            "answer",
            8,
        ),
        Victim(
            "parity",
            ("dev", "effects", "-o"),
            ("parity", "--stored", "--report"),
            "parity.md",
            4,
        ),
    ]
    return {one.name: one for one in found}


def _model(folder: Path) -> dict[str, str]:
    """Write two models that every format can tell some of; return their paths."""
    found = {}
    for name, value in (("old", 1), ("new", 2)):
        path = folder / "given" / name / "model.mod"
        path.write_text(f"Mine\nT   54   3.1416    0.000   0.0000\n  IA  {value}  2.1\nEND\n")
        found[name] = str(path)
    return found
