"""DISCOS's pointing models: XML, for each receiver phi and P1..P30 as the Field System has them."""

from __future__ import annotations

from decimal import Decimal
from html import escape
from pathlib import Path
from xml.etree import ElementTree as ET

from pyport.errors import BadInput
from pyport.files import write_whole
from pyport.formats.field_system.ctl import FITTED, OFF, entries, numbered
from pyport.formats.model_file import ModelFile
from pyport.models.terms.field_system import NUMBER
from pyport.recordings.formats.text import Line, read_text

_SPACE = "urn:schemas-cosylab-com:PointingModel:1.0"


def read(path: Path, receiver: str = "") -> ModelFile:
    """Read the model of a receiver.

    Raises `BadInput`: the file is none of these, or has several receivers and none is named.
    """
    text = read_text(path)
    if "<!DOCTYPE" in text or "<!ENTITY" in text:
        raise BadInput("a document type is declared, expected plain elements", path)
    try:
        root = ET.fromstring(text.encode())  # noqa: S314 - no entities: refused above
    except ET.ParseError as error:
        raise BadInput(f"not XML: {error}", path, error.position[0]) from None
    found = {_text(one, "receiverCode", path): one for one in root if _name(one) == "Receiver"}
    if not found:
        raise BadInput("no <Receiver>, expected one for each pointing model", path)
    if not receiver and len(found) == 1:
        (receiver,) = found
    if receiver not in found:
        wanted = f"expected FILE#CODE with one of {', '.join(found)}"
        raise BadInput(f"receiver {receiver!r} is not here, {wanted}", path)
    return _model(found[receiver], receiver, path)


def _model(element: ET.Element, receiver: str, path: Path) -> ModelFile:
    whole = Line(path, 1, "")
    present = {_name(one) for one in element}
    size = sum(f"coefficientVal{n:02d}" in present for n in range(NUMBER))
    marks = [
        int(whole.decimal(_text(element, f"coefficientNum{n:02d}", path), "a flag"))
        for n in range(size)
    ]
    values = [
        whole.decimal(_text(element, f"coefficientVal{n:02d}", path), f"P{n + 1}")
        for n in range(size)
    ]
    return ModelFile(
        "field-system",
        entries(values, marks),
        title=receiver,
        phi_deg=whole.decimal(_text(element, "phi", path), "phi"),
        details={"flags": marks},
    )


def _name(element: ET.Element) -> str:
    return element.tag.rpartition("}")[2]


def _text(element: ET.Element, name: str, path: Path) -> str:
    for one in element:
        if _name(one) == name and one.text and one.text.strip():
            return one.text.strip()
    raise BadInput(f"a <Receiver> has no <{name}>, expected one", path)


def write(file: ModelFile, path: Path) -> None:
    """Write a model in the Field System's vocabulary as that of one receiver."""
    values, marks = numbered(file)
    pad = NUMBER - len(values)
    values, marks = values + [Decimal(0)] * pad, marks + [OFF] * pad
    with write_whole(path) as out:
        out.write("<?xml version='1.0' encoding='UTF-8'?>\n")
        out.write(f'<PointingModel xmlns="{_SPACE}">\n<Receiver>\n')
        title = escape(file.title or "RECEIVER", quote=False)
        out.write(f"\t<receiverCode>{title}</receiverCode>\n")
        out.write(f"\t<phi>{file.phi_deg}</phi>\n")
        for n, (value, mark) in enumerate(zip(values, marks, strict=True)):
            used = OFF if mark == OFF else FITTED
            out.write(f"\t<coefficientNum{n:02d}> {used} </coefficientNum{n:02d}>")
            out.write(f" <coefficientVal{n:02d}> {value:f} </coefficientVal{n:02d}>\n")
        out.write("</Receiver>\n</PointingModel>\n")
