"""Evaluation of friction and other quantities, with intervals, from forces and areas summed over contacts."""
