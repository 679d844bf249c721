"""Models in datasets: what a file must hold beside the fields of a solution, so that its model can be made again."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import singledispatch
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..foundation.checks import Mask, Vector
from ..geometry.cuts import Cuts
from ..geometry.lattice import Lattice
from ..geometry.on_arms import ArmField
from ..geometry.outline import Outline
from ..models.base import ContactModel
from ..models.beam import Beam
from ..models.cable import Cable
from ..models.cable_net import CableNet
from ..models.membrane import Membrane
from ..models.mesh_membrane import MeshMembrane
from ..models.on_area import AreaModel
from ..models.on_lattice import LatticeModel
from ..models.plate import Plate
from ..models.tension import Tension

if TYPE_CHECKING:
    import xarray as xr

KIND = "contactqp_model"
"""Name of the attribute that tells which kind of model a file holds."""


_ALONG = {"x": ("row", "arm_along_x"), "y": ("arm_along_y", "column")}
"""Dimensions of what arms along x and along y have."""


class Record(NamedTuple):
    """What is written of a model beside load and support.

    Attributes
    ----------
    attributes : dict of str
        Numbers and words.
    variables : mapping of str to (dimensions, array, meaning)
    """

    attributes: dict[str, Any]
    variables: Mapping[str, tuple[tuple[str, ...], Any, str]]


@singledispatch
def record_of(model: ContactModel) -> Record:
    """Return what is written of a model; of one of one's own nothing, so that it cannot be made again."""
    return Record({}, {})


def _units(model: ContactModel) -> dict[str, str]:
    return {f"unit_of_{name}": unit for name, unit in model.unit_names.items()}


def _units_in(data: xr.Dataset) -> dict[str, str]:
    names = ("length", "force")
    return {name: str(data.attrs[f"unit_of_{name}"]) for name in names if f"unit_of_{name}" in data.attrs}


def _on_lattice(model: LatticeModel, kind: str) -> Record:
    lattice = model.lattice
    attributes = {
        KIND: kind,
        "upwards": int(model.upwards),
        "origin": np.array(lattice.origin),
        "overshoot": lattice.overshoot,
        "slanted": int(lattice.slanted),
        "caution_of_lattice": lattice.caution,
        **_units(model),
    }
    if lattice.halved is not None:
        attributes["halved_squares"] = np.flatnonzero(lattice.halved)
    arms = _arms(model)
    if arms:
        attributes["same_tension"] = int(model.tension_of_arms.same)
    if lattice.cuts is not None:
        told = "length of arms along {}, in spacings: less than 1 where the frame cuts them"
        arms |= {
            f"arm_length_{axis}": (_ALONG[axis], cut, told.format(axis))
            for axis, cut in zip("xy", lattice.cuts, strict=True)
        }
    if lattice.outline is not None:
        attributes["contour_sagitta"] = lattice.outline.sagitta
        arms |= _contour(lattice.outline)
    if model.frame_heights is None:
        return Record(attributes, arms)
    x, y, heights = model.frame_places
    place = ("frame_point",)
    variables = {
        "frame_height": (place, heights, "height of the frame"),
        "frame_x": (place, x, "abscissa of the frame point"),
        "frame_y": (place, y, "ordinate of the frame point"),
    }
    return Record(attributes, arms | variables)


def _arms(model: LatticeModel) -> dict[str, tuple[tuple[str, ...], Any, str]]:
    """Return the tension of each arm by name, where it is not one number: it does not follow from that at the nodes."""
    if model.tension_of_arms.constant:
        return {}
    rows, columns = model.lattice.shape
    shapes = {"x": (rows, columns + 1), "y": (rows + 1, columns)}
    return {
        f"arm_tension_{axis}": (
            _ALONG[axis],
            np.broadcast_to(field.arms, shapes[axis]) if np.ndim(field.arms) == 0 else field.arms,
            f"of arms along {axis}",
        )
        for axis, field in zip("xy", model.tension_of_arms.fields, strict=False)
    }


