"""The documentation as a site: `make docs`. It fetches nothing, when built or when read."""

from importlib.metadata import version as version_of

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.application import Sphinx

project = "pyport"
author = "the pyport developers"
project_copyright = "2026, the pyport developers"
version = release = version_of("pyport-pointing")

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx_click",
]
exclude_patterns = ["proof/proof", "proof/sets"]

html_theme = "furo"
html_title = "pyport"
html_show_sourcelink = False
html_copy_source = False

# Headings down to this level can be linked to, as `page.md#heading`.
myst_heading_anchors = 3
myst_enable_extensions = ["deflist", "dollarmath"]
# Formulae are MathML in the page: nothing is fetched to show them.
html_math_renderer = "mathml"

# The tutorial is run each time: what it shows is what this version answers. It must not fail.
nb_execution_mode = "force"
nb_execution_raise_on_error = True
# The diagnosis of 1,000 recordings may take half a minute on a busy machine.
nb_execution_timeout = 600

napoleon_numpy_docstring = True
napoleon_google_docstring = False
napoleon_use_ivar = True
autodoc_typehints = "none"
# An attribute of one class is named like those of two others: no reference was meant.
suppress_warnings = ["ref.python"]
autodoc_member_order = "bysource"
autodoc_default_options = {"members": True, "show-inheritance": False}


def _formula(display):
    """Return what writes a formula into a page, in a line or as a block."""

    def visit(translator, node):
        text = convert(node.astext(), display=display)
        translator.body.append(text if display == "inline" else f"<p>{text}</p>")
        raise nodes.SkipNode

    return visit, None


def setup(app: Sphinx):
    """Register formulae as MathML."""
    app.add_html_math_renderer("mathml", _formula("inline"), _formula("block"))
