"""Definition of a study: bodies, contact, inputs with uncertainty, and options of a measured pair."""
