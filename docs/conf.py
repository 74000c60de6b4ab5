"""Configuration of the documentation."""

import functools
import os
import re
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path
from typing import Any, NoReturn

import sphinx.search
from docutils import nodes
from latex2mathml.converter import convert
from myst_nb.core.execute import direct
from sphinx import addnodes
from sphinx.application import Sphinx
from sphinx.errors import SphinxError
from sphinx.search.en import SearchEnglish
from sphinx.transforms.post_transforms import SphinxPostTransform
from sphinx.util.images import get_image_size
from sphinx.writers.html5 import HTML5Translator

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "docs/scripts"))

import reference  # noqa: E402  (docs/scripts/reference.py)

project = "stiction"
author = "The stiction developers"
version = release = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["version"]
copyright = author  # noqa: A001

extensions = ["myst_nb", "sphinx.ext.autodoc", "numpydoc"]
myst_enable_extensions = ["dollarmath", "colon_fence"]
myst_heading_anchors = 3
exclude_patterns = ["_build", "built", "generated"]
nitpicky = False
default_role = "autolink"
smartquotes = False  # Quotation marks and the two hyphens of an option remain as written.
autodoc_typehints = "none"
numpydoc_show_class_members = False
autosummary_generate = False
html_theme = "furo"
html_title = f"stiction {version}"
html_static_path = ["_static"]
html_css_files = ["stiction.css"]
html_math_renderer = "mathml"

# The code cells of each page run in an empty directory at every build, and an error in a cell ends the build.
nb_execution_mode = "force"
nb_execution_in_temp = True
nb_execution_timeout = 300
nb_execution_raise_on_error = True
nb_merge_streams = True
nb_output_stderr = "remove"  # Discard standard error, because it contains progress and times.
# Join the pieces of 100 bytes in which IPython passes on the output of `%%sh` cells, so that lines are not broken.
direct.single_nb_execution = functools.partial(direct.single_nb_execution, coalesce_streams=True)
# Run the commands of the environment that builds the pages, without progress bars.
os.environ["PATH"] = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
os.environ["TTY_COMPATIBLE"] = "0"
os.environ["STICTION_SCANS"] = str(Path(__file__).resolve().parents[1] / "examples/scans")
os.environ["COLUMNS"] = "88"  # characters


def write_reference_pages(app: Sphinx) -> None:
    """Write the reference pages that are generated from the package."""
    built_directory = Path(app.srcdir) / "built"
    built_directory.mkdir(exist_ok=True)
    for name, text in reference.render_pages(Path(app.srcdir)).items():
        path = built_directory / name
        if not path.exists() or path.read_text("utf-8") != text:
            path.write_text(text, encoding="utf-8")


ACCESSIBILITY_REPLACEMENTS = (
    ('role="heading"><span class="caption-text"', 'role="heading" aria-level="2"><span class="caption-text"'),
    ("<pre>", '<pre tabindex="0">'),
    ("<th></th>", "<td></td>"),
    ('<noscript>\n<div class="admonition error">', '<h1>Search</h1>\n<noscript>\n<div class="admonition error">'),
    ('<div class="table-wrapper', '<div tabindex="0" class="table-wrapper'),
    ('<div class="output text_html"', '<div tabindex="0" class="output text_html"'),
    ('<div class="formula"', '<div tabindex="0" class="formula"'),
    (' aria-label="Toggle hidden content"', ""),
    ('<aside class="sidebar-drawer', '<aside aria-label="Pages" class="sidebar-drawer'),
    ('<aside class="toc-drawer', '<aside aria-label="Sections of this page" class="toc-drawer'),
    (
        '<div class="content-icon-container">',
        '<div role="navigation" aria-label="Page" class="content-icon-container">',
    ),
)
"""Replacements in HTML pages that make them easier to use with a keyboard or a screen reader."""


def list_markdown_pages(app: Sphinx) -> list[Path]:
    """Return the HTML pages that were built from Markdown."""
    return [Path(app.outdir) / f"{name}.html" for name in sorted(app.env.found_docs)]


def improve_accessibility(app: Sphinx, exception: Exception | None) -> None:
    """Make scrollable elements reachable by keyboard, set the levels of headings, and name landmarks."""
    generated_pages = [Path(app.outdir) / name for name in ("genindex.html", "search.html")]
    for page in (*list_markdown_pages(app), *generated_pages) if exception is None else ():
        text = page.read_text("utf-8")
        for original_html, accessible_html in ACCESSIBILITY_REPLACEMENTS:
            text = text.replace(original_html, accessible_html)
        page.write_text(text, encoding="utf-8")


