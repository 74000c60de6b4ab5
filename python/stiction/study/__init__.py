"""Definition of a study: bodies, contact, inputs with their uncertainty, and options for a pair of measured bodies."""
