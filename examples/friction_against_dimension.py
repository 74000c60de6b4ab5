"""Print friction with its interval for several fractal dimensions, with a modulus and a roughness of your choice."""

from stiction import Study, friction_map, run

study = Study.named("quick").with_changes(
    {
        "surfaces.fractal_dimension": [1.1, 1.3, 1.5],
        "surfaces.amplitude": ["50 nm"],
        "contact.effective_modulus": "70 GPa",
        "ensemble.repetitions": 20,
    }
)
result = run(study, progress=True)
# The loads are in mN, and tau0 is in GPa.
friction = friction_map(result, loads=[0.001, 0.01], mu0=[0.3], tau0=[0.0, 0.1])

for row in friction.to_dataframe().reset_index().itertuples():
    value = f"{row.friction_coefficient:.3f} ({row.lower:.3f} to {row.upper:.3f})" if row.status == "ok" else row.status
    print(f"D = {row.fractal_dimension:.1f}  F_N = {row.load:g} mN  tau0 = {row.tau0:g} GPa  mu_s = {value}")
