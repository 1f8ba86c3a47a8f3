"""The simulated machine: honest pictures of a surface on the footboard, and whole recordings with their truth.

| file | what |
|---|---|
| `foot`, `level_set`, `objects`, `surface` | what stands on the board |
| `machine` | the true machine, a little off its design |
| `motion` | the turning head and its encoder |
| `cut`, `shadow`, `depth`, `light`, `exposure`, `picture` | one frame |
| `visibility` | which skin the sheets can see at all |
| `record` | a whole scan |
"""
