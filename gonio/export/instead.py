"""What people write that no shader has, and what to write instead."""

from __future__ import annotations

import ast

# What people write, and what to write instead.
INSTEAD = {
    ast.While: "a loop over a fixed number of steps: for i in range(8): ...",
    ast.Break: "a loop that makes all its steps, and x = select(condition, new, x) in it",
    ast.Continue: "a loop that makes all its steps, and x = select(condition, new, x) in it",
    ast.IfExp: "select(condition, yes, no), which computes both",
    ast.Lambda: "a function with a name",
    ast.ListComp: "one statement for each element",
    ast.SetComp: "one statement for each element",
    ast.DictComp: "one statement for each element",
    ast.GeneratorExp: "one statement for each element",
    ast.List: "variables, vec2 and vec3, or a tuple of options",
    ast.Set: "a tuple of options, as in self.form in ('a', 'b')",
    ast.Dict: "variables, or 'if' on an option",
    ast.JoinedStr: "the option itself, as in self.form == 'a'; a shader has no text",
    ast.Try: "nothing; shaders have no exceptions",
    ast.Raise: "the check in check_together; shaders have no exceptions",
    ast.Assert: "the check in check_together; shaders have no exceptions",
    ast.With: "plain statements",
    ast.FunctionDef: "a function of the module or a method",
    ast.AsyncFunctionDef: "a function of the module or a method",
    ast.ClassDef: "a class of the module",
    ast.Import: "the import at the top of the file",
    ast.ImportFrom: "the import at the top of the file",
    ast.Match: "if and elif on an option",
    ast.Delete: "nothing; names that are not used cost nothing",
    ast.Subscript: "v.x, v.y, v.z, unpack the results (a, b = f(x)), or decide with 'if' on an option",
    ast.NamedExpr: "an assignment of its own",
    ast.Starred: "each value by its name",
    ast.Yield: "return",
    ast.YieldFrom: "return",
    ast.Await: "the call alone",
    ast.Global: "a named number of the module, which is never changed",
    ast.Nonlocal: "a named number of the module, which is never changed",
}

# The same for Python's own functions.
BUILTINS = {
    "abs": "absolute(x)",
    "min": "minimum(a, b)",
    "max": "maximum(a, b)",
    "pow": "power(x, exponent)",
    "sum": "a + b + c",
    "float": "the value alone; all numbers are floats",
    "int": "x - fract(x) for the whole part",
    "round": "x + 0.5 - fract(x + 0.5)",
    "divmod": "fract, and what is left",
    "bool": "a comparison",
    "tuple": "return a, b",
    "print": "nothing; a shader cannot print",
    "len": "the number itself",
    "zip": "one statement for each element",
    "enumerate": "for i in range(8): ...",
    "super": "super().name(...), which calls a method of a class above; properties and functions have none",
}
