"""Interface of linear models on finite records: y = T u and its adjoint, matrix-free.

`System`, `SystemMatrix`, `StateSpace` and `ImpulseResponse` are time-invariant and have a frequency
response as well; `TimeVarying` and `LiftedModel` live on the record. A model of one's own needs
the four members below; laws and finite-record analysis ask for nothing else.
"""

from typing import Any, Protocol, TypeGuard

from armside.arrays import Array


class RecordModel(Protocol):
    """Linear map T of records at rest before, from n_inputs to n_outputs columns."""

    @property
    def n_inputs(self) -> int: ...
    @property
    def n_outputs(self) -> int: ...

    def simulate(self, signal: Array, /) -> Array:
        """T u, shape (N, n_outputs), for u of shape (N, n_inputs)."""
        ...

    def adjoint(self, signal: Array, /) -> Array:
        """T^T e, shape (N, n_inputs), for e of shape (N, n_outputs)."""
        ...


def is_record_model(model: Any) -> TypeGuard[RecordModel]:
    """The object has the members of a `RecordModel`."""
    return all(hasattr(model, name) for name in ("n_inputs", "n_outputs", "simulate", "adjoint"))


def check_shape(model: "RecordModel", shape: tuple[int, ...], width: int, what: str) -> None:
    """Raise ValueError for a record of another shape than the model's, `width` many `what`."""
    covered = getattr(model, "n_samples", shape[0])
    if shape[0] != covered:
        raise ValueError(f"T_u covers {covered} samples, the record {shape[0]}")
    if shape[1] != width:
        raise ValueError(f"T_u has {width} {what}, the record {shape[1]}")
