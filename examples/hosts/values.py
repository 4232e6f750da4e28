"""Prints the parameters of material.json for path_tracer.cpp: a line "x y z 0" for each member."""

import json

with open("material.json", encoding="utf-8") as file:
    parameters = json.load(file)["parameters"]
for parameter in parameters:
    if parameter["offset"] is not None:
        print(*(parameter["value"] * 3)[:3], 0)
