"""Random rectangular membranes, enclosed on a lattice and on one that is 8 times as fine, and what contradicts there.

Either enclosure is of the membrane itself, so that no lower bound of one may lie above an upper bound of the other.
"""

from typing import Any, NamedTuple

import numpy as np
from scipy.ndimage import distance_transform_edt

import contactqp as cq
from contactqp.continuum.data import Data
from contactqp.continuum.relatives import finer
from contactqp.profiles import Cone, Cylinder, Hemisphere, HillAndFloor, Paraboloid, Plane, Sampled, Uppermost

HALVINGS = 3
"""How often the spacing is halved for the finer lattice."""

ROOM = 1e-13
"""Data that are rounded at the lattices' own points are the same but for this part of a quantity."""


class Wave:
    """mean + part sin(ax + φ) cos(by + ψ), of which slope and second derivatives are known."""

    def __init__(self, rng, size, mean, part):
        self.turns = rng.uniform(0.0, 6.0, 2) / size
        self.phases = rng.uniform(0.0, 2 * np.pi, 2)
        self.mean, self.part = float(mean), float(part)

    def __call__(self, x, y):
        (a, b), (first, second) = self.turns, self.phases
        return self.mean + self.part * np.sin(a * x + first) * np.cos(b * y + second)

    def declared(self):
        """Return the function with no more than its second derivatives: it is a mean of two waves along slants."""
        return cq.Smooth(self, second_derivative=abs(self.part) * float(self.turns.max()) ** 2)

    def steep(self):
        """Return the function with no more than its slope."""
        return cq.Smooth(self, lipschitz=abs(self.part) * float(self.turns.max()))


class Kink:
    """mean + slope |x - place|."""

    def __init__(self, mean, slope, place):
        self.mean, self.slope, self.place = mean, slope, place

    def __call__(self, x, y):
        return self.mean + self.slope * np.abs(x - self.place) + 0 * y


def random_rectangle(seed):
    """Return a membrane over a rectangle of 2 to 16 squares along a side, all else drawn as well."""
    rng = np.random.default_rng(seed)
    rows, columns = (int(count) for count in rng.integers(2, 17, 2))
    spacing = 10.0 ** rng.uniform(-2, 2)
    corner = rng.uniform(-1, 1, 2) * 8 * spacing
    lattice = cq.Lattice.from_mask(np.ones((rows - 1, columns - 1), dtype=bool), spacing, tuple(corner + spacing))
    sides = np.array([columns, rows]) * spacing
    tension, pressure = 10.0 ** rng.uniform(-1, 1), 10.0 ** rng.uniform(-3, 3)
    sag = 0.13 * pressure * sides.min() ** 2 / tension
    depth = sag * 10.0 ** rng.uniform(-1.3, 0.2)
    data: dict[str, Any] = {"tension": tension, "upwards": bool(rng.integers(2))}
    data["load"] = _load(rng, lattice, corner, sides, pressure)
    data["support"] = _support(rng, lattice, corner, sides, depth)
    if rng.uniform() < 0.3:
        wave = Wave(rng, sides.min(), -0.1 * depth, 0.1 * depth)
        data["frame_height"] = (_turned(wave) if data["upwards"] else wave).declared()
    if rng.uniform() < 0.45:
        _bind(rng, data, sides, depth)
    if data["upwards"]:
        data = {name: _risen(name, given) for name, given in data.items()}
    return cq.Membrane(lattice, **data)


def _load(rng, lattice, corner, sides, pressure):
    mean = pressure * rng.uniform(-0.3, 1.5)
    wave = Wave(rng, sides.min(), mean, pressure * rng.uniform(0, 1.5))
    choices = [
        lambda: mean,
        wave.declared,
        wave.declared,
        wave.steep,
        lambda: cq.Smooth(
            Kink(mean, pressure / sides[0], corner[0] + sides[0] * rng.uniform()), lipschitz=pressure / sides[0]
        ),
        lambda: mean + pressure * rng.uniform(-0.5, 0.5, lattice.size),
    ]
    return choices[rng.integers(len(choices))]()


def _support(rng, lattice, corner, sides, depth):
    """Return a support that lies at no less than zero."""
    middle = tuple(corner + sides * rng.uniform(0.2, 0.8, 2))
    tilt = rng.uniform(-0.4, 0.4, 2) * depth / sides
    plane = Plane(depth - float(tilt @ (corner + sides / 2)), *map(float, tilt))
    far = float((sides**2).sum())
    choices = [
        lambda: depth,
        lambda: plane,
        lambda: Paraboloid(depth, far / (2 * depth * rng.uniform(0.2, 4.0)), middle),
        lambda: Paraboloid(1.01 * depth, -far / (2 * depth), middle),
        lambda: Hemisphere(depth, 1.01 * float(np.sqrt(far)), middle),
        lambda: Wave(rng, sides.min(), depth, 0.8 * depth).declared(),
        lambda: Uppermost(plane, Cone(0.3 * depth, 2.0 * depth / sides[0], middle)),
        lambda: Uppermost(plane, Cylinder(0.2 * depth, float(sides[0]) / 3, middle)),
        lambda: Uppermost(plane, Hemisphere(0.2 * depth, float(sides.min()) / 3, middle)),
        lambda: depth * rng.uniform(0.5, 1.5, lattice.size),
        lambda: Wave(rng, sides.min(), depth, 0.8 * depth).steep(),
        lambda: _roof(corner, sides, depth),
        lambda: HillAndFloor(depth, depth * rng.uniform(1.0, 5.0), float(sides.max()) / 64),
        lambda: _survey(rng, corner[0], sides[0], depth),
    ]
    return choices[rng.integers(len(choices))]()


