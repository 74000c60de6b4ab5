"""Reference for the elastic-plastic sphere: equations of Jackson & Green, J. Tribol. 127 (2005) 343."""

from math import exp, pi, sqrt


def jackson_green(ratio, radius, modulus, strength, poisson):
    """Return the critical interference, and force and area at `ratio` times the critical interference."""
    C = 1.295 * exp(0.736 * poisson)
    critical = (pi * C * strength / (2 * modulus)) ** 2 * radius
    critical_force = 4 / 3 * (radius / modulus) ** 2 * (C / 2 * pi * strength) ** 3
    critical_area = pi**3 * (C * strength * radius / (2 * modulus)) ** 2
    if ratio < 1.9:
        return critical, critical_force * ratio**1.5, critical_area * ratio
    B = 0.14 * exp(23 * strength / modulus)
    area = critical_area * ratio * (ratio / 1.9) ** B
    contact_radius = sqrt(area / pi)
    hardness = 2.84 * strength * (1 - exp(-0.82 * (contact_radius / radius) ** -0.7))
    force = critical_force * (
        exp(-(ratio ** (5 / 12)) / 4) * ratio**1.5
        + 4 * hardness / (C * strength) * (1 - exp(-(ratio ** (5 / 9)) / 25)) * ratio
    )
    return critical, force, area
