"""The random walk: position-free paths through a stack, in one loop for values, densities and samples.

Guo, Hašan, Zhao, "Position-free Monte Carlo simulation for arbitrary layered BSDFs", SIGGRAPH Asia 2018.
Layers are plane and endless, so a path is a sequence of surfaces and directions, without places. A walk
starts at the viewer. At each of its events the light is connected to it: the light's own path goes
straight down through the surfaces above the event, refracted at a facet of each that is sampled (at smooth
ones there is nothing to sample). A path whose last events are refractions can so be made in several ways:
the walk makes its first directions and the light the others. Multiple importance sampling by the balance
heuristic (Veach 1997, section 9.2.2) gives each way the share of its density in the sum of all.

A lane of a kernel does one walk after the other for the same pair of directions, so that no lane waits for
others with longer walks.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import drjit as dr

from gonio.lang import (
    MU_MIN,
    Color,
    Float,
    Mask,
    Sample,
    Vec2,
    Vec3,
    absolute,
    exp,
    maximum,
    minimum,
    select,
    vec2,
    vec3,
)
from gonio.model import Model
from gonio.reference.interfaces import (
    RIVALS_MAX,
    TINY,
    Bend,
    Event,
    Pile,
    Rough,
    chance,
    channels,
    compression,
)

Quantity = Literal["value", "density", "sample"]
"""What a walk is for: the BRDF's value, the density of samples, or a sample with its weight."""

# Walks may be ended at random when they arrive at something from above, in proportion to what they still
# carry, but not before they have met so many surfaces. On the way up none ends: the densities of the
# light's paths, which are ways up, would have to tell how much the walk had carried there.
EVENTS_CERTAIN = 2

# Surfaces after which every walk may be ended, and with what probability it then goes on. Light that a
# sharp and lossless base keeps beyond the angle of total reflection would otherwise walk for ever.
EVENTS_LONG, LONG_SURVIVAL = 64, 0.95

# Random numbers come in steps of 1e-7, and a probability must be much larger than one.
SURVIVAL_MIN = 0.01


