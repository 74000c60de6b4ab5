"""Computations in addition to a result: onset of sliding, scaled heights, several cutoffs, and single contacts."""
