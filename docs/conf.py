"""Configuration of the documentation."""

import tomllib
from pathlib import Path

project = "stiction"
author = "The stiction developers"
version = release = tomllib.loads((Path(__file__).parents[1] / "pyproject.toml").read_text("utf-8"))["project"][
    "version"
]
copyright = author  # noqa: A001

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.mathjax", "numpydoc"]
myst_enable_extensions = ["dollarmath", "colon_fence"]
source_suffix = {".md": "markdown"}
exclude_patterns = ["_build", "*_table.md", "claims_*.md"]
nitpicky = False
autodoc_typehints = "none"
numpydoc_show_class_members = False
autosummary_generate = False
html_theme = "furo"
html_title = f"stiction {version}"
