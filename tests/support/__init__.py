"""Inputs and independent quadrature that several test files share."""
