"""Facets of a parametric surface: as many as its bend asks for, span by span."""

from collections.abc import Callable

import numpy as np

from footscan.coordinates import Floats, Ints

Evaluate = Callable[[Floats, Floats], Floats]
"""Parameters `(n,)` and `(m,)` on 0..1 -> points `(n, m, 3)`."""

_PARTS = 8
"""Pieces of a span that are looked at; the bend of a polynomial changes little within one."""
_BOTH = 2.0
"""Bends along both parameters add up in the middle of a facet."""
_MOST_IN_SPAN = 256
_SAME = 1e-8
"""Of the chord error: coordinates are rounded to it, so that places of a pole or a seam become the very same."""


def facets_of(evaluate: Evaluate, breaks: tuple[Floats, Floats], chord: float, longest: float) -> tuple[Floats, Ints]:
    """Points and triangles of a whole surface.

    A chord over a piece of h lies at most |P''| h^2 / 8 beside its curve.

    Args:
        evaluate: The surface.
        breaks: Ends of its spans both ways, from 0 to 1.
        chord: No facet lies further beside the surface, in its own unit.
        longest: No facet is longer along a parameter.

    Returns:
        `(n, 3)` and `(m, 3)`, turned as the surface is.
    """
    fine = [_divided(each, np.full(len(each) - 1, _PARTS)) for each in breaks]
    along = _pieces(evaluate(fine[0], _halved(breaks[1])), chord, longest)
    across = _pieces(evaluate(_halved(breaks[0]), fine[1]).swapaxes(0, 1), chord, longest)
    xyz = evaluate(_divided(breaks[0], along), _divided(breaks[1], across))
    xyz = np.round(xyz / (_SAME * chord)) * (_SAME * chord)
    rows, columns = xyz.shape[:2]
    index = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]
    faces = np.concatenate([np.stack(three, axis=-1).reshape(-1, 3) for three in ((a, b, c), (a, c, d))])
    return xyz.reshape(-1, 3), faces


def _pieces(xyz: Floats, chord: float, longest: float) -> Ints:
    """Into how many pieces `(k,)` each span is cut, given points `(8k + 1, m, 3)` along it."""
    spans = (len(xyz) - 1) // _PARTS
    inner = np.arange(spans)[:, None] * _PARTS + np.arange(1, _PARTS)
    bend = np.linalg.norm(xyz[inner - 1] - 2.0 * xyz[inner] + xyz[inner + 1], axis=-1).max(axis=(1, 2))
    step = np.linalg.norm(np.diff(xyz, axis=0), axis=-1).reshape(spans, _PARTS, -1)
    by_bend = _PARTS * np.sqrt(_BOTH * bend / (8.0 * chord))
    by_length = step.sum(axis=1).max(axis=1) / longest
    return np.clip(np.ceil(np.maximum(by_bend, by_length)), 1, _MOST_IN_SPAN).astype(np.int64)


def _halved(breaks: Floats) -> Floats:
    return _divided(breaks, np.full(len(breaks) - 1, 2))


def _divided(breaks: Floats, pieces: Ints) -> Floats:
    """Spans cut into so many equal pieces."""
    span = np.repeat(np.arange(len(pieces)), pieces)
    share = (np.arange(len(span)) - np.repeat(np.cumsum(pieces) - pieces, pieces)) / pieces[span]
    return np.append(breaks[span] + share * np.diff(breaks)[span], breaks[-1])
