"""What Python can say and a shader cannot: refused with its place, or the same in both.

Each case is the body of a model's eval. Either the exporter shows the line and says what to write, or the
exported text gives what Python gives. In the long run (--long) that is tried in every language.
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from support.methods import HEAD, compare, made

from gonio.export import ExportError, export
from gonio.export.targets import TARGETS
from gonio.materials.model_file import load
from gonio.model import Model

# --- the same in both ------------------------------------------------------------------------------

SAME: dict[str, tuple[str, str, str]] = {
    "a property": (
        "return self.rho * self.double",
        "@property\ndef double(self):\n    return 2 * self.width",
        "",
    ),
    "or gives the value": (
        "mode = self.mode or 'other'\nif mode == 'other':\n    return self.rho\nreturn 2 * self.rho",
        "mode = ''",
        "",
    ),
    "and gives the last value": ("return self.rho * (self.form and self.width)", "", ""),
    "a comment that ends in a backslash": (
        "x = self.width  # a path C:\\\n# next \\\nreturn self.rho * x",
        "",
        "",
    ),
    "a comment with a form feed": ("# one \f two ??/\nreturn self.rho * self.width", "", ""),
    "a docstring with a backslash": (
        "return self.rho * f(wi.z)",
        "",
        'def f(x):\n    r"""Ends in \\ \\\n    """\n    return 2 * x',
    ),
    "whole powers of negative numbers": (
        "return self.rho * power(wi.x, 3) + power(wi.y, 2.0) * power(wi.x - 2, -3) + power(wi.x, 20)"
        " + power(wi.x, 17) + power(wi, 5)",
        "",
        "",
    ),
    "a helper that compares": (
        "return self.rho * select(both(wi.x < wo.x, wi.y > wo.y), 3, 4)",
        "",
        "def both(a, b):\n    return a & ~b",
    ),
    "a number of math": ("return self.rho * math.pi / math.e", "", ""),
    "arguments by keyword alone": (
        "return self.rho * f(wi.z, k=3) + f(wo.z)",
        "",
        "def f(x, *, k=2):\n    return x * k",
    ),
    "a reassigned loop variable": (
        "total = 0\nfor i in range(4):\n    i = i + wi.z\n    total = total + i\nreturn self.rho * total",
        "",
        "",
    ),
    "a swap": ("a, b = wi.x, wo.y\na, b = b, a\nreturn vec3(a, b, a - b)", "", ""),
    "three names turned": (
        "a, b, c = wi.x, wi.y, wi.z\na, b, c = b, c, a\nreturn vec3(a, b, c)",
        "",
        "",
    ),
    "two names for a value": ("a = b = wi.x * 2\nb = b + 1\nreturn vec3(a, b, a - b)", "", ""),
    "+= in a loop": (
        "total = 0.0\nfor i in range(4):\n    total += wi.z * i\n    total *= 0.5\nreturn self.rho * total",
        "",
        "",
    ),
    "an annotated name": ("x: Float = wi.z * 2\nreturn self.rho * x", "", ""),
    "integers that single precision has not": (
        "return self.rho * ((2**24 + 1 - 2**24) + (10**30 - (10**30 - 8)))",
        "",
        "",
    ),
    "names of other languages": (
        "half, NULL, bool3, asm, PI_ = wi.x, wi.y, wi.z, wo.x, wo.y\nM_PI = half + NULL\n"
        "float3 = M_PI + bool3\nreturn vec3(float3, asm, PI_)",
        "",
        "",
    ),
    "a name and its replacement": ("half, half_ = wi.x, wi.y\nreturn vec3(half, half_, 1)", "", ""),
    "names with a prefix of OpenGL": (
        "gl_x = wi.x\nwebgl_y = 2 * gl_x\nreturn vec3(gl_x, webgl_y, 1)",
        "",
        "",
    ),
    "an underscore that is read after it got another value": (
        "_ = wi.z\n_, b = wi.x, wi.y\nreturn self.rho * (_ - 3 * b)",
        "",
        "",
    ),
    "an underscore that is read after a function": (
        "_ = wi.z\n_, b = f(wi.x)\nreturn self.rho * (_ - 3 * b)",
        "",
        "def f(x):\n    first = x * 2\n    second = x + 5\n    return first, second",
    ),
    "underscores": ("_ = wi.x\n_A = wi.y\nreturn vec3(_, _A, 1)", "", ""),
    "parameters with reserved names": (
        "return self.rho * self.half + self.half_ * self.f",
        'half: Float = param(0.5, 0, 1, "x")\nhalf_: Float = param(0.5, 0, 1, "x")\n'
        'f: Float = param(0.5, 0, 1, "x")\nu1: Float = param(0.5, 0, 1, "x")\n'
        'value: Float = param(0.5, 0, 1, "x")',
        "",
    ),
    "two numbers of one name": (
        "return self.rho * (K + self.K)",
        "K = 3.0",
        "K = 2.0",
    ),
    "a local named like a number of the class": (
        "K = wi.z\nreturn self.rho * (K + self.K)",
        "K = 3.0",
        "",
    ),
    "a class's number, inherited": (
        "return self.rho * self.twice()",
        "",
        "class Base(Model, register=False):\n    K = 2.0\n    def twice(self):\n        return 2 * self.K",
    ),
    "a static method": (
        "return self.rho * self.twice(wi.z)",
        "@staticmethod\ndef twice(x):\n    return 2 * x",
        "",
    ),
    "a flag as an argument": (
        "return self.rho * f(wi.z, True) + f(wi.z, False)",
        "",
        "def f(x, flag):\n    if flag:\n        return 2 * x\n    return x",
    ),
    "a function as an argument": (
        "return self.rho * f(sin, wi.z)",
        "",
        "def f(g, x):\n    return g(x) + 1",
    ),
    "a condition on a named number": (
        "if N > 2:\n    return self.rho\nreturn 2 * self.rho",
        "",
        "N = 3",
    ),
    "a NamedTuple": (
        "pair = f(wi.z)\nheight, size = f(wo.z)\nreturn self.rho * pair.height + pair.size * size + height",
        "",
        'class Pair(NamedTuple):\n    """Two."""\n\n    height: Float\n    """The height."""\n'
        "    size: Color\n\n\n"
        "def f(x):\n    return Pair(2 * x, size=x)",
    ),
    "a NamedTuple that carries a choice": (
        "return self.rho * f(Facets(self.width, self.form))",
        "",
        "class Facets(NamedTuple):\n    alpha: Float\n    form: str\n\n\ndef f(facets):\n"
        "    if facets.form == 'round':\n        return 2 * facets.alpha\n    return facets.alpha",
    ),
    "methods of NamedTuples": (
        "one, other = Pair(wi.z, 2), Other(wo.z)\n"
        "return self.rho * one.total(wo.z) * other.total(wi.z) * mean(one) * mean(other)",
        "",
        "class Pair(NamedTuple):\n    a: Float\n    b: Float\n\n    def total(self, pair, weight=2.0):\n"
        "        return self.half() + weight * self.b * pair\n\n    def half(self):\n"
        "        return 0.5 * self.a\n\n\n"
        "class Other(NamedTuple):\n    a: Float\n\n    def total(self, x):\n"
        "        return Pair(self.a, x).total(x) + x\n\n    def half(self):\n        return self.a\n\n\n"
        "def mean(values):\n    return values.half() + values.a",
    ),
    "a NamedTuple in another one": (
        "pair = Outer(Inner(wi.x, wi.y), wo.x)\npair = Outer(Inner(pair.inner.b, pair.inner.a), pair.c)\n"
        "return vec3(pair.inner.a, pair.inner.b, pair.c)",
        "",
        "class Inner(NamedTuple):\n    a: Float\n    b: Float\n\n\n"
        "class Outer(NamedTuple):\n    inner: Inner\n    c: Float",
    ),
    "variables that nothing reads": ("x = wi.z\nx = x + 1\ny = 2\nreturn self.rho", "", ""),
    "colours compared by ==": (
        "return select(self.rho == self.rho, wi, wo) + select(wi != wo, wi, 1)",
        "",
        "",
    ),
    "a method for directions below the horizon": (
        "down = vec3(wi.x, wi.y, -wi.z)\nreturn self.rho + self.pdf(down, wo) + self.pdf(wi, wo)",
        "",
        "",
    ),
    "a loop that does nothing": ("for i in range(3):\n    x = i\nreturn self.rho", "", ""),
    "a loop that does not count": (
        "x = wi.z\nfor i in range(3):\n    x = x * 0.5\nreturn self.rho * x",
        "",
        "",
    ),
    "two masks as arguments": (
        "pair = Both(wi.x < wo.x, wi.y > wo.y)\n"
        "return self.rho * f(wi.x < wo.x, wi.y > wo.y + wi.x) * select(pair.a & pair.b, 2, 3)",
        "",
        "class Both(NamedTuple):\n    a: Mask\n    b: Mask\n\n\n"
        "def f(a, b):\n    return select(a & ~b, 1, 2)",
    ),
    "helpers named like what users call": (
        "return self._eval(wi, wo) * self._pdf(wi.y) + self._albedo(wo.x) * self._load()",
        "def _eval(self, wi, wo):\n    return self.rho * wi.x\n\ndef _pdf(self, x):\n    return x * 2\n\n"
        "def _albedo(self, x):\n    return x + 1\n\ndef _load(self):\n    return 3 * self.width",
        "",
    ),
    "numbers that single precision would compare otherwise": (
        "return self.rho * select(0.1 + 0.2 == 0.3, wi.x, wi.y) + select(1 + 1e-9 > 1, wi.x, wi.y)",
        "",
        "",
    ),
    "numbers of a loop": (
        "a, b, sign, total = 0, 1, 1, wi.x\nfor i in range(20):\n    a, b = b, a + b\n"
        "    total = total + sign * wi.y / (2 * i + 1) + select(i < 3, wi.x, wo.x)\n"
        "    total = total * select(i / 20 < 0.52, 1, 0.9)\n"
        "    sign = -sign\nreturn self.rho * total * a / b",
        "",
        "",
    ),
    "many terms": (" + ".join(["return self.rho"] + ["wi * 0.01"] * 60), "", ""),
}


@pytest.fixture(scope="session")
def languages(request: pytest.FixtureRequest) -> list[str]:
    """C++, and all of them in the long run."""
    return list(TARGETS) if request.config.getoption("--long") else ["cpp"]


def test_what_is_accepted_means_the_same(tmp_path: Path, languages: list[str]) -> None:
    models = []
    for i, case in enumerate(SAME.values()):
        folder = tmp_path / str(i)
        folder.mkdir()
        body, fields, head = case
        if "class Base" in head:  # the model derives from it
            model = made(folder, body, fields, head)
            path = folder / "mine.py"
            text = path.read_text(encoding="utf-8")
            path.write_text(
                text.replace("Mine(Model, register", "Mine(Base, register"), encoding="utf-8"
            )
            model = load(path)()
        else:
            model = made(folder, body, fields, head)
        models.append(model)
    for language in languages:
        compare(models, language)


# --- refused ---------------------------------------------------------------------------------------

REFUSED: dict[str, tuple[str, str, str, str]] = {
    "a cached property": (
        "return self.rho * self.double",
        "@functools.cached_property\ndef double(self):\n    return 2 * self.width",
        "",
        "@property",
    ),
    "a wrapped function": (
        "return self.rho * f(wi.z)",
        "",
        "def twice(g):\n    @functools.wraps(g)\n    def inner(x):\n        return 2 * g(x)\n"
        "    return inner\n\n\n"
        "@twice\ndef f(x):\n    return x",
        "decorator",
    ),
    "a wrapper without wraps": (
        "return self.rho * f(wi.z)",
        "",
        "def twice(g):\n    def inner(x):\n        return 2 * g(x)\n    return inner\n\n\n"
        "@twice\ndef f(x):\n    return x",
        "around this one",
    ),
    "a cached function": (
        "return self.rho * f(wi.z)",
        "",
        "@functools.cache\ndef f(x):\n    return x",
        "vocabulary",
    ),
    "a flag that changes in a loop": (
        "first = True\ntotal = 0\nfor i in range(3):\n    if first:\n        total = total + wi.z\n"
        "    first = False\nreturn self.rho * total",
        "",
        "",
        "from step to step",
    ),
    "a loop's local after the loop": (
        "for i in range(3):\n    K = wi.z * i\nreturn self.rho * K",
        "",
        "K = 2.0",
        "give it a value before",
    ),
    "the loop's variable after the loop": (
        "for i in range(3):\n    x = i\nreturn self.rho * i",
        "",
        "",
        "give it a value before",
    ),
    "a loop's variable that has a value": (
        "i = wi.z\nfor i in range(3):\n    x = i\nreturn self.rho * i",
        "",
        "",
        "has a value already",
    ),
    "a name of a branch that is not taken": (
        "if self.form == 'flat':\n    K = wi.z\nreturn self.rho * K",
        "",
        "K = 2.0",
        "give it a value before",
    ),
    "a closure": (
        "return self.rho * f(wi.z)",
        "",
        "K = 9.0\n\n\ndef make(K):\n    def f(x):\n        return K * x\n    return f\n\n\nf = make(2.0)",
        "around this one",
    ),
    "a complex result": ("return self.rho * (-2.0) ** 0.5", "", "", "complex"),
    "a division by zero": ("return self.rho * (1 / 0)", "", "", "Python cannot compute"),
    "an integer of 400 digits": (f"return self.rho * {'9' * 400}", "", "", "does not fit"),
    "a power of 400 digits": ("return self.rho * 10**400", "", "", "does not fit"),
    "infinity by name": ("return self.rho * math.inf", "", "", "does not fit"),
    "1,500 terms": (" + ".join(["return self.rho"] + ["wi"] * 1500), "", "", "terms"),
    "+= on an argument": (
        "x = f(wi.z)\nreturn self.rho * x",
        "",
        "def f(x):\n    x += 1\n    return x",
        "argument",
    ),
    "+= on the value of a parameter": (
        "x = self.width\nx += 1\nreturn self.rho * x",
        "",
        "",
        "another name",
    ),
    "+= on a component": ("x = wi.z\nx += 1\nreturn self.rho * x * wi.z", "", "", "another name"),
    "+= after a second name": (
        "x = wi.z * 2\ny = x\nx += 1\nreturn self.rho * x * y",
        "",
        "",
        "another name",
    ),
    "+= through a loop": (
        "x, y = wi.z * 2, wi.z * 3\nfor i in range(3):\n    x += y\n    y = x\nreturn self.rho * x * y",
        "",
        "",
        "another name",
    ),
    "+= on what a function passes back": (
        "y = wi.z * 2\nx = f(y)\nx += 1\nreturn self.rho * x * y",
        "",
        "def f(x):\n    return x",
        "another name",
    ),
    "the loop's number as an exponent": (
        "x = 0\nfor i in range(3):\n    x = x + power(wi.x, i)\nreturn self.rho * x",
        "",
        "",
        "exponent",
    ),
    "a chain of comparisons": (
        "return self.rho * select(0 < wi.z < 1, 1, 0)",
        "",
        "",
        "(a < b) & (b < c)",
    ),
    "a walrus": ("return self.rho * (x := wi.z)", "", "", "assignment of its own"),
    "star arguments": (
        "return self.rho * f(*(wi.z, 1))",
        "",
        "def f(a, b):\n    return a",
        "name each",
    ),
    "a nested function": (
        "def f(x):\n    return x\nreturn self.rho * f(wi.z)",
        "",
        "",
        "function of the module",
    ),
    "is between texts": (
        "if self.form is ROUND:\n    return self.rho\nreturn wi",
        "",
        "ROUND = 'round'",
        "==",
    ),
    "in on numbers": ("return self.rho * select(wi.z in wo, 1, 0)", "", "", "options"),
    "a ternary on a value": ("return self.rho * (1 if wi.z > 0 else 2)", "", "", "select"),
    "a comparison of kinds": (
        "if self.form < 3:\n    return self.rho\nreturn wi",
        "",
        "",
        "cannot compare",
    ),
    "a global that changes": ("global K\nK = 3\nreturn self.rho * K", "", "K = 2", "never changed"),
    "a list": ("x = TABLE[0]\nreturn self.rho * x", "", "TABLE = [1.0, 2.0]", "unpack"),
    "text": ("return self.rho * len(f'{wi.z}')", "", "", "a shader has no 'len'"),
    "integer division": ("return self.rho * (wi.z // 0.1)", "", "", "fract"),
    "a remainder": ("return self.rho * (wi.x % 1)", "", "", "fract"),
    "a function of Python": ("return self.rho * max(wi.z, 0.5)", "", "", "maximum(a, b)"),
    "an import inside": ("import math\nreturn self.rho * math.pi", "", "", "top of the file"),
    "what __init__ sets": (
        "return self.rho * self.extra",
        "def __init__(self, **given):\n    super().__init__(**given)\n"
        "    object.__setattr__(self, 'extra', 2.0)",
        "",
        "unknown in kernels",
    ),
    "what only kernels have": (
        "if self.float_type is None:\n    return self.rho\nreturn wi",
        "",
        "",
        "no meaning in a shader",
    ),
    "a class method": (
        "return self.rho * self.twice(wi.z)",
        "@classmethod\ndef twice(cls, x):\n    return 2 * x",
        "",
        "write a method",
    ),
    "results without names": (
        "a, b = f(wi.z)\nreturn self.rho * a * b",
        "",
        "def f(x):\n    return x, 2 * x",
        "NamedTuple",
    ),
    "a call for nothing": (
        "f(wi.z)\nreturn self.rho",
        "",
        "def f(x):\n    return x",
        "leave it out",
    ),
    "a copy with other parameters": (
        "return self.replace(width=1).pdf(wi, wo) * self.rho",
        "",
        "",
        "no meaning",
    ),
    "an inverted mask of a colour": (
        "return select(~(wi > wo), wi, wo)",
        "",
        "",
        "swap the branches",
    ),
    "the length of a number": ("return self.rho * length(wi.z)", "", "", "cannot take a number"),
    "super with a class": (
        "return super(Mine, self).eval(wi, wo)",
        "",
        "",
        "super() takes nothing",
    ),
    "a third argument of eval": (
        "return self.rho * f(wi.z)",
        "",
        "def f(x, /, y):\n    return x",
        "missing",
    ),
    "match": (
        "match self.form:\n    case 'round':\n        return self.rho\nreturn wi",
        "",
        "",
        "if and elif",
    ),
    "a generator": ("return self.rho * sum(x for x in (1, 2))", "", "", "a + b + c"),
    "an inverted comparison of plain numbers": (
        "x = -K\nreturn self.rho * select(~(x < 0) & (wi.z > 0), wi.z, 1)",
        "",
        "K = 1.5",
        "opposite comparison",
    ),
    "assert": ("assert self.form\nreturn self.rho", "", "", "no exceptions"),
    "deletion": ("x = wi.z\ndel x\nreturn self.rho", "", "", "cost nothing"),
    "a lambda of the module": ("return self.rho * f(wi.z)", "", "f = lambda x: 2 * x", "'def'"),
    "a wrapped property": (
        "return self.rho * self.twice",
        "@property\n@doubled\ndef twice(self):\n    return self.width",
        "def doubled(g):\n    @functools.wraps(g)\n    def inner(self):\n        return 2 * g(self)\n"
        "    return inner",
        "'def'",
    ),
    "a NamedTuple that makes its members anew": (
        "return self.rho * Turned(wi.z, 2).a",
        "",
        "class Pair(NamedTuple):\n    a: Float\n    b: Float\n\n\nclass Turned(Pair):\n"
        "    def __new__(cls, a, b):\n        return super().__new__(cls, b, a)",
        "one NamedTuple",
    ),
    "a NamedTuple with a property over a member": (
        "return self.rho * Fixed(wi.z, 2).a",
        "",
        "class Pair(NamedTuple):\n    a: Float\n    b: Float\n\n\nclass Fixed(Pair):\n"
        "    @property\n    def a(self):\n        return 5.0",
        "one NamedTuple",
    ),
    "what a NamedTuple can do in Python only": (
        "return self.rho * Pair(wi.z, 2)._replace(a=1).a",
        "",
        "class Pair(NamedTuple):\n    a: Float\n    b: Float",
        "no plain method",
    ),
    "several components at once": (
        "return self.rho * wi.xyz",
        "",
        "",
        "one by one",
    ),
    "a number with operators of its own": (
        "return self.rho * K",
        "",
        "class Odd(float):\n    def __mul__(self, other):\n        return 7 * other\n\n"
        "    __rmul__ = __mul__\n\n\nK = Odd(2)",
        "write numbers",
    ),
    "300 functions that call each other": (
        "return self.rho * f300(wi.z)",
        "",
        "def f0(x):\n    return x * 2\n\n\n"
        + "\n\n\n".join(f"def f{i}(x):\n    return f{i - 1}(x) + 1" for i in range(1, 301)),
        "too deeply",
    ),
    "a number of an enumeration": (
        "return self.rho * E.A",
        "",
        "import enum\n\n\nclass E(enum.IntEnum):\n    A = 2",
        "write numbers",
    ),
    "a mask that has two names and is changed": (
        "m = wi.x > 0\nn = m\nm &= wi.y > 0\nreturn self.rho * select(n, 1, 2) * select(m, 3, 5)",
        "",
        "",
        "m = m & ...",
    ),
    "a number for a colour and for a new name": (
        "a = self.rho\na = b = wi.z\nreturn a * b",
        "",
        "",
        "another type",
    ),
    "a difference of large numbers with names": (
        "big = 1e8\nmore = big + 1\nreturn self.rho * wi.z * (more - big)",
        "",
        "",
        "single precision",
    ),
    "numbers of a loop that overflow on the way": (
        "a = 1\nfor i in range(200):\n    a = a * 2\nfor i in range(200):\n    a = a / 2\n"
        "return self.rho * wi.z * a",
        "",
        "",
        "single precision",
    ),
    "digits that a loop loses": (
        "a = 1\nfor i in range(30):\n    a = a * 2\nd = a + 1\nreturn self.rho * wi.z * (d - a)",
        "",
        "",
        "single precision",
    ),
    "steps compared with rounded numbers": (
        "t = wi.x\nfor i in range(4):\n    t = t + select(i * 0.1 == 0.3, wi.x, wi.y)\nreturn self.rho * t",
        "",
        "",
        "comparison",
    ),
    "a step divided and compared": (
        "t = wi.x\nfor i in range(4):\n    t = t + select(i / 3 * 3 == i, wi.x, wi.y)\nreturn self.rho * t",
        "",
        "",
        "comparison",
    ),
    "a number whose name is not English": (
        "return self.rho * \u03c0 * wi.z",
        "",
        "\u03c0 = 3.0",
        "English alphabet",
    ),
    "a number of the class with two underscores": (
        "return self.rho * self.A__B",
        "A__B = 3.0",
        "",
        "A_B",
    ),
    "a NamedTuple whose name is not English": (
        "return self.rho * Gr\u00f6\u00dfe(wi.z, 2).a",
        "",
        "class Gr\u00f6\u00dfe(NamedTuple):\n    a: Float\n    b: Float",
        "English alphabet",
    ),
    "a member whose name is not English": (
        "return self.rho * Pair(wi.z, 2).\u00e4",
        "",
        "class Pair(NamedTuple):\n    \u00e4: Float\n    b: Float",
        "English alphabet",
    ),
    "an array as a condition": (
        "if VALUES:\n    return self.rho\nreturn self.rho * wi.z",
        "",
        "import numpy as np\n\nVALUES = np.array([1, 2])",
        "a ndarray",
    ),
    "an array compared, as a condition": (
        "a = 1 if VALUES == 1 else 2\nreturn self.rho * wi.z * a",
        "",
        "import numpy as np\n\nVALUES = np.array([1, 2])",
        "a ndarray",
    ),
    "an array beside or": (
        "a = VALUES or 2\nreturn self.rho * wi.z * a",
        "",
        "import numpy as np\n\nVALUES = np.array([1, 2])",
        "a ndarray",
    ),
    "a vector as three values": ("x, y, z = wi\nreturn self.rho * x", "", "", "v.x, v.y, v.z"),
    "a number that becomes a colour": (
        "t = 0\nfor i in range(3):\n    t = t + self.rho * i\nreturn t",
        "",
        "",
        "begin with t = vec3(...)",
    ),
    "a number of NumPy's": (
        "return self.rho * K",
        "",
        "import numpy as np\n\nK = np.float32(0.25)",
        "write 0.25",
    ),
    "recursion by two": (
        "return self.rho * f(wi.z)",
        "",
        "def f(x):\n    return g(x)\n\n\ndef g(x):\n    return f(x) + 1",
        "calls itself",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_would_change_is_refused_with_its_place(case: str, tmp_path: Path) -> None:
    body, fields, head, words = REFUSED[case]
    model = made(tmp_path, body, fields, head)
    with pytest.raises(ExportError) as caught:
        export({"mine": model}, "glsl", only=["eval"])
    told = str(caught.value)
    assert words in told
    path, line = re.match(r"(.+?\.py):(\d+)", told).groups()  # type: ignore[union-attr]
    shown = Path(path).read_text(encoding="utf-8").split("\n")[int(line) - 1]
    *_, quoted, marks = told.split("\n")
    assert quoted == shown.rstrip()
    assert set(marks.strip()) == {"^"}


CLASSES = """
class _Base(Model, register=False):
    rho: Color = param((0.8, 0.8, 0.8), 0, 1, "a colour")
    def eval(self, wi, wo):
        return self.rho * self._w(wi.x)
    def sample(self, wo, u):
        return Sample(wo, 1)
    def pdf(self, wi, wo):
        return wi.z
    def _w(self, x):
        return x * 3

