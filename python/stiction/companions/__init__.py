"""Additional results of a pair: onset of sliding, scaled heights, several scan cutoffs, and single contacts."""
