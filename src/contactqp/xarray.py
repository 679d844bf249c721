"""The accessor ``ds.contact`` of xarray's datasets: solve what a dataset describes, and ask what a solution's holds.

``import contactqp.xarray`` registers it; importing contactqp alone does not, because that loads no xarray.

A solution's dataset has a variable ``contact``, and ``ds.contact`` stays that: it is the variable itself, an
`xarray.DataArray` that computes and compares as before, with the methods of the accessor besides.

Examples
--------
>>> import numpy as np
>>> import xarray as xr
>>> import contactqp.xarray
>>> x, y = np.linspace(0.0, 1.0, 17), np.linspace(0.0, 0.5, 9)
>>> ground = 0.06 + 0.1 * np.hypot(x - 0.5, y[:, None] - 0.25)
>>> ds = xr.Dataset({"support": (("y", "x"), ground)}, {"x": x, "y": y}).assign(load=4.0, tension=1.0)
>>> solved = ds.contact.solve()
>>> solved.attrs["status"], int(solved.contact.sum())
('certified', 17)
>>> solved.contact.patches()[["nodes", "area"]].round(4).to_dict("list")
{'nodes': [17], 'area': [0.0664]}
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from .foundation.checks import Mask, Vector, finite_number
from .foundation.loading import load_modules
from .foundation.pictures import UnitNames
from .geometry.lattice import Lattice, patches_on_grid
from .io.model_records import KIND, model_in, values_at_nodes
from .io.patches import table_of
from .models.base import ContactModel
from .models.cable import Cable
from .models.membrane import Membrane
from .plotting.states import colours_by_number, draw_legend_of_states
from .plotting.style import new_figure, same_scales, tidy
from .solving.solve import solve

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

    from .solving.solution import Solution

_NAME = "contact"


class ContactMethods:
    """Methods of ``ds.contact``; `contactqp.xarray` tells when it is there.

    The dataset lies along y and x, or along x alone for a cable, with coordinates at equal steps.
    """

    __slots__ = ()

    _dataset: xr.Dataset

    def model(
        self,
        *,
        tension: Any = None,
        nodes: Any = None,
        frame_height: Any = 0.0,
        upwards: bool | None = None,
        units: UnitNames | None = None,
    ) -> ContactModel:
        """Return the model that the dataset describes by ``load``, ``support`` and ``tension``.

        A solution's dataset tells its whole model, of whatever kind: that is made anew, with the load and the support
        that the dataset has now, if nothing else is asked for.

        Parameters
        ----------
        tension : float, array, function or pair of these, optional
            As for `contactqp.Membrane`. By default the dataset's variable or attribute of that name, or those named
            tension_x and tension_y; the variables ceiling and foundation are taken as well.
        nodes : array of bool, shape (rows, columns), optional
            Which points are nodes; all else is frame. By default they are those with a load and a support, where
            others are nan; where none is nan, all but the outermost rows and columns, which are the frame.
        frame_height : number, array or function of (x, y)
            Height of the frame (length).
        upwards : bool, optional
            Whether heights are elevations; by default what the attribute ``upwards`` says, or False.
        units : str or mapping, optional
            See `contactqp.Membrane`.

        Raises
        ------
        ValueError
            If something is missing, the coordinates are not at equal steps, or they are not those of the model that
            a solution's dataset tells.
        """
        data = self._dataset
        if KIND in data.attrs:
            asked = {"tension": tension, "nodes": nodes, "upwards": upwards, "units": units}
            asked |= {} if isinstance(frame_height, float) and frame_height == 0.0 else {"frame_height": frame_height}
            return self._told({name for name, value in asked.items() if value is not None})
        missing = [name for name in ("load", "support") if name not in data]
        if missing:
            told = " and ".join(missing)
            raise ValueError(f"the dataset must have load and support, but has no variable {told}")
        grid: dict[str, Any] = {
            name: data[name].sortby([axis for axis in ("x", "y") if axis in data[name].coords])
            for name in (*_FIELDS, *(name for name in ("ceiling", "foundation") if name in data))
        }
        first = {axis: self._start(axis) for axis in ("x", "y") if axis in data.dims}
        if "x" not in first:
            raise ValueError(f"the dataset must lie along y and x, or along x alone, it lies along {set(data.dims)}")
        spacing = self._spacing(list(first))
        given: dict[str, Any] = {"tension": self._tension(tension), "frame_height": frame_height, "units": units}
        given["upwards"] = bool(data.attrs.get("upwards", False)) if upwards is None else upwards
        if "y" not in first:
            inner: dict[str, Any] = {
                name: field.isel(x=slice(1, -1)) if field.ndim else field for name, field in grid.items()
            }
            count = data.sizes["x"] - 2
            return Cable(nodes=count, spacing=spacing, start=first["x"], **inner, **given)
        crs = str(data["spatial_ref"].attrs.get("spatial_ref", "")) if "spatial_ref" in data.variables else ""
        mask = self._nodes(nodes)
        lattice = Lattice(mask, spacing, (first["x"], first["y"]), crs=crs or str(data.attrs.get("crs", "")))
        # What is nan beside the nodes does no harm.
        fields: dict[str, Any] = {name: field.fillna(0.0) if field.ndim else field for name, field in grid.items()}
        return Membrane(lattice, given.pop("tension"), **fields, **given)

    def _told(self, asked: set[str]) -> ContactModel:
        """Return the model that a solution's dataset tells."""
        data = self._dataset
        if asked:
            raise ValueError(
                f"the dataset is a solution's and tells its whole model, a {data.attrs[KIND]}, so that "
                f"{', '.join(sorted(asked))} cannot be given; change the dataset, or drop its attribute {KIND}"
            )
        data = self._in_order
        model = model_in(data)
        for name, place in model.coordinates.items():
            there = data[name].to_numpy() if name in data.coords else np.zeros(0)
            if there.shape != place.values.shape or not np.allclose(there, place.values, equal_nan=True):
                raise ValueError(
                    f"the dataset tells a whole {data.attrs[KIND]}, but its {name} are not those of the nodes; take "
                    f"all of it, or drop its attribute {KIND}"
                )
        return model

    def solution(self, backend: str = "auto", *, tol: float | str = 1e-6, **options: Any) -> Solution:
        """Return the solution of that model.

        Parameters
        ----------
        backend, tol
            See `contactqp.solve`.
        **options
            Those of `model`, and others as for `contactqp.solve`.
        """
        names = ("tension", "nodes", "frame_height", "upwards", "units")
        of_model = {name: options.pop(name) for name in names if name in options}
        return solve(self.model(**of_model), backend, tol=tol, **options)

    def solve(self, backend: str = "auto", *, tol: float | str = 1e-6, **options: Any) -> xr.Dataset:
        """Return the solution as a dataset, see `contactqp.Solution.to_dataset`; arguments as for `solution`."""
        return self.solution(backend, tol=tol, **options).to_dataset()

    def patches(self) -> pd.DataFrame:
        """Return a row for each contact patch of a solution: nodes in contact that arms, or sides of triangles, join.

        Of a dataset that does not tell its whole model they are points side by side in a row or a column.

        Returns
        -------
        pandas.DataFrame
            patch, nodes, area (of a cable: length), reaction, x and y, as `contactqp.Solution.patches`.
        """
        held, reaction = self._solved("contact"), self._solved("reaction")
        model = self._own_model()
        if model is not None:
            labels, count = model.contact_patches(self._at_nodes("contact", model) > 0)
            force = self._at_nodes("reaction", model)
            return table_of(labels, count, force, model.node_x, model.node_y, model.node_area)
        contact = np.atleast_2d(held.to_numpy() > 0)
        labels, count = patches_on_grid(contact)
        x, y = np.meshgrid(held["x"], held["y"] if "y" in held.dims else [0.0])
        area = np.full(labels.size, self._spacing([str(axis) for axis in held.dims]) ** held.ndim)
        return table_of(labels.ravel(), count, reaction.to_numpy().ravel(), x.ravel(), y.ravel(), area)

    def pressure_histogram(self, bins: int | NDArray[np.float64] = 20) -> xr.DataArray:
        """Return the area in contact (of a cable: the length) under how much pressure.

        Parameters
        ----------
        bins : int or array
            How many, or their edges.

        Returns
        -------
        xarray.DataArray
            Along ``pressure``, the middles of the bins, with the coordinates ``lower`` and ``upper``.

        Raises
        ------
        ValueError
            If the nodes stand for no area, as those of a cable net, so that there is no pressure.
        """
        held, model = self._solved("contact"), self._own_model()
        if model is not None and model.node_area is None:
            raise ValueError(
                f"nodes of {model!r} stand for no area, so that there is no pressure; patches() has their reactions"
            )
        pressure = self._solved("contact_pressure")
        if model is None:
            values = pressure.to_numpy()[held.to_numpy() > 0]
            area = np.full(values.size, self._spacing([str(axis) for axis in held.dims]) ** held.ndim)
        else:
            touching = self._at_nodes("contact", model) > 0
            values = self._at_nodes("contact_pressure", model)[touching]
            area = np.broadcast_to(model.node_area, model.size)[touching]  # type: ignore[arg-type]
        held_area, edges = np.histogram(values, bins, weights=area)
        coordinates = {
            "pressure": ("pressure", (edges[1:] + edges[:-1]) / 2, {"units": pressure.attrs.get("units", "")}),
            "lower": ("pressure", edges[:-1]),
            "upper": ("pressure", edges[1:]),
        }
        return xr.DataArray(held_area, coordinates, ("pressure",), "area", {"long_name": "area in contact"})

    def plot(self, ax: Any = None, *, title: str = "Contact map") -> Figure:
        """Draw where a solution touches: the certain states, where the dataset has them; of a cable its line.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Axes of your own to draw into.
        title : str
            Headline.

        Returns
        -------
        matplotlib.figure.Figure
        """
        held = self._solved("contact")
        figure = new_figure(6.5, 5) if ax is None else ax.get_figure()
        axes = figure.subplots() if ax is None else ax
        if "y" not in held.dims:
            for name in ("deflection", "support"):
                axes.plot(held["x"], self._solved(name), label=name)
            touching = self._solved("deflection").where(held > 0)
            axes.plot(held["x"], touching, ".", label="in contact")
            axes.set(xlabel="x", ylabel="height", title=title)
            axes.legend(frameon=False)
            if not self._dataset.attrs.get("upwards", False):
                axes.invert_yaxis()
            return figure
        proven = "contact_state" in self._dataset
        known = self._solved("gap").notnull()
        state = self._dataset["contact_state"] if proven else held.where(known).astype(float)
        colours, low, high = colours_by_number()
        axes.pcolormesh(held["x"], held["y"], state, cmap=colours, vmin=low, vmax=high, shading="nearest")
        numbers = state.to_numpy()
        numbers = numbers[np.isfinite(numbers)].astype(np.int64)
        draw_legend_of_states(axes, numbers, "certainly " if proven else "")
        axes.set(xlabel="x", ylabel="y", title=title)
        same_scales(axes)
        tidy(axes)
        return figure

    def _own_model(self) -> ContactModel | None:
        """Return the model that a solution's dataset tells; None where it tells none, or is a part of a lattice's."""
        if KIND not in self._dataset.attrs:
            return None
        try:
            return self._told(set())
        except ValueError:
            if "x" in self._dataset.dims:
                return None
            raise

    def _at_nodes(self, name: str, model: ContactModel) -> Vector:
        return values_at_nodes(self._in_order, name, model)

    @property
    def _in_order(self) -> xr.Dataset:
        """The dataset with its coordinates ascending."""
        return self._dataset.sortby([axis for axis in ("x", "y") if axis in self._dataset.dims])

    def _solved(self, name: str) -> xr.DataArray:
        if name not in self._dataset:
            raise ValueError(f"the dataset has no variable {name!r}: it is no solution; ds.contact.solve() returns one")
        return self._dataset[name]

    def _start(self, axis: str) -> float:
        return float(self._dataset[axis].min())

    def _spacing(self, axes: list[str]) -> float:
        steps = {}
        for axis in axes:
            if axis not in self._dataset.coords:
                raise ValueError(f"the dataset must have the coordinate {axis}")
            places = np.sort(np.asarray(self._dataset[axis], dtype=np.float64))
            if places.size < 2:
                continue
            step = (places[-1] - places[0]) / (places.size - 1)
            if step <= 0 or np.abs(places - places[0] - step * np.arange(places.size)).max() > 1e-6 * step:
                raise ValueError(f"the coordinate {axis} must have equal steps")
            steps[axis] = float(step)
        if not steps:
            return finite_number(self._dataset.attrs.get("spacing"), "the attribute spacing")
        if max(steps.values()) - min(steps.values()) > 1e-6 * min(steps.values()):
            told = ", ".join(f"{step:g} along {axis}" for axis, step in steps.items())
            raise ValueError(f"the steps must be the same along x and y, they are {told}")
        # The lattice's own number, where the dataset has it, is not rounded.
        own = float(self._dataset.attrs.get("spacing", np.nan))
        return own if abs(own - steps["x" if "x" in steps else "y"]) <= 1e-9 * own else next(iter(steps.values()))

    def _tension(self, given: Any) -> Any:
        if given is not None:
            return given
        found = {
            name: self._dataset[name] if name in self._dataset else self._dataset.attrs.get(name)
            for name in ("tension", "tension_x", "tension_y")
        }
        if found["tension"] is not None:
            return found["tension"]
        if found["tension_x"] is not None and found["tension_y"] is not None:
            return found["tension_x"], found["tension_y"]
        raise ValueError("the dataset has no variable and no attribute tension: say solve(tension=...)")

    def _nodes(self, given: Any) -> Mask:
        data = self._dataset.sortby(["x", "y"])
        shape = data.sizes["y"], data.sizes["x"]
        if given is not None:
            mask = given.sortby(["x", "y"]).transpose("y", "x") if isinstance(given, xr.DataArray) else given
            return np.asarray(mask)
        if "node_mask" in data:
            return np.asarray(data["node_mask"].transpose("y", "x") > 0)
        known = np.ones(shape, dtype=np.bool_)
        for name in _FIELDS:
            if data[name].ndim:
                known &= data[name].transpose("y", "x").notnull().to_numpy()
        if known.all():
            known[[0, -1]] = known[:, [0, -1]] = False
        return known


