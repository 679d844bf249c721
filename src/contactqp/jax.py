"""Contact as a differentiable function of JAX arrays.

``pip install 'contactqp[jax]'`` installs what it needs. JAX computes in single precision unless it is told
``jax.config.update("jax_enable_x64", True)``.
"""

from __future__ import annotations

from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from .models.base import ContactModel
from .solving.layer import Fields, Layer

__all__ = ["Contact", "contact"]


class Contact(NamedTuple):
    """Gap and deflection (length), and reaction (force) at the nodes: arrays of shape (..., n)."""

    gap: jax.Array
    deflection: jax.Array
    reaction: jax.Array


def contact(model: ContactModel, load: Any = None, support: Any = None, *, tol: float = 1e-10) -> Contact:
    """Return what a model answers to a load and a support, with gradients by both.

    It may stand in functions that are compiled by ``jit``, differentiated backwards by ``grad`` and mapped over batches
    by ``vmap``. The backward pass solves the adjoint equations of the free nodes, see `contactqp.solving.sensitivity`.
    Where nodes have neither gap nor reaction it takes them for held, so that it returns one of the one-sided
    derivatives.

    Parameters
    ----------
    model : Membrane, Cable, CableNet or another ContactModel
    load, support : number or array, shape (n,) or (..., n), optional
        In the units and the sense of the model's own, in node order, a number for all nodes; by default the model's.
        Leading dimensions are a batch, over which one that has none is repeated.
    tol : float
        Bound of the error, relative to the error scale.

    Returns
    -------
    Contact

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong kind or shape.

    Examples
    --------
    >>> import contactqp as cq
    >>> cable = cq.Cable(nodes=9, spacing=1.0, tension=1.0, load=1.0, support=2.0)
    >>> jax.grad(lambda load: contact(cable, load).reaction.sum())(jnp.ones(9)).shape
    (9,)
    """
    layer = Layer(model, tol)
    given = {
        "load": jnp.asarray(model.load if load is None else load),
        "support": jnp.asarray(model.support if support is None else support),
    }
    for name, array in given.items():
        if array.shape and array.shape[-1] != model.size:
            raise ValueError(f"{name} must be a number or have shape (..., {model.size}), got {array.shape}")
    shape = jnp.broadcast_shapes((model.size,), *(array.shape for array in given.values()))
    arrays = (jnp.broadcast_to(array.astype(jnp.result_type(float)), shape) for array in given.values())
    return Contact(*_contact(_Same(layer), *arrays))


class _Same:
    """A layer as a static argument, which is the same only as itself."""

    def __init__(self, layer: Layer) -> None:
        self.layer = layer


@partial(jax.custom_vjp, nondiff_argnums=(0,))
def _contact(same: _Same, load: jax.Array, support: jax.Array) -> Any:
    return _called(same.layer.answers, 3, load, support)


def _forward(same: _Same, load: jax.Array, support: jax.Array) -> Any:
    return _contact(same, load, support), (load, support)


def _backward(same: _Same, data: Any, weights: Any) -> Any:
    def gradients(load: Any, support: Any, *given: Any) -> Any:
        return same.layer.gradients(load, support, Fields(*given))

    return _called(gradients, 2, *data, *weights)


_contact.defvjp(_forward, _backward)


def _called(function: Any, count: int, *arrays: jax.Array) -> Any:
    """Return the arrays that a function of numpy's returns, each with the shape of the first that it is given."""

    def call(*given: Any) -> Any:
        found = function(*(np.asarray(array, dtype=np.float64) for array in given))
        return tuple(np.asarray(part, dtype=arrays[0].dtype) for part in found)

    shape = jax.ShapeDtypeStruct(arrays[0].shape, arrays[0].dtype)  # type: ignore[no-untyped-call]
    return jax.pure_callback(call, (shape,) * count, *arrays, vmap_method="broadcast_all")
