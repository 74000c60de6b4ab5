"""Measured and generated profiles and surfaces, their preparation and their roughness."""
