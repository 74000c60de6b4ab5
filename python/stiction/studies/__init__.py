"""Ensembles of pairs over planes of parameters."""