@dataclass(frozen=True)
class Channels:
    """A base with more than three channels: a copy of the model for every three of them."""

    models: Sequence[Model]
    count: int

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """BRDF value in 1/sr, with all channels."""
        colours = [m.eval(wi, wo) for m in self.models]
        found = [c for colour in colours for c in _three(colour)][: self.count]
        wide = dr.expr_t(*found)
        if not dr.is_array_v(wide):
            return dr.scalar.Array4f64(*found)
        return dr.replace_shape_t(wide, (self.count, -1))(*found)

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample` in 1/sr."""
        return self.models[0].pdf(wi, wo)

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """A direction that the first copy chooses."""
        return self.models[0].sample(wo, u)


@dataclass(frozen=True)
class Scene:
    """A stack whose numbers are values of a kernel."""

    surfaces: Sequence[Rough | Pile]
    """From the top down."""
    etas: Sequence[Float]
    """Index below over index above of each surface."""
    n2: Sequence[Float]
    """Squared index below each surface, over that above the stack."""
    depths: Sequence[Color]
    """Optical depth of the slab below each surface."""
    base: Model | Channels

    def colour(self, x: Float) -> Color:
        """Grey, with as many channels as the absorption has."""
        return type(self.depths[0])(x)


class Link(NamedTuple):
    """The light's path from outside down to one surface, and what MIS has to know of it."""

    d: Vec3
    """Direction towards the light above that surface."""
    weight: Color
    """What is left of the light."""
    inverse: Float
    """Density with which a walk would take the same path upwards, over that of the light."""
    rivals: Float
    """Sum of the densities of the other ways, in which the walk makes directions of this path itself, over
    that of this one and over the walk's density at d; 0 where there are none."""

    def share(self, density: Float, before: Float = 0) -> Float:
        """The share of this way, if the walk would sample d with `density`.

        before: the same sum for ways in which the light makes more of the path.
        """
        return 1 / (1 + density * self.rivals + before)


@dataclass
class State:
    """One lane of the loop."""

    done: Any
    level: Any
    """The surface that the walk has arrived at; the base is the number of surfaces."""
    a: Any
    """Where it came from: a.z > 0 from above, a.z < 0 from below."""
    weight: Any
    density: Any
    """With which the walk sampled its direction."""
    rivals: Any
    """Sum of the densities of the ways in which the light makes the walk's direction and perhaps some
    before it, over the walk's own; apart from the factor light / walk of this direction."""
    events: Any
    found: Any
    """Sum over this walk's connections."""
    total: Any
    squares: Any
    exit: Any
    specular: Any
    """The walk has met smooth surfaces only."""
    rng: Any


def negated(mask: Any) -> Any:
    """The opposite of a mask or a Python bool."""
    return not mask if isinstance(mask, bool) else ~mask


def at(values: Sequence[Any], level: Any) -> Any:
    """The value of each lane's own level."""
    found = values[-1]
    for k in range(len(values) - 2, -1, -1):
        found = select(level == k, values[k], found)
    return found


def light_path(scene: Scene, wi: Vec3, draw: Callable[[], Float] | None) -> list[Link]:
    """The light's way down to each surface and to the base; `draw` gives the facets' random numbers."""
    zero = 0 * wi.z
    links = [Link(wi, scene.colour(zero + 1), zero + 1, 0)]
    for k, surface in enumerate(scene.surfaces):
        before, eta, depth = links[-1], scene.etas[k], scene.depths[k]
        lit = before.d.z > 0
        a = _upwards(lit, before.d)
        rivals: Float
        if isinstance(surface, Rough):
            assert draw is not None
            d, weight, light, up = surface.light(a, eta, vec2(draw(), draw()))
            inverse = before.inverse * up / maximum(light, TINY)
            rivals = (1 + up * before.rivals) / maximum(light, TINY)
        else:
            bend = surface.bend(a.z, True)
            d, weight = vec3(a.x / eta, a.y / eta, bend.cos_out), bend.transmitted
            back = surface.bend(maximum(d.z, MU_MIN), False)
            step = chance(back) * compression(maximum(d.z, MU_MIN), a.z, 1 / eta)
            inverse, rivals = before.inverse * step, before.rivals * step
        through = lit & (d.z > 0)
        crossed = exp(-depth / maximum(d.z, MU_MIN))
        weight = select(through, before.weight * weight * crossed, 0)
        inverse = select(through, inverse, 0)
        rivals = select(through, minimum(rivals, RIVALS_MAX), 0)
        links.append(Link(d, weight, inverse, rivals))
    return links


def walk(
    scene: Scene, wo: Vec3, wi: Vec3 | None, rng: Any, walks: Any, quantity: Quantity, Float: Any
) -> State:
    """Walk `walks` times from wo, which is above the horizon, in every lane of `rng`.

    Args:
        scene: the stack.
        wo: the viewer.
        wi: the direction to connect to, above the horizon; None for samples.
        rng: a Dr.Jit generator of random numbers, with its own sequence in each lane.
        walks: how many; a number or one for each lane.
        quantity: "value" sums the BRDF without what the topmost facets mirror at once (see `direct`);
            "density" sums the density of samples at wi, likewise; "sample" sums weights.
        Float: number type of the kernel.
    """
    walker = _Walker(scene, wo, wi, quantity, Float, rng)
    (state,) = dr.while_loop(
        (walker.begin(),),
        lambda state: state.done < walks,
        walker.step,
        max_iterations=-1,
        label="gonio_reference",
    )
    return state  # type: ignore[no-any-return]


def direct(scene: Scene, wi: Vec3, wo: Vec3) -> tuple[Float, Float]:
    """What the topmost facets mirror at once: the BRDF's value, and the density of such samples."""
    surface = scene.surfaces[0]
    if isinstance(surface, Pile):  # a mirror's reflection is no function
        return 0 * wo.z, 0 * wo.z
    once = surface.connect(wo, wi, scene.etas[0], True)
    return once.value, once.density


class _Walker:
    """The steps of a walk for one quantity."""

    def __init__(
        self, scene: Scene, wo: Vec3, wi: Vec3 | None, quantity: Quantity, Float: Any, rng: Any
    ) -> None:
        self.scene, self.wi, self.quantity, self.Float, self.rng = scene, wi, quantity, Float, rng
        self.base_level = len(scene.surfaces)
        self.width = 1 if Float is float else dr.width(rng.state)
        self.start = self._wide(wo)
        self.rough = [isinstance(s, Rough) for s in scene.surfaces]
        # A path with nothing to sample is the same for all walks.
        self.fixed = wi is not None and not any(self.rough)
        self.links = light_path(scene, wi, None) if wi is not None and self.fixed else []

    def _number(self, x: float) -> Any:
        return x if self.Float is float else dr.full(self.Float, x, self.width)

    def _whole(self, x: int) -> Any:
        return x if self.Float is float else dr.full(dr.uint32_array_t(self.Float), x, self.width)

    def _mask(self, x: bool) -> Any:
        return x if self.Float is float else dr.full(dr.mask_t(self.Float), x, self.width)

    def _wide(self, w: Vec3) -> Vec3:
        zero = self._number(0)
        return vec3(w.x + zero, w.y + zero, w.z + zero)

    def _colour(self, x: float) -> Color:
        return self.scene.colour(self._number(x))

    def begin(self) -> State:
        """The state before the first walk."""
        return State(
            done=self._whole(0),
            level=self._whole(0),
            a=self.start,
            weight=self._colour(1),
            density=self._number(0),
            rivals=self._number(0),
            events=self._whole(0),
            found=self._colour(0),
            total=self._colour(0),
            squares=self._colour(0),
            exit=vec3(self._number(0), self._number(0), self._number(0)),
            specular=self._mask(True),
            rng=self.rng,
        )

    def step(self, state: State) -> tuple[State]:
        """One event at the base, for walks that are there, and one at a surface, for all."""
        self.rng = state.rng
        links = self.links
        if self.wi is not None and not self.fixed:
            links = light_path(self.scene, self.wi, self._draw)
        self._at_base(state, links)
        self._at_surface(state, links)
        return (state,)

    def _draw(self) -> Float:
        return self.rng.next_float64() if self.Float is float else self.rng.next_float(self.Float)

    def _at_base(self, state: State, links: Sequence[Link]) -> None:
        scene, below = self.scene, len(self.scene.surfaces)
        here = state.level == below
        a = _upwards(here & (state.a.z > 0), state.a)
        survival = _survival(state)
        if links:
            link = links[below]
            d = _upwards(link.d.z > 0, link.d)
            density = scene.base.pdf(d, a) if self.quantity == "density" or not self.fixed else 0
            share = link.share(density)
            if self.quantity == "value":
                gain = state.weight * link.weight * scene.base.eval(d, a) * (share / scene.n2[-1])
            else:
                gain = scene.colour(survival * density * link.inverse * share)
            state.found = state.found + select(here, gain, 0)
        alive = self._draw() < survival
        w, density = scene.base.sample(a, vec2(self._draw(), self._draw()))
        sampled = alive & (density > 0)
        w = _upwards(sampled, w)
        scale = w.z / select(sampled, density, 1)
        crossed = exp(-scene.depths[-1] / maximum(w.z, MU_MIN))
        weight = select(sampled, scene.base.eval(w, a) * (crossed * scale / survival), 0)
        state.weight = select(here, state.weight * weight, state.weight)
        state.a = select(here, -w, state.a)
        state.density = select(here, density, state.density)
        state.rivals = select(here, 1, state.rivals)
        state.specular = state.specular & (state.level != below)
        state.level = select(here, self._whole(below - 1), state.level)

    def _at_surface(self, state: State, links: Sequence[Link]) -> None:
        scene, level = self.scene, state.level
        from_above = state.a.z > 0
        a = vec3(state.a.x, state.a.y, maximum(absolute(state.a.z), MU_MIN))
        down = at(scene.etas, level)
        eta = select(from_above, down, 1 / down)

        survival: Float = 1
        if self.base_level > 1:
            survival = select(from_above, _survival(state), 1)
        if links and any(self.rough):
            gain = self._connected(state, a, from_above, eta, links)
            if self.quantity == "density":
                gain = gain * survival
            state.found = state.found + gain
        event = self._scattered(state, a, from_above, eta)
        state.weight = state.weight * event.weight
        if self.base_level > 1:
            state.weight = select(self._draw() < survival, state.weight / survival, 0)
        state.density = event.density
        state.rivals = event.rivals
        state.specular = state.specular & at([not r for r in self.rough], level)

        upwards = from_above != event.transmitted
        z = select(from_above, event.w.z, -event.w.z)
        w = vec3(event.w.x, event.w.y, z)
        leaves = upwards & (level == 0)
        slab = select(upwards, select(level == 0, level, level - 1), level)
        crossed = exp(-at(scene.depths, slab) / maximum(absolute(z), MU_MIN))
        state.weight = select(leaves, state.weight, state.weight * crossed)
        carries = _most(state.weight) > 0
        ends = leaves | negated(carries)
        if self.quantity == "sample":
            left = leaves & carries
            state.found = select(left, state.weight, 0)
            state.exit = select(left, w, state.exit)

        # A walk that has ended is reckoned up, and the next one starts.
        found, zero = state.found, 0 * state.found
        state.total = state.total + select(ends, found, zero)
        state.squares = state.squares + select(ends, found * found, zero)
        state.found = select(ends, zero, found)
        state.done = select(ends, state.done + 1, state.done)
        state.level = select(ends, 0, select(upwards, slab, level + 1))
        state.a = select(ends, self.start, -w)
        state.weight = select(ends, self._colour(1), state.weight)
        state.events = select(ends, 0, state.events + 1)

    def _connected(
        self, state: State, a: Vec3, from_above: Mask, eta: Float, links: Sequence[Link]
    ) -> Color:
        """The light that a rough surface mirrors or refracts towards this walk."""
        scene, level = self.scene, state.level
        rough = self._facets(level)
        reach = links[: self.base_level]
        link = Link(*(at(field, level) for field in zip(*reach, strict=True)))
        lit = link.d.z > 0
        joint = rough.connect(a, _upwards(lit, link.d), eta, from_above)
        before = joint.light_density / maximum(state.density, TINY) * state.rivals
        share = link.share(joint.density, select(from_above, 0, before))
        # What the topmost facets mirror at once is left to `direct`; a walk may have ended at the base.
        counts = (
            lit
            & (_most(state.weight) > 0)
            & at(self.rough, level)
            & negated(from_above & (level == 0))
        )
        if self.quantity == "value":
            outside = [1, *scene.n2]
            n2 = select(from_above, at(outside[:-1], level), at(outside[1:], level))
            return select(counts, state.weight * link.weight * (joint.value * share / n2), 0)
        return select(counts, scene.colour(joint.density * link.inverse * share), 0)

    def _scattered(self, state: State, a: Vec3, from_above: Mask, eta: Float) -> Event:
        """A new direction at the surface of each lane."""
        level, before = state.level, (state.density, state.rivals)
        forced = None
        if self.quantity == "value":
            # Light that is mirrored at once, or leaves, is reckoned with by connections.
            forced = (level == 0) & from_above, (level == 0) & negated(from_above)
        pick = self._draw()
        found: Event | None = None
        if any(self.rough):
            u = vec2(self._draw(), self._draw())
            found = self._facets(level).scatter(a, before, eta, u, pick, forced)
        for k, surface in enumerate(self.scene.surfaces):
            if not isinstance(surface, Pile):
                continue
            down, up = surface.bend(a.z, True), surface.bend(a.z, False)
            bend = Bend(*(select(from_above, x, y) for x, y in zip(down, up, strict=True)))
            event = surface.scatter(a, before, bend, eta, pick, forced)
            if found is None:
                found = event
                continue
            found = Event(*(select(level == k, x, y) for x, y in zip(event, found, strict=True)))
        assert found is not None
        return found

    def _facets(self, level: Any) -> Rough:
        """The rough surface of each lane; any of them where the lane's own is smooth."""
        surfaces = [s if isinstance(s, Rough) else None for s in self.scene.surfaces]
        some = next(s for s in surfaces if s is not None)
        filled = [s or some for s in surfaces]
        alike = all(s.ggx == some.ggx for s in filled)
        ggx = some.ggx if alike else at([self._mask(s.ggx) for s in filled], level)
        return Rough(at([s.alpha for s in filled], level), ggx)


def _survival(state: State) -> Float:
    """Probability that a walk goes on from what it has arrived at."""
    survival = select(state.events >= EVENTS_CERTAIN, minimum(_most(state.weight), 1), 1)
    survival = select(state.events >= EVENTS_LONG, minimum(survival, LONG_SURVIVAL), survival)
    return maximum(survival, SURVIVAL_MIN)


def _most(colour: Color) -> Float:
    """The largest channel."""
    return functools.reduce(maximum, channels(colour))


def _upwards(allowed: Mask, w: Vec3) -> Vec3:
    """w where it is allowed, and the normal elsewhere."""
    return vec3(select(allowed, w.x, 0), select(allowed, w.y, 0), select(allowed, w.z, 1))


def _three(colour: Color | Float) -> list[Float]:
    """Three channels, also of a grey model."""
    parts = channels(colour)
    return parts if len(parts) == 3 else parts * 3
