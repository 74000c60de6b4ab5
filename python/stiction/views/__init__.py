"""Presentation of results as text, tables, figures and reports."""
