"""Friction studies of ensembles of surface pairs over ranges of parameters."""
