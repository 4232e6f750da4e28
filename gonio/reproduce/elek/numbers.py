"""What the sentences say."""

from __future__ import annotations

import math

import numpy as np

import gonio
from gonio.arrays.elementwise import elementwise
from gonio.bake import tables
from gonio.mitsuba import textures
from gonio.parts import fresnel, metals
from gonio.render.passes import ready_mitsuba
from gonio.reproduce.elek import TEXT, formulas
from gonio.reproduce.elek.figures import half_width, mip_level, printed_albedo
from gonio.reproduce.measure import directions, gray
from gonio.reproduce.sheet import Sheet


@TEXT.item("tarnish", "section 4.2", "the copper is modulated with a dark-orange tone")
def tarnish(sheet: Sheet) -> None:
    bare = gonio.Patina(extent=-1.0, tarnish=0.0, bare_alpha=0.3)
    w = directions(0.3), directions(0.3, math.pi)
    tone = bare.replace(tarnish=1.0).eval(*w) / bare.eval(*w)
    sheet.claim("red over blue of the tone", ">=", "1", float(tone[0] / tone[2]), why="orange")
    sheet.claim("its luminance", "<=", "0.5", float(tone @ (0.2126, 0.7152, 0.0722)), why="dark")


@TEXT.item("thickness", "sections 3 and 4.2", "a map of the thickness, a map of the roughness")
def thickness(sheet: Sheet) -> None:
    coat = gonio.WeidlichWilkie(
        sigma_a=(0.1, 1, 1), thickness=np.array([0.2, 1.0]), alpha=np.array([0.1, 0.3])
    )
    found = np.asarray(coat.eval(directions(0.3), directions(0.3, 2.0)))
    sheet.claim("values of two points with a thickness and a roughness each", "=", "2", len(found))
    sheet.claim(
        "blue of the thick point over that of the thin", "<=", "1", float(found[1, 2] / found[0, 2])
    )


@TEXT.item("morelayers", "section 3", "more layers by recursion")
def more_layers(sheet: Sheet) -> None:
    inner = gonio.WeidlichWilkie(base="eon")
    coats = gonio.WeidlichWilkie(base=gonio.WeidlichWilkie(base=inner))
    sheet.claim(
        "a value of three coats",
        ">=",
        "0",
        float(gray(coats)(directions(0.3), directions(0.5, 1.0))),
    )


@TEXT.item("phonglayers", "section 3.1", "even Phong can be a layer")
def phong_layers(sheet: Sheet) -> None:
    coat = gonio.WeidlichWilkie(base="phong")
    sheet.claim(
        "a value of a coat over Phong",
        ">=",
        "0",
        float(gray(coat)(directions(0.3), directions(0.5, 1.0))),
    )
    sheet.remark(
        "as a base; as a coat it would need a transmission of its own, of which the text has no formula"
    )


@TEXT.item("7dof", "section 3.1", "F has 7 degrees of freedom")
def degrees_of_freedom(sheet: Sheet) -> None:
    index = metals.metal("Cu")
    given = np.concatenate([[0.3], np.ravel(index["eta"]), np.ravel(index["k"])])

    def F(values: np.ndarray) -> np.ndarray:
        return np.asarray(elementwise(fresnel.F_conductor, values[0], values[1:4], values[4:]))

    step = 1e-3 * np.eye(len(given))
    matter = [float(np.abs(F(given + one) - F(given)).max()) > 0 for one in step]
    sheet.claim(
        "numbers that change F of a metal: the angle, n and kappa of three colours",
        "=",
        "7",
        sum(matter),
    )


@TEXT.item("f3", "section 3.1", "F is evaluated three times")
def three_fresnels(sheet: Sheet) -> None:
    wi, wo = (directions(a)[None] for a in (0.3, 0.5))
    evaluated = []

    def F(cos: np.ndarray, n: float, k: float = 0.0) -> np.ndarray:
        evaluated.append(n)
        return formulas.lazanyi(cos, n, k)

    def base(i: np.ndarray, o: np.ndarray) -> np.ndarray:
        return formulas.torrance_sparrow(0.3, F(formulas.half(i, o)[1], 0.2, 3.9), i, o)

    formulas.layered(1.5, 0.1, 0.0, base, wi, wo, F)
    F(wo[..., 2], 1.5)  # Algorithm 1, line 28: of the environment
    sheet.claim("calls of F in Eq. 2 to 4 and line 28 of Algorithm 1", "=", "3", len(evaluated))


