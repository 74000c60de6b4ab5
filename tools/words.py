"""Draw random sentences and names from the committed tree, and check names and sentences against tools/words.toml.

words.py sample [--seed S] [--number N] [--functions N]
    Print N sentences and N names as a table in which a reader marks each one. The same seed and commit give the
    same sample. With --functions, print whole functions to explain from name, summary and body instead.
words.py check
    Exit with status 1 and one line for each name or sentence that words.toml rejects, and for each line of a page
    that the documentation drops.
"""

from __future__ import annotations

import argparse
import ast
import functools
import gc
import io
import random
import re
import subprocess
import sys
import tarfile
import tokenize
import tomllib
from collections.abc import Callable, Iterator, Mapping
from itertools import chain
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
WORD_RULES_FILE = ROOT / "tools/words.toml"
SENTENCE_KINDS = ("docstring", "comment", "message", "documentation", "commit subject")
NAME_KINDS = ("function", "class", "constant", "variable", "test")
MIN_COMMENT_LENGTH = 25  # characters; most shorter comments are units and markers
MIN_SENTENCE_WORDS = 7
MAX_COMMITS = 200
MAX_SAMPLE_LENGTH = 300
# Maximum length (lines) of a drawn function, because a reader cannot explain a longer one quickly.
MAX_FUNCTION_LINES = 40
PYTHON_DIRECTORIES = ("python/stiction", "tests", "benchmarks", "docs", "examples", "packaging", "tools", "dev")
IMPORTABLE_DIRECTORIES = ("python/stiction", "tests/support", "tests/reference", "packaging", "tools")

TextsByPath = Mapping[str, str]
"""Contents of text files, by their path in the tree."""
SampledText = tuple[str, str]
"""Location and text of a sentence or name."""


# ---- Reading the tree -----------------------------------------------------------------------------------------------


def read_commit_files() -> TextsByPath:
    """Return the contents of all text files in the current commit, by path."""
    archive_bytes = subprocess.run(["git", "archive", "HEAD"], cwd=ROOT, capture_output=True, check=True).stdout
    texts = {}
    with tarfile.open(fileobj=io.BytesIO(archive_bytes)) as tar_file:
        for member in tar_file:
            if member.isfile() and (is_python(member.name) or member.name.endswith((".md", ".cpp", ".hpp", ".js"))):
                file = tar_file.extractfile(member)
                assert file is not None
                texts[member.name] = file.read().decode("utf-8")
    return texts


def read_tracked_files(is_read: Callable[[str], bool]) -> TextsByPath:
    """Return the contents of the tracked files in the working tree whose names `is_read` accepts, by path."""
    tracked_files = subprocess.run(
        ["git", "ls-files"], cwd=ROOT, capture_output=True, check=True, text=True
    ).stdout.split()
    return {
        name: (ROOT / name).read_text("utf-8") for name in tracked_files if is_read(name) and (ROOT / name).exists()
    }


def is_python(name: str) -> bool:
    return name == "dev" or name.endswith(".py")


def is_page(name: str) -> bool:
    return name.endswith(".md")


def is_in_directories(name: str, directories: tuple[str, ...]) -> bool:
    return any(name == directory or name.startswith(f"{directory}/") for directory in directories)


def iterate_syntax_nodes(
    files: TextsByPath, directories: tuple[str, ...] = PYTHON_DIRECTORIES
) -> Iterator[tuple[str, ast.AST]]:
    """Yield each node in the syntax tree of each Python file, with the path of the file."""
    for name, text in sorted(files.items()):
        if is_python(name) and is_in_directories(name, directories):
            for node in list_syntax_nodes(text):
                yield name, node


@functools.cache
def list_syntax_nodes(text: str) -> list[ast.AST]:
    return list(ast.walk(ast.parse(text)))


# ---- Sentences ------------------------------------------------------------------------------------------------------


def docstring_summaries(files: TextsByPath) -> Iterator[SampledText]:
    """Yield the summary of each docstring of a module, class, function or constant."""
    for name, node in iterate_syntax_nodes(files):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef):
            text = ast.get_docstring(node)
            if text:
                yield f"{name}:{getattr(node, 'name', 'module')}", " ".join(text.split("\n\n")[0].split())
            for previous_node, node_after in zip(node.body, node.body[1:], strict=False):
                if isinstance(previous_node, ast.Assign | ast.AnnAssign) and isinstance(node_after, ast.Expr):
                    value = node_after.value
                    if isinstance(value, ast.Constant) and isinstance(value.value, str):
                        yield f"{name}:{node_after.lineno}", " ".join(value.value.split("\n\n")[0].split())


