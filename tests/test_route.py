"""What users hold and what kernels hold: two classes with one text."""

import copy
import pickle
from types import new_class
from typing import Any

import numpy as np
import pytest
from support.tolerances import SINGLE

import gonio
from gonio.arrays.kernel import opaque
from gonio.fields import ModelError
from gonio.lang import Color, Vec3
from gonio.model import Model, OnArrays, param

UP = np.array([0.0, 0.6, 0.8])


class Doubled(gonio.EON, register=False):
    """Twice its class's values."""

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """By way of the class above."""
        return 2 * super().eval(wi, wo)


class Bare(gonio.Lambert, register=False):
    """Returns what is left of rho where its own method is reached without a guard."""

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """A value below the horizon as well."""
        return self.rho


def bound(model):
    """The model in plain Python."""
    return model.bind(float, lambda path, declared, value: opaque(float, declared.width, value))


def test_users_hold_a_variant_on_arrays_and_kernels_the_class_itself() -> None:
    model = gonio.EON(roughness=0.3)
    assert isinstance(model, gonio.EON)
    assert isinstance(model, OnArrays)
    inside = bound(model)
    assert type(inside) is gonio.EON
    assert not isinstance(inside, OnArrays)
    assert model.written is inside.written is gonio.EON
    assert inside.float_type is float
    assert not hasattr(model, "float_type")


def test_models_inside_a_bound_model_are_bound() -> None:
    inside = bound(gonio.WeidlichWilkie(base="eon"))
    assert type(inside.base) is gonio.EON


def test_super_reaches_the_written_method() -> None:
    expected = 2 * gonio.EON().eval(UP, UP)
    np.testing.assert_allclose(Doubled().eval(UP, UP), expected, rtol=SINGLE)


def test_a_bound_model_is_zero_below_the_horizon_and_so_is_what_users_hold() -> None:
    below = -UP
    np.testing.assert_array_equal(Bare(rho=0.5).eval(below, UP), 0)
    vectors = (opaque(float, 3, tuple(w)) for w in (below, UP))
    assert list(bound(Bare(rho=0.5)).eval(*vectors)) == [0, 0, 0]
    np.testing.assert_array_equal(Bare(rho=0.5).eval(UP, UP), 0.5)


@pytest.mark.parametrize(
    "again", [copy.copy, copy.deepcopy, lambda m: pickle.loads(pickle.dumps(m))]
)
def test_a_model_is_copied_and_pickled_with_its_values(again) -> None:
    model = gonio.WeidlichWilkie(alpha=0.2, **{"base.rho": (0.1, 0.2, 0.3)})
    value = model.eval(UP, UP)  # now it keeps a bound model
    made = again(model)
    assert made == model
    assert repr(made) == repr(model)
    np.testing.assert_array_equal(made.eval(UP, UP), value)


def test_numpy_arrays_as_parameters_are_pickled() -> None:
    made = pickle.loads(pickle.dumps(gonio.EON(roughness=np.array([0.1, 0.9]))))
    np.testing.assert_array_equal(made.roughness, [0.1, 0.9])


def test_deriving_from_the_type_of_a_model_says_what_to_derive_from() -> None:
    with pytest.raises(
        ModelError, match=r"Mine derives from the type of a model; .* model\.written"
    ):

        class Mine(type(gonio.EON()), register=False):
            """Not possible."""


def test_a_missing_direction_is_named() -> None:
    with pytest.raises(TypeError, match="'wo'"):
        gonio.EON().eval(UP)


def test_one_model_of_two_has_the_parameters_of_both() -> None:
    class Both(gonio.Lambert, gonio.Phong, register=False):
        """The sum of two."""

        def eval(self, wi: Vec3, wo: Vec3) -> Color:
            """By way of both classes."""
            return gonio.Lambert.eval(self, wi, wo) + gonio.Phong.eval(self, wi, wo)

    expected = gonio.Lambert(rho=0.2).eval(UP, UP) + gonio.Phong(rho=0.2, specular=0.3).eval(UP, UP)
    found = Both(rho=0.2, specular=0.3).eval(UP, UP)
    np.testing.assert_allclose(found, expected, rtol=SINGLE)


