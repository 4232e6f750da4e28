"""Classes that are no models are told so in one line, with class, name and place; odd ones work."""

from __future__ import annotations

import copy
import re
import sys
from pathlib import Path
from types import new_class
from typing import Any

import numpy as np
import pytest

from gonio.export import export
from gonio.fields import ModelError
from gonio.lang import Color, Float, Vec3, vec3
from gonio.materials.model_file import ModelFileError, load
from gonio.model import Model, child, model, param

UP = np.array([0.6, 0, 0.8])

HEAD = '''"""Mine."""
from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import TYPE_CHECKING, Generic, NamedTuple, Protocol, TypeVar, runtime_checkable

from gonio import lang
from gonio.claims import Claims, Place, at_most, kink, white_furnace
from gonio.lang import Color, Float, Sample, Vec2, Vec3, vec3
from gonio.model import Model, child, option, param

if TYPE_CHECKING:
    from nowhere import Elsewhere

T = TypeVar("T")
shared = param(0.25, 0, 1, "shared")


class Loose:
    def twice(self, x):
        return 2 * x


class Colourful:
    rho = 0.5


class Valued:
    @property
    def rho(self):
        return 0.5


class Demanding:
    def __init__(self, wanted):
        self.wanted = wanted


class Watching:
    def __init_subclass__(cls, strict=True):
        super().__init_subclass__()


class _Base(Model, register=False):
    rho: Color = param(0.5, 0, 1, "albedo")

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        return self.rho * 1

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        return Sample(wo, 1)

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        return wi.z

    def shine(self):
        return 1


class _Other(Model, register=False):
    gloss: Float = param(0.5, 0, 1, "gloss")


'''