def _contour(outline: Outline) -> dict[str, tuple[tuple[str, ...], Any, str]]:
    """Return the lines of a contour by name: their corners, and to which of the lines each belongs."""
    corners, place = np.concatenate(outline.rings), ("contour_point",)
    number = np.repeat(np.arange(len(outline.rings)), [len(ring) for ring in outline.rings])
    return {
        "contour_x": (place, corners[:, 0], "abscissa of the corners of the contour that the lattice is fitted to"),
        "contour_y": (place, corners[:, 1], "ordinate of the corners of the contour"),
        "contour_ring": (place, number, "which of the contour's closed lines each corner belongs to"),
    }


def _outline(data: xr.Dataset) -> Outline | None:
    """Return the contour of a lattice that is fitted to it."""
    if "contour_x" not in data:
        return None
    corners = np.column_stack([data[f"contour_{axis}"].to_numpy() for axis in "xy"])
    ends = np.flatnonzero(np.diff(data["contour_ring"].to_numpy())) + 1
    return Outline(tuple(np.split(corners, ends)), float(data.attrs["contour_sagitta"]))


def _tension(data: xr.Dataset, at_nodes: Callable[[Any], Vector]) -> Any:
    if "arm_tension_x" not in data:
        return float(data.attrs["tension"])
    same, fields = bool(data.attrs["same_tension"]), []
    for axis in ("x", "y"):
        if f"arm_tension_{axis}" in data:
            name = "tension" if same else f"tension_{axis}"
            nodes = at_nodes(data[name].to_numpy()) if name in data else float(data.attrs[name])
            arms = np.array(data[f"arm_tension_{axis}"].to_numpy(), dtype=np.float64)
            fields.append(ArmField(float(arms.flat[0]) if (arms == arms.flat[0]).all() else arms, nodes))
    return Tension(tuple(fields), same)


def _cuts(data: xr.Dataset) -> Cuts | None:
    """Return how long arms are, of a lattice that is fitted to its frame."""
    if "arm_length_x" not in data:
        return None
    return Cuts(*(np.array(data[f"arm_length_{axis}"].to_numpy(), dtype=np.float64) for axis in "xy"))


def _beside(data: xr.Dataset, at_nodes: Callable[[Any], Vector]) -> dict[str, Any]:
    """Return ceiling and foundation, as far as there are such."""
    return {name: at_nodes(data[name].to_numpy()) for name in ("ceiling", "foundation") if name in data}


@record_of.register(Membrane)
def _membrane(model: Membrane) -> Record:
    return _in_plan(model, "membrane")


@record_of.register(Plate)
def _plate(model: Plate) -> Record:
    attributes, variables = _in_plan(model, "plate")
    return Record(attributes | {"edge": model.edge, "poisson_ratio": model.poisson_ratio}, variables)


def _in_plan(model: AreaModel, kind: str) -> Record:
    attributes, variables = _on_lattice(model, kind)
    nodes = model.lattice.mask.astype(np.int8)
    return Record(
        attributes | {"rows": model.rows}, {**variables, "node_mask": (("y", "x"), nodes, "1 where there is a node")}
    )


@record_of.register(Cable)
def _cable(model: Cable) -> Record:
    attributes, variables = _on_lattice(model, "cable")
    return Record(attributes | {"start": model.start}, variables)


@record_of.register(Beam)
def _beam(model: Beam) -> Record:
    attributes, variables = _on_lattice(model, "beam")
    stiffness = model.point_stiffness
    if not isinstance(stiffness, float):
        told = "bending stiffness at the nodes and at both ends"
        variables = {**variables, "point_bending_stiffness": (("beam_point",), stiffness, told)}
    return Record(attributes | {"start": model.start, "ends": " ".join(model.ends)}, variables)


