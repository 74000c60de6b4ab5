"""Measured and generated profiles and height maps, their preparation and their roughness."""