def comments(files: TextsByPath) -> Iterator[SampledText]:
    """Yield the comments in Python, C++ and JavaScript. Comments on consecutive lines are joined."""
    for name, text in sorted(files.items()):
        lines: list[tuple[int, bool, str]] = []
        if is_python(name):
            for token in tokenize.generate_tokens(io.StringIO(text).readline):
                if token.type == tokenize.COMMENT:
                    is_whole_line = token.line.lstrip().startswith("#")
                    lines.append((token.start[0], is_whole_line, token.string.lstrip("#! ")))
        elif name.endswith((".cpp", ".hpp", ".js")):
            for line_number, line in enumerate(text.splitlines(), 1):
                if match := re.search(r"(?:^|[;{},]) *///?<? ?(.+)", line):
                    lines.append((line_number, line.lstrip().startswith("//"), match[1]))
        joined_comments: list[tuple[int, int, str]] = []
        for line_number, is_whole_line, comment in lines:
            if is_whole_line and joined_comments and joined_comments[-1][1] == line_number - 1:
                joined_comments[-1] = (joined_comments[-1][0], line_number, f"{joined_comments[-1][2]} {comment}")
            else:
                joined_comments.append((line_number, line_number if is_whole_line else 0, comment))
        for line_number, _, comment in joined_comments:
            is_marker = re.search(r"----|^(type|fmt|noqa|ruff): ?|^namespace |NOLINT", comment)
            if len(comment) >= MIN_COMMENT_LENGTH and not is_marker:
                yield f"{name}:{line_number}", comment


def exception_messages(files: TextsByPath) -> Iterator[SampledText]:
    """Yield the message texts of exceptions and warnings in the package."""
    for name, node in iterate_syntax_nodes(files, ("python/stiction",)):
        if isinstance(node, ast.Raise) and isinstance(node.exc, ast.Call):
            arguments = node.exc.args
        elif isinstance(node, ast.Call) and ast.unparse(node.func).endswith("warn"):
            arguments = node.args
        else:
            continue
        for argument in arguments[:1]:
            if isinstance(argument, ast.JoinedStr) or (
                isinstance(argument, ast.Constant) and isinstance(argument.value, str) and " " in argument.value
            ):
                yield f"{name}:{node.lineno}", ast.unparse(argument)


def documentation_sentences(files: TextsByPath) -> Iterator[SampledText]:
    """Yield the sentences of the documentation."""
    for name, text in sorted(files.items()):
        if name.endswith(".md") and "generated" not in name:
            body = re.sub(r"```.*?```|\A---.*?^---", "", text, flags=re.DOTALL | re.MULTILINE)
            for block in re.split(r"\n\s*\n|\n\s*(?=[-*] |\d+\. )", body):
                paragraph = re.sub(r"^([-*]|\d+\.) ", "", " ".join(block.split()))
                if paragraph and not paragraph.startswith(("#", "|", "(", ":", "<", "![")):
                    for sentence in re.split(r"(?<=[.:])\s+(?=[A-Z*`[μτ])", paragraph):
                        if len(sentence.split()) >= MIN_SENTENCE_WORDS:
                            yield name, sentence


def commit_subjects(files: TextsByPath) -> Iterator[SampledText]:
    """Yield the subjects of the newest commits."""
    log_command = ["git", "log", f"-{MAX_COMMITS}", "--format=%h %s"]
    for line in subprocess.run(log_command, cwd=ROOT, capture_output=True, check=True, text=True).stdout.splitlines():
        commit, subject = line.split(" ", 1)
        yield commit, subject


SENTENCE_SOURCES: dict[str, Callable[[TextsByPath], Iterator[SampledText]]] = dict(
    zip(
        SENTENCE_KINDS,
        (docstring_summaries, comments, exception_messages, documentation_sentences, commit_subjects),
        strict=True,
    )
)


# ---- Names ----------------------------------------------------------------------------------------------------------


