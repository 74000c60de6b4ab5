"""Figures of results for print: one module per topic, and `draw_figures` for all figures of a result."""

from stiction.views.figures.standard import draw_figures

__all__ = ["draw_figures"]
