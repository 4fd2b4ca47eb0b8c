"""Model files of all formats: read by suffix or content, written by suffix."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from pyport.errors import BadInput
from pyport.files import is_file
from pyport.formats import discos, katpoint_model, ska_mid, toml_model, tpoint_mod
from pyport.formats.field_system import ctl
from pyport.formats.model_file import ModelFile
from pyport.models import toml
from pyport.models.model import BUILT_IN, Model
from pyport.recordings.formats.lines import Line


@dataclass(frozen=True)
class ModelFormat:
    """A format of model files: its name, suffixes, vocabulary, and how it is read and written.

    `any_mount` tells whether it has terms for others than alt-azimuth ones.
    """

    name: str
    suffixes: tuple[str, ...]
    vocabulary: str
    read: Callable[[Path], ModelFile]
    write: Callable[[ModelFile, Path], None] | None
    any_mount: bool = False


FORMATS = {
    one.name: one
    for one in (
        ModelFormat(
            "tpoint-mod", (".mod",), "tpoint", tpoint_mod.read, tpoint_mod.write, any_mount=True
        ),
        ModelFormat("fs-ctl", (".ctl",), "field-system", ctl.read, ctl.write, any_mount=True),
        ModelFormat("fs-err-model", (), "field-system", ctl.read_new_model, None),
        ModelFormat(
            "katpoint", (".txt", ".katpoint"), "katpoint", katpoint_model.read, katpoint_model.write
        ),
        ModelFormat("ska-mid", (".json",), "ska-mid", ska_mid.read, ska_mid.write),
        ModelFormat("discos", (".xml",), "field-system", discos.read, discos.write),
        ModelFormat("toml", (".toml",), "", toml_model.read, toml_model.write),
    )
}
BY_SUFFIX = {suffix: one for one in FORMATS.values() for suffix in one.suffixes}


def load(name: str) -> Model:
    """Return a built-in model, one from a file, or from a katpoint description.

    Files are TOML; TPOINT's .mod, the Field System's .ctl and .err, katpoint's, SKA-Mid's .json and
    DISCOS's .xml, of which `FILE#RECEIVER` picks one.

    Raises `BadInput`: there is no such model or file, or the file does not describe a model.
    """
    if name in BUILT_IN:
        return BUILT_IN[name]()
    if katpoint_model.is_description(name):
        line = Line(Path("katpoint description"), 1, name)
        return katpoint_model.describe(line).model("katpoint description")
    path, _ = split(name)
    if not is_file(path):
        known = ", ".join(sorted(BUILT_IN))
        raise BadInput(f"no model and no file is called {name!r}; built in are {known}")
    if path.suffix.lower() == ".toml" and not toml_model.names_terms(path):
        return toml.model_of(path)
    return read(name).model(path.stem)


def split(name: str | Path) -> tuple[Path, str]:
    """Return the path and the receiver of `FILE#RECEIVER`."""
    path = Path(name)
    if is_file(path):
        return path, ""
    file, _, receiver = str(name).rpartition("#")
    return (Path(file), receiver) if file else (path, "")


def read(name: str | Path, chosen: str = "") -> ModelFile:
    """Read a model file, of a named format, of its suffix's, or of what its content looks like.

    Raises `BadInput`: there is no such file, or it is none of a model.
    """
    path, receiver = split(name)
    if not is_file(path):
        raise BadInput("no such file, expected a pointing model", path)
    if receiver:
        return discos.read(path, receiver)
    return (FORMATS[chosen] if chosen else format_of(path)).read(path)


def format_of(path: Path) -> ModelFormat:
    """Return the format of a model file by its suffix; katpoint's has none of its own."""
    if path.suffix.lower() == ".err":
        return FORMATS["fs-err-model"]
    return BY_SUFFIX.get(path.suffix.lower(), FORMATS["katpoint"])
