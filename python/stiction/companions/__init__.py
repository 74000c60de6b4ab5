"""Further results of a pair: onset of sliding, friction with scaled heights or other cutoffs, and single contacts."""
