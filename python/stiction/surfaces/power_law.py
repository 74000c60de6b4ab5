"""The likeliest power law of a spectrum, and the exponents that are nearly as likely."""

from __future__ import annotations

import math

import numpy as np

from stiction._checks import Floats

_NEWTON_STEPS, _HALVINGS = 50, 30


class PowerLaw:
    """Likeliest power law P ∝ q^-s through powers that are gamma distributed, their shapes the weights."""

    def __init__(self, log_q: Floats, power: Floats, weight: Floats) -> None:
        self._total = float(weight.sum())
        share = weight / self._total
        self._middle = float(share @ log_q)
        self._log_q = log_q - self._middle
        self._largest = float(power.max())
        self._power = share * power / self._largest
        self.exponent = 0.0
        for _ in range(_NEWTON_STEPS):  # the loss is convex, with a logarithm of a sum of exponentials
            scaled = self._power * np.exp(self.exponent * self._log_q)
            scaled /= scaled.sum()
            gradient = float(scaled @ self._log_q)
            step = gradient / float(scaled @ (self._log_q - gradient) ** 2)
            self.exponent -= min(max(step, -2.0), 2.0)
            if abs(step) < 1e-10:
                break
        self.least_loss = self.loss(self.exponent)

    def _log_level(self, exponent: float) -> float:
        return math.log((self._power * np.exp(exponent * self._log_q)).sum()) + math.log(self._largest)

    def loss(self, exponent: float) -> float:
        """Minus the log-likelihood but for a constant, the prefactor at its best."""
        return self._total * self._log_level(exponent)

    @property
    def log_prefactor(self) -> float:
        """Ln C of the law C q^-s."""
        return self._log_level(self.exponent) + self.exponent * self._middle

    def interval(self, most_loss: float) -> tuple[float, float]:
        """Exponents between which the loss is not larger than a value above the least."""
        ends = []
        for side in (-1.0, 1.0):
            near, far = 0.0, 0.1
            while self.loss(self.exponent + side * far) < most_loss:
                near, far = far, 2 * far
            for _ in range(_HALVINGS):
                middle = (near + far) / 2
                near, far = (middle, far) if self.loss(self.exponent + side * middle) < most_loss else (near, middle)
            ends.append(self.exponent + side * far)
        return ends[0], ends[1]
