"""Definition of a study: bodies, contact, inputs with their uncertainty, and the options of a pair."""
