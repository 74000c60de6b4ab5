"""The numbers of an interactive page without a browser: its script `numbers.js` in V8, on what a page carries."""

import base64
import json
import re
import zlib
from importlib import resources

import numpy as np


class PageNumbers:
    """The functions of `numbers.js`, with the facts and numbers of one page as they stand in it.

    `result` is the page's by its first motion; `results` has all motions.
    """

    def __init__(self, page):
        from py_mini_racer import MiniRacer

        self._engine = MiniRacer()
        self._engine.eval((resources.files("stiction.views.report") / "numbers.js").read_text("utf-8"))
        self._engine.eval(f"const facts = {_element(page, 'facts')}; null")
        for name in self("() => Object.keys(facts.bytes)"):
            planes = list(zlib.decompress(base64.b64decode(_element(page, f"packed-{name}") or "eJwDAAAAAAE=")))
            self._engine.eval(f"const {name} = doubles(Uint8Array.from({planes}), facts.bytes.{name}); null")
        self._engine.eval(
            "const count = facts.rules.length * facts.directions.length;"
            "const sumsOf = parts(facts.perRepetition, count, sums);"
            "const motions = parts(facts.variables, count, means).map((means, m) => ({means, sums: sumsOf[m]}));"
            "const results = motions.map((motion, m) => ({facts, ...motion, motions, chosen: [m], kind: 0,"
            " members: facts.kinds[0].members}));"
            "const result = results[0]; null"
        )

    def __call__(self, function, *arguments):
        """What an expression in JavaScript, a function, returns for arguments; numbers keep every bit, NaN too."""
        values = ", ".join(json.dumps(argument) for argument in arguments)
        # JSON has no NaN and no infinity.
        written = "(_, value) => typeof value === 'number' && !Number.isFinite(value) ? `number ${value}` : value"
        text = self._engine.eval(f"JSON.stringify(({function})({values}), {written})")
        return json.loads(re.sub(r'"number (-?)(\w+)"', r"\1\2", text))

    def arrays(self, quantity, *arguments, motion=0):
        """The points that `readOff` returns, as arrays by name."""
        points = self(f"(...rest) => readOff(results[{motion}], ...rest)", quantity, *arguments)
        names = ("value", "lower", "upper")
        result = {name: np.array([point[name] for point in points]) for name in names}
        result["status"] = np.array([point["status"] for point in points])
        for name in self("() => Object.keys(facts.validity)"):
            result[name] = np.array([(point["validity"] or {}).get(name, np.nan) for point in points])
        return result


def _element(page, name):
    """The text of a script element of a page, if there is one."""
    result = re.search(rf'<script type="[\w/-]+" id="{name}">(.*?)</script>', page, re.DOTALL)
    return result[1] if result else ""
