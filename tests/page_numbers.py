"""The numbers of the interactive page without a browser: its script `numbers.js` in V8, on what a page carries."""

import base64
import json
import re
import zlib
from importlib import resources

import numpy as np


class PageNumbers:
    """The functions of `numbers.js`, with the facts and numbers of one page as they stand in it."""

    def __init__(self, page):
        from py_mini_racer import MiniRacer

        self._engine = MiniRacer()
        self._engine.eval((resources.files("stiction.views.report") / "numbers.js").read_text("utf-8"))
        self._engine.eval(f"const facts = {_element(page, 'facts')}; const result = {{facts}};")
        for name in ("means", "sums", "profiles", "contacts"):
            planes = list(zlib.decompress(base64.b64decode(_element(page, f"packed-{name}"))))
            self._engine.eval(f"const {name} = doubles(Uint8Array.from({planes}), facts.bytes.{name}); null")
        self._engine.eval("result.means = parts(facts.variables, means); null")
        self._engine.eval("result.sums = parts(facts.perRepetition, sums); null")

    def __call__(self, function, *arguments):
        """What an expression in JavaScript, a function, returns for arguments; numbers keep every bit, NaN too."""
        values = ", ".join(json.dumps(argument) for argument in arguments)
        # JSON has no NaN and no infinity.
        written = "(_, value) => typeof value === 'number' && !Number.isFinite(value) ? `number ${value}` : value"
        text = self._engine.eval(f"JSON.stringify(({function})({values}), {written})")
        return json.loads(re.sub(r'"number (-?)(\w+)"', r"\1\2", text))

    def arrays(self, function, *arguments):
        """The points that `frictionAt` or `areaAt` returns, as arrays by name."""
        points = self(f"(...rest) => {function}(result, ...rest)", *arguments)
        names = ("value", "lower", "upper")
        found = {name: np.array([point[name] for point in points]) for name in names}
        found["status"] = np.array([point["status"] for point in points])
        for name in self("() => Object.keys(facts.validity)"):
            found[name] = np.array([(point["validity"] or {}).get(name, np.nan) for point in points])
        return found


def _element(page, name):
    """The text of a script element of a page."""
    return re.search(rf'<script type="[\w/-]+" id="{name}">(.*?)</script>', page, re.DOTALL)[1]
