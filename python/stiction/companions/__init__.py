"""Further computations for a pair: onset of sliding, scaled heights, other cutoffs, and single contacts."""
