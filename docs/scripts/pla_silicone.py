"""Draw docs/images/pla_silicone.png, and print the numbers on two silicones in tutorials/friction_tests.md.

    python docs/scripts/pla_silicone.py pla_silicone.csv

The file is a table of silicone, load, coefficient, standard deviation and cycles, from
github.com/tolstoys19/Friction-Measurements-Between-PLA-and-Silicone.
"""

import sys
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pandas
from scipy.optimize import least_squares
from scipy.special import erf
from stiction.views.style import (
    ALL_CONTACTS_COLOUR,
    FORCE_COLOUR,
    MATPLOTLIB_STYLE,
    PAGE_WIDTH,
    new_figure,
    save_figure,
)

IMAGE_FILE = Path(__file__).resolve().parents[1] / "images/pla_silicone.png"
TABLE_LOADS = (10, 20, 30, 50, 100, 150, 200, 300, 400, 500, 600, 700)
MIN_FITTED_LOAD = 50.0  # mN
MAX_LOAD = 700.0  # load (mN) above which values jump, as if the measuring range had changed
FORCE_CELL_RELATIVE_ERROR = 0.02


def fit_laws(load, coefficient, standard_error):
    """Return (mu0, tau0 A0) of a flat, (mu0, tau0 A0, F1) of a rough flat (mN), and residuals divided by errors."""
    columns = np.stack([np.ones_like(load), 1 / load], axis=1) / standard_error[:, np.newaxis]
    flat_law = np.linalg.lstsq(columns, coefficient / standard_error, rcond=None)[0]

    def residuals(law_parameters):
        return (
            law_parameters[0] + law_parameters[1] / load * erf(load / law_parameters[2]) - coefficient
        ) / standard_error

    rough_law = least_squares(residuals, [1.0, 200.0, 100.0], bounds=(0, np.inf))
    return flat_law, columns @ flat_law - coefficient / standard_error, rough_law.x, rough_law.fun


def main(tests_file):
    table = pandas.read_csv(tests_file)
    table = table[table["load (mN)"] <= MAX_LOAD].sort_values("load (mN)")
    with mpl.rc_context(MATPLOTLIB_STYLE):
        figure = new_figure(66, width=PAGE_WIDTH)
        force_axes, coefficient_axes = figure.subplots(1, 2)
        for (name, tests), colour in zip(table.groupby("silicone"), (ALL_CONTACTS_COLOUR, FORCE_COLOUR), strict=True):
            load, coefficient = tests["load (mN)"].to_numpy(float), tests["coefficient"].to_numpy()
            standard_deviation = tests["standard deviation"].to_numpy()
            force_axes.plot(load, coefficient * load, ".", color=colour, markersize=3, label=name)
            coefficient_axes.errorbar(
                load, coefficient, standard_deviation, fmt=".", color=colour, markersize=3, linewidth=0.5
            )
            standard_error = np.hypot(
                standard_deviation / np.sqrt(tests["cycles"].to_numpy()), FORCE_CELL_RELATIVE_ERROR * coefficient
            )
            is_fitted = load >= MIN_FITTED_LOAD
            flat_law, flat_residuals, rough_law, rough_residuals = fit_laws(
                load[is_fitted], coefficient[is_fitted], standard_error[is_fitted]
            )
            coefficient_by_load = dict(zip(load, coefficient, strict=True))
            print(
                f"| {name} |",
                " | ".join(
                    f"{coefficient_by_load[table_load]:.2f}" if table_load in coefficient_by_load else ""
                    for table_load in TABLE_LOADS
                ),
                "|",
            )
            for law, law_parameters, residuals in (
                ("flat", flat_law, flat_residuals),
                ("rough", rough_law, rough_residuals),
            ):
                chi_squared = float((residuals**2).sum())
                print(
                    f"  {law}: {np.round(law_parameters, 3)} chi2 {chi_squared:.0f} "
                    f"of {is_fitted.sum() - len(law_parameters)}",
                    file=sys.stderr,
                )
            if name.startswith("Dragon"):
                fine_loads = np.geomspace(load.min(), load.max(), 200)
                coefficient_axes.plot(
                    fine_loads, flat_law[0] + flat_law[1] / fine_loads, "--", color="black", label="full contact"
                )
                rough_coefficient = rough_law[0] + rough_law[1] / fine_loads * erf(fine_loads / rough_law[2])
                coefficient_axes.plot(
                    fine_loads, rough_coefficient, color="black", label="rough contact, closing with load"
                )
        force_axes.set(xlabel="normal load (mN)", ylabel="kinetic friction (mN)", xlim=(0, 700), ylim=(0, 1000))
        coefficient_axes.set(
            xlabel="normal load (mN)", ylabel="coefficient of kinetic friction", xscale="log", ylim=(0, 4)
        )
        force_axes.legend(loc="upper left")
        coefficient_axes.legend(loc="upper right")
        save_figure(figure, IMAGE_FILE)


if __name__ == "__main__":
    main(sys.argv[1])
