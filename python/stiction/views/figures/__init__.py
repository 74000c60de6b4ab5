"""Figures of results for print, one module per topic; `draw_figures` draws all of a result."""

from stiction.views.figures.standard import draw_figures

__all__ = ["draw_figures"]
