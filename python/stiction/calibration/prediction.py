"""Predictions of the friction of other surfaces from a fitted interface."""

from __future__ import annotations

import math
import warnings
from collections.abc import Hashable
from pathlib import Path
from typing import Any

import numpy as np

from stiction._checks import Floats
from stiction.calibration.friction_tests import (
    AreaFactor,
    Ball,
    FrictionTest,
    depends_on_junction_growth,
    evaluate_test_sums,
)
from stiction.evaluate.budget import predict_interval
from stiction.mechanics.friction import FrictionCurve, FrictionLaw
from stiction.solve.member_sums import MemberSums
from stiction.study.interfaces import (
    HARDNESS_HEADER_ENTRY,
    InterfaceStrength,
    ValueWithLimits,
    cover_credible_intervals,
)


class Interface(InterfaceStrength):
    """Interface with a joint distribution of mu0 and tau0, fitted to tests, that predicts friction of other surfaces.

    Attributes
    ----------
    fits : tuple of StrengthFit
        Fits for the requested sliding rules, in order of preference.
    area_per_load : float, 1/GPa
        True area per load (A/F) of the tests, at which mu0 + tau0 A/F is identified.
    variation : float
        Standard deviation of A/F among the tests, divided by the mean.
    separated : bool
        True if the tests determine mu0 and tau0 separately, rather than only the sum mu0 + tau0 A/F.
    advice, tests : tuple
        Further tests that would separate mu0 and tau0, and the tests of the fit, as in `InterfaceStrength`.
    about : mapping of str to str
        Kind ("measured", "lumped" or "bound"), materials, conditions and source.

    Examples
    --------
    >>> from stiction import interface
    >>> strength = interface("MoS2 on bearing steel, dry air")
    >>> strength.separated, round(strength.tau0[0], 4)
    (True, 0.0248)
    """

    def predict(self, result: Any, load: float | str) -> ValueWithLimits:
        """Predict the friction coefficient of other surfaces at a load, with its 95 % interval.

        Parameters
        ----------
        result : Result, HalfSpaceCurve, LoadCurve or Ball
        load : float or str, mN

        Returns
        -------
        (float, float, float)
            Median, lower limit and upper limit. The interval includes the joint uncertainty of mu0 and tau0, and the
            scatter of the area between positions. The upper limit is infinite if the interface may be
            stronger than the softer body. For measured bodies, the interval is
            the combined interval that `pair` computes with this interface, without alternative preparations of the
            scans. This does not apply if tests and result share their surfaces or an uncertain input, such as the
            exponent of bodies that yield or a modulus: their common errors cancel here, but not in `pair`, which
            samples all inputs except the hardness and the junction growth again.

        Warns
        -----
        UserWarning
            If the junction growth differs between the tests and the result.
        """
        if not (isinstance(result, (Ball, FrictionCurve)) or hasattr(result, "dataset") or hasattr(result, "attrs")):
            raise ValueError(f"result must be a Result, a curve or a Ball, got {type(result).__name__}")
        from scipy.special import ndtr

        fit, generator = self.fits[0], np.random.default_rng(1)
        test_sums = evaluate_test_sums(FrictionTest(result, load, coefficient=0.0), fit.sliding)

        def draw_scores(name: Hashable) -> Floats:
            # If the parameter also affects the tests of the fit, use its samples from the fit.
            return fit.scores[name] if name in fit.scores else generator.standard_normal(len(fit.mu0))

        area_samples = np.exp(test_sums.scatter * draw_scores(test_sums.surfaces))
        if (area_factor := test_sums.area_factor) is not None:
            samples = area_factor.input_values({name: ndtr(draw_scores(name)) for name in area_factor.nuisance_names})
            if "hardness" in samples and area_factor.uncertain_inputs["hardness"].describes_same_hardness(
                self.about.get(HARDNESS_HEADER_ENTRY, "")
            ):
                samples["hardness"] = fit.hardness
            if "junction_growth" in samples and self.has_equal_junction_growth(
                area_factor.uncertain_inputs["junction_growth"]
            ):
                samples["junction_growth"] = fit.junction_growth
        growth = None if area_factor is None else area_factor.junction_growth
        depends_on_growth = growth is not None or depends_on_junction_growth(
            test_sums, float(np.median(fit.mu0)), float(np.median(fit.tau0))
        )
        if depends_on_growth and self.junction_growth is not None and not self.has_equal_junction_growth(growth):
            test_growth, result_growth = (
                estimate.short_text if estimate is not None else "0" for estimate in (self.junction_growth, growth)
            )
            warnings.warn(
                f"the interface was calibrated with junction growth {test_growth}, and the result has "
                f"{result_growth}; press both with the same junction_growth",
                stacklevel=2,
            )

        def compute_coefficients(mu0: Floats, tau0: Floats) -> tuple[Floats, Floats]:
            """Return friction coefficients and their upper limits, which are infinite where the softer body shears."""
            law, fraction, total_area = FrictionLaw(mu0, tau0), np.ones(()), area_samples
            if area_factor is not None:
                area, fraction = area_factor.onset_factors(samples, law)
                total_area = area_samples * area
            values = law.coefficient(test_sums.sums, np.where(tau0 > 0, total_area, 1.0), fraction)
            values = np.where(np.isfinite(values), values, np.inf)
            return values, np.where(fraction < 1, np.inf, values)

        coefficients, upper_coefficients = zip(
            *(compute_coefficients(*strengths) for strengths in self.strength_samples), strict=True
        )
        value, lower, _ = cover_credible_intervals(coefficients)
        _, _, upper = cover_credible_intervals(upper_coefficients)
        has_shared_errors = test_sums.surfaces in fit.scores or (
            area_factor is not None and bool(fit.scores.keys() & self._list_separate_nuisances(area_factor))
        )
        if isinstance(result, (Ball, FrictionCurve)) or has_shared_errors:
            return value, lower, upper
        sums = MemberSums.of(result)
        if not sums.study.is_measured:
            return value, lower, upper
        combined_interval = predict_interval(sums, float(FrictionTest(result, load, coefficient=0.0).load), self)
        # The mean over a single position has no interval. Then return the interval of the fit.
        return (
            (value, lower, upper)
            if math.isnan(combined_interval.lower + combined_interval.upper)
            else (value, *combined_interval)
        )

    def _list_separate_nuisances(self, area_factor: AreaFactor) -> set[Hashable]:
        """Return the names of an area factor's nuisance parameters, except those with joint samples in the fit."""
        uncertain_inputs = area_factor.uncertain_inputs
        joint_names = {
            "hardness": "hardness" in uncertain_inputs
            and uncertain_inputs["hardness"].describes_same_hardness(self.about.get(HARDNESS_HEADER_ENTRY, "")),
            "junction_growth": self.has_equal_junction_growth(uncertain_inputs.get("junction_growth")),
        }
        return {area_factor.nuisance_name(name) for name in uncertain_inputs if not joint_names.get(name)}


