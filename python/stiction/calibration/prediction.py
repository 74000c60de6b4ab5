"""Predictions of the friction of other surfaces from a fitted interface."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from stiction._checks import Floats
from stiction._warnings import warn_caller
from stiction.calibration.friction_tests import Ball, FrictionTest, depends_on_junction_growth, evaluate_test_sums
from stiction.evaluate.budget import predict_coefficient
from stiction.mechanics.friction import FrictionCurve, FrictionLaw
from stiction.solve.member_sums import MemberSums
from stiction.study.interfaces import (
    InterfaceStrength,
    StrengthFit,
    ValueWithLimits,
    area_error_name,
    cover_credible_intervals,
)
from stiction.study.shared_inputs import apply_ranges_of_pair, find_shared_inputs


class Interface(InterfaceStrength):
    """Interface: joint distribution of mu0 and tau0 from friction tests, for predictions on other surfaces.

    Attributes
    ----------
    fits : tuple of StrengthFit
        Fits for the requested sliding rules, in order of preference.
    area_per_load : float, 1/GPa
        Median true area per load (A/F), averaged over the tests, at which mu0 + tau0 A/F is identified.
    variation : float
        Standard deviation of A/F among the tests that slid, divided by the mean; each test has the weight 1/error².
    separated : bool
        True if the tests determine mu0 and tau0 separately, rather than only the sum mu0 + tau0 A/F.
    advice, tests : tuple
        Further tests that would separate mu0 and tau0, and the tests of the fit, as in `InterfaceStrength`.
    about : mapping of str to str
        Kind ("measured", "lumped" or "bound"), materials, conditions and source.
    common : float
        Relative standard uncertainty that all tests share; NaN for a published interface or an older file.

    Examples
    --------
    >>> from stiction import interface
    >>> strength = interface("MoS2 on bearing steel, dry air")
    >>> strength.separated, round(strength.tau0[0], 4)
    (True, 0.0248)
    """

    def predict(self, result: Any, load: float | str) -> ValueWithLimits:
        """Predict the friction coefficient of other surfaces, and its 95 % interval, at a given load.

        Parameters
        ----------
        result : Result, HalfSpaceCurve, LoadCurve or Ball
        load : float or str, mN

        Returns
        -------
        (float, float, float)
            Coefficient, lower limit and upper limit. For measured bodies, these are the numbers that `pair` gives with
            this interface, which covers unresolved roughness and positions too. Inputs that affected the tests, such as
            the hardness of the same material, have the same error in the tests and here; of two ranges with the same
            central value, the narrower one applies. If the interface was calibrated on this pair, errors of its true
            area cancel. The upper limit is infinite if the interface may be stronger than the softer body.

        Warns
        -----
        UserWarning
            If the junction growth differs between the tests and the result.
        """
        if not (isinstance(result, (Ball, FrictionCurve)) or hasattr(result, "dataset") or hasattr(result, "attrs")):
            raise ValueError(f"result must be a Result, a curve or a Ball, got {type(result).__name__}")
        from scipy.special import ndtr

        fit, generator = self.fits[0], np.random.default_rng(1)
        test = FrictionTest(result, load, coefficient=0.0)
        test_sums = evaluate_test_sums(test, fit.sliding)

        area_error, area_factor = area_error_name(test_sums.surfaces), test_sums.area_factor
        names = [area_error, *area_factor.nuisance_names]
        independent_scores = {
            name: generator.standard_normal(fit.mu0.size) for name in dict.fromkeys(names) if name not in fit.scores
        }
        growth = area_factor.junction_growth
        depends_on_growth = growth is not None or depends_on_junction_growth(
            test_sums, float(np.median(fit.mu0)), float(np.median(fit.tau0))
        )
        if depends_on_growth and self.junction_growth is not None and not self.has_equal_junction_growth(growth):
            test_growth, result_growth = (
                estimate.short_text if estimate is not None else "0" for estimate in (self.junction_growth, growth)
            )
            warn_caller(
                f"the interface was calibrated with junction growth {test_growth}, and the result has "
                f"{result_growth}; press both with the same junction_growth"
            )

        is_measured_pair = not isinstance(result, (Ball, FrictionCurve)) and MemberSums.of(result).study.is_measured
        if is_measured_pair:
            combined = predict_coefficient(MemberSums.of(result), float(test.load), self)
            # For a single relative position of the bodies, the combined interval is NaN, so the fit's interval is used.
            if not any(map(math.isnan, combined)):
                return combined

        shared_inputs = find_shared_inputs(self, area_factor.inputs, area_factor.surfaces)

        def compute_coefficients(fit: StrengthFit) -> tuple[Floats, Floats]:
            """Return samples of the coefficient and of its upper limit, which is infinite if the softer body shears."""
            # A parameter that affects both the tests and the prediction keeps the random samples drawn by the fit.
            scores = {**independent_scores, **fit.scores}
            law = FrictionLaw(fit.mu0, fit.tau0)
            samples = area_factor.input_values({name: ndtr(scores[name]) for name in area_factor.nuisance_names})
            # If the result and the tests share an uncertain input, the samples of this input drawn by the fit are used.
            shared_names = shared_inputs.keys() & area_factor.uncertain_inputs.keys()
            samples |= {name: shared_inputs[name].sample(fit) for name in shared_names}
            area, friction_fraction = area_factor.onset_area_and_friction_factors(samples, law)
            total_area = np.exp(test_sums.scatter * scores[area_error]) * area
            values = law.coefficient(test_sums.sums, np.where(fit.tau0 > 0, total_area, 1.0), friction_fraction)
            values = np.where(np.isfinite(values), values, np.inf)
            return values, np.where(friction_fraction < 1, np.inf, values)

        sampled_fits = apply_ranges_of_pair(self, shared_inputs).sampled_fits
        coefficients, upper_coefficients = zip(*(compute_coefficients(each) for each, _ in sampled_fits), strict=True)
        coverages = [coverage for _, coverage in sampled_fits]
        median, lower_limit, _ = cover_credible_intervals(list(zip(coefficients, coverages, strict=True)))
        _, _, upper_limit = cover_credible_intervals(list(zip(upper_coefficients, coverages, strict=True)))
        return median, lower_limit, upper_limit


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
    ValueError: cannot read the interface file no such file: No such file or directory
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
