"""What the arguments of foreign code are: light, viewer, normal, cosines between them, and parameters.

Told by types and names, as programs have them; `--map` says it where that is not clear.
"""

from __future__ import annotations

import re
from collections.abc import Container, Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from gonio.fields import Parameter
from gonio.foreign.declarations import Constructor, Function, Variable
from gonio.foreign.expressions import Array, Expression, parse
from gonio.foreign.sampled import NOTHING
from gonio.foreign.source import ForeignError, Source
from gonio.messages import did_you_mean
from gonio.model import models

# Names in lower case without underscores, by what they stand for.
DIRECTIONS = {
    "wi": "l wi light lightdir lightdirection lightvec lightvector tolight ldir wl incoming omegai "
    "dirtolight lightdirectionws worldlightdir directlightdirection wilocal in i",
    "wo": "v wo view viewdir viewdirection viewvec viewvector eye eyedir eyevec e toeye toviewer tocamera "
    "camera cameradir omegao outgoing vdir worldviewdir wolocal out o",
    "normal": "n normal nrm norm nor shadingnormal worldnormal geometrynormal ns ng nn surfacenormal "
    "normalws",
    "tangent": "t x tangent tangentu tx dpdu tangentws tu worldtangent",
    "bitangent": "b y bitangent binormal dpdv ty tv bt bitangentws worldbinormal",
    "half": "h half halfvec halfvector halfdir wh wm m halfway",
}
COSINES = {
    "cos_i": "nol ndotl ndl nl dotnl costhetai cosi mui cosl costhetal ldotn lon cosnl clampednol",
    "cos_o": "nov ndotv ndv nv dotnv costhetao coso muo cosv costhetav vdotn von cosnv clampednov",
    "cos_h": "noh ndoth ndh nh dotnh costhetah cosh muh hdotn hon cosnh",
    "cos_d": "loh ldoth ldh lh dotlh voh vdoth vdh vh dotvh costhetad hdotv hdotl hov hol cosd",
    "cos_v": "lov ldotv ldv lv dotlv vdotl vol vdl dotvl",
    "cos_tangent_h": "toh tdoth dottoh hdotx hdott toh_",
    "cos_bitangent_h": "boh bdoth hdoty hdotb",
    "cos_tangent_i": "tol tdotl ldotx ldott",
    "cos_bitangent_i": "bol bdotl ldoty ldotb",
    "cos_tangent_o": "tov tdotv vdotx vdott",
    "cos_bitangent_o": "bov bdotv vdoty vdotb",
}
# Random numbers of functions that sample; u3 is one more for those that choose a lobe by it.
RANDOM = {
    "u1": "u1 u0 xi1 xi0 r1 r0 rand1 rand0 rnd1 e1 ux rx randx randu randomu u",
    "u2": "u2 xi2 r2 rand2 rnd2 e2 uy ry randy randv randomv v",
    "u3": "u3 xi3 r3 rand3 rnd3 e3 uc uz ulobe rlobe lobe choice select randlobe",
}
_RANDOM_VECTORS = (
    "u xi rand rnd random uv e r rands randoms sample u2 xi2 eta uniform samples u3 xi3"
)
ROLES = (*DIRECTIONS, *COSINES, *RANDOM)

# What functions are asked for.
KINDS = ("value", "sample", "pdf", "albedo")

# Where the members of the object are whose method is called, and what it is made of.
MEMBERS, MADE_OF = "gonio_self.", "gonio_made."

# Kinds of numbers, by the ends of their types' names in all languages.
_VECTOR = re.compile(
    r"(?:^|::)(?:[iub]?vec|float|half|double|real|packed_float|simd_float|min16float|Vec|Vector|V|vec|"
    r"vector|Float|Color|Colour|color|Spectrum|RGB|Normal)(?P<n>[234])?(?:[fhd]|<f(?:32|16)>|<float>|<half>)?$"
)
_NUMBER = re.compile(
    r"(?:^|::)(?:float|half|double|real|f32|f16|min16float|Float|Real|scalar|float_t|half_t)$"
)
_WHOLE = re.compile(r"(?:^|::)(?:int|uint|bool|i32|u32|unsigned|size_t|uint32_t|int32_t|char)$")
_COLOURS = re.compile(
    r"(?:^|::)(?:Spectrum|Color|Colour|RGB|Vector|Normal|Vec|color|vector|point|normal)$"
)