SCANS_DIRECTORY = ROOT / "examples/scans"
STEEL_ON_BRASS_OPTIONS = {
    "upper": "steel",
    "lower": "brass",
    "hardness": "120 HV ± 10 %",
    "mu0": 0.2,
    "tau0": "50 MPa",
    "mechanics": "half-space",
}
STEEL_ON_STEEL_OPTIONS = STEEL_ON_BRASS_OPTIONS | {
    "lower": "steel",
    "mu0": "0.2±0.01",
    "tau0": "20±2 MPa",
    "hardness": "2±0.1 GPa",
}
EXAMPLE_REPORT_INPUTS: dict[str, tuple[str, dict[str, Any]]] = {
    "quoted": (
        "honed_{}.csv",
        STEEL_ON_STEEL_OPTIONS | {"work_of_adhesion": "0 mJ/m^2", "load": "20 mN", "lay": "grooves"},
    ),
    "maps": ("ground_{}.x3p", STEEL_ON_BRASS_OPTIONS | {"load": "50 MPa"}),
    "lines": ("lapped_{}.csv", STEEL_ON_BRASS_OPTIONS | {"load": "10 mN", "lay": "grooves"}),
}
"""Scan files and pair options of the interactive example reports, by name of the report."""


def write_example_reports(app: Sphinx, exception: Exception | None) -> None:
    """Write an interactive report for each kind of result."""
    if exception is not None or app.builder.format != "html" or app.config.nb_execution_mode == "off":
        return
    from stiction import Study, pair, run
    from stiction.views.report import save_report

    directory = Path(app.outdir) / "live"
    directory.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as result_directory:
        for name, (files, options) in EXAMPLE_REPORT_INPUTS.items():
            scans = (SCANS_DIRECTORY / files.format(side) for side in ("upper", "lower"))
            pair(*scans, **options, directory=Path(result_directory) / name).save_report(directory / f"{name}.html")
    save_report(run(Study.named("quick")), directory / "study.html", name="quick")
    command = ["stiction", "characterise", SCANS_DIRECTORY / "lapped_upper.csv", "--output", directory / "surface.html"]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)


def check_for_build_paths(app: Sphinx, exception: Exception | None) -> None:
    """End the build with an error if a page contains a path of the build machine."""
    directory_pattern = "|".join(re.escape(f"{directory}{os.sep}") for directory in (ROOT, tempfile.gettempdir()))
    for page in sorted(Path(app.outdir).rglob("*.html")) if exception is None else ():
        if match := re.search(rf"(?<![\w.])(?:{directory_pattern})", page.read_text("utf-8")):
            raise SphinxError(f"{page.name} contains the path {match[0]}")


def check_for_broken_emphasis(app: Sphinx, exception: Exception | None) -> None:
    """End the build with an error if a paragraph ends with a star, because the star of E* ended an emphasis."""
    for page in list_markdown_pages(app) if exception is None else ():
        if match := re.search(r"[^\n<>]{0,40}[.!?)]\*</p>", page.read_text("utf-8")):
            raise SphinxError(f"{page.name} has emphasis that ends too early: {match[0]}")


def check_for_stray_comments(app: Sphinx, page: str, source: list[str]) -> None:
    """End the build with an error if a line inside a paragraph starts with %, which MyST reads as a comment."""
    text = re.sub(r"^(`{3,}).*?^\1", "", source[0], flags=re.DOTALL | re.MULTILINE)
    if match := re.search(r"(?<=\S\n)%[^\n]{0,40}", text):
        raise SphinxError(f"{page}: a line of a paragraph must not start with %, got {match[0]!r}")


# ---- Links ----------------------------------------------------------------------------------------------------------


LINK_TARGETS = reference.find_link_targets(ROOT / "docs")
AMBIGUOUS_NAMES = LINK_TARGETS.keys() & reference.list_command_and_key_names()
"""Public names that are also a command, or a key or section of study files, such as `pair` and `cut_off`."""