@record_of.register(CableNet)
def _net(model: CableNet) -> Record:
    end, at_segment = ("segment", "end"), ("segment",)
    variables = {
        "point_x": (("point_number",), model.positions[:, 0], "abscissa of each point, fixed ones included"),
        "point_y": (("point_number",), model.positions[:, 1], "ordinate of each point, fixed ones included"),
        "segment_points": (end, np.asarray(model.segments), "numbers of the points at the ends of each segment"),
        "tension": (at_segment, model.tension, "horizontal tension of each segment"),
        "force_density": (at_segment, model.force_density, "tension over length in plan of each segment"),
        "fixed_point": (("fixed",), np.asarray(model.fixed), "numbers of the fixed points"),
        "fixed_height": (("fixed",), model.fixed_height, "heights of the fixed points"),
    }
    return Record({KIND: "net", "upwards": int(model.upwards), **_units(model)}, variables)


@record_of.register(MeshMembrane)
def _mesh(model: MeshMembrane) -> Record:
    attributes = {KIND: "mesh membrane", "upwards": int(model.upwards), **_units(model)}
    if isinstance(model.tension, float):
        return Record(attributes, {})
    return Record(attributes, {"tension": (("triangle",), model.tension, "tension of each triangle")})


def model_in(data: xr.Dataset) -> ContactModel:
    """Return the model that a dataset of a file holds, made anew, with all its checks.

    Raises
    ------
    ValueError
        If it holds none, or a part is missing.
    """
    kind = str(data.attrs.get(KIND, ""))
    if kind not in _MAKERS:
        told = f"{kind!r}" if kind else "none"
        raise ValueError(f"it must tell its model by the attribute {KIND} ({', '.join(_MAKERS)}), it has {told}")
    try:
        return _MAKERS[kind](data)
    except KeyError as error:
        raise ValueError(f"it tells of a {kind}, but has no {error.args[0]!r}") from None


def _heights(data: xr.Dataset) -> Any:
    if "frame_height" not in data:
        return 0.0
    # The points come in the order in which they were written.
    stored = data["frame_height"].to_numpy()
    return lambda x, y: stored


def _made_membrane(data: xr.Dataset) -> Membrane:
    lattice = _lattice(data)
    return Membrane(lattice, _tension(data, lattice.gather), **_fields_in_plan(data, lattice))


def _made_plate(data: xr.Dataset) -> Plate:
    lattice, told = _lattice(data), data.attrs
    return Plate(
        lattice,
        float(told["bending_stiffness"]),
        tension=_tension(data, lattice.gather),
        edge=told["edge"],
        poisson_ratio=float(told["poisson_ratio"]),
        **_fields_in_plan(data, lattice),
    )


def _lattice(data: xr.Dataset) -> Lattice:
    told = data.attrs
    return Lattice(
        data["node_mask"].to_numpy() > 0,
        float(told["spacing"]),
        _pair(told["origin"]),
        overshoot=float(told["overshoot"]),
        caution=str(told["caution_of_lattice"]),
        crs=str(told.get("crs", "")),
        slanted=bool(told.get("slanted", 0)),
        halved=_halved(data),
        cuts=_cuts(data),
        outline=_outline(data),
    )


def _halved(data: xr.Dataset) -> Mask | None:
    if "halved_squares" not in data.attrs:
        return None
    rows, columns = data["node_mask"].shape
    halved = np.zeros((rows + 1, columns + 1), dtype=np.bool_)
    halved.flat[np.atleast_1d(data.attrs["halved_squares"])] = True
    return halved


def _fields_in_plan(data: xr.Dataset, lattice: Lattice) -> dict[str, Any]:
    return {
        "load": lattice.gather(data["load"].to_numpy()),
        "support": lattice.gather(data["support"].to_numpy()),
        "frame_height": _heights(data),
        "upwards": bool(data.attrs["upwards"]),
        "rows": data.attrs["rows"],
        "units": _units_in(data),
        **_beside(data, lattice.gather),
    }


