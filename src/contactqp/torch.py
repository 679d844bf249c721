"""Contact as a differentiable function of PyTorch tensors.

``pip install 'contactqp[torch]'`` installs what it needs.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import torch

from .models.base import ContactModel
from .solving.layer import Fields, Layer

__all__ = ["Contact", "contact"]


class Contact(NamedTuple):
    """Gap and deflection (length), and reaction (force) at the nodes: tensors of shape (..., n)."""

    gap: torch.Tensor
    deflection: torch.Tensor
    reaction: torch.Tensor


def contact(
    model: ContactModel,
    load: torch.Tensor | None = None,
    support: torch.Tensor | None = None,
    *,
    tol: float = 1e-10,
) -> Contact:
    """Return what a model answers to a load and a support, with gradients by both.

    The backward pass solves the adjoint equations of the free nodes, see `contactqp.solving.sensitivity`. Where nodes
    have neither gap nor reaction it takes them for held, so that it returns one of the one-sided derivatives.

    Parameters
    ----------
    model : Membrane, Cable, CableNet or another ContactModel
    load, support : tensor, shape (n,) or (..., n), optional
        In the units and the sense of the model's own, in node order; by default the model's. Leading dimensions are a
        batch, over which one that has none is repeated.
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
    >>> load = torch.ones(9, dtype=torch.float64, requires_grad=True)
    >>> contact(cable, load).reaction.sum().backward()
    >>> load.grad.shape
    torch.Size([9])
    """
    layer = Layer(model, tol)
    tensors = [
        torch.as_tensor(np.array(own)) if given is None else given
        for own, given in ((model.load, load), (model.support, support))
    ]
    found: Any = _Contact.apply(layer, *torch.broadcast_tensors(*tensors))
    return Contact(*found)


class _Contact(torch.autograd.Function):
    @staticmethod
    def forward(ctx: Any, layer: Layer, load: torch.Tensor, support: torch.Tensor) -> tuple[torch.Tensor, ...]:
        ctx.layer = layer
        ctx.save_for_backward(load, support)
        return tuple(_like(load, field) for field in layer.answers(_array(load), _array(support)))

    @staticmethod
    def backward(ctx: Any, *weights: torch.Tensor) -> tuple[Any, ...]:
        load, support = ctx.saved_tensors
        given = Fields(*(_array(weight) for weight in weights))
        by_load, by_support = ctx.layer.gradients(_array(load), _array(support), given)
        return None, _like(load, by_load), _like(support, by_support)


def _array(tensor: torch.Tensor) -> np.ndarray[Any, Any]:
    return np.asarray(tensor.detach().cpu().numpy(), dtype=np.float64)


def _like(tensor: torch.Tensor, values: Any) -> torch.Tensor:
    return torch.as_tensor(values, dtype=tensor.dtype, device=tensor.device)
