"""Configuration of the documentation."""

import functools
import os
import re
import sys
import tempfile
import tomllib
from pathlib import Path
from typing import NoReturn

from docutils import nodes
from latex2mathml.converter import convert
from myst_nb.core.execute import direct
from sphinx.application import Sphinx
from sphinx.errors import SphinxError
from sphinx.writers.html5 import HTML5Translator

ROOT = Path(__file__).parents[1]

project = "stiction"
author = "The stiction developers"
version = release = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["version"]
copyright = author  # noqa: A001

extensions = ["myst_nb", "sphinx.ext.autodoc", "numpydoc"]
myst_enable_extensions = ["dollarmath", "colon_fence"]
exclude_patterns = ["_build", "generated"]
nitpicky = False
autodoc_typehints = "none"
numpydoc_show_class_members = False
autosummary_generate = False
html_theme = "furo"
html_title = f"stiction {version}"
html_math_renderer = "mathml"

# Pages with code cells are computed anew at every build, each in an empty directory; a cell that fails ends the build.
nb_execution_mode = "force"
nb_execution_in_temp = True
nb_execution_timeout = 300
nb_execution_raise_on_error = True
# IPython hands on what a `%%sh` cell prints in pieces of 100 bytes; without this each would be set on lines of its own.
direct.single_nb_execution = functools.partial(direct.single_nb_execution, coalesce_streams=True)
# Cells run commands, those of the environment that builds the pages, and have no terminal to draw bars on.
os.environ["PATH"] = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
os.environ["TTY_COMPATIBLE"] = "0"


def refuse_paths(app: Sphinx, exception: Exception | None) -> None:
    """End the build if what a cell printed tells where it was built."""
    folders = "|".join(re.escape(f"{folder}{os.sep}") for folder in (ROOT, tempfile.gettempdir()))
    for page in sorted(Path(app.outdir).glob("*.html")) if exception is None else ():
        if found := re.search(rf"(?<![\w.])(?:{folders})", page.read_text("utf-8")):
            raise SphinxError(f"{page.name} holds the path {found[0]}")


def mathml(node: nodes.math | nodes.math_block) -> str:
    """A formula as browsers know it: MathJax would have to be fetched by whoever reads the pages."""
    formula = convert(node.astext(), display="block" if isinstance(node, nodes.math_block) else "inline")
    if ">\\" in formula:  # a command that the converter does not know stands in the page as it is
        raise SphinxError(f"not all of this formula can be set: {node.astext()}")
    return formula


def put_formula(translator: HTML5Translator, node: nodes.math | nodes.math_block) -> NoReturn:
    translator.body.append(mathml(node))
    raise nodes.SkipNode


def setup(app: Sphinx) -> None:
    app.add_html_math_renderer("mathml", (put_formula, None), (put_formula, None))
    app.connect("build-finished", refuse_paths)
