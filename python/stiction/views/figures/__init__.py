"""Figures of results for print, with one module per topic. `draw_figures` draws all figures of a result."""

from stiction.views.figures.standard import draw_figures

__all__ = ["draw_figures"]
