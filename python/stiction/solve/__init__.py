"""Computation of the contact sums of all members, and their storage."""