# Ranges that names suggest where gonio's own models do not have the name.
SUGGESTED = (
    (r"(?:^|_)(?:ior|eta|index)|ior$", 1.0, 3.0, 1.5),
    (r"(shininess|exponent|glossiness_power|power|spec_?power|nu|nv|^n|^ns)$", 1.0, 1000.0, 32.0),
    (r"^k$|extinction", 0.0, 8.0, 3.0),
)


@dataclass(frozen=True)
class Leaf:
    """One number or vector that the harness sets: an argument, a member of one, or a uniform."""

    place: str
    """Where it is set, such as "params.roughness"."""
    type: str
    width: int
    """How many numbers it has."""
    whole: bool
    """Whether it is an int or bool."""
    variable: Variable
    components: tuple[str, ...] = ()
    """Names of its components where it is a struct of numbers, not a built-in vector."""


@dataclass(frozen=True)
class Matched:
    """All leaves with the formula of each, and the parameters that the formulas leave free."""

    leaves: tuple[tuple[Leaf, Expression], ...]
    parameters: dict[str, Parameter]
    notes: tuple[str, ...]
    """What was assumed, for people."""
    kind: str = "value"
    """Of KINDS."""

    @property
    def columns(self) -> int:
        """How many numbers the harness reads for each call."""
        return sum(leaf.width for leaf, _ in self.leaves)

    def explained(self) -> str:
        """What each argument was taken for."""
        return ", ".join(
            f"{leaf.place.removeprefix(MEMBERS).removeprefix(MADE_OF)} = {expression.text}"
            for leaf, expression in self.leaves
        )


def constructor(source: Source, function: Function) -> Constructor | None:
    """What makes the object whose method a function is, if its arguments can be set."""
    maker = source.constructors.get(function.owner)
    if maker is None or not maker.computes:
        return None
    try:
        for argument in maker.arguments:
            list(leaves_of(source, argument))
    except ForeignError:
        return None
    return maker


def width_of(kind: str) -> int:
    """How many numbers a type has: 1, 2, 3 or 4; 0 for what is no type of numbers."""
    if _NUMBER.search(kind) or _WHOLE.search(kind):
        return 1
    match = _VECTOR.search(kind)
    if match and match["n"]:
        return int(match["n"])
    return 3 if _COLOURS.search(kind) else 0


def leaves_of(
    source: Source, variable: Variable, prefix: str = "", depth: int = 0
) -> Iterable[Leaf]:
    """The numbers that a variable consists of.

    Raises:
        ForeignError: a type that is neither a number, nor a vector, nor a struct of these.
    """
    place = prefix + variable.name
    if variable.type == NOTHING:
        return
    if variable.pointer or variable.array:
        width = 3 if not variable.array else int(variable.array) if variable.array.isdigit() else 0
        if width_of(variable.type) == 1 and 1 <= width <= 4:
            yield Leaf(
                place, variable.type, width, False, variable, tuple(f"[{k}]" for k in range(width))
            )
            return
        raise ForeignError(
            f"{source.path}: {place} is an array or a pointer to {variable.type}; only "
            "arrays of two to four numbers can be set."
        )
    members = source.structs.get(variable.type.rpartition("::")[2])
    if members is not None and depth < 6:
        numbers = all(_NUMBER.search(m.type) and not m.array for m in members)
        names = [m.name for m in members]
        if numbers and names in (["x", "y", "z"], ["r", "g", "b"], ["x", "y"]):
            yield Leaf(
                place, variable.type, len(names), False, variable, tuple(f".{n}" for n in names)
            )
            return
        if len(members) == 1 and members[0].array == "3" and width_of(members[0].type) == 1:
            inner = members[0].name
            yield Leaf(
                place, variable.type, 3, False, variable, tuple(f".{inner}[{k}]" for k in range(3))
            )
            return
        for member in members:
            known = width_of(member.type) or member.type.rpartition("::")[2] in source.structs
            if not known and not re.search(rf"\.\s*{member.name}\b", source.text):
                continue  # a matrix that nothing reads
            yield from leaves_of(source, member, place + ".", depth + 1)
        return
    if not (width := width_of(variable.type)):
        raise ForeignError(
            f"{source.path}: {place.removeprefix(MEMBERS)} is a {variable.type}, which is no number, "
            "vector or struct of them in this file; give a function without it, or write one that calls it."
        )
    yield Leaf(place, variable.type, width, bool(_WHOLE.search(variable.type)), variable)


