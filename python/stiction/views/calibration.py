"""What friction tests say of mu0 and tau0: as text, as JSON, and as a picture."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from stiction._number_format import finite, percent, with_interval, with_unit
from stiction._repr import render_png
from stiction.studies.calibration_fit import MIN_VARIATION
from stiction.studies.interfaces import EXCLUDED, UNLIKELY, Fit, Interface
from stiction.views.point import RULES
from stiction.views.rows import entry, record
from stiction.views.style import ALL, FORCE, FULL_WIDTH, STYLE, new_figure
from stiction.views.text import aligned, fitted

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST_POINTS = 800  # draws that are shown of a joint distribution


def calibration_text(interface: Interface) -> str:
    """What is identified, whether both are separated, how well each rule fits, and what would tell them apart."""
    first = interface.fits[0]
    at = f"at A/F = {interface.area_per_load:.3g} /GPa, {RULES[first.sliding]}"
    lines = [fitted(f"μ0 + τ0 A/F = {with_interval(*interface.identified)} {at}", hang="  ")]
    if interface.separated:
        tau0 = (1e3 * each for each in interface.tau0)
        lines += [f"μ0 = {with_interval(*interface.mu0)}", f"τ0 = {with_interval(*tau0)} MPa"]
    else:
        lines += [fitted(each, hang="  ") for each in _not_separated(interface)]
    if interface.growth is not None:
        lines += [fitted(_growth_words(interface), hang="  ")]
    lines += ["", *(fitted(each, hang="  ") for fit in interface.fits for each in _fit_words(interface, fit))]
    if interface.advice:
        table = [["what would tell them apart", "± μ0", "± τ0"]]
        table += [[words, f"{mu0:.2g}", with_unit(tau0, "GPa")] for words, mu0, tau0 in interface.advice]
        lines += ["", aligned(table)]
    return "\n".join(lines)


def _not_separated(interface: Interface) -> Iterator[str]:
    value, ratio = interface.identified[0], interface.area_per_load
    count = len(interface.tests)
    few = f"A/F varies by {percent(interface.variation)} among {count} tests" if count > 1 else "there is one test"
    need = f", and {MIN_VARIATION:.0%} are needed".replace("%", " %") if count > 2 else ", and three are needed"
    yield f"Only μ0 + τ0 A/F is measured: {few}{need} to know either alone."
    yield f"What is left: from μ0 = {value:.3g}, τ0 = 0 to μ0 = 0, τ0 = {with_unit(value / ratio, 'GPa')}."


def _growth_words(interface: Interface) -> str:
    """Return α of junction growth that the tests were calibrated with, and its interval where it is a range."""
    assert interface.growth is not None, "tests have α"
    words = f"Junction growth: the tests have α = {interface.growth.short_text}"
    if interface.growth.is_exact:
        return f"{words}. A pair with this interface takes the same."
    low, value, high = np.quantile(interface.fits[0].junction_growth, [0.025, 0.5, 0.975])
    return f"{words}, and are consistent with {with_interval(value, low, high)}. A pair with it takes the same."


def _fit_words(interface: Interface, fit: Fit) -> Iterator[str]:
    rule = RULES[fit.sliding]
    if not fit.freedom:
        yield f"{rule}: as many unknowns as tests, so the fit cannot be judged."
    elif math.isnan(fit.probability):
        yield f"{rule}: errors were found from the scatter of {fit.freedom} degrees of freedom."
    else:
        words = f"{rule}: χ² = {fit.chi_squared:.3g} of {fit.freedom} degrees of freedom"
        if fit.sliding in interface.excluded:
            yield f"{words}: excluded by the tests (probability {fit.probability:.1g})."
        elif fit.scale > 1:
            yield f"{words}: residuals are larger than the errors allow, which were multiplied by {fit.scale:.2g}."
        elif fit.probability < UNLIKELY:
            yield f"{words}: a poor fit."
        else:
            yield f"{words}."
    if fit.trend < EXCLUDED:
        yield f"{rule}: residuals vary with the load (probability {fit.trend:.1g}), so the law does not fit."


def calibration_record(interface: Interface) -> str:
    """The same as JSON."""
    alone = "ok" if interface.separated else "not separated"
    at = {"area_per_load_per_GPa": interface.area_per_load}
    values = [
        entry(name, value, unit, lower=low, upper=high, at=place, status=status)
        for name, (value, low, high), unit, place, status in (
            ("identified", interface.identified, "1", at, "ok"),
            ("mu0", interface.mu0, "1", {}, alone),
            ("tau0", interface.tau0, "GPa", {}, alone),
        )
    ]
    fits = [
        {
            "sliding": fit.sliding, "chi_squared": finite(fit.chi_squared), "freedom": fit.freedom,
            "probability": finite(fit.probability), "errors_multiplied_by": fit.scale, "trend": finite(fit.trend),
        }
        for fit in interface.fits
    ]  # fmt: skip
    advice = [{"what": words, "error_of_mu0": mu0, "error_of_tau0": tau0} for words, mu0, tau0 in interface.advice]
    return record(
        "calibrate", values, kind="interface", variation=interface.variation, separated=interface.separated,
        junction_growth=None if interface.growth is None else interface.growth.short_text,
        excluded=list(interface.excluded), fits=fits, would_separate=advice,
    )  # fmt: skip


def interfaces_text(found: Sequence[Mapping[str, str]]) -> str:
    """A paragraph for each interface that was read in a source."""
    parts = []
    for each in found:
        kind = ", ".join(each[name] for name in ("kind", "motion") if name in each)
        law = f"{kind}: μ0 = {each['mu0']}, τ0 = {each['tau0']}"
        others = {name.replace("_", " "): text for name, text in each.items() if name not in _OF_LAW}
        rest = (text if name in _PLAIN else f"{name} {text}" for name, text in others.items())
        parts.append("\n".join([each["name"], *(fitted(line, indent="  ", hang="  ") for line in (law, *rest))]))
    return "\n\n".join(parts)


_OF_LAW = ("name", "kind", "motion", "mu0", "tau0")
_PLAIN = ("conditions", "source")
"""Entries of an interface that say by themselves what they are."""


def calibration_figure(interface: Interface) -> Figure:
    """Tests and fit over A/F beside the joint distribution of mu0 and tau0; 170 mm wide.

    Examples
    --------
    >>> from stiction import Ball, FrictionTest, calibrate, calibration_figure
    >>> ball = Ball("5 mm", "3 GPa")
    >>> tests = [FrictionTest(ball, load, coefficient=0.3, uncertainty=0.01) for load in (10.0, 100.0, 1000.0)]
    >>> len(calibration_figure(calibrate(tests)).axes)
    2
    """
    import matplotlib as mpl

    if not isinstance(interface, Interface):
        raise ValueError(f"interface must be an Interface, as calibrate() gives it, got {type(interface).__name__}")
    with mpl.rc_context(STYLE):
        figure = new_figure(66, width=FULL_WIDTH)
        data, joint = figure.subplots(1, 2)
        _tests_panel(data, interface)
        fit = interface.fits[0]
        joint.plot(1e3 * fit.tau0[:MOST_POINTS], fit.mu0[:MOST_POINTS], ".", color=ALL, markersize=2, alpha=0.3)
        joint.set(xlabel="adhesive shear strength $\\tau_0$ (MPa)", ylabel="molecular friction coefficient $\\mu_0$")
        joint.set(xlim=(0, None), ylim=(0, None))
        joint.set_title("both are known" if interface.separated else "only their sum is known")
    vars(figure)["_repr_png_"] = partial(render_png, figure)
    return figure


def _tests_panel(axes: Axes, interface: Interface) -> None:
    points = np.array(interface.tests, dtype=float).reshape(-1, 4)
    largest = 1.15 * max(points[:, 0].max(initial=0.0), interface.area_per_load)
    ratio = np.linspace(0.0, largest, 60)
    band = np.array([interface.at(each) for each in ratio])
    axes.fill_between(ratio, band[:, 1], band[:, 2], color=ALL, alpha=0.15, linewidth=0, label="95 %")
    axes.plot(ratio, band[:, 0], color=ALL, linewidth=1, label="$\\mu_0 + \\tau_0 A/F$")
    slid = points[:, 3] > 0
    axes.errorbar(
        points[slid, 0], points[slid, 1], 2 * np.nan_to_num(points[slid, 2]), fmt="o", color=FORCE, markersize=2.5,
        linewidth=0.6, label="tests, ±2 standard errors",
    )  # fmt: skip
    if not slid.all():
        axes.plot(points[~slid, 0], points[~slid, 1], "^", color=FORCE, markersize=3, label="held")
    axes.set(xlim=(0, largest), ylim=(0, 1.3 * max(points[:, 1].max(initial=0.0), band[-1, 0])))
    axes.set(xlabel="true contact area over load $A/F$ (1/GPa)", ylabel="coefficient of static friction")
    axes.legend(loc="lower right")
