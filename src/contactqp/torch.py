"""Contact as a differentiable function of PyTorch tensors.

``pip install 'contactqp[torch]'`` installs what it needs.
"""

from __future__ import annotations

from typing import Any, NamedTuple, NoReturn

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

    It may stand in functions that ``torch.func`` differentiates backwards (``grad``, ``vjp``, ``jacrev``) and maps over
    batches (``vmap``). There are no forward derivatives (``jvp``, ``jacfwd``), and no second ones. Problems are solved
    one after the other on the processor in double precision, wherever the tensors are and whatever they hold.

    Parameters
    ----------
    model : Membrane, Cable, CableNet or another ContactModel
    load, support : tensor of floating-point numbers, shape (n,) or (..., n), optional
        In the units and the sense of the model's own, in node order; by default the model's. Leading dimensions are a
        batch, over which one that has none is repeated.
    tol : float
        Bound of the error, relative to the error scale.

    Returns
    -------
    Contact
        On the device of the tensors that were given, and of their type, the wider one of two.

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong kind, shape or device.

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
    given = {name: value for name, value in (("load", load), ("support", support)) if value is not None}
    _check(given, model.size)
    dtype, device = torch.float64, torch.device("cpu")
    if given:
        first, *others = given.values()
        device, dtype = first.device, first.dtype
        for other in others:
            dtype = torch.promote_types(dtype, other.dtype)
    own = {"load": model.load, "support": model.support}
    tensors = [
        torch.as_tensor(given[name] if name in given else np.array(own[name]), dtype=dtype, device=device)
        for name in ("load", "support")
    ]
    found: Any = _Contact.apply(layer, *torch.broadcast_tensors(*tensors))
    return Contact(*found)


def _check(given: dict[str, Any], size: int) -> None:
    """Raise an error unless what was given are tensors that go together."""
    for name, value in given.items():
        if not isinstance(value, torch.Tensor):
            raise TypeError(f"{name} must be a torch.Tensor, got {value!r}; write torch.as_tensor(...)")
        if not value.is_floating_point():
            raise TypeError(
                f"{name} must be a tensor of floating-point numbers, got {value.dtype}; write {name}.to(torch.float64)"
            )
        if tuple(value.shape[-1:]) != (size,):
            raise ValueError(f"{name} must have shape (..., {size}), got {tuple(value.shape)}")
    if len(given) < 2:
        return
    load, support = given["load"], given["support"]
    if load.device != support.device:
        raise ValueError(
            f"load and support must be on one device, got {load.device} and {support.device}; "
            f"write support.to({str(load.device)!r})"
        )
    try:
        torch.broadcast_shapes(load.shape, support.shape)
    except RuntimeError:
        raise ValueError(
            f"load and support must have batches that go together, got shapes {tuple(load.shape)} and "
            f"{tuple(support.shape)}"
        ) from None


class _Contact(torch.autograd.Function):
    @staticmethod
    def forward(layer: Layer, load: torch.Tensor, support: torch.Tensor) -> tuple[torch.Tensor, ...]:
        return tuple(_like(load, field) for field in layer.answers(_array(load), _array(support)))

    @staticmethod
    def setup_context(ctx: Any, inputs: Any, output: Any) -> None:
        ctx.layer, load, support = inputs
        ctx.save_for_backward(load, support)

    @staticmethod
    def backward(ctx: Any, *weights: torch.Tensor) -> tuple[Any, ...]:
        return None, *_Gradients.apply(ctx.layer, *ctx.saved_tensors, *weights)

    @staticmethod
    def vmap(info: Any, dims: Any, layer: Layer, *tensors: torch.Tensor) -> tuple[Any, Any]:
        return _Contact.apply(layer, *_together(info.batch_size, dims[1:], tensors)), (0, 0, 0)


class _Gradients(torch.autograd.Function):
    """The backward pass as a function of its own, which ``torch.func`` maps over batches."""

    @staticmethod
    def forward(layer: Layer, load: torch.Tensor, support: torch.Tensor, *weights: torch.Tensor) -> Any:
        given = Fields(*(_array(weight) for weight in weights))
        found = layer.gradients(_array(load), _array(support), given)
        return tuple(_like(load, part) for part in found)

    @staticmethod
    def setup_context(ctx: Any, inputs: Any, output: Any) -> None:
        """Keep nothing: there is no second derivative."""

    @staticmethod
    def backward(ctx: Any, *weights: torch.Tensor) -> NoReturn:
        raise NotImplementedError("contact has no second derivatives: take its gradients without create_graph=True")

    @staticmethod
    def vmap(info: Any, dims: Any, layer: Layer, *tensors: torch.Tensor) -> tuple[Any, Any]:
        if dims[1:3] != (None, None):
            return _Gradients.apply(layer, *_together(info.batch_size, dims[1:], tensors)), (0, 0)
        # Rows of a Jacobian: the problems are the same, and are solved already.
        weights = zip(*_together(info.batch_size, dims[3:], tensors[2:]), strict=True)
        rows = [_Gradients.apply(layer, *tensors[:2], *each) for each in weights]
        return tuple(torch.stack(part) for part in zip(*rows, strict=True)), (0, 0)


def _together(size: int, dims: Any, tensors: tuple[torch.Tensor, ...]) -> list[torch.Tensor]:
    """Return tensors with their batch first, repeated where they have none."""
    return [
        tensor.expand(size, *tensor.shape) if dim is None else tensor.movedim(dim, 0)
        for dim, tensor in zip(dims, tensors, strict=True)
    ]


def _array(tensor: torch.Tensor) -> np.ndarray[Any, Any]:
    return np.asarray(tensor.detach().to("cpu", torch.float64).numpy())


def _like(tensor: torch.Tensor, values: Any) -> torch.Tensor:
    return torch.as_tensor(values, dtype=tensor.dtype, device=tensor.device)
