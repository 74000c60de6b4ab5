"""Figures of results for print: a module for each topic, and `draw_figures` for the figures of a result."""

from stiction.views.figures.standard import draw_figures

__all__ = ["draw_figures"]
