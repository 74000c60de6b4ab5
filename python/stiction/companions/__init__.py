"""Further solutions for a pair, stored beside its result."""
