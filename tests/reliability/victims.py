"""The commands that torture.py kills: how each is called for an old and for a new answer."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from pyport.examiner.sealed.protocol import Spec
from pyport.examiner.sealed.record import files
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
        Spec("unknown", "unknown", "spiral", 1.0, ROWS),
    ]


def prepare(folder: Path) -> None:
    """Make the files that the commands read, once, before any of them is called."""
    for number, (night, model) in enumerate(zip(_nights(folder), _models(folder), strict=True)):
        case = Spec("one", "one", "refraction", 1.0, ROWS * (1 + number)).make(number)
        files.write_recordings(case, night)
        for part in ("C00", "C01"):
            place = night.parent / "set" / f"antenna={part}"
            place.mkdir(parents=True)
            convert(str(night), place / "night.parquet")
        term = f"  IA  {1 + number}  2.1"
        model.write_text(f"Mine\nT   54   3.1416    0.000   0.0000\n{term}\nEND\n")


def _nights(folder: Path) -> list[Path]:
    return [folder / "given" / name / "night.csv" for name in ("old", "new")]


def _models(folder: Path) -> list[Path]:
    return [path.with_name("model.mod") for path in _nights(folder)]


def victims(folder: Path) -> dict[str, Victim]:
    """Return the commands to kill by name; they read what `prepare` made in the folder."""
    old, new = map(str, _nights(folder))
    old_model, new_model = map(str, _models(folder))
    sets = [str(Path(path).parent / "set") for path in (old, new)]
    few = ("--az", "0:10:1")
    binary = ("table", "--format", "binary")
    recordings = {"csv": 8, "ecsv": 8, "parquet": 8, "dat": 8}
    models = {"mod": 3, "toml": 3, "json": 3, "xml": 3, "ctl": 3}

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
                ("convert", "--leave-out", old_model),
                ("convert", "--leave-out", new_model),
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
