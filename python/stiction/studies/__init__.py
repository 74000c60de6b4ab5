"""Studies: computation of friction for ensembles of surface pairs over ranges of parameters."""