def match(
    source: Source,
    function: Function,
    mapping: Mapping[str, str],
    ranges: Mapping[str, tuple[float, float]],
    constants: Mapping[str, str],
    kind: str = "value",
    strict: bool = True,
) -> Matched:
    """Find out what each number is that a function needs.

    Args:
        source: with the function.
        function: to be called.
        mapping: what --map says: formulas by argument, member or uniform.
        ranges: what --range says.
        constants: what --uniform says.
        kind: of KINDS.
        strict: whether all that is given has to be found.

    Raises:
        ForeignError: something cannot be told, or a name that is given does not exist.
    """
    words = source.reached(function)
    leaves = [leaf for a in function.arguments if not a.written for leaf in leaves_of(source, a)]
    if function.owner:
        maker = constructor(source, function)
        for argument in maker.arguments if maker else ():
            leaves += leaves_of(source, argument, MADE_OF)
        # What a constructor has made stays as it is
        made = maker.words if maker else ()
        words = words | {*made}
        for member in source.structs.get(function.owner, ()):
            if member.name in words and member.name not in made:
                leaves += leaves_of(source, member, MEMBERS)
    for uniform in source.uniforms:
        if uniform.name in words and not uniform.array:
            leaves += leaves_of(source, uniform)
    bodies = "\n".join(f.body for f in source.called(function))
    for variable in source.globals:
        written = rf"(?<![\w.]){variable.name}\b\s*(?:\.\w+\s*)?(?:[-+*/]?=(?!=)|\+\+|--)"
        if variable.name in words and not re.search(written, bodies):
            leaves += leaves_of(source, variable)
    given = dict(mapping) | dict(constants)
    leaves = [leaf for leaf in leaves if _read(source, leaf, words, {*given, *ranges})]
    # Globals of the file that are named
    places = {leaf.place for leaf in leaves}
    places |= {leaf.variable.shown for leaf in leaves}
    for name in given if strict else ():
        if not any(name in (p, p.rpartition(".")[2]) for p in places):
            known = [
                leaf.variable.shown or leaf.place for leaf in leaves if not leaf.variable.fixed
            ]
            raise ForeignError(
                f"{source.path}: {function.name} needs no {name!r}; {did_you_mean(name, known)}"
                f"it needs {', '.join(known)}."
            )
    matched: list[tuple[Leaf, Expression]] = []
    notes: list[str] = []
    incident = _incident(leaves, given)
    pair = any(_plain(leaf.place.rpartition(".")[2])[0] == "nu" for leaf in leaves)
    nameless, lone = _lone_direction(leaves, given) if kind == "value" else (None, "")
    for leaf in leaves:
        last = leaf.place.rpartition(".")[2]
        last = leaf.variable.shown or last
        text = given.get(leaf.place, given.get(last))
        if text is None:
            text = _random(leaf) if kind == "sample" else ""
            if not text and leaf is nameless:
                text = "wi" if lone == "light" else "wo"
                notes.append(
                    f'{leaf.place} is taken for the {lone}; --map "{last}=..." says otherwise'
                )
            if not text and leaf is incident:
                text = "-wo"
                notes.append(
                    f'{leaf.place} is -wo, where the viewer looks; --map "{last}=wi" if not'
                )
            text = text or _guess(source, leaf, ranges, pair)
            if text in ("1", "(1, 1, 1)", "(1, 1, 1, 1)") and _LIT.search(leaf.place):
                notes.append(f'{leaf.place} is 1, as it is the light; --map "{last}=..." if not')
            if (
                text in ("(0, 0, 0)", "(0, 0, 0, 1)", "wi", "wo")
                and leaf.width >= 3
                and _position(leaf)
            ):
                notes.append(
                    f'{leaf.place} is a position: {text}; --map "{last}=..." says otherwise'
                )
            if leaf.whole and not leaf.variable.fixed:
                notes.append(f"{leaf.place} is {text}; --uniform {last}=1 for another")
        matched.append((leaf, parse(text)))
    used = set().union(*(e.names for _, e in matched)) if matched else set()
    for what, enough in (
        ("the light", {"wi", "cos_i", "half", "cos_d", "cos_h", "cos_v", "cos_tangent_i"}),
        ("the viewer", {"wo", "cos_o", "half", "cos_d", "cos_h", "cos_v", "cos_tangent_o"}),
    ):
        if what == "the light" and kind in ("sample", "albedo"):
            continue
        if not used & enough:
            if what == "the viewer" and all(
                leaf.width not in (3, 4)
                or set(e.names) & set(ROLES)
                or _COLOURED.search(leaf.place)
                for leaf, e in matched
            ):
                notes.append("it has no argument for the viewer: all directions see the same")
                continue
            role = "wi" if what == "the light" else "wo"
            arrays = [
                f"{u.name}[{u.array}]" for u in source.uniforms if u.array and u.name in words
            ]
            more = f" (arrays such as {arrays[0]} cannot be set)" if arrays else ""
            raise ForeignError(
                f"{source.path}: {function.signature} has no argument for {what}{more}; say "
                f'which one it is with --map "NAME={role}".'
            )
    parameters: dict[str, Parameter] = {}
    for leaf, expression in matched:
        for name in sorted(expression.names - set(ROLES)):
            width = leaf.width if expression.alone == name and leaf.width >= 3 else 1
            if name not in parameters:
                parameters[name], assumed = _declared(name, min(width, 3), leaf, ranges)
                if assumed:
                    notes.append(assumed)
    if (unknown := set(ranges) - set(parameters)) and strict:
        name = sorted(unknown)[0]
        raise ForeignError(
            f"{source.path}: there is no parameter {name!r} for --range; {did_you_mean(name, parameters)}"
            f"there are {', '.join(parameters) or 'none'}."
        )
    if kind == "sample" and not used & set(RANDOM):
        raise ForeignError(
            f"{source.path}: {function.signature} has no random numbers; say which they are with "
            '--map "NAME=(u1, u2)".'
        )
    return Matched(tuple(matched), parameters, tuple(notes), kind)