# What stands in the file; "# here" marks the line that the message names.
WRONG = {
    "a property over a parameter": (
        "class Mine(_Base):\n    @property\n    def rho(self):  # here\n        return 0.5",
        "Mine: rho is a property and a parameter",
    ),
    "a method over a parameter": (
        "class Mine(_Base):\n    def rho(self):  # here\n        return 0.5",
        "Mine: rho is a method and a parameter",
    ),
    "a number over a parameter": (
        "class Mine(_Base):\n    rho = 0.25  # here",
        "Mine: rho is a name of the class and a parameter",
    ),
    "a parameter over a method": (
        'class Mine(_Base):\n    shine: Float = param(0.5, 0, 1, "shine")  # here',
        "Mine: shine is a method of _Base and a parameter",
    ),
    "a property of a class beside": (
        "class Mine(Valued, _Base):  # here\n    pass",
        "Mine: rho is a property of Valued and a parameter",
    ),
    "a number of a class behind": (
        "class Mine(_Base, Colourful):  # here\n    pass",
        "Mine: rho is a name of the class of Colourful",
    ),
    "an __init__ that cannot do without": (
        "class Mine(_Base):\n    def __init__(self, rho):  # here\n        super().__init__(rho=rho)",
        "Mine: __init__ cannot do without rho",
    ),
    "an __init__ of a class beside": (
        "class Mine(Demanding, _Base):  # here\n    pass",
        "Mine: __init__ cannot do without wanted",
    ),
    "a __new__": (
        "class Mine(_Base):\n    def __new__(cls):  # here\n        return 3",
        "Mine: gonio gives every model its __new__",
    ),
    "a name": ('class Mine(_Base):\n    name = "other"  # here', "every model its name"),
    "a parameter called __class__": (
        'class Mine(_Base):\n    __class__: Float = param(0.5, 0, 1, "class")  # here',
        "Mine: every model has __class__",
    ),
    "a declaration that is not called": (
        "class Mine(_Base):\n    gloss: Float = param  # here",
        "Mine: gloss is not called",
    ),
    "an annotation alone": (
        "class Mine(_Base):\n    gloss: Float  # here",
        "Mine: gloss has no value",
    ),
    "an annotation that stops": (
        'class Mine(_Base):\n    gloss: lang.Number = param(0.5, 0, 1, "gloss")  # here',
        "Mine: write gloss: Float",
    ),
    "an option without values": (
        'class Mine(_Base):\n    form: str = option(doc="form")  # here',
        "write option",
    ),
    "an option of numbers": (
        'class Mine(_Base):\n    form: str = option(1, 2, doc="form")  # here',
        "write option",
    ),
    "claims of a size that is a number": (
        "class Mine(_Base):\n    claims = Claims(energy=1.05)  # here",
        "Mine: in its claims energy is at_most.SIZE. with a number from 0 up, or several in . ., not 1.05",
    ),
    "claims of a size below zero": (
        "class Mine(_Base):\n    claims = Claims(wasted=at_most(-0.1))  # here",
        "Mine: in its claims wasted is at_most.SIZE. with a number from 0 up, or several in . ., not -0.1",
    ),
    "claims of a size in a list": (
        "class Mine(_Base):\n    claims = Claims(energy=[at_most(1.1)])  # here",
        "Mine: in its claims energy is at_most.SIZE.",
    ),
    "claims of a size with an option that is not there": (
        'class Mine(_Base):\n    claims = Claims(energy=at_most(1.1, form="x"))  # here',
        "Mine: in its claims energy has form, which is no option",
    ),
    "claims of a place for a kink": (
        "class Mine(_Base):\n    claims = Claims(kinks=Place.EQUAL_COSINES)  # here",
        "Mine: in its claims kinks is kink.Place.EQUAL_COSINES.",
    ),
    "claims of a kink at a word": (
        'class Mine(_Base):\n    claims = Claims(kinks=kink("mu_i"))  # here',
        "or several in . ., not 'mu_i'",
    ),
    "claims of a furnace as a size": (
        "class Mine(_Base):\n    claims = Claims(furnace=at_most(1e-3))  # here",
        "Mine: in its claims furnace is white_furnace.within=1e-6, rho=1.",
    ),
    "claims of a furnace of another parameter": (
        "class Mine(_Base):\n    claims = Claims(furnace=white_furnace(within=1e-6, rhoo=1))  # here",
        "Mine: in its claims white_furnace has rhoo, which is no parameter",
    ),
    "claims of a name that falls as text": (
        'class Mine(_Base):\n    claims = Claims(falls="rho")  # here',
        "such as .'rho',., not 'rho'",
    ),
    "claims of another name that falls": (
        'class Mine(_Base):\n    claims = Claims(falls=("gloss",))  # here',
        "Mine: in its claims falls has 'gloss', which is no parameter",
    ),
    "an option with one value twice": (
        'class Mine(_Base):\n    form: str = option("a", "a", doc="form")  # here',
        "write option",
    ),
    "a model inside that has no name": (
        'class Mine(_Base):\n    base: Model = child(Model, "base")  # here',
        "write child",
    ),
    "a scale that is no function": (
        'class Mine(_Base):\n    gloss: Float = param(0.5, 0, 1, "gloss", rougher="alpha")  # here',
        "rougher is a function",
    ),
    "a default that is an array": (
        "import numpy as np\n\n\nclass Mine(_Base):\n"
        '    gloss: Float = param(np.array([0.5, 3]), 0, 1, "gloss")  # here',
        "the default of gloss is a number",
    ),
    "an asynchronous method": (
        "class Mine(_Base):\n    async def pdf(self, wi, wo):  # here\n        return wi.z",
        r"Mine: write def pdf\(self, wi, wo\)",
    ),
    "claims that are none": ("class Mine(_Base):\n    claims = 3  # here", "claims is Claims"),
    "a caveat alone": ('class Mine(_Base):\n    caveats = "bad"  # here', "caveats is"),
    "a number": ("class Mine(int, _Base):  # here\n    pass", "Mine derives from int"),
    "a tuple": (
        "class Pair(NamedTuple):\n    a: int\n\n\nclass Mine(_Base, Pair):  # here\n    pass",
        "Mine derives from tuple",
    ),
}


def made(folder: Path, text: str) -> type[Model]:
    path = folder / "mine.py"
    path.write_text(HEAD + text + "\n", encoding="utf-8")
    return load(path)


@pytest.mark.parametrize("case", WRONG)
def test_a_class_that_is_no_model_is_told_in_one_line_with_its_place(
    case: str, tmp_path: Path
) -> None:
    text, words = WRONG[case]
    with pytest.raises(ModelFileError) as caught:
        made(tmp_path, text)
    told = str(caught.value)
    line, said = re.fullmatch(r"\S+mine\.py, line (\d+): (.+)", told).groups()  # type: ignore[union-attr]
    assert "# here" in (HEAD + text).split("\n")[int(line) - 1]
    assert re.search(words, said)