@TEXT.item("mip", "section 3.1", "disable MIP-mapping of the table of D")
def mip(sheet: Sheet) -> None:
    table = tables.distribution_table("beckmann")
    for level, relation in ((0, "<="), (3, ">=")):
        error = tables.distribution_error(mip_level(table, level), "beckmann", 8, 0.01).largest
        sheet.claim(
            f"largest error over the peak at m 0.01, level {level}",
            relation,
            1 / 255,
            error,
            why="a step of 8 bits",
        )


def _table(symbol: str) -> tables.Table:
    index = metals.metal(symbol)
    return tables.fresnel_table(index["eta"], index["k"])


@TEXT.item("128", "section 3.1", "128 samples of F suffice")
def samples_128(sheet: Sheet) -> None:
    for symbol in ("Cu", "Au"):
        index = metals.metal(symbol)
        error = tables.fresnel_error(_table(symbol), index["eta"], index["k"]).largest
        sheet.claim(
            f"{symbol}: largest error of a table of 128",
            "<=",
            1 / 255,
            error,
            why="a step of 8 bits",
        )


@TEXT.item("384", "section 3.1", "384 bytes as R8G8B8")
def bytes_384(sheet: Sheet) -> None:
    table = _table("Cu")
    eight_bits = np.uint8(np.round(np.clip(table, 0, 1) * 255))
    sheet.claim("bytes of gonio's table in 8 bits", "=", "384", eight_bits.nbytes)


@TEXT.item("atlas", "section 3.1", "hundreds of materials in tens of kB")
def atlas(sheet: Sheet) -> None:
    rows = [_table(symbol) for symbol in metals.metals()]
    each = np.uint8(np.round(np.clip(np.stack(rows), 0, 1) * 255)).nbytes / len(rows)
    sheet.claim("kB of 200 rows of gonio's tables", "<=", "99", 200 * each / 1000)


@TEXT.item("lazanyi", "section 3.1", "Lazanyi and Szirmay-Kalos deviate by 5 % at most")
def lazanyi(sheet: Sheet) -> None:
    cos = np.linspace(0.0005, 1, 4001)
    for symbol in ("Ag", "Au", "Cu", "Al", "Cr"):
        index = metals.metal(symbol)
        ours = theirs = 0.0
        for eta, k in zip(index["eta"], index["k"], strict=True):
            exact = formulas.conductor(cos, eta, k)
            fit = elementwise(fresnel.F_lazanyi, cos, eta, k) - elementwise(
                fresnel.F_conductor, cos, eta, k
            )
            ours = max(ours, float(np.abs(fit).max()))
            theirs = max(theirs, float(np.abs(formulas.lazanyi(cos, eta, k) - exact).max()))
        if theirs <= 0.055:
            sheet.claim(
                f"{symbol}: largest difference from the exact F",
                "<=",
                "0.055",
                ours,
                why="5 %, rounded",
            )
        else:
            sheet.refute(
                f"{symbol}: largest difference from the exact F",
                "<=",
                "0.05",
                ours,
                proof=theirs,
                within=1e-6,
                why="Fresnel's equations in complex numbers: metals of much absorption dip "
                "before the horizon",
            )


@TEXT.item("u8", "section 3.1", "u^8 can be computed in 3 multiplications")
def power_8(sheet: Sheet) -> None:
    u, count = 0.7, 0
    power = u
    while power > u**8 * 1.0000001:
        power, count = power * power, count + 1
    sheet.claim("squarings until u^8", "=", "3", count)
    table = tables.distribution_table("beckmann", 65)
    at = float(
        tables.look_up_distribution(table, math.pi / 2 * (32 / 64) ** 8, tables.ALPHA_LOW**0.5)
    )
    sheet.claim(
        "the middle entry of a row, looked up at u^8",
        "=",
        float(table[32, 32]),
        at,
        within=1e-4 * at,
    )
    sheet.remark(
        "that builds the table; a lookup by the angle needs the inverse, three square roots"
    )


@TEXT.item("002", "section 3.1", "the linear mapping begins to show below m = 0.02")
def linear_mapping(sheet: Sheet) -> None:
    linear = tables.distribution_table("beckmann", exponent=1)
    errors = {
        m: tables.distribution_error(linear, "beckmann", 1, m).largest for m in (0.01, 0.02, 0.05)
    }
    sheet.claim(
        "largest error over the peak at m 0.01", ">=", 1 / 255, errors[0.01], why="a step of 8 bits"
    )
    sheet.claim("the same at m 0.05", "<=", 1 / 255, errors[0.05])
    sheet.show("the same at m 0.02", errors[0.02])