def _read(source: Source, leaf: Leaf, words: Container[str], given: Container[str]) -> bool:
    """Whether code reads a member of a struct; all else counts as read."""
    last = leaf.place.rpartition(".")[2]
    if "." not in leaf.place or source.entry or leaf.variable.shown:
        return True
    if last in words or last in given or leaf.place in given or leaf.variable.name in words:
        return True
    return re.search(rf"\b{re.escape(last)}\b", source.headers) is not None


def _plain(name: str) -> tuple[str, str]:
    """A name in lower case without underscores, and without a prefix such as u_ as well."""
    low = name.lower()
    return low.replace("_", ""), re.sub(
        r"^(?:[uvagip]|in|arg|param|shading|frag)_+", "", low
    ).replace("_", "")


# Parts of longer names, the first that fits: geometryViewDir, sunDirectionWS, worldSpaceNormal.
_PARTS = (
    ("half", r"half"),
    ("bitangent", r"bitangent|binormal"),
    ("tangent", r"tangent"),
    ("normal", r"normal(?!i[sz])"),
    ("wi", r"(?:light|sun|lamp|incoming|incident)\w*(?:dir|vec)|^to(?:light|sun|lamp)"),
    ("wo", r"(?:view|eye|cam|outgoing)\w*(?:dir|vec)|^to(?:view|eye|cam)"),
)


def _position(leaf: Leaf) -> bool:
    """Whether a vector is a point; p may be a colour of a model that has it in a struct."""
    owner, _, last = (leaf.variable.shown or leaf.place).rpartition(".")
    plain = _plain(last)[0]
    if plain == "p":
        return (
            not owner or re.search(r"hit|surf|geo|vert|isect|frag|point", owner, re.I) is not None
        )
    return re.search(r"pos(ition)?(ws)?$|^hit$|^point$", plain) is not None


def direction_of(leaf: Leaf) -> str:
    """The direction that the name of a vector means; empty if it tells nothing."""
    last = leaf.variable.shown or leaf.place.rpartition(".")[2]
    plain, bare = _plain(last)
    for role, names in DIRECTIONS.items():
        if plain in names.split() or bare in names.split():
            return role
    # Of a struct: directLight.direction
    whole = leaf.place.replace(".", "").lower() if plain in ("direction", "dir", "vec") else plain
    if re.search(r"colou?r|pos(ition)?$|albedo|tint", plain):
        return ""
    return next((role for role, pattern in _PARTS if re.search(pattern, whole)), "")