_FIELDS = ("load", "support")


class Contact(ContactMethods):
    """What ``ds.contact`` is, where the dataset has no variable of that name."""

    __slots__ = ("_dataset",)

    def __init__(self, dataset: xr.Dataset) -> None:
        self._dataset = dataset


class ContactArray(ContactMethods, xr.DataArray):  # type: ignore[no-untyped-call]
    """The variable ``contact`` of a solution's dataset, with the methods of `ContactMethods`."""

    __slots__ = ("_dataset",)

    @property
    def plot(self) -> Any:  # type: ignore[override]
        """Draw the contact map of the dataset; of what has been computed from the variable the values."""
        if hasattr(self, "_dataset"):
            return super().plot
        return xr.DataArray(self).plot


class _Accessor:
    """What ``ds.contact`` is, looked up anew each time, so that a variable that is replaced is not remembered."""

    def __get__(self, dataset: xr.Dataset | None, owner: type) -> Any:
        if dataset is None:
            return ContactMethods
        if _NAME not in dataset.variables:
            return Contact(dataset)
        variable = ContactArray(dataset[_NAME])
        variable._dataset = dataset
        return variable


def register() -> None:
    """Register ``ds.contact``; importing the module has done so."""
    load_modules("xarray")
    xr.Dataset.contact = _Accessor()  # type: ignore[attr-defined]


register()