def read_interface(path: str | Path) -> Interface:
    """Read an interface from a file that `write_interface` wrote.

    Parameters
    ----------
    path : path
        Path of the file.

    Returns
    -------
    interface : Interface
        Joint distribution of mu0 and tau0 (GPa).

    Raises
    ------
    ValueError
        If the file cannot be read, or is not an interface file.

    See Also
    --------
    write_interface : Inverse function.

    Examples
    --------
    >>> from stiction import read_interface
    >>> read_interface("no such file")
    Traceback (most recent call last):
    ...
    ValueError: no such file cannot be read as an interface: No such file or directory
    """
    return Interface.read(path)


def interface(name_or_path: str | Path) -> Interface:
    """Return a published interface, or read an interface from a file that `stiction calibrate` wrote.

    Parameters
    ----------
    name_or_path : str or path
        Name of a published interface as in `interfaces`, or path of a file.

    Returns
    -------
    interface : Interface
        Joint distribution of mu0 and tau0 (GPa).

    Raises
    ------
    ValueError
        If no interface or file has this name.

    See Also
    --------
    interfaces : Names of the published interfaces.
    read_interface : Files only.

    Examples
    --------
    >>> from stiction import interface
    >>> interface("MoS2 on bearing steel, dry air").about["motion"]
    'kinetic'
    """
    return Interface.named(name_or_path)
