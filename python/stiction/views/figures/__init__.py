"""Figures of results for print, in one style: a module for each topic, and `drawn` for those of a result."""

from stiction.views.figures.standard import drawn

__all__ = ["drawn"]
