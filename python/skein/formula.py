"""Formulas of a scene (docs/scene.md) over NumPy arrays: read by the grammar of src/formula/formula.cpp, never given to Python to carry out."""

import re

import numpy as np

from .needs import NotResults

DEEPEST, LONGEST = 120, 4000  # brackets and signs within each other, two for a bracket; characters, as in scenes
TOKEN = re.compile(r"\s*(?:((?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)|([A-Za-z_]\w*)|(\*\*|<=|>=|==|!=|[-+*/^<>(),]))")
COMPARE = {"<": np.less, ">": np.greater, "<=": np.less_equal, ">=": np.greater_equal, "==": np.equal, "!=": np.not_equal}
CONSTANTS = {"pi": np.pi, "e": np.e}


def _folded(f):
    def of_all(first, *others):
        for other in others:
            first = f(first, other)
        return first
    return of_all


FUNCTIONS = {name: (getattr(np, name), 1, 1) for name in ("sin", "cos", "tan", "exp", "log", "sqrt", "abs", "floor", "tanh", "sign")} | {
    "atan": (np.arctan, 1, 1), "atan2": (np.arctan2, 2, 2), "mod": (np.mod, 2, 2), "if": (np.where, 3, 3),
    "step": (lambda a: np.where(np.less(a, 0), 0.0, 1.0), 1, 1), "ramp": (lambda a, b: np.clip(np.divide(a, b), 0, 1), 2, 2),
    "min": (_folded(np.minimum), 2, 99), "max": (_folded(np.maximum), 2, 99), "hypot": (_folded(np.hypot), 2, 99)}


class _Reader:
    """One formula, token by token. Each rule works out what it has read."""

    def __init__(self, text, names):
        self.text, self.names, self.tokens, self.at, self.depth = str(text)[:LONGEST], names, [], 0, 0
        if len(str(text)) > LONGEST:
            self.refuse(f"more than {LONGEST} characters")
        text, end = self.text, 0
        while text[end:].strip():
            token = TOKEN.match(text, end)
            if not token:
                self.refuse(f"'{text[end:].strip()[0]}' is no part of a formula")
            self.tokens.append(token.groups())
            end = token.end()

    def refuse(self, why):
        known = ", ".join(sorted({*self.names, *CONSTANTS, *FUNCTIONS}))
        raise NotResults(f"formula '{self.text[:200]}': {why}; it may name {known}")

    def sign(self, *signs):
        """Takes one of these, where it is next."""
        if self.at < len(self.tokens) and self.tokens[self.at][2] in signs:
            self.at += 1
            return self.tokens[self.at - 1][2]
        return None

    def need(self, sign):
        if not self.sign(sign):
            self.refuse(f"'{sign}' is expected")

    def whole(self):
        value = self.comparison()
        if self.at < len(self.tokens):
            self.refuse("an operator is expected")
        return value

    def comparison(self):
        self.depth += 1
        if self.depth > DEEPEST:
            self.refuse(f"brackets too deep")
        value = self.sum()
        if sign := self.sign(*COMPARE):
            value = np.where(COMPARE[sign](value, self.sum()), 1.0, 0.0)
        self.depth -= 1
        return value

    def sum(self):
        value = self.product()
        while sign := self.sign("+", "-"):
            value = value + self.product() if sign == "+" else value - self.product()
        return value

    def product(self):
        value = self.unary()
        while sign := self.sign("*", "/"):
            value = value * self.unary() if sign == "*" else np.divide(value, self.unary())
        return value

    def unary(self):
        self.depth += 1
        if self.depth > DEEPEST:
            self.refuse(f"too many signs")
        sign = self.sign("-", "+")
        value = self.power() if not sign else -self.unary() if sign == "-" else self.unary()
        self.depth -= 1
        return value

    def power(self):
        value = self.primary()
        return np.float_power(value, self.unary()) if self.sign("^", "**") else value

    def primary(self):
        if self.sign("("):
            value = self.comparison()
            self.need(")")
            return value
        number, name, _ = self.tokens[self.at] if self.at < len(self.tokens) else (None, None, None)
        self.at += 1
        if number:
            return float(number)
        if not name:
            self.refuse("a value is expected")
        if self.sign("("):
            return self.call(name)
        if name in self.names:
            return self.names[name]
        if name in CONSTANTS:
            return CONSTANTS[name]
        self.refuse(f"'{name}' is not known")

    def call(self, name):
        values = [self.comparison()]
        while self.sign(","):
            values.append(self.comparison())
        self.need(")")
        if name not in FUNCTIONS:
            self.refuse(f"'{name}' is no function")
        function, least, most = FUNCTIONS[name]
        if not least <= len(values) <= most:
            self.refuse(f"'{name}' takes {least} value{'s' if least > 1 else ''}, not {len(values)}")
        return function(*values)


def evaluate(text, **names):
    """Values of a formula whose names have these values, numbers or arrays. Raises NotResults where the text is no formula of such names."""
    with np.errstate(all="ignore"):  # in the branch of an `if` that is not taken
        return _Reader(text, names).whole()
