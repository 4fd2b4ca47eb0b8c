"""Every reader of pyport: where its code is, good files to start from, and how it is called."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import seeds
from asked import COMMANDS, ask, asked_seeds, call
from seeds import ECSV, NIGHT, parquet

from pyport.cli import pyport as program
from pyport.effects import Circumstances
from pyport.examiner.sealed.record.published import read_answers, read_report, read_seal
from pyport.examiner.sealed.scoring.judge import judge, place
from pyport.formats.convert import convert
from pyport.formats.field_system import agreement
from pyport.formats.models import load
from pyport.planning.target_lists import read_catalogue
from pyport.recordings import masks, read
from pyport.recordings.files import read_survey
from pyport.recordings.formats import mapped as columns
from pyport.recordings.formats.text import read_text
from pyport.recordings.raw import NOTHING, FileOptions
from pyport.recordings.scans import measure
from pyport.recordings.where import where
from pyport.steering import offsets_at, read_table
from pyport.steering.lookup import answers
from pyport.watch import follow
from pyport.watch.state import load as load_state

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
    """Read a model, let it predict, and write it."""
    load(str(path)).offsets(AT)
    convert(str(path), path.with_name("converted.toml"))


def effects(path: Path) -> None:
    """Read a model that lists effects, and let it predict."""
    load(str(path)).offsets(AT)


def description(path: Path) -> None:
    """Take a file's text for katpoint's description of a model."""
    load(read_text(path)).offsets(AT)


def filtered(path: Path) -> None:
    """Take a file's text for a filter of recordings."""
    night = path.with_name("night.csv")
    night.write_bytes(NIGHT)
    where(read(night), read_text(path))


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
    list(answers(seeds.table(), read_text(path).splitlines(), path.name))


def data_set(path: Path) -> None:
    """Take a file for a part of a data set."""
    part = path.parent / "set" / "antenna=C01"
    part.mkdir(parents=True, exist_ok=True)
    path.replace(part / "night.parquet")
    read(part.parent)


def grid(path: Path) -> None:
    """Take a file for the unit responses that the Field System computed."""
    path = path.replace(path.with_name(agreement.GRID))
    try:
        list(agreement.text(path.parent))
    finally:
        path.unlink()


def fits(path: Path) -> None:
    """Take a file for a fit of the Field System's, beside its data and its model."""
    path.with_suffix(".xtr").write_bytes(seeds.XTR)
    path.with_name(agreement.MODEL).write_bytes(seeds.CTL)
    list(agreement.text(path.parent))


def report(path: Path) -> None:
    """Take a file for what a solver said of a case of a sealed set."""
    told = read_report(path)
    causes = [
        {"effect": "refraction", "class": ["refraction"], "parameters": {"r": 58.0}, "where": one}
        for one in (
            {"region": [{"column": "el_deg", "low": 5, "high": 10}]},
            {"curve": [{"az_deg": 0.0, "el_deg": 20.0}, {"az_deg": 90.0, "el_deg": 30.0}]},
            {"since": "2003-06-01T12:00:00Z"},
        )
    ]
    told_columns = {
        "el_deg": ["7", "20"],
        "time_utc": ["2003-06-01T10:00:00", "2003-06-01T13:00:00"],
    }
    judge("case", {"truth": {"effects": causes}, "spec": {"group": "one"}}, told)
    for cause in causes:
        place(told_columns, told.get("findings", []), [cause])