class PublicNameLinkTransform(SphinxPostTransform):
    """Sphinx transform that links public names in code font to their entries in the reference.

    Outside the Python reference, ambiguous names are linked only with parentheses, as in `pair()`. The page about
    commands names no functions.
    """

    default_priority = 5

    def run(self, **_: Any) -> None:
        """Wrap each public name in a cross-reference."""
        page = self.env.current_document.docname
        if page == "reference/commands":
            return
        is_python_reference = page.startswith("reference/api")
        for literal in list(self.document.findall(nodes.literal)):
            name = literal.astext().removesuffix("()")
            is_ambiguous = literal.astext() in AMBIGUOUS_NAMES and not is_python_reference
            if (
                name not in LINK_TARGETS
                or is_ambiguous
                or isinstance(literal.parent, (nodes.reference, addnodes.pending_xref, nodes.title))
            ):
                continue
            link = addnodes.pending_xref(
                "", refdomain="py", reftype="obj", reftarget=LINK_TARGETS[name], refexplicit=True, refwarn=True,
                refdoc=page,
            )  # fmt: skip
            literal.replace_self(link)
            link += literal


UNIT_PATTERN = r"(?:[kMGnµμm]?(?:m|N|Pa|J|s)\b|[nµμmc]?m[²³]|(?:cm|h|min|HV|HRC|[kMG]i?B)\b|°|%)"
DIGIT_GROUP_PATTERN = r"(?:(?<=\b\d)|(?<=\b\d\d)|(?<=\b\d\d\d)) (?=\d\d\d\b)"
NUMBER_SPACE_PATTERN = re.compile(rf"(?<=\d) (?={UNIT_PATTERN})|{DIGIT_GROUP_PATTERN}")
"""Spaces inside a number and in front of its unit, at which a line must not be broken."""


class OptionTransform(SphinxPostTransform):
    """Sphinx transform that adds the class `option` to code with options, such as `--load 1` or `pair --gap FILE`."""

    default_priority = 5

    def run(self, **_: Any) -> None:
        for literal in self.document.findall(nodes.literal):
            if any(word.startswith("-") for word in literal.astext().split()):
                literal["classes"].append("option")


class NumberSpaceTransform(SphinxPostTransform):
    """Sphinx transform that keeps a number and its unit, and the digits of a number, on one line."""

    default_priority = 5

    def run(self, **_: Any) -> None:
        for text in list(self.document.findall(nodes.Text)):
            if isinstance(text.parent, (nodes.literal, nodes.FixedTextElement, nodes.math, nodes.raw)):
                continue
            joined_text = NUMBER_SPACE_PATTERN.sub("\N{NO-BREAK SPACE}", text)
            if joined_text != text:
                text.parent.replace(text, nodes.Text(joined_text))


MIN_WIDE_ASPECT_RATIO, MIN_PAGE_WIDE_ASPECT_RATIO = 1.7, 1.4
"""Ratios of width to height above which an image scrolls on a narrow screen instead of shrinking.

The second ratio is for figures that are as wide as a printed page.
"""
MIN_PAGE_WIDE_PIXELS = 1500


class WideImageTransform(SphinxPostTransform):
    """Sphinx transform that adds the class `wide` to wide images."""

    default_priority = 5

    def run(self, **_: Any) -> None:
        for image in self.document.findall(nodes.image):
            image_size = get_image_size(Path(self.env.srcdir) / image["uri"])
            if image_size is None:
                continue
            is_page_wide = image_size[0] > MIN_PAGE_WIDE_PIXELS
            if image_size[0] > (MIN_PAGE_WIDE_ASPECT_RATIO if is_page_wide else MIN_WIDE_ASPECT_RATIO) * image_size[1]:
                image["classes"].append("wide")
                image.setdefault("width", "100%")  # An image with a width links to its file in full size.


class CommandPromptTransform(SphinxPostTransform):
    """Sphinx transform that adds a prompt to commands in cells, and the file name to files that cells write."""

    default_priority = 4

    def run(self, **_: Any) -> None:
        for literal in list(self.document.findall(nodes.literal_block)):
            magic_line, _newline, text = literal.astext().partition("\n")
            if magic_line.startswith("%%sh"):
                displayed_text = re.sub(r"^(?=\S)(?<!\\\n)", "$ ", text, flags=re.MULTILINE)
                language = "console"
            elif magic_line.startswith("%%writefile "):
                displayed_text, language = f"# {magic_line.split()[1]}\n{text}", "toml"
            else:
                continue
            highlighted_block = nodes.literal_block(
                displayed_text, displayed_text, language=language, classes=literal["classes"]
            )
            literal.replace_self(highlighted_block)


