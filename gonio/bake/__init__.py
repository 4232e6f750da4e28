"""What real-time shaders look up: tables of F and D, prefiltered light, light by formulas."""
