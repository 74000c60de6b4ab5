"""Quantities and their intervals, evaluated from contact sums: forces and areas summed over a member's contacts."""