def is_role(place: str, role: str) -> bool:
    """Whether a name is one of those of a direction."""
    return bool(
        {*_plain(place.rpartition(".")[2])} & {*DIRECTIONS[role].split(), "direction", "dir"}
    )


# What a vector that is no direction is called.
_COLOURED = re.compile(
    r"albedo|colou?r|diffuse|spec|f0|f90|\bk_?[ads]$|rho|base|tint|reflect|sheen|radiance|intensity",
    re.I,
)


def _incident(leaves: Iterable[Leaf], given: Container[str]) -> Leaf | None:
    """The I of reflect(I, N), which leads to the surface, if there is a light beside it and no viewer."""
    found, roles = None, set()
    for leaf in leaves:
        last = leaf.variable.shown or leaf.place.rpartition(".")[2]
        if leaf.width != 3 or leaf.place in given or last in given:
            continue
        names = set(_plain(last))
        if names & {"i", "incident"}:
            found = leaf
        else:
            roles.add(direction_of(leaf))
    return found if "wi" in roles and "wo" not in roles else None


# What belongs to the light, and how bright it is.
_LIT = re.compile(r"light|lamp|sun|radiance|attenuation|shadow|visibility", re.I)
_BRIGHT = re.compile(
    r"colou?r$|intensity|radiance|power$|energy$|attenuation|strength|^light$|shadow|visibility",
    re.I,
)

_DIRECTION = re.compile(r"dir(ection)?$|vec(tor)?$")


def _lone_direction(leaves: Iterable[Leaf], given: Container[str]) -> tuple[Leaf | None, str]:
    """The one vector that is called a direction and is not known, where one direction alone is missing.

    What the others are tells which: "light" or "viewer".
    """
    found, roles = [], set()
    for leaf in leaves:
        last = leaf.variable.shown or leaf.place.rpartition(".")[2]
        if leaf.width not in (3, 4):
            continue
        known = direction_of(leaf)
        if leaf.place in given or last in given:
            return None, ""  # who maps one direction says all that is not clear
        if known:
            roles.add(known)
        elif _DIRECTION.search(_plain(last)[0]):
            found.append(leaf)
    missing = [name for role, name in (("wi", "light"), ("wo", "viewer")) if role not in roles]
    if len(found) == 1 and len(missing) == 1:
        return found[0], missing[0]
    return None, ""


def _random(leaf: Leaf) -> str:
    """The random numbers that a name suggests."""
    plain, bare = _plain(leaf.place.rpartition(".")[2])
    if leaf.width in (2, 3) and {plain, bare} & set(_RANDOM_VECTORS.split()):
        return "(u1, u2)" if leaf.width == 2 else "(u1, u2, u3)"
    for role, names in RANDOM.items():
        if leaf.width == 1 and {plain, bare} & set(names.split()):
            return role
    return ""


