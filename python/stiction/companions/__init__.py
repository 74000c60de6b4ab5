"""Results in addition to the main result: onset of sliding, scaled heights, several cutoffs, and single contacts."""