def _roof(corner, sides, depth):
    """Return what a roof is over the rectangle, which begins at its frame: the bound of elastic and plastic torsion."""
    slope = 2 * depth / float(sides.min())
    (west, south), (east, north) = corner, corner + sides
    flanks = [(-slope * west, slope, 0.0), (slope * east, -slope, 0.0)]
    flanks += [(-slope * south, 0.0, slope), (slope * north, 0.0, -slope)]
    return Uppermost(*(Plane(*map(float, flank)) for flank in flanks))


def _survey(rng, west, width, depth):
    places = np.sort(west + width * np.concatenate([[-0.1, 1.1], rng.uniform(0, 1, rng.integers(1, 8))]))
    return Sampled(
        places, depth * rng.uniform(0.3, 1.5, places.size), interpolation=["linear", "pchip"][rng.integers(2)]
    )


def _bind(rng, data, sides, depth):
    """Add some of what only energies are enclosed with: tensions, springs and a ceiling."""
    tension = data["tension"]
    wave = Wave(rng, sides.min(), tension, 0.2 * tension)
    kinds = [tension, (tension, tension * rng.uniform(0.3, 3.0)), wave.declared(), (wave.declared(), tension)]
    data["tension"] = kinds[rng.integers(4)]
    if rng.uniform() < 0.5:
        stiffness = tension / sides.min() ** 2 * 10.0 ** rng.uniform(-1, 1.5)
        spring = Wave(rng, sides.min(), stiffness, 0.9 * stiffness)
        data["foundation"] = [stiffness, spring.declared()][rng.integers(2)]
    if rng.uniform() < 0.5:
        height = depth * rng.uniform(0.21, 0.6)
        roof = Wave(rng, sides.min(), -height - 0.2 * depth, 0.2 * depth)
        data["ceiling"] = [-height, _turned(roof).declared() if data["upwards"] else roof.declared()][rng.integers(2)]


def _turned(wave):
    wave.mean, wave.part = -wave.mean, -wave.part
    return wave


def _risen(name, given):
    """Return heights as elevations; what profiles tell are depths in any case, and functions have been turned."""
    if name == "support" and isinstance(given, cq.Smooth):
        return cq.Smooth(_turned(given.function), lipschitz=given.lipschitz, second_derivative=given.second_derivative)
    return -given if name in ("support", "ceiling") and isinstance(given, float | np.ndarray) else given


class Enclosed(NamedTuple):
    """A membrane, the answer of its lattice, and what that proves, at every point if such a membrane can be."""

    model: cq.Membrane
    solution: cq.Solution
    found: cq.Continuum

    @property
    def pointwise(self):
        return self.found.pointwise is not None


def enclosed(model):
    """Solve for a membrane on its lattice and enclose it."""
    solution = cq.solve(model, tol=1e-9, on_failure="ignore")
    try:
        found = solution.continuum("pointwise")
    except ValueError as refusal:
        if "effort='energy' does" not in str(refusal):
            raise
        found = solution.continuum()
    return Enclosed(model, solution, found)


def refined(model):
    """Return a membrane on a lattice that is 2 to the power `HALVINGS` times as fine."""
    for _ in range(HALVINGS):
        model = finer(model)
    return model


def contradictions(coarse, fine):
    """Return the names of the bounds of which not both can be true."""
    told = {"potential energy": _apart(coarse.found.energy, fine.found.energy)}
    told["energy norm"] = energy_distance(coarse, fine) - coarse.found.energy_error - fine.found.energy_error
    told["proof"] = float(not (coarse.found.proven and fine.found.proven))
    if coarse.pointwise and fine.pointwise:
        told |= _at_nodes(coarse, fine) | _in_squares(coarse, fine)
        for name in ("area", "reaction"):
            told[name] = _apart(*(getattr(one.found.contact, name) for one in (coarse, fine)))
        told["largest depth"] = _apart(coarse.found.largest_depth, fine.found.largest_depth)
    return [name for name, excess in told.items() if not excess <= 0]


