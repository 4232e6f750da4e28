"""Which lines of code a preprocessor keeps: what is left out has no functions, structs or uniforms for us.

Conditions of names, numbers, defined(), ! && || and comparisons are decided; lines under others are kept.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Sequence


def active(text: str, defines: Sequence[str] = ()) -> str:
    """The text with the lines that are left out blank, every other character in its place.

    Args:
        text: without comments.
        defines: macros from outside, NAME or NAME=VALUE.
    """
    macros = {name: value or "1" for name, _, value in (d.partition("=") for d in defines)}
    # For each open #if: whether its lines are kept, whether one branch was taken, whether it is decided
    stack: list[tuple[bool, bool, bool]] = []
    found = []
    for line in text.split("\n"):
        match = re.match(r"\s*#\s*(if|ifdef|ifndef|elif|else|endif|define|undef)\b\s*(.*)", line)
        keeps = all(kept for kept, _, _ in stack)
        if match is None:
            found.append(line if keeps else " " * len(line))
            continue
        found.append(line)
        word, rest = match[1], match[2].strip()
        if word in ("if", "ifdef", "ifndef"):
            value = _value(word, rest, macros)
            stack.append((value is not False, value is True, value is not None))
        elif word in ("elif", "else") and stack:
            _, taken, decided = stack.pop()
            value = (True if word == "else" else _value("if", rest, macros)) if decided else None
            if taken:
                stack.append((False, True, True))
            else:
                stack.append((value is not False, value is True, value is not None))
        elif word == "endif" and stack:
            stack.pop()
        elif keeps and word == "define" and (name := re.match(r"(\w+)(\(?)\s*(.*)", rest)):
            macros[name[1]] = name[3] if not name[2] else ""
        elif keeps and word == "undef":
            macros.pop(rest, None)
    return "\n".join(found)


def _value(word: str, rest: str, macros: dict[str, str]) -> bool | None:
    """What a condition says; None where that is not decided."""
    if word in ("ifdef", "ifndef"):
        name = re.match(r"\w+", rest)
        return None if name is None else (name[0] in macros) == (word == "ifdef")
    text = re.sub(
        r"\bdefined\s*(?:\(\s*(\w+)\s*\)|(\w+))",
        lambda m: str(int((m[1] or m[2]) in macros)),
        rest,
    )
    for _ in range(4):  # macros of macros
        text = re.sub(r"[A-Za-z_]\w*", lambda m: macros.get(m[0], "0") or "0", text)
    text = text.replace("&&", " and ").replace("||", " or ")
    text = re.sub(r"!(?!=)", " not ", text)
    try:
        tree = ast.parse(text.strip(), mode="eval")
        return bool(_number(tree.body))
    except (SyntaxError, ValueError, ZeroDivisionError, RecursionError):
        return None


def _number(node: ast.expr) -> float:
    """The value of a condition.

    Raises:
        ValueError: something else than numbers and operators.
    """
    if isinstance(node, ast.Constant) and isinstance(node.value, (int, float)):
        return float(node.value)
    if isinstance(node, ast.BoolOp):
        values = [bool(_number(v)) for v in node.values]
        return float(all(values) if isinstance(node.op, ast.And) else any(values))
    if isinstance(node, ast.UnaryOp):
        value = _number(node.operand)
        return float(not value) if isinstance(node.op, ast.Not) else -value
    if isinstance(node, ast.Compare) and len(node.ops) == 1:
        a, b = _number(node.left), _number(node.comparators[0])
        kinds = {
            ast.Eq: a == b,
            ast.NotEq: a != b,
            ast.Lt: a < b,
            ast.LtE: a <= b,
            ast.Gt: a > b,
            ast.GtE: a >= b,
        }
        return float(kinds[type(node.ops[0])])
    if isinstance(node, ast.BinOp) and isinstance(node.op, (ast.Add, ast.Sub, ast.Mult)):
        a, b = _number(node.left), _number(node.right)
        return (
            a + b
            if isinstance(node.op, ast.Add)
            else a - b
            if isinstance(node.op, ast.Sub)
            else a * b
        )
    raise ValueError