def _made_cable(data: xr.Dataset) -> Cable:
    told = data.attrs
    return Cable(
        nodes=data.sizes["x"],
        spacing=float(told["spacing"]),
        tension=_tension(data, np.array),
        load=data["load"].to_numpy(),
        support=data["support"].to_numpy(),
        frame_height=_heights(data),
        start=float(told["start"]),
        upwards=bool(told["upwards"]),
        units=_units_in(data),
        **_beside(data, np.array),
    )


def _made_beam(data: xr.Dataset) -> Beam:
    told = data.attrs
    left, right = str(told["ends"]).split()
    between = data.sizes["x"] - (left == "free") - (right == "free")
    stiffness = data.get("point_bending_stiffness")
    return Beam(
        nodes=between,
        spacing=float(told["spacing"]),
        bending_stiffness=float(told["bending_stiffness"]) if stiffness is None else stiffness.to_numpy(),
        tension=_tension(data, np.array),
        load=data["load"].to_numpy(),
        support=data["support"].to_numpy(),
        ends=(left, right),  # type: ignore[arg-type]
        frame_height=_heights(data),
        start=float(told["start"]),
        upwards=bool(told["upwards"]),
        units=_units_in(data),
        **_beside(data, np.array),
    )


def _made_net(data: xr.Dataset) -> CableNet:
    positions = np.column_stack([data["point_x"].to_numpy(), data["point_y"].to_numpy()])
    shape: dict[str, Any] = {
        "load": data["load"].to_numpy(),
        "support": data["support"].to_numpy(),
        "fixed": data["fixed_point"].to_numpy(),
        "fixed_height": data["fixed_height"].to_numpy(),
        "upwards": bool(data.attrs["upwards"]),
        "units": _units_in(data),
        **_beside(data, np.array),
    }
    segments, tension, density = (data[name].to_numpy() for name in ("segment_points", "tension", "force_density"))
    net = CableNet(positions, segments, tension=tension, **shape)
    # One of the two was given, and the other follows to rounding.
    return (
        net
        if np.array_equal(net.force_density, density)
        else CableNet(positions, segments, force_density=density, **shape)
    )


def _made_mesh(data: xr.Dataset) -> MeshMembrane:
    fixed = data["fixed"].to_numpy() > 0
    return MeshMembrane(
        np.column_stack([data["x"].to_numpy(), data["y"].to_numpy()]),
        data["triangles"].to_numpy(),
        data["tension"].to_numpy() if "tension" in data else float(data.attrs["tension"]),
        load=data["load"].to_numpy(),
        support=data["support"].to_numpy(),
        fixed=fixed,
        frame_height=data["frame_height"].to_numpy(),
        upwards=bool(data.attrs["upwards"]),
        units=_units_in(data),
        **_beside(data, np.array),
    )


def _pair(value: Any) -> tuple[float, float]:
    x, y = np.asarray(value, dtype=np.float64)
    return float(x), float(y)


_MAKERS: dict[str, Callable[[xr.Dataset], ContactModel]] = {
    "membrane": _made_membrane,
    "cable": _made_cable,
    "beam": _made_beam,
    "plate": _made_plate,
    "net": _made_net,
    "mesh membrane": _made_mesh,
}


def own_gap(data: xr.Dataset, model: ContactModel) -> Vector:
    """Return the gap that a dataset holds, as it was solved for, where there is no support as well, shape (n,)."""
    return values_at_nodes(data, "gap_from_reference" if "gap_from_reference" in data else "gap", model)


def values_at_nodes(data: xr.Dataset, name: str, model: ContactModel) -> Vector:
    """Return a variable of a dataset at the nodes of the model that it tells, shape (n,).

    Raises
    ------
    ValueError
        If there is no such variable, or it lies elsewhere.
    """
    if name not in data:
        raise ValueError(f"it has no variable {name!r}")
    values = np.asarray(data[name].to_numpy(), dtype=np.float64)
    if isinstance(model, LatticeModel) and values.ndim == 2:
        values = model.lattice.gather(values)
    return model.at_nodes(values, name)
