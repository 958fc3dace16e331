"""Policies as plain C: a network of linear layers with its weights, without other libraries."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from robot_dynamics.numbers import Numbers

ACTIVATIONS = {
    "elu": "x > 0.0f ? x : expm1f(x)",
    "relu": "x > 0.0f ? x : 0.0f",
    "tanh": "tanhf(x)",
}
"""C expressions of the activations by name."""


def policy_code(
    layers: Sequence[tuple[Numbers, Numbers]],
    *,
    activation: str = "elu",
    mean: Numbers | None = None,
    deviation: Numbers | None = None,
    limit: float | None = 1.0,
    name: str = "policy",
) -> str:
    """C file with the function ``void policy(const float *observation, float *action)``.

    The observation is normalized, (x − mean)/deviation. Each layer is W x + b, and the activation follows all
    layers but the last. Actions are clipped to ±limit. The file needs only ``math.h``; it has no state and
    allocates no memory.

    Parameters
    ----------
    layers : sequence of (array_like, array_like)
        Weights W (outputs, inputs) and biases b (outputs,) of each layer.
    activation : {"elu", "relu", "tanh"}
        Activation of the inner layers.
    mean : array_like, shape (observations,), optional
        Mean of the observations; default: 0.
    deviation : array_like, shape (observations,), optional
        Standard deviation of the observations; default: 1.
    limit : float, optional
        Largest action; `None` for no limit.
    name : str
        Name of the function.

    Returns
    -------
    str
        Text of the file.

    Raises
    ------
    ValueError
        The activation is unknown, the layers do not fit together, or a number is not finite.

    Examples
    --------
    >>> from robot_dynamics.policy_code import policy_code
    >>> code = policy_code([([[1.0, -2.0]], [0.5])], limit=None)
    >>> "void policy(const float *observation, float *action)" in code
    True
    """
    if activation not in ACTIVATIONS:
        raise ValueError(f"activation is {activation!r}; there are {', '.join(ACTIVATIONS)}")
    tables = [(np.asarray(w, np.float32), np.asarray(b, np.float32)) for w, b in layers]
    if not tables:
        raise ValueError("layers is empty; a policy has at least one layer")
    inputs = tables[0][0].shape[-1]
    width = inputs
    for k, (w, b) in enumerate(tables):
        if w.ndim != 2 or w.shape[1] != width or b.shape != w.shape[:1]:
            raise ValueError(f"layer {k} has weights {w.shape} and biases {b.shape}; its input has {width} numbers")
        width = len(b)
    shift = np.zeros(inputs, np.float32) if mean is None else np.asarray(mean, np.float32)
    scale = np.ones(inputs, np.float32) if deviation is None else 1.0 / np.asarray(deviation, np.float32)
    if shift.shape != (inputs,) or scale.shape != (inputs,):
        raise ValueError(f"mean and deviation have shapes {shift.shape} and {scale.shape}; they must have ({inputs},)")
    arrays = [shift, scale, *(table for layer in tables for table in layer)]
    if not all(np.isfinite(table).all() for table in arrays):
        raise ValueError("a weight, a bias, a mean or a deviation is not finite")
    widest = max(inputs, *(len(b) for _, b in tables))
    lines = [
        f"/* Policy with {inputs} observations and {width} actions. */",
        "#include <math.h>",
        "",
        _table("mean", shift),
        _table("scale", scale),
    ]
    for k, (w, b) in enumerate(tables):
        lines += [_table(f"w{k}", w.ravel()), _table(f"b{k}", b)]
    lines += [
        "",
        f"static float activation(float x) {{ return {ACTIVATIONS[activation]}; }}",
        "",
        "static void layer(const float *w, const float *b, int inputs, int outputs, const float *x, float *y) {",
        "    for (int i = 0; i < outputs; ++i) {",
        "        float sum = b[i];",
        "        for (int j = 0; j < inputs; ++j) sum += w[i * inputs + j] * x[j];",
        "        y[i] = sum;",
        "    }",
        "}",
        "",
        f"void {name}(const float *observation, float *action) {{",
        f"    float x[{widest}], y[{widest}];",
        f"    for (int i = 0; i < {inputs}; ++i) x[i] = (observation[i] - mean[i]) * scale[i];",
    ]
    for k, (w, _) in enumerate(tables):
        lines.append(f"    layer(w{k}, b{k}, {w.shape[1]}, {w.shape[0]}, x, y);")
        if k + 1 < len(tables):
            lines.append(f"    for (int i = 0; i < {w.shape[0]}; ++i) x[i] = activation(y[i]);")
    clipped = "y[i]" if limit is None else f"fminf(fmaxf(y[i], {_number(-limit)}), {_number(limit)})"
    lines += [f"    for (int i = 0; i < {width}; ++i) action[i] = {clipped};", "}", ""]
    return "\n".join(lines)


def _number(x: float) -> str:
    return f"{np.float32(x)!r}".removeprefix("np.float32(").removesuffix(")") + "f"


def _table(name: str, numbers: NDArray[np.float32]) -> str:
    words = [_number(float(x)) for x in numbers]
    rows = [", ".join(words[k : k + 8]) for k in range(0, len(words), 8)]
    return f"static const float {name}[{len(words)}] = {{\n    " + ",\n    ".join(rows) + "};"


__all__ = ["policy_code"]
