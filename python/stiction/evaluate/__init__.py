"""Evaluation of friction and other quantities with intervals. Inputs: forces and areas summed over contacts."""