@TEXT.item("512", "section 3.1", "512 x 512 in 16 bit floating point: 0.5 MB")
def table_512(sheet: Sheet) -> None:
    table = tables.distribution_table("beckmann")
    half_floats = table.astype(np.float16)
    sheet.claim("MB of gonio's table in 16 bits", "=", "0.5", half_floats.nbytes / 2**20)
    sheet.claim(
        "largest value of the table: it fits into 16 bits", "<=", "65504", float(table.max())
    )
    sheet.show("printed D of m = 1/511 at its peak, which does not", 511.0**2)


@TEXT.item("g", "section 3.1", "G leaves a few multiplications and two divisions")
def divisions(sheet: Sheet) -> None:
    wi, wo = directions(0.9), directions(0.4, 2.0)
    model = gonio.TorranceSparrow(masking="cook_torrance", fresnel="white", distribution="beckmann")
    n, h = formulas.half(wi, wo)
    code = min(1.0, min(wo[2] * (2 * n) / h, wi[2] * (2 * n) / h))
    f = float(gray(model)(wi, wo))
    D = float(formulas.D(0.3, n)) / math.pi
    sheet.claim(
        "G by the two quotients of Appendix B",
        "=",
        float(code),
        f * 4 * wi[2] * wo[2] / D,
        within=1e-9,
    )


@TEXT.item("m2", "section 3", "m2 is clamped to m1")
def clamp(sheet: Sheet) -> None:
    def below(m: float) -> gonio.Model:
        return gonio.WeidlichWilkie(alpha=0.4, base=gonio.TorranceSparrow(alpha=m))

    sheet.claim(
        "half width of m2 = 0.05 over that of m2 = 0.4, under m1 = 0.4",
        "=",
        "1",
        half_width(below(0.05)) / half_width(below(0.4)),
        within=1e-6,
    )


@TEXT.item("m", "section 2.1", "the roughness m is from 0 to 1")
def roughness(sheet: Sheet) -> None:
    declared = gonio.TorranceSparrow.fields["alpha"]
    sheet.claim("highest m", "=", "1", float(getattr(declared, "high", math.nan)), within=0)
    sheet.claim(
        "lowest m", "<=", "0.001", float(getattr(declared, "low", math.nan)), why="0 is no function"
    )


@TEXT.item(
    "transition", "section 4.2", "transition from 0 to 1, extent from -transition to 1 + transition"
)
def transition(sheet: Sheet) -> None:
    extent, soft = (gonio.Patina.fields[name] for name in ("extent", "transition"))
    sheet.claim("lowest extent", "=", "-1", float(getattr(extent, "low", math.nan)), within=0)
    sheet.claim("highest extent", "=", "2", float(getattr(extent, "high", math.nan)), within=0)
    sheet.claim("highest transition", "=", "1", float(getattr(soft, "high", math.nan)), within=0)
    sheet.claim(
        "lowest transition",
        "<=",
        "0.001",
        float(getattr(soft, "low", math.nan)),
        why="0 divides by 0",
    )


@TEXT.item("tiles", "section 4.1", "the normal map is tiled 1000 times")
def tiles(sheet: Sheet) -> None:
    ready_mitsuba()
    node = textures.flake_texture(textures.flake_map(16), tiles=1000.0)
    sheet.claim("a texture of 1000 tiles can be made: entries of its node", ">=", "1", len(node))


@TEXT.item("nearest", "section 4.1", "no filtering of the flakes' map")
def nearest(sheet: Sheet) -> None:
    ready_mitsuba()
    node = textures.flake_texture(textures.flake_map(16))
    sheet.claim("'nearest' stands in the texture's node", "=", "1", float("nearest" in repr(node)))


@TEXT.item("albedo", "section 2.1", "physically plausible: the albedo is at most 1")
def albedo(sheet: Sheet) -> None:
    theta = math.radians(85)
    model = gonio.WeidlichWilkie(eta=1.5, alpha=0.3, base=gonio.Lambert(rho=1))
    sheet.refute(
        "albedo of Eq. 2 over white Lambert, 85 degrees",
        "<=",
        "1",
        float(model.albedo(directions(theta))[0]),
        proof=printed_albedo(theta),
        within=1e-2,
        why="the paper's own recurrence, integrated: what enters at the half vector's angle is "
        "more than arrives",
    )
    honest = model.replace(transmission="both_ways", solid_angle="compressed")
    sheet.claim(
        "the same with gonio's options", "<=", "1", float(honest.albedo(directions(theta))[0])
    )