def _apart(first, second):
    """Return how far two brackets are apart, beyond the rounding of the data that they are about."""
    sizes = [abs(end) for end in (*first, *second) if np.isfinite(end)]
    return max(first.lower - second.upper, second.lower - first.upper) - ROOM * max(sizes, default=0.0)


def _at_nodes(coarse, fine):
    values = {"lower": fine.found.lower, "upper": fine.found.upper}
    values |= {name: getattr(fine.found.pointwise, name) for name in ("gap_lower", "gap_upper")}
    there = {name: at_nodes_of(coarse.model, fine.model, value) for name, value in values.items()}
    own, answer = coarse.found, coarse.solution.deflection
    room = ROOM * max(np.abs(own.lower).max(), np.abs(own.upper).max(), coarse.model.height_scale)
    return {
        "deflection": max((own.lower - there["upper"]).max(), (there["lower"] - own.upper).max()) - room,
        "gap": max(
            (own.pointwise.gap_lower - there["gap_upper"]).max(), (there["gap_lower"] - own.pointwise.gap_upper).max()
        )
        - room,
        "error": max((answer - there["upper"]).max(), (there["lower"] - answer).max()) - own.error_bound - room,
        "order": max((own.lower - own.upper).max(), (fine.found.lower - fine.found.upper).max()),
    }


def _in_squares(coarse, fine):
    found = [one.found.pointwise for one in (coarse, fine)]
    places = []
    for wide, narrow in zip(found[0].edges, found[1].edges, strict=True):
        at = np.searchsorted(wide, (narrow[1:] + narrow[:-1]) / 2) - 1
        places.append(np.clip(at, 0, wide.size - 2))
    around = np.ix_(places[1], places[0])
    low, high = found[0].gap_lower_in_cells[around], found[0].gap_upper_in_cells[around]
    states = [coarse.found.contact, fine.found.contact]
    room = ROOM * max(coarse.model.height_scale, float(np.nanmax(high)))
    return {
        "gap in squares": np.nanmax(
            [np.nanmax(low - found[1].gap_upper_in_cells), np.nanmax(found[1].gap_lower_in_cells - high)]
        )
        - room,
        "free boundary": _farther(states, around, found[1].edges, room),
        "clear": float((states[0].clear[around] & states[1].contact).sum()),
        "contact": float((states[0].contact[around] & states[1].clear).sum()),
    }


def _farther(states, around, edges, room):
    """Return how much farther than is told a square that is undecided is from where the free boundary may be."""
    width, undecided = states[0].free_boundary_width, states[0].undecided[around]
    if not (undecided.any() and np.isfinite(width)):
        return 0.0
    spacing = edges[0][1] - edges[0][0]
    # A point of it is the corner of no clear square, and not of squares in contact alone.
    known = [states[1].contact | states[1].undecided, states[1].clear | states[1].undecided]
    farthest = max(distance_transform_edt(~each)[undecided].max() if each.any() else np.inf for each in known)
    return (farthest - np.sqrt(2)) * spacing - width - room


def at_nodes_of(coarse, fine, values):
    """Return what the nodes of a lattice have of values at those of a finer one."""
    column, row = (
        np.rint((place - start) / fine.lattice.spacing).astype(int)
        for place, start in zip((coarse.node_x, coarse.node_y), fine.lattice.origin, strict=True)
    )
    return fine.lattice.scatter(values)[row, column]


def energy_distance(coarse, fine):
    """Return no more than the energy norm of the difference of both answers' interpolants.

    Of the tension the least is taken, and of the foundation nothing.
    """
    below = [one.model.padded_below(one.solution.gap) for one in (coarse, fine)]
    data = [Data.of(one.model) for one in (coarse, fine)]
    own, other = (
        np.where(each.plan.nodes, depths, np.where(each.plan.frame, each.frame.values, 0.0))[_box(each.plan.points)]
        for each, depths in zip(data, below, strict=True)
    )
    apart = _prolonged(own, 2**HALVINGS) - other
    along_x, along_y = data[1].least_tension
    across, up = np.diff(apart, axis=1), np.diff(apart, axis=0)
    stored = along_x * _squares(across[:-1], across[1:]) + along_y * _squares(up[:, :-1], up[:, 1:])
    return float(np.sqrt(stored)) * (1 - 1e-9) - 1e-13 * coarse.found.energy_norm


def _box(points):
    rows, columns = (np.flatnonzero(points.any(axis=axis)) for axis in (1, 0))
    return slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)


def _squares(first, second):
    return float((first**2 + first * second + second**2).sum()) / 3


def _prolonged(points, times):
    for axis in (0, 1):
        places = np.linspace(0, points.shape[axis] - 1, times * (points.shape[axis] - 1) + 1)
        low = np.minimum(places.astype(int), points.shape[axis] - 2)
        share = np.expand_dims(places - low, 1 - axis)
        points = points.take(low, axis) * (1 - share) + points.take(low + 1, axis) * share
    return points
