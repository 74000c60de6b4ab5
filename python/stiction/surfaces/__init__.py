"""Profiles: measured or generated heights on a uniform grid."""
