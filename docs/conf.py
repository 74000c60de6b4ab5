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
from sphinx.writers.html5 import HTML5Translator

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "docs/scripts"))

import reference  # noqa: E402, beside the other scripts

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
autodoc_typehints = "none"
numpydoc_show_class_members = False
autosummary_generate = False
html_theme = "furo"
html_title = f"stiction {version}"
html_static_path = ["_static"]
html_css_files = ["stiction.css"]
html_math_renderer = "mathml"

# Pages with code cells are computed anew at every build, each in an empty directory; a cell that fails ends the build.
nb_execution_mode = "force"
nb_execution_in_temp = True
nb_execution_timeout = 300
nb_execution_raise_on_error = True
nb_merge_streams = True
nb_output_stderr = "remove"  # how far a command is, and how long it took
# IPython hands on what a `%%sh` cell prints in pieces of 100 bytes; without this each would be set on lines of its own.
direct.single_nb_execution = functools.partial(direct.single_nb_execution, coalesce_streams=True)
# Cells run commands, those of the environment that builds the pages, and have no terminal to draw bars on.
os.environ["PATH"] = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
os.environ["TTY_COMPATIBLE"] = "0"
os.environ["STICTION_SCANS"] = str(Path(__file__).resolve().parents[1] / "examples/scans")
os.environ["COLUMNS"] = "88"  # what a box of code holds on a wide screen


def write_reference(app: Sphinx) -> None:
    """The pages that are made from the package: tables of names, keys of study files, options of commands."""
    built = Path(app.srcdir) / "built"
    built.mkdir(exist_ok=True)
    for name, text in reference.pages(Path(app.srcdir)).items():
        path = built / name
        if not path.exists() or path.read_text("utf-8") != text:
            path.write_text(text, encoding="utf-8")


REACHABLE = (
    ('role="heading"><span class="caption-text"', 'role="heading" aria-level="2"><span class="caption-text"'),
    ("<pre>", '<pre tabindex="0">'),
    ('<div class="table-wrapper', '<div tabindex="0" class="table-wrapper'),
    ('<div class="output text_html"', '<div tabindex="0" class="output text_html"'),
    ('<div class="formula"', '<div tabindex="0" class="formula"'),
    (' aria-label="Toggle hidden content"', ""),
)
"""What the theme leaves out for those who use a keyboard or a screen reader, and what it should say."""


def written_pages(app: Sphinx) -> list[Path]:
    """Return the pages that were written from Markdown."""
    return [Path(app.outdir) / f"{name}.html" for name in sorted(app.env.found_docs)]


def make_reachable(app: Sphinx, exception: Exception | None) -> None:
    """What scrolls sideways can be reached by keys, and headings have a level."""
    for page in written_pages(app) if exception is None else ():
        text = page.read_text("utf-8")
        for before, after in REACHABLE:
            text = text.replace(before, after)
        page.write_text(text, encoding="utf-8")


SCANS = ROOT / "examples/scans"
ON_BRASS = {"upper": "steel", "lower": "brass", "mu0": 0.2, "tau0": "50 MPa", "mechanics": "half-space"}
ON_STEEL = ON_BRASS | {"lower": "steel", "mu0": "0.2±0.01", "tau0": "20±2 MPa", "hardness": "2±0.1 GPa"}
LIVE: dict[str, tuple[str, dict[str, Any]]] = {
    "quoted": ("honed_{}.csv", ON_STEEL | {"work_of_adhesion": "0 mJ/m^2", "load": "20 mN", "lay": "grooves"}),
    "maps": ("ground_{}.x3p", ON_BRASS | {"load": "50 MPa"}),
    "lines": ("lapped_{}.csv", ON_BRASS | {"load": "10 mN", "lay": "grooves"}),
}
"""How the sample scans are pressed for the pages of results that a reader may play with."""


def make_live(app: Sphinx, exception: Exception | None) -> None:
    """A page of each kind of result, as `stiction report` makes it."""
    if exception is not None or app.builder.format != "html" or app.config.nb_execution_mode == "off":
        return
    from stiction import Study, pair, run
    from stiction.views.report import save_report

    folder = Path(app.outdir) / "live"
    folder.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as place:
        for name, (files, given) in LIVE.items():
            scans = (SCANS / files.format(side) for side in ("upper", "lower"))
            pair(*scans, **given, directory=Path(place) / name).save_report(folder / f"{name}.html")
    save_report(run(Study.named("quick")), folder / "study.html", name="quick")
    command = ["stiction", "characterise", SCANS / "lapped_upper.csv", "--output", folder / "surface.html"]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)


def refuse_paths(app: Sphinx, exception: Exception | None) -> None:
    """End the build if what a cell printed tells where it was built."""
    folders = "|".join(re.escape(f"{folder}{os.sep}") for folder in (ROOT, tempfile.gettempdir()))
    for page in sorted(Path(app.outdir).rglob("*.html")) if exception is None else ():
        if found := re.search(rf"(?<![\w.])(?:{folders})", page.read_text("utf-8")):
            raise SphinxError(f"{page.name} holds the path {found[0]}")