def add_description(
    app: Sphinx, page: str, template: str, context: dict[str, Any], doctree: nodes.document | None
) -> None:
    """Add the title and the first paragraph of a page to its metadata, for search engines and link previews."""
    if doctree is None:
        return
    paragraphs = (paragraph.astext() for paragraph in doctree.findall(nodes.paragraph))
    text = " ".join(next(paragraphs, "").split())[:300].replace("&", "&amp;").replace('"', "&quot;")
    title = re.sub("<[^>]+>", "", context.get("title", project))
    context["metatags"] = context.get("metatags", "") + (
        f'<meta name="description" content="{text}" />\n<meta property="og:title" content="{title}" />\n'
        f'<meta property="og:description" content="{text}" />\n<meta property="og:site_name" content="{project}" />\n'
    )


# ---- Formulas -------------------------------------------------------------------------------------------------------

MATH_CODE_POINT_RANGES = (
    "U+20-7E,U+A0-FF,U+300-3FF,U+2000-20CF,U+2100-22FF,U+2300-23FF,U+27C0-27FF,U+2980-2AFF,U+1D400-1D7FF"
)


def write_formula_font(app: Sphinx) -> None:
    """Write a font for formulas: the mathematical glyphs of STIX Two Math.

    The font (SIL Open Font License 1.1) is part of the package ziamath.
    """
    import logging
    from importlib import resources

    from fontTools.subset import Options, Subsetter, load_font, parse_unicodes, save_font

    path = Path(app.outdir) / "_static/stix-two-math.woff2"
    if app.builder.format != "html" or path.exists():
        return
    logging.getLogger("fontTools").setLevel(logging.WARNING)
    options = Options(flavor="woff2", layout_features=["*"], drop_tables=["DSIG"], name_IDs=["*"], hinting=False)
    with resources.as_file(resources.files("ziamath") / "fonts/STIXTwoMath-Regular.ttf") as source:
        font = load_font(str(source), options)
    subsetter = Subsetter(options)
    subsetter.populate(unicodes=parse_unicodes(MATH_CODE_POINT_RANGES.replace("U+", "")))
    subsetter.subset(font)
    path.parent.mkdir(parents=True, exist_ok=True)
    save_font(font, str(path), options)


def to_mathml(node: nodes.math | nodes.math_block) -> str:
    """Return a formula as MathML, which browsers display without further downloads."""
    formula = convert(node.astext(), display="block" if isinstance(node, nodes.math_block) else "inline")
    if ">\\" in formula:  # The converter leaves unknown commands unchanged in the output.
        raise SphinxError(f"the formula contains an unknown command: {node.astext()}")
    return re.sub(r"<mi>(cos|sin|tan|arcsin|arctan|ln|log)</mi>", r"<mi>\1</mi><mspace width='0.17em'/>", formula)


def visit_formula(translator: HTML5Translator, node: nodes.math | nodes.math_block) -> NoReturn:
    if not isinstance(node, nodes.math_block):
        translator.body.append(to_mathml(node))
        raise nodes.SkipNode
    number = f'<span class="eqno">({node["number"]})</span>' if node.get("number") else ""
    translator.body.append(f'<div class="formula">{to_mathml(node)}{number}</div>\n')
    raise nodes.SkipNode


_ASCII_NAMES_BY_SYMBOL = {"μ0": "mu0", "τ0": "tau0", "μ_s": "mu_s"}


class EnglishSearchWithSymbols(SearchEnglish):
    """English search index in which a symbol and its ASCII name count as the same word."""

    def split(self, input: str) -> list[str]:  # noqa: A002  (name of the argument in Sphinx)
        """Return the words of a text, and the alternative spelling of symbols."""
        alternative_spellings = _ASCII_NAMES_BY_SYMBOL | {
            name: symbol for symbol, name in _ASCII_NAMES_BY_SYMBOL.items()
        }
        words = super().split(input)
        return [*words, *(alternative_spellings[word] for word in words if word in alternative_spellings)]


def setup(app: Sphinx) -> None:
    sphinx.search.languages["en"] = EnglishSearchWithSymbols
    app.add_html_math_renderer("mathml", (visit_formula, None), (visit_formula, None))
    app.add_post_transform(PublicNameLinkTransform)
    app.add_post_transform(OptionTransform)
    app.add_post_transform(NumberSpaceTransform)
    app.add_post_transform(CommandPromptTransform)
    app.add_post_transform(WideImageTransform)
    app.connect("builder-inited", write_reference_pages)
    app.connect("builder-inited", write_formula_font)
    app.connect("html-page-context", add_description)
    app.connect("build-finished", write_example_reports)
    app.connect("build-finished", improve_accessibility)
    app.connect("build-finished", check_for_build_paths)
    app.connect("build-finished", check_for_broken_emphasis)
    app.connect("source-read", check_for_stray_comments)