def bound_names(node: ast.AST) -> Iterator[tuple[str, str]]:
    """Yield the kind and the spelling of each name that a node of a syntax tree defines."""
    if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
        yield ("test" if node.name.startswith("test_") else "function"), node.name
    elif isinstance(node, ast.ClassDef):
        yield "class", node.name
    elif isinstance(node, ast.arg):
        yield "variable", node.arg
    elif isinstance(node, ast.Name | ast.Attribute) and isinstance(node.ctx, ast.Store):
        name = node.id if isinstance(node, ast.Name) else node.attr
        yield ("constant" if is_constant(name) else "variable"), name


def is_constant(name: str) -> bool:
    return name.isupper() and len(name.strip("_")) > 1


def names_by_kind(files: TextsByPath) -> dict[str, list[SampledText]]:
    """Return the location and spelling of all defined names by kind. A repeated name counts once per file."""
    unique_names: dict[str, dict[SampledText, None]] = {kind: {} for kind in NAME_KINDS}
    for path, node in iterate_syntax_nodes(files):
        for kind, name in bound_names(node):
            if len(name.strip("_")) > 1:
                unique_names[kind][path, name] = None
    return {kind: list(items) for kind, items in unique_names.items()}


# ---- Sample ---------------------------------------------------------------------------------------------------------


def sample_rows(items_by_kind: Mapping[str, list[SampledText]], number: int, generator: random.Random) -> Iterator[str]:
    """Yield a table row for each of `number` random items, with equal numbers of each kind if possible."""
    yield "| mark | kind | place | text |\n|---|---|---|---|"
    for i, (kind, items) in enumerate(items_by_kind.items()):
        num_sampled = number // len(items_by_kind) + (i < number % len(items_by_kind))
        for location, text in generator.sample(items, min(num_sampled, len(items))):
            yield f"|  | {kind} | {location} | {text[:MAX_SAMPLE_LENGTH].replace('|', chr(92) + '|')} |"


def sample_functions(files: TextsByPath, number: int, generator: random.Random) -> Iterator[str]:
    """Yield the source of `number` random functions of the package that have a docstring."""
    functions = []
    for name, node in iterate_syntax_nodes(files, ("python/stiction",)):
        if isinstance(node, ast.FunctionDef) and ast.get_docstring(node):
            end_line = node.end_lineno or node.lineno
            if end_line - node.lineno <= MAX_FUNCTION_LINES:
                functions.append((name, "\n".join(files[name].splitlines()[node.lineno - 1 : end_line])))
    for name, source in generator.sample(functions, number):
        yield f"## {name}\n\n```python\n{source}\n```\n"


def print_sample(seed: int, number: int, functions: int) -> None:
    files, generator = read_commit_files(), random.Random(seed)
    print(f"Seed {seed}. Mark each: C clear, A awkward but understood, X read twice or misunderstood.\n")
    if functions:
        print(*sample_functions(files, functions, generator), sep="\n")
        return
    for items_by_kind in (
        {kind: list(find_items(files)) for kind, find_items in SENTENCE_SOURCES.items()},
        names_by_kind(files),
    ):
        print(", ".join(f"{len(items)} of kind {kind}" for kind, items in items_by_kind.items()), end="\n\n")
        print(*sample_rows(items_by_kind, number, generator), "", sep="\n")


# ---- Check ----------------------------------------------------------------------------------------------------------


def rejected_words(words_by_directory: Mapping[str, list[str]], path: str) -> set[str]:
    """Return the words that a file must not contain: those listed for `all`, and for each directory above the file."""
    return set(
        chain.from_iterable(
            words
            for directory, words in words_by_directory.items()
            if directory == "all" or is_in_directories(path, (directory,))
        )
    )


def find_name_faults(files: TextsByPath, words_by_directory: Mapping[str, list[str]]) -> Iterator[str]:
    words_by_path = {path: rejected_words(words_by_directory, path) for path in files}
    for path, node in iterate_syntax_nodes(files):
        for kind, name in bound_names(node):
            if name.strip("_").lower() in words_by_path[path]:
                yield f"{path}:{getattr(node, 'lineno', 1)}: {name} is no noun of the field, for a {kind}"


