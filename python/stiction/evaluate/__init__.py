"""Quantities and their intervals, evaluated from the contact sums of the members."""
