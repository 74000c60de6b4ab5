"""Studies, which compute the friction of ensembles of surface pairs over ranges of parameters."""