def test_a_copy_is_changed_by_name_whatever_the_class_is_made_from() -> None:
    class Chalk(gonio.EON, register=False):
        """Made from one word."""

        def __init__(self, kind: str = "fine", **given: Any) -> None:
            super().__init__(roughness={"fine": 0.5, "coarse": 1.0}[kind], **given)

    assert Chalk("coarse", rho=0.2).replace(rho=0.5).roughness == 1
    assert copy.deepcopy(Chalk("coarse")) == Chalk("coarse")


def test_a_field_of_a_model_cannot_be_taken_away() -> None:
    model = gonio.EON()
    with pytest.raises(AttributeError, match="does not change"):
        del model.roughness
    assert model == gonio.EON()


class Unguarded:
    """Has a method of models, but is none."""

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """A value below the horizon as well."""
        return wi.z * 0 + 1


class Loose:
    """Has a parameter of models, but is none."""

    rho: Color = param(0.5, 0, 1, "albedo")


MISTAKES = {
    "rho: Float = param": ({"rho": param(0.5, 0, 1, "albedo")}, (Model,)),
    "every model has numeric": ({"numeric": param(0.5, 0, 1, "number")}, (Model,)),
    "every model has name": ({"name": param(0.5, 0, 1, "number")}, (Model,)),
    r"write def eval\(self, wi, wo\)": ({"eval": lambda self, wi: wi.z}, (Model,)),
    r"write def pdf\(self, wi, wo\)": ({"pdf": staticmethod(lambda wi, wo: wi.z)}, (Model,)),
    r"Unguarded has eval.*class Unguarded\(Model": ({}, (Unguarded, Model)),
    "Loose has rho": ({}, (Loose, Model)),
}


@pytest.mark.parametrize("message", MISTAKES)
def test_a_class_that_is_no_model_yet_is_told_what_to_write(message: str) -> None:
    body, bases = MISTAKES[message]
    with pytest.raises(ModelError, match=message):
        new_class("Wrong", bases, {"register": False}, lambda space: space.update(body))


def test_a_type_of_a_parameter_that_is_not_imported_is_named() -> None:
    text = "class Wrong(Model, register=False):\n    rho: 'Colour' = param(0.5, 0, 1, 'albedo')"
    with pytest.raises(ModelError, match="annotation Colour is not known"):
        exec(text, {"Model": Model, "param": param, "__name__": "__main__"})


def test_a_model_of_another_file_cannot_take_a_name_by_inheriting_all() -> None:
    with pytest.raises(ModelError, match=r"two models are called 'eon'.*tests\.eon"):
        new_class("EON", (gonio.EON,), {}, lambda space: space.update(__module__="tests.eon"))
    assert type(gonio.model("eon")).written.__module__ == "gonio.models.eon"


def test_calls_that_reach_no_arrays_say_what_to_call() -> None:
    with pytest.raises(ModelError, match="call eval of the model itself"):
        gonio.EON.eval(gonio.EON(), UP, UP)
    with pytest.raises(ModelError, match=r"by name, not 0\.5 alone; known are rho"):
        gonio.EON(0.5)
    with pytest.raises(ModelError, match="Model is no model by itself"):
        Model()

    class Unfinished(Model, register=False):
        """Cannot be sampled."""

        def eval(self, wi: Vec3, wo: Vec3) -> Color:
            """A cosine."""
            return wi.z

    with pytest.raises(ModelError, match="unfinished has no method sample"):
        Unfinished().sample(UP, (0.5, 0.5))


def test_a_copy_is_refused_what_the_model_refuses() -> None:
    model = gonio.TorranceSparrow(compensation="turquin")
    with pytest.raises(ModelError, match="is made for distribution='ggx'"):
        model.replace(distribution="beckmann")
