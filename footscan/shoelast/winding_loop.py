"""Turning faces like their neighbours, as a compiled loop."""

import numpy as np

from footscan.compiled import compiled
from footscan.coordinates import Bools, Ints


@compiled
def spread_turns(begin: Ints, other: Ints, against: Bools) -> Bools:
    """Walk over neighbours; in each piece the smaller part is turned."""
    count = len(begin) - 1
    state = np.full(count, -1, dtype=np.int64)
    turned = np.zeros(count, dtype=np.bool_)
    queue = np.empty(count, dtype=np.int64)
    for seed in range(count):
        if state[seed] >= 0:
            continue
        state[seed] = 0
        queue[0] = seed
        head, tail, ones = 0, 1, 0
        while head < tail:
            face = queue[head]
            head += 1
            for k in range(begin[face], begin[face + 1]):
                if state[other[k]] < 0:
                    state[other[k]] = state[face] ^ (1 if against[k] else 0)
                    ones += state[other[k]]
                    queue[tail] = other[k]
                    tail += 1
        flip = 1 if 2 * ones <= tail else 0
        for k in range(tail):
            turned[queue[k]] = state[queue[k]] == flip
    return turned