def refuse_broken_emphasis(app: Sphinx, exception: Exception | None) -> None:
    """End the build if a paragraph ends in a star: emphasis that an E* in it has ended before."""
    for page in written_pages(app) if exception is None else ():
        if found := re.search(r"[^\n<>]{0,40}[.!?)]\*</p>", page.read_text("utf-8")):
            raise SphinxError(f"{page.name} has emphasis that ends too early: {found[0]}")


# ---- Links ----------------------------------------------------------------------------------------------------------


TARGETS = reference.targets(ROOT / "docs")


class LinkNames(SphinxPostTransform):
    """A public name that a page sets as code is a link to what the reference says of it."""

    default_priority = 5

    def run(self, **_: Any) -> None:
        """Wrap such literals into references, which Sphinx resolves."""
        for literal in list(self.document.findall(nodes.literal)):
            name = literal.astext().removesuffix("()")
            if name not in TARGETS or isinstance(literal.parent, (nodes.reference, addnodes.pending_xref, nodes.title)):
                continue
            link = addnodes.pending_xref(
                "", refdomain="py", reftype="obj", reftarget=TARGETS[name], refexplicit=True, refwarn=True,
                refdoc=self.env.current_document.docname,
            )  # fmt: skip
            literal.replace_self(link)
            link += literal


class CellsAsTyped(SphinxPostTransform):
    """A cell that runs a command is shown as one types it, and one that writes a file under the name of the file."""

    default_priority = 4

    def run(self, **_: Any) -> None:
        for literal in list(self.document.findall(nodes.literal_block)):
            magic, _newline, text = literal.astext().partition("\n")
            if magic.startswith("%%sh"):
                shown = re.sub(r"^(?=\S)(?<!\\\n)", "$ ", text, flags=re.MULTILINE)
                language = "console"
            elif magic.startswith("%%writefile "):
                shown, language = f"# {magic.split()[1]}\n{text}", "toml"
            else:
                continue
            new = nodes.literal_block(shown, shown, language=language, classes=literal["classes"])
            literal.replace_self(new)


def describe(app: Sphinx, page: str, template: str, context: dict[str, Any], doctree: nodes.document | None) -> None:
    """What search engines and previews show of a page: its title and its first paragraph."""
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

GLYPHS = "U+20-7E,U+A0-FF,U+300-3FF,U+2000-20CF,U+2100-22FF,U+2300-23FF,U+27C0-27FF,U+2980-2AFF,U+1D400-1D7FF"


def ship_font(app: Sphinx) -> None:
    """A font with what formulas need (stretching brackets, large operators), which few systems have.

    STIX Two Math (SIL Open Font License 1.1) comes with the package ziamath; its glyphs for formulas go along.
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
    subsetter.populate(unicodes=parse_unicodes(GLYPHS.replace("U+", "")))
    subsetter.subset(font)
    path.parent.mkdir(parents=True, exist_ok=True)
    save_font(font, str(path), options)


def mathml(node: nodes.math | nodes.math_block) -> str:
    """A formula as browsers know it: MathJax would have to be fetched by whoever reads the pages."""
    formula = convert(node.astext(), display="block" if isinstance(node, nodes.math_block) else "inline")
    if ">\\" in formula:  # a command that the converter does not know stands in the page as it is
        raise SphinxError(f"not all of this formula can be set: {node.astext()}")
    return re.sub(r"<mi>(cos|sin|tan|arcsin|arctan|ln|log)</mi>", r"<mi>\1</mi><mspace width='0.17em'/>", formula)


def put_formula(translator: HTML5Translator, node: nodes.math | nodes.math_block) -> NoReturn:
    block = isinstance(node, nodes.math_block)
    translator.body.append(f'<div class="formula">{mathml(node)}</div>\n' if block else mathml(node))
    raise nodes.SkipNode


_ALIKE = {"μ0": "mu0", "τ0": "tau0", "μ_s": "mu_s"}


class Search(SearchEnglish):
    """English, where a symbol and its name in ASCII are one word to whoever searches."""

    def split(self, input: str) -> list[str]:  # noqa: A002, the name that Sphinx gives it
        """Words, and the other way to write each."""
        alike = _ALIKE | {name: symbol for symbol, name in _ALIKE.items()}
        words = super().split(input)
        return [*words, *(alike[word] for word in words if word in alike)]


def setup(app: Sphinx) -> None:
    sphinx.search.languages["en"] = Search
    app.add_html_math_renderer("mathml", (put_formula, None), (put_formula, None))
    app.add_post_transform(LinkNames)
    app.add_post_transform(CellsAsTyped)
    app.connect("builder-inited", write_reference)
    app.connect("builder-inited", ship_font)
    app.connect("html-page-context", describe)
    app.connect("build-finished", make_live)
    app.connect("build-finished", make_reachable)
    app.connect("build-finished", refuse_paths)
    app.connect("build-finished", refuse_broken_emphasis)
