"""Ensembles drawn again from the repetitions of a result, and what they say at a load (bootstrap)."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from stiction._checks import Floats
from stiction.mechanics import friction
from stiction.mechanics.model import Sliding
from stiction.studies.crossing import Crossing
from stiction.studies.member_values import SIX
from stiction.studies.store import pieces
from stiction.studies.study import study_of

if TYPE_CHECKING:
    import xarray

Quantity = Literal["friction", "area", "stiffness"]
Ruling = Literal["percentiles", "bands"]
"""How the interval of an extreme over D is found: from the extremes of resampled ensembles, or from bands."""

HIGHEST = 1.65
"""Fractal dimension up to which bands are for profiles that touch at asperities."""

RESAMPLES = 400

FLATTER, STEEPER = 0.05, 0.2
"""Amplitudes (µm) of the claim about amplitudes."""

_SUMS = ("contact_area", *SIX)
"""What the claims are about, which asperities and the half-space both have."""


def has_amplitudes(amplitudes: Floats) -> bool:
    """Whether those are there that a claim is about."""
    return all(bool(np.isclose(amplitudes, each, rtol=1e-9).any()) for each in (FLATTER, STEEPER))


class Resampled:
    """Ensemble means of a result and of ensembles drawn from its repetitions, (resample, D) at one amplitude at a time.

    The first resample is the ensemble itself.
    """

    def __init__(
        self,
        dataset: xarray.Dataset,
        amplitude: float,
        *,
        sliding: Sliding | None = None,
        ruling: Ruling = "percentiles",
    ) -> None:
        study = study_of(dataset)
        self._step = study.contact.step
        rules = study.contact.rules()
        if (sliding or rules[0]) not in rules:
            raise ValueError(f"the result has no sliding rule {sliding!r}, it has {', '.join(rules)}")
        data = dataset.sel(sliding=sliding or rules[0]) if "sliding" in dataset.dims else dataset
        if ruling == "bands" and study.surfaces.kind == "profile" and study.contact.mechanics == "asperities":
            data = data.sel(fractal_dimension=data["fractal_dimension"] <= HIGHEST)
        self.ruling = ruling
        repetitions = data.sizes["repetition"]
        random = np.random.default_rng(study.ensemble.seed)
        even = np.full(repetitions, 1 / repetitions)
        # How often each is drawn: a few times at most, so that a byte holds it however many there are.
        drawn = np.ones((1 + RESAMPLES, repetitions), np.uint8)
        for resample in drawn[1:]:
            resample[:] = random.multinomial(repetitions, even)
        dims = ("repetition", "fractal_dimension", "amplitude", self._step)
        names = (*_SUMS, "approach") if self._step == "load" else _SUMS
        self._means: dict[str, Floats] = {}
        first = 0
        for piece in pieces(data, names):
            weights = drawn[:, first : first + piece.sizes["repetition"]] / repetitions
            first += piece.sizes["repetition"]
            for name in names:
                added = np.tensordot(weights, piece[name].transpose(*dims).values, axes=1)
                self._means[name] = self._means[name] + added if name in self._means else added
        self.dimensions = data["fractal_dimension"].values
        self._steps = data[self._step].values
        self._amplitudes = data["amplitude"].values
        self.amplitude = amplitude
        self.left_out: set[float] = set()
        lowest, highest = self._reached([amplitude])
        self.light, self.middle, self.heavy = (
            between(lowest.max(), highest.min(), part).item() for part in (0.1, 0.5, 0.9)
        )

    def _reached(self, amplitudes: ArrayLike) -> tuple[Floats, Floats]:
        """(D,) ends of the range of elastic loads that 99 % of the ensembles reach at every one of some amplitudes."""
        elastic = np.stack([self.sums("normal_elastic", amplitude) for amplitude in np.atleast_1d(amplitudes)])
        lowest = np.quantile(elastic[..., 0], 0.99, axis=1).max(axis=0)
        return lowest, np.quantile(elastic.max(axis=-1), 0.01, axis=1).min(axis=0)

    def sums(self, name: str, amplitude: float) -> Floats:
        """(resample, D, approach)."""
        at = int(np.argmin(np.abs(self._amplitudes - amplitude)))
        if not math.isclose(self._amplitudes[at], amplitude, rel_tol=1e-9):
            raise ValueError(f"the result has no amplitude of {amplitude:g} µm, which a claim needs")
        return np.asarray(self._means[name][:, :, at])

    def middle_of_all_amplitudes(self) -> Floats | None:
        """(D,) loads in the middle, in ratio, of those that all amplitudes reach at a fractal dimension.

        None where the result lacks the amplitudes that a claim is about.
        """
        if not has_amplitudes(self._amplitudes):
            return None
        return between(*self._reached(self._amplitudes), 0.5)

    def usable(self, values: Floats, where: Any) -> Any:
        """Which fractal dimensions of some have a value (resample, D); the others are noted as left out.

        None, if that is less than half of them, or if the result has but one in the range: a number of the rest would
        not be what it is called.
        """
        usable = where & np.isfinite(values[0]) & (np.isfinite(values).mean(axis=0) > 1 - 1 / 40)
        self.left_out.update(float(dimension) for dimension in self.dimensions[where & ~usable])
        enough = where.sum() > 1 and 2 * usable.sum() >= where.sum()
        return usable if enough else np.zeros_like(usable)

    def at(
        self,
        what: Quantity,
        load: float | Floats,
        *,
        mu0: float = 0.4,
        tau0: float = 0.0,
        amplitude: float | None = None,
    ) -> Floats:
        """(resample, D): a quantity where the mean load reaches one load, or one for each D; NaN where it does not."""
        pair: Any = SimpleNamespace(**{name: self.sums(name, amplitude or self.amplitude) for name in _SUMS})
        normal = friction.normal_load(pair, mu0, tau0)
        match what:
            case "friction":
                values = friction.tangential_load(pair, mu0, tau0)
            case "area":
                values = pair.contact_area
            case "stiffness":
                values = np.gradient(normal, self._steps, axis=-1, edge_order=2)
                if self._step == "load":  # by the half-space, whose approaches follow from the loads
                    approach = self.sums("approach", amplitude or self.amplitude)
                    values = values / np.gradient(approach, self._steps, axis=-1, edge_order=2)
        loads = np.broadcast_to(np.asarray(load, dtype=np.float64), self.dimensions.shape)
        result = np.full(normal.shape[:2], np.nan)
        for d in np.flatnonzero(np.isfinite(loads)):
            crossing = Crossing.of(normal[:, d], loads[d : d + 1])
            result[:, d] = np.where(crossing.reached, crossing.at(values[:, d]), np.nan)[:, 0]
        return result / loads if what == "friction" else result

    def within(self, start: float, stop: float) -> Any:
        """Which fractal dimensions lie in a range, both ends included."""
        return (self.dimensions > start - 1e-9) & (self.dimensions < stop + 1e-9)


def between(lowest: Any, highest: Any, part: float) -> Floats:
    """A load at some part, in ratio, of the way from the lowest to the highest; NaN where that is none."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where((lowest > 0) & (lowest < highest), lowest * (highest / lowest) ** part, np.nan)