def log(path: Path) -> None:
    """Take a file for a log that grows: half of it at first, then the rest."""
    content = path.read_bytes()
    path.write_bytes(content[: len(content) // 2])
    cursor = follow.Cursor()
    for _ in range(2):
        for batch in follow.new(path, NOTHING, cursor):
            cursor = batch.cursor
        path.write_bytes(content)


def mapped(path: Path) -> None:
    """Take a file for a table whose columns have other names."""
    read(path, FileOptions(mapping=columns.propose(columns.sheet(path))))


def column_map(path: Path) -> None:
    """Take a file for the map of a table's columns."""
    table = path.with_name("mine.csv")
    table.write_bytes(seeds.MINE)
    read(table, FileOptions(mapping=columns.parse(str(path))))


def state(path: Path) -> None:
    """Take a file for the state of a watch."""
    load_state(seeds.watched()[1], path)


def _modules(names: Iterable[str]) -> tuple[str, ...]:
    return tuple(f"pyport.{name}" for name in names)


def readers() -> dict[str, Reader]:
    """Return all readers by name."""
    raw = ("recordings.interpret", "recordings.raw", "columns")
    lines = ("recordings.formats.text",)
    field_system = ("recordings.formats.xtr", *lines)
    terms = ("formats.model_file", *lines)
    sheets = ("recordings.formats.mapped", "recordings.formats.sheet")
    katpoint, katpoint_csv = ("formats.katpoint_model", *terms), "recordings.formats.katpoint_csv"
    tpoint_dat = "recordings.formats.tpoint.dat"
    agrees = ("formats.field_system.agreement",)
    streams = tuple(f"recordings.stream.{one}" for one in ("pieces", "chunk", "cells", "reduce"))
    scans = ("recordings.scans",)
    judges = ("examiner.sealed.scoring.judge",)
    all_of_them = (
        ("csv", ".csv", (NIGHT,), recordings, ("recordings.formats.csv", *lines, *raw)),
        ("ecsv", ".ecsv", (ECSV,), recordings, ("recordings.formats.tables", *raw)),
        ("parquet", ".parquet", (parquet(),), recordings, ("recordings.formats.tables", *raw)),
        ("data-set", ".parquet", (parquet(seeds.PLAIN), parquet()), data_set, streams),
        (
            "tpoint-dat",
            ".dat",
            (seeds.DAT,),
            recordings,
            (tpoint_dat, *lines, *raw),
        ),
        (
            "tpoint-equatorial",
            ".dat",
            (seeds.EQUATORIAL,),
            recordings,
            ("recordings.formats.tpoint.equatorial", tpoint_dat),
        ),
        ("other-names", ".txt", (seeds.MINE, seeds.PLAIN), mapped, sheets),
        ("column-map", ".toml", (seeds.MAP,), column_map, ("recordings.formats.mapped",)),
        ("log", ".csv", (NIGHT, seeds.PLAIN), log, ("watch.follow",)),
        ("watch-state", ".npz", (seeds.state(),), state, ("watch.state",)),
        ("catalogue", ".csv", (seeds.CATALOGUE,), read_catalogue, ("planning.target_lists",)),
        ("completed-model", ".toml", (seeds.completed(),), model, ("formats.models", *terms)),
        *(
            (
                f"options-{name}",
                ".txt",
                asked_seeds(name),
                ask(name),
                (f"cli.{program.shared.get(name, name)}",),
            )
            for name in COMMANDS
        ),
        (
            "python",
            ".txt",
            tuple(b"%d" % n for n in range(8)),
            call,
            ("arguments", "api"),
        ),
        ("fs-xtr", ".xtr", (seeds.XTR,), recordings, (*field_system, *raw)),
        ("fs-err", ".err", (seeds.fit(),), recordings, (*field_system, *raw)),
        ("katpoint-csv", ".csv", (seeds.KATPOINT_CSV,), recordings, (katpoint_csv, *lines, *raw)),
        ("scans", ".csv", (seeds.SCANS,), measure, scans),
        ("survey", ".csv", (seeds.SURVEY,), read_survey, ("recordings.files",)),
        ("mask", ".mask", (seeds.mask(),), mask, ("recordings.masks",)),
        ("filter", ".txt", (seeds.FILTER,), filtered, ("recordings.where",)),
        ("toml-effects", ".toml", (seeds.TOML_EFFECTS,), effects, ("models.toml",)),
        ("toml-terms", ".toml", (seeds.TOML_TERMS,), model, ("formats.models", *terms)),
        ("tpoint-mod", ".mod", (seeds.MOD,), model, ("formats.tpoint_mod", *terms)),
        ("fs-ctl", ".ctl", (seeds.CTL,), model, ("formats.field_system.ctl", *terms)),
        ("fs-err-model", ".err", (seeds.fit(),), model, ("formats.field_system.ctl", *terms)),
        ("fs-responses", ".csv", (seeds.GRID,), grid, agrees),
        ("fs-fits", ".err", (seeds.fit(),), fits, agrees),
        ("katpoint", ".txt", seeds.KATPOINT, model, ("formats.katpoint_model", *terms)),
        ("katpoint-description", ".txt", seeds.KATPOINT[:1], description, katpoint),
        ("ska-mid", ".json", (seeds.SKA,), model, ("formats.katpoint_model", *terms)),
        ("discos", ".xml", (seeds.DISCOS,), model, ("formats.discos", *terms)),
        ("table-binary", ".bin", (seeds.binary(),), table, ("steering.binary", "steering.lookup")),
        ("table-ascii", ".txt", (seeds.ascii_table(),), table, ("steering.ascii",)),
        ("table-places", ".txt", (b"1 10\n0.5 12.5\n",), places, ("steering.lookup",)),
        ("seal", ".json", (seeds.SEAL,), read_seal, ("examiner.sealed.record.published",)),
        ("answers", ".json", (seeds.ANSWERS,), read_answers, ("examiner.sealed.record.published",)),
        ("report", ".json", (seeds.REPORT,), report, ("examiner.sealed.record.published", *judges)),
    )
    return {
        name: Reader(name, suffix, seeds, call, _modules(modules))
        for name, suffix, seeds, call, modules in all_of_them
    }
