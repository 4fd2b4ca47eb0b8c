"""Figures into files: the same figure gives the same bytes, drawn and laid out once."""

from __future__ import annotations

import functools
import tempfile
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any, cast

from pyport.files import write_whole

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: Format -> what else would be stamped on a file, and is not.
FORMATS: dict[str, dict[str, Any]] = {
    "pdf": {"CreationDate": None, "ModDate": None, "Producer": None, "Creator": None},
    "png": {"Software": None},
    "svg": {"Date": None, "Creator": None},
}
#: Dots per inch for print.
DPI = 200
#: The typeface of a PDF, and what it has: Latin and Greek letters, marks, arrows, signs of
#: mathematics, shapes. A figure with other letters has the typeface that it comes from.
TYPEFACE, WHOLE = "pyport Sans", "DejaVu Sans"
LETTERS = ((0x20, 0x180), (0x370, 0x400), (0x2000, 0x20A0), (0x2190, 0x2270), (0x25A0, 0x2600))


def write(figure: Figure, path: Path, dpi: float = DPI) -> Path:
    """Write a figure in the format that the suffix says, whole or not at all."""
    import matplotlib as mpl

    kind = path.suffix[1:]
    # Text stays text: it can be found, copied and set in the paper's own type.
    settings = {"svg.fonttype": "none", "svg.hashsalt": "pyport", "pdf.fonttype": 42}
    with mpl.rc_context(cast(Any, settings)), write_whole(path, "wb") as file:
        _save(figure, file, kind, dpi)
    return path


def _save(figure: Figure, file: IO[bytes], kind: str, dpi: float) -> None:
    """Lay a figure out and draw it once; `savefig` does each twice."""
    import matplotlib as mpl

    layout = figure.get_layout_engine()
    if layout is not None:
        layout.execute(figure)
        figure.set_layout_engine("none")
    figure.set_dpi(dpi)
    if kind == "png":
        from matplotlib.backends.backend_agg import FigureCanvasAgg

        FigureCanvasAgg(figure).print_png(file, metadata=FORMATS[kind])
    elif kind == "svg":
        from matplotlib.backends.backend_svg import FigureCanvasSVG

        FigureCanvasSVG(figure).print_svg(file, metadata=FORMATS[kind])
    else:
        from matplotlib.backends.backend_pdf import FigureCanvasPdf

        if _is_plain(figure):
            mpl.rcParams["font.sans-serif"] = [_typeface()]
        FigureCanvasPdf(figure).print_pdf(file, metadata=FORMATS[kind])


def _is_plain(figure: Figure) -> bool:
    """Tell whether the typeface of a PDF has all letters of a figure."""
    from matplotlib.text import Text

    texts = cast(list[Text], figure.findobj(Text))
    letters = {ord(letter) for text in texts for letter in text.get_text()} - {ord("\n")}
    return all(any(first <= one < last for first, last in LETTERS) for one in letters)


@functools.cache
def _typeface() -> str:
    """Make the typeface of a PDF and return its name.

    Of the whole one with its thousands of signs and rules a part is made for every file, which
    takes longer than all else. It keeps the glyphs' names, which would be made up for every file.
    """
    from fontTools import subset
    from matplotlib import font_manager

    options = subset.Options(name_IDs=["*"], notdef_outline=True, glyph_names=True)
    options.drop_tables += ["FFTM", "GDEF", "GPOS", "GSUB", "MATH"]
    font = subset.load_font(font_manager.findfont(WHOLE), options)
    part = subset.Subsetter(options)
    part.populate(unicodes=[one for first, last in LETTERS for one in range(first, last)])
    part.subset(font)
    for record in font["name"].names:
        if WHOLE in str(record) or record.nameID == 6:  # 6 is the name without blanks
            record.string = TYPEFACE.replace(" ", "") if record.nameID == 6 else TYPEFACE
    with tempfile.NamedTemporaryFile(suffix=".ttf", delete=False) as file:
        font.save(file)
    import atexit

    atexit.register(Path(file.name).unlink, missing_ok=True)
    font_manager.fontManager.addfont(file.name)
    return TYPEFACE
