"""What users hold and what kernels hold: two classes with one text."""

import copy
import pickle

import numpy as np
import pytest
from support.tolerances import SINGLE

import gonio
from gonio.arrays.kernel import opaque
from gonio.fields import ModelError
from gonio.lang import Color, Vec3
from gonio.model import OnArrays

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