MODELS = {
    "an annotation for checkers of types": "class Mine(_Base):\n    seen: Elsewhere = None",
    "an annotation in quotes": 'class Mine(_Base):\n    gloss: "Float" = param(0.5, 0, 1, "gloss")',
    "a class beside it": "class Mine(Loose, _Base):\n"
    "    def eval(self, wi, wo):\n        return self.rho * self.twice(wi.z)",
    "a class that looks on": "class Mine(Watching, _Base):\n    pass",
    "an annotation of what is nowhere": 'class Mine(_Base):\n    seen: "Elsewhere"',
    "a protocol": "@runtime_checkable\nclass Twice(Protocol):\n    def twice(self, x): ...\n\n\n"
    "class Mine(Twice, _Base):\n    def twice(self, x):\n        return 2 * x",
    "a generic class": "class _Of(_Base, Generic[T], register=False):\n    pass\n\n\n"
    "class Mine(_Of[int]):\n    pass",
    "two models above": "class Mine(_Base, _Other):\n"
    "    def eval(self, wi, wo):\n        return self.rho * self.gloss",
    "one model above twice": "class _Left(_Base, register=False):\n    pass\n\n\n"
    "class _Right(_Base, register=False):\n    pass\n\n\nclass Mine(_Left, _Right):\n    pass",
    "a parameter declared again": 'class Mine(_Base):\n    rho: Color = param(0.25, 0, 1, "albedo")',
    "a parameter called self": 'class Mine(_Base):\n    self: Float = param(0.5, 0, 1, "self")',
    "places of its own": 'class Mine(_Base):\n    __slots__ = ("more",)',
    "one declaration under two names": "class Mine(_Base):\n    a: Color = shared\n    b: Float = shared\n"
    "\n    def eval(self, wi, wo):\n        return self.a * self.b",
}


@pytest.mark.parametrize("case", MODELS)
def test_an_odd_class_is_a_model_as_any_other(case: str, tmp_path: Path) -> None:
    cls = made(tmp_path, MODELS[case])
    mine = cls()
    assert np.isfinite(mine.eval(UP, UP)).all()
    assert mine.replace() == mine == copy.deepcopy(mine)
    assert list(mine.rows())
    for language in ("glsl", "osl"):
        assert export({"mine": mine}, language, only=["eval"])


@pytest.mark.parametrize("names", [{}, {"__name__": "nowhere"}, {"__name__": "__main__"}])
def test_a_class_of_text_that_python_runs_knows_the_names_beside_it(names: dict[str, str]) -> None:
    """As notebooks, documentation tests and consoles run it: of no module, or of another one."""
    text = HEAD.partition("class _Other")[0]
    space: dict[str, Any] = dict(names)
    exec(text + "class Mine(_Base, register=False):\n    pass", space)
    assert np.isfinite(space["Mine"]().eval(UP, UP)).all()


def test_a_declaration_under_two_names_is_one_of_each(tmp_path: Path) -> None:
    fields = made(tmp_path, MODELS["one declaration under two names"]).fields
    assert [(fields[n].name, fields[n].width) for n in "ab"] == [("a", 3), ("b", 1)]  # type: ignore[union-attr]


def test_an_init_that_sets_nothing_says_so(tmp_path: Path) -> None:
    text = "class Mine(_Base):\n    def __init__(self, **given):\n        pass"
    line = (HEAD + text).split("\n").index("    def __init__(self, **given):") + 1
    with pytest.raises(
        ModelError, match=rf"Mine: __init__ in \S+mine\.py, line {line}, leaves rho"
    ):
        made(tmp_path, text)()
    text = (
        "class Mine(_Base):\n    def __init__(self, **given):\n        super().__init__(**given)\n"
    )
    with pytest.raises(AttributeError, match="Mine has no parameter extra; declare it"):
        made(tmp_path, text + "        self.extra = 3")()


def test_a_dataclass_is_no_model(tmp_path: Path) -> None:
    with pytest.raises(ModelError, match="Mine is decorated by @dataclass"):
        made(tmp_path, "@dataclass\nclass Mine(_Base):\n    pass")()


def test_a_model_that_has_itself_inside_never_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys.modules[Model.__module__], "_registry", {})

    def body(space: dict[str, object]) -> None:
        space.update(
            __module__="tests.ring",
            __annotations__={"base": Model, "gloss": Float},
            base=child("ring", "itself"),
            gloss=param(0.5, 0, 1, "gloss"),
        )

    new_class("Ring", (Model,), {}, body)
    with pytest.raises(ModelError, match="ring: base has ring inside by default"):
        model("ring")


def test_a_default_model_that_is_not_there_says_whose_it_is() -> None:
    class Coated(Model, register=False):
        """Over nothing."""

        base: Model = child("nothing", "what lies below")
        gloss: Float = param(0.5, 0, 1, "gloss")

        def eval(self, wi: Vec3, wo: Vec3) -> Color:
            return vec3(self.gloss, 0, 0)

    with pytest.raises(ModelError, match="coated: base: no model 'nothing'"):
        Coated()