def _guess(source: Source, leaf: Leaf, ranges: Container[str], pair: bool) -> str:
    """The role that a name suggests, else a parameter of that name.

    Args:
        source: for messages.
        leaf: what is to be set.
        ranges: names of parameters that the user knows.
        pair: whether there is a nu, so that nv is an exponent.
    """
    last = leaf.variable.shown or leaf.place.rpartition(".")[2]
    # A struct inside of a struct: params.base.rho is base_rho, beside params.rho
    name = leaf.variable.shown or "_".join(leaf.place.split(".")[1:]) or last
    name = name.rstrip("_") or name  # gamma_ where gamma is a word of the language
    plain, bare = _plain(last)
    default = leaf.variable.default
    if leaf.variable.fixed and last not in ranges:
        shown = [f"{x:.9g}" for x in default or (0.0,) * leaf.width]
        return shown[0] if leaf.width == 1 else f"({', '.join(shown)})"
    if leaf.variable.shown and leaf.width == 2:
        return f"({last}, {last})"
    if leaf.variable.shown and not leaf.whole:
        return last
    if leaf.whole:
        return f"{leaf.variable.default[0]:g}" if leaf.variable.default else "0"
    wide = leaf.width in (3, 4)  # the fourth number is 1
    if leaf.width == 4 and (role := direction_of(leaf)):
        return role
    if (leaf.width == 1 or wide) and _LIT.search(leaf.place) and _BRIGHT.search(last):
        return "1" if leaf.width == 1 else f"(1, 1, 1{', 1' * (leaf.width - 3)})"
    if wide:
        if role := direction_of(leaf):
            return role
        if _position(leaf):
            # Of a surface in the origin, with the light and the viewer at a distance of 1
            light, viewer = (re.search(w, plain) for w in ("light|lamp|sun", "cam|eye|view"))
            origin = "(0, 0, 0)" if leaf.width == 3 else "(0, 0, 0, 1)"
            return "wi" if light else "wo" if viewer else origin
        if re.search(r"dir(ection)?$|vec(tor)?$|normal(?!i[sz])|tangent", plain):
            raise ForeignError(
                f"{source.path}: cannot tell what {leaf.place} ({leaf.type}) is; say it with "
                f'--map "{last}=wi", or wo, normal, tangent, bitangent, half, or (0, 0, 1).'
            )
    if leaf.width == 1 and leaf.variable.low is None and not (plain == "nv" and pair):
        for role, names in COSINES.items():
            if plain in names.split() or bare in names.split():
                return role
    if leaf.width == 2 and re.search(r"uv|tex_?coord|^st$", plain):
        return "(0.5, 0.5)"
    if leaf.width == 2:
        raise ForeignError(
            f"{source.path}: cannot tell what {leaf.place} ({leaf.type}) is; say it with "
            f'--map "{last}=(0.5, 0.5)".'
        )
    return name


def _declared(
    name: str, width: int, leaf: Leaf, ranges: Mapping[str, tuple[float, float]]
) -> tuple[Parameter, str]:
    """Range and default of a parameter, and what was assumed."""
    variable = leaf.variable
    if name in ranges:
        low, high = ranges[name]
        middle = variable.default[0] if variable.default else 0.5 * (low + high)
        return Parameter(float(np.clip(middle, low, high)), low, high, name, name, width), ""
    if variable.low is not None and variable.high is not None:
        default = variable.default if width == 3 else variable.default[0]
        return Parameter(default, variable.low, variable.high, name, name, width), ""
    for cls in models().values():
        known = cls.fields.get(name)
        if isinstance(known, Parameter) and known.width == width and np.isfinite(known.high):
            low, high, default = known.low, known.high, known.default
            break
    else:
        low, high, default = 0.0, 1.0, 0.5
        words = re.sub(
            r"(?<=[a-z])(?=[A-Z])", "_", name
        ).lower()  # materialIor; metallic has no eta
        for pattern, a, b, c in SUGGESTED:
            if width == 1 and re.search(pattern, words):
                low, high, default = a, b, c
    if len(variable.default) == width:
        default = variable.default if width == 3 else variable.default[0]
        low, high = min([low, *variable.default]), max([high, *variable.default])
    text = f"{name} is taken from {low:.4g} to {high:.4g}; --range {name}={low:.4g}..{high:.4g} for another"
    return Parameter(default, low, high, name, name, width), text


def environment(wi: Array, wo: Array) -> dict[str, Array]:
    """Values of all roles, in the local frame, for directions (n, 3)."""
    n = len(wi)
    h = wi + wo
    h = h / np.maximum(np.linalg.norm(h, axis=1, keepdims=True), 1e-300)
    x, y, z = (np.tile(axis, (n, 1)) for axis in np.eye(3))
    return {
        "wi": wi,
        "wo": wo,
        "normal": z,
        "tangent": x,
        "bitangent": y,
        "half": h,
        "cos_i": wi[:, 2],
        "cos_o": wo[:, 2],
        "cos_h": h[:, 2],
        "cos_d": (wi * h).sum(1),
        "cos_v": (wi * wo).sum(1),
        "cos_tangent_h": h[:, 0],
        "cos_bitangent_h": h[:, 1],
        "cos_tangent_i": wi[:, 0],
        "cos_bitangent_i": wi[:, 1],
        "cos_tangent_o": wo[:, 0],
        "cos_bitangent_o": wo[:, 1],
    }