def find_test_name_faults(files: TextsByPath, words_by_directory: Mapping[str, list[str]]) -> Iterator[str]:
    for path, node in iterate_syntax_nodes(files, ("tests",)):
        if isinstance(node, ast.FunctionDef) and node.name.startswith("test_"):
            first_word = node.name.split("_")[1]
            if first_word in rejected_words(words_by_directory, path):
                yield f"{path}:{node.lineno}: {node.name} does not begin with the unit that is tested"


def find_first_word_faults(files: TextsByPath, words_by_directory: Mapping[str, list[str]]) -> Iterator[str]:
    for location, sentence in chain(docstring_summaries(files), comments(files)):
        if sentence.split()[0] in rejected_words(words_by_directory, location.split(":")[0]):
            yield f"{location}: {sentence[:60]!r} does not begin with a verb or with the thing that it describes"


def find_dropped_line_faults(pages: TextsByPath) -> Iterator[str]:
    """Yield the lines of paragraphs that the documentation drops, because a line that starts with % is a comment."""
    for path, text in pages.items():
        is_code, previous_line = False, ""
        for number, line in enumerate(text.splitlines(), start=1):
            if line.lstrip().startswith("```"):
                is_code = not is_code
            elif line.lstrip().startswith("%") and previous_line.strip() and not is_code:
                yield f"{path}:{number}: a paragraph has a line that starts with %, which the documentation drops"
            previous_line = line


def modules_by_repeated_class(files: TextsByPath) -> dict[str, set[str]]:
    """Return the modules that define the same class name, by class name."""
    modules: dict[str, set[str]] = {}
    for path, node in iterate_syntax_nodes(files):
        if isinstance(node, ast.ClassDef):
            modules.setdefault(node.name.strip("_"), set()).add(path)
    return {name: paths for name, paths in modules.items() if len(paths) > 1}


def modules_by_repeated_constant(files: TextsByPath) -> dict[str, set[str]]:
    """Return the modules that define the same constant with different values, by name of the constant."""
    modules: dict[str, dict[str, str]] = {}
    for path, text in sorted(files.items()):
        if not is_python(path) or not is_in_directories(path, IMPORTABLE_DIRECTORIES):
            continue
        module = list_syntax_nodes(text)[0]
        assert isinstance(module, ast.Module)
        for node in module.body:
            if isinstance(node, ast.Assign | ast.AnnAssign) and node.value is not None:
                for target in node.targets if isinstance(node, ast.Assign) else [node.target]:
                    if isinstance(target, ast.Name) and is_constant(target.id):
                        modules.setdefault(target.id.strip("_"), {})[path] = ast.unparse(node.value)
    return {name: set(values) for name, values in modules.items() if len(set(values.values())) > 1}


def find_repetition_faults(meanings_by_name: Mapping[str, set[str]], accepted_names: list[str]) -> Iterator[str]:
    for name in sorted(set(meanings_by_name) - set(accepted_names)):
        yield f"{name} has several meanings: {', '.join(sorted(meanings_by_name[name]))}"


def check_words_and_names() -> None:
    files, rules = read_tracked_files(is_python), tomllib.loads(WORD_RULES_FILE.read_text("utf-8"))
    faults = [
        *find_name_faults(files, rules["names"]),
        *find_test_name_faults(files, rules["test_names"]),
        *find_first_word_faults(files, rules["openings"]),
        *find_dropped_line_faults(read_tracked_files(is_page)),
        *find_repetition_faults(modules_by_repeated_class(files), rules["repeated"]["classes"]),
        *find_repetition_faults(modules_by_repeated_constant(files), rules["repeated"]["constants"]),
    ]
    if faults:
        print(*faults, sep="\n")
        sys.exit(f"words: {len(faults)} faults in names, sentences and pages; tools/words.toml lists rejected words")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    commands.add_parser("check")
    options = commands.add_parser("sample")
    options.add_argument("--seed", type=int, default=random.randrange(10**6))
    options.add_argument("--number", type=int, default=150, metavar="N", help="sentences, and names")
    options.add_argument("--functions", type=int, default=0, metavar="N")
    arguments = vars(parser.parse_args())
    # Disable garbage collection: syntax trees contain no cycles, and the search for cycles takes half of the time.
    gc.disable()
    if arguments.pop("command") == "check":
        check_words_and_names()
    else:
        print_sample(**arguments)


if __name__ == "__main__":
    main()