class _Middle(_Base, register=False):
    def _w(self, x):
        return x * 5
    def _call(self, x):
        return super()._w(x) + 1
    @staticmethod
    def _s(x):
        return x * 7
"""


def classes(folder: Path, text: str) -> Model:
    """A model that derives from the classes above."""
    head = HEAD.partition("{head}")[0]
    path = folder / "mine.py"
    path.write_text(head + CLASSES + text, encoding="utf-8")
    return load(path)()


def test_super_begins_at_the_class_that_a_method_is_written_in(tmp_path: Path) -> None:
    """Not at one below, where the method has another name."""
    text = (
        "\nclass Mine(_Middle, register=False):\n    _other = _Middle._call\n"
        "    def _w(self, x):\n        return x * 11\n"
        "    def eval(self, wi, wo):\n"
        "        return self.rho * self._other(wi.x) + self._call(wi.y) + super()._w(wo.x)\n"
    )
    compare([classes(tmp_path, text)], "cpp")


def test_super_passes_over_nothing_that_a_class_has(tmp_path: Path) -> None:
    """A static method between two plain ones is what Python calls."""
    text = (
        "\nclass _Lower(_Middle, register=False):\n"
        "    @staticmethod\n    def _w(x):\n        return x * 100\n"
        "\nclass Mine(_Lower, register=False):\n"
        "    def eval(self, wi, wo):\n        return self.rho * super()._w(wi.x)\n"
    )
    with pytest.raises(ExportError, match=r"mine\.py:\d+:\d+: '_w' of _Lower is a staticmethod"):
        export({"mine": classes(tmp_path, text)}, "glsl", only=["eval"])


STEPS = "def f(x, n=2):\n    t = 0\n    for i in range(n):\n        t = t + x\n    return t"


def test_a_function_that_counts_its_steps_is_one_for_each_number(tmp_path: Path) -> None:
    model = made(tmp_path, "return self.rho * f(wi.z) * f(wi.x, 5) * f(wi.y, 2)", "", STEPS)
    found = export({"mine": model}, "glsl", only=["eval"])[0].source
    assert re.findall(r"float (mine_f\w*)\(float x\)", found) == ["mine_f", "mine_f_5"]
    assert re.findall(r"_step < (\d)", found) == ["2", "5"]


def test_methods_have_names_of_their_own_where_a_language_has_methods(tmp_path: Path) -> None:
    """For two options, or beside one that differs by an underscore: Slang takes a name once."""
    fields = (
        "def _g(self, x, kind):\n    return x + self.width if kind == 'a' else x * self.width\n\n"
        "def g(self, x):\n    return x / self.width"
    )
    body = "return self.rho * (self._g(wi.x, 'a') + self._g(wi.y, 'b') + self.g(wi.z))"
    found = export({"mine": made(tmp_path, body, fields)}, "slang", only=["eval"])[0].source
    names = re.findall(r"float (\w+)\(float x\) \{", found)
    assert len(names) == len(set(names)) == 3


@pytest.mark.parametrize("exponent", ["2 * n", "m"])
def test_an_exponent_that_comes_out_whole_is_a_product(exponent: str, tmp_path: Path) -> None:
    """Of a negative base pow is not a number, where Python multiplies."""
    head = (
        f"def g(x, k):\n    return power(x, k) + x\n\n\n"
        f"def f(x, n):\n    m = 2 * n\n    return power(x, {exponent}) + g(x, {exponent})"
    )
    whole = made(tmp_path, "return self.rho * f(wi.x, 0.5)", "", head)
    assert "pow" not in export({"mine": whole}, "glsl", only=["eval"])[0].source
    broken = made(tmp_path, "return self.rho * f(wi.z, 0.4)", "", head)
    assert "pow(" in export({"mine": broken}, "glsl", only=["eval"])[0].source


def test_variables_of_a_shader_give_way_to_parameters(tmp_path: Path) -> None:
    """A parameter called value was declared twice in Open Shading Language."""
    names = ("value", "drawn", "reflected")
    fields = "\n".join(f'{n}: Float = param(0.5, 0, 1, "a number")' for n in names)
    body = f"return self.rho * ({' + '.join(f'self.{n}' for n in names)})"
    found = export({"mine": made(tmp_path, body, fields)}, "osl")[0].source
    shader = found[found.index("shader mine(") :]
    for name in names:
        assert len(re.findall(rf"(?:float|vector|MineSample) {name} =", shader)) == 1
        assert re.search(rf"(?:vector|MineSample) {name}\w+ = mine_", shader)


def test_steps_that_a_call_leaves_open_are_refused_where_they_are_counted(tmp_path: Path) -> None:
    """With the line of the call, also through a function between."""
    head = f"{STEPS}\n\n\ndef g(x, m):\n    return f(x, m + 1)"
    for body in ("return self.rho * f(wi.z, wi.x)", "return self.rho * g(wi.z, self.width)"):
        model = made(tmp_path, body, "", head)
        with pytest.raises(
            ExportError, match=r"mine\.py:\d+:\d+: .* line \d+ calls \w with . not known"
        ) as e:
            export({"mine": model}, "glsl", only=["eval"])
        at, call = re.findall(r"(?:mine\.py:|line )(\d+)", str(e.value))
        lines = (tmp_path / "mine.py").read_text(encoding="utf-8").split("\n")
        assert "range(n)" in lines[int(at) - 1]
        assert body in lines[int(call) - 1]


def test_a_wrapped_method_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "wrapped.py"
    text = HEAD.format(
        head="def dimmed(f):\n    @functools.wraps(f)\n    def inner(self, wi, wo):\n"
        "        return 0.5 * f(self, wi, wo)\n    return inner",
        fields="",
        body="        return self.rho",
    )
    path.write_text(text.replace("    def eval", "    @dimmed\n    def eval"), encoding="utf-8")
    model = load(path)()
    with pytest.raises(ExportError, match=r"(?s)wrapped\.py:\d+:.*decorator.*\^"):
        export({"wrapped": model}, "glsl")


def test_a_density_for_another_direction_is_not_trusted_below_the_horizon(tmp_path: Path) -> None:
    model = made(tmp_path, "return self.rho")
    path = tmp_path / "mine.py"
    text = path.read_text(encoding="utf-8")
    for returned, masked in (
        ("Sample(vec3(wo.x, wo.y, -wo.z), self.pdf(wo, wo))", True),
        ("Sample(wo, self.pdf(wo, wo))", False),
        ("Sample(wo, pdf(wo, wo))", True),
    ):
        changed = text.replace("return Sample(wo, 1)", f"return {returned}").replace(
            "class Mine", "def pdf(wi, wo):\n    return wi.z\n\n\nclass Mine"
        )
        path.write_text(changed, encoding="utf-8")
        model = load(path)()
        found = export({"mine": model}, "glsl", only=["sample"])[0].source
        body = found[found.index("MineSample mine_sample") :]
        assert ("> mu_min" in body) is masked, returned


def test_a_method_of_the_class_above_is_0_below_the_horizon_too(tmp_path: Path) -> None:
    base = (
        "class Base(Model, register=False):\n    def eval(self, wi, wo):\n        return wi.z * wi"
    )
    down = "vec3(wi.x, wi.y, -wi.z)"
    for arguments, tests in ((f"{down}, wo", 2), ("wi, wo", 1), ("wo, wi", 1)):
        made(tmp_path, f"return super().eval({arguments})", "", base)
        path = tmp_path / "mine.py"
        text = path.read_text(encoding="utf-8").replace("Mine(Model, reg", "Mine(Base, reg")
        path.write_text(text, encoding="utf-8")
        found = export({"mine": load(path)()}, "glsl", only=["eval"])[0].source
        assert found.count("<= mu_min") == tests


def test_a_file_that_is_not_what_python_runs_is_refused(tmp_path: Path) -> None:
    model = made(tmp_path, "return self.rho * 2")
    path = tmp_path / "mine.py"
    text = path.read_text(encoding="utf-8")
    path.write_text(text.replace("self.rho * 2", "self.rho * 3"), encoding="utf-8")
    with pytest.raises(ExportError, match="the file has changed"):
        export({"mine": model}, "glsl")
    # A comment changes nothing
    path.write_text(text.replace("self.rho * 2", "self.rho * 2  # so"), encoding="utf-8")
    assert "* 2.0" in export({"mine": model}, "glsl")[0].source


def test_a_named_tuple_becomes_a_struct_with_its_names_and_descriptions(tmp_path: Path) -> None:
    head = (
        'class Lobe(NamedTuple):\n    """A lobe of light."""\n\n    weight: Float\n    """How much."""\n'
        "    tint: Color\n\n\ndef lobe(x):\n    return Lobe(x, tint=x)"
    )
    body = "made = lobe(wi.z)\nweight, tint = lobe(wo.z)\nreturn made.weight * tint * weight"
    model = made(tmp_path, body, "", head)
    for language in TARGETS:
        found = export({"mine": model}, language, only=["eval"])[0].source
        assert "// A lobe of light." in found
        assert re.search(r"struct MineLobe( : IDifferentiable)? \{", found)
        assert re.search(r"weight\b.*// How much$", found, re.M)
        assert re.search(r"made\.weight", found)
        assert "first" not in found


def test_members_and_arguments_that_nothing_reads_are_left_out(tmp_path: Path) -> None:
    head = "def f(x, y, z):\n    return 2 * x"
    model = made(tmp_path, "return self.rho * f(wi.z, self.width, wo)", "", head)
    (exported,) = export({"mine": model}, "glsl", only=["eval"])
    assert "float mine_f(float x) {" in exported.source
    assert "mine_f(wi.z)" in exported.source
    assert [m.path for m in exported.entry.members] == ["rho"]
    assert "width" not in exported.source


def test_a_function_that_passes_on_is_inlined(tmp_path: Path) -> None:
    head = (
        "def f(x):\n    return 2 * x\n\n\ndef g(x):\n    return f(x)\n\n\ndef one(x):\n    return 1"
    )
    model = made(tmp_path, "return self.rho * g(wi.z) * one(wo.z)", "", head)
    found = export({"mine": model}, "glsl", only=["eval"])[0].source
    assert "return params.rho * mine_f(wi.z);" in found
    assert "mine_g" not in found


def test_names_of_models_avoid_the_prefixes_of_opengl(tmp_path: Path) -> None:
    model = made(tmp_path, "return self.rho")
    for name in ("gl_x", "webgl_x", "gl"):
        for language in ("glsl", "essl", "cpp"):
            (exported,) = export({name: model}, language, only=["eval"])
            assert exported.entry.prefix == f"my_{name}"
            assert not re.search(rf"\b{name}_\w+\(", exported.source)


def test_comments_are_folded_anew_and_call_things_by_their_names(tmp_path: Path) -> None:
    head = (
        "def f_long(x):\n"
        '    """Twice x.\n\n'
        "    A paragraph that is as wide as the lines of this file may be, so that its last word has no\n"
        "    room in a shader; `f_other` is what f_long calls.\n\n    short\n    lines\n"
        '    """\n'
        "    return 2 * f_other(x)\n\n\ndef f_other(x):\n    return x * x + PI"
    )
    found = export({"mine": made(tmp_path, "return self.rho * f_long(wi.z)", "", head)}, "glsl")[
        0
    ].source
    assert "mine_f_other is what mine_f_long calls." in found
    assert "// short\n// lines\n" in found
    assert not re.search(r"^// \w+\n// room in", found, re.M)
