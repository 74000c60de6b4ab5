"""Further solutions for a pair that are stored alongside its result."""
