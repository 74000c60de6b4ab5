"""Numbers of an interactive report, computed without a browser by its script `numbers.js` in the engine V8."""

import base64
import json
import re
import zlib
from importlib import resources

import numpy as np


class ReportEvaluator:
    """Data of one report, and the functions of `numbers.js` that evaluate the data."""

    def __init__(self, page):
        from py_mini_racer import MiniRacer

        self._engine = MiniRacer()
        self._engine.eval((resources.files("stiction.views.report") / "numbers.js").read_text("utf-8"))
        self._engine.eval(f"const facts = {_script_text(page, 'facts')}; null")
        self.facts = json.loads(_script_text(page, "facts"))
        floats, small = (
            zlib.decompress(base64.b64decode(_script_text(page, f"packed-{name}"))) for name in ("floats", "small")
        )
        self._engine.eval(
            f"const numbers = {{offsets: facts.tables, floats: doubles(Uint8Array.from({list(floats)}), facts.leading),"
            f" small: Int8Array.from({np.frombuffer(small, np.int8).tolist()}), formats: facts.formats}}; null"
        )

    def __call__(self, function, *arguments):
        """Call a JavaScript function, and return its result with exact numbers, also NaN and infinities."""
        values = ", ".join(json.dumps(argument) for argument in arguments)
        # Pass NaN and infinities as text, because JSON cannot represent them.
        replacer = "(_, value) => typeof value === 'number' && !Number.isFinite(value) ? `number ${value}` : value"
        text = self._engine.eval(f"JSON.stringify(({function})({values}), {replacer})")
        return json.loads(re.sub(r'"number (-?)(\w+)"', r"\1\2", text))

    def coefficient_index(self, *, kind=0, cell=0, amplitude=0, rule=0, way=0, load=0):
        """Return the index of a coefficient in the arrays of the report."""
        facts = self.facts
        cell_index = (kind * len(facts["cells"]["values"]) + cell) * max(1, len(facts["amplitudes"])) + amplitude
        return ((cell_index * len(facts["rules"]) + rule) * len(facts["ways"]) + way) * len(
            facts["loads"]["values"]
        ) + load

    def parameters(self, mu0, tau0):
        """Return the slider positions (tau0 in MPa) for given mu0 and tau0 (GPa)."""
        values = [
            min(self.facts["axes"][name]["values"], key=lambda candidate, value=value: abs(candidate - value))
            for name, value in (("mu0", mu0), ("tau0", 1000 * tau0))
        ]
        assert np.allclose(values, [mu0, 1000 * tau0], rtol=1e-9), "the report has no values at this mu0 and tau0"
        return values

    def evaluate_quantity(self, name, mu0, tau0, **place):
        """Return a quantity at mu0 and tau0 (GPa) as a dict: number, limits, decimals, text, and status."""
        return self(
            "(name, index, mu0, tau0) => { const place = placeAt(facts.axes, mu0, tau0);"
            " const point = pointAt(numbers, name, index, place);"
            " const code = numbers.small[facts.tables.status + index * place.size + place.node];"
            " const status = facts.statuses[code].name;"
            " return {...point, text: quoted(point), coefficient: coefficientText({...point, status}), status}; }",
            name, self.coefficient_index(**place), *self.parameters(mu0, tau0),
        )  # fmt: skip

    def evaluate_assessment(self, mu0, tau0, *, cell, amplitude, way, load):
        """Return the assessment and the caveats at mu0 and tau0 (GPa)."""
        facts = self.facts
        cell_index = cell * max(1, len(facts["amplitudes"])) + amplitude
        index = (cell_index * len(facts["ways"]) + way) * len(facts["loads"]["values"]) + load
        return self(
            "(index, mu0, tau0) => judgementAt(numbers, facts.judgements, index, placeAt(facts.axes, mu0, tau0))",
            index, *self.parameters(mu0, tau0),
        )  # fmt: skip

    def format_validity(self, name, mu0, tau0, **place):
        """Return the text of a validity indicator, and whether the indicator exceeds its limit."""
        return self(
            "(name, index, mu0, tau0) => { const place = placeAt(facts.axes, mu0, tau0); return ["
            "printed(numberAt(numbers, `mean_${name}`, index, place)),"
            " numbers.small[facts.tables[`beyond_${name}`] + index * place.size + place.node]]; }",
            name, self.coefficient_index(**place), *self.parameters(mu0, tau0),
        )  # fmt: skip


def _script_text(page, name):
    """Return the text of a script element in a page, or "" if the element is absent."""
    match = re.search(rf'<script type="[\w/-]+" id="{name}">(.*?)</script>', page, re.DOTALL)
    return match[1] if match else ""
