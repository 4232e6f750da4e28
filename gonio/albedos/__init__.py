"""Albedos without a closed form: three rules of quadrature, and which of them fits a model."""
