"""Syntax trees of source files."""

import ast
import functools


@functools.cache
def parse_file(path):
    """Return the syntax tree of a source file, which tests of several files read."""
    return ast.parse(path.read_text("utf-8"))
